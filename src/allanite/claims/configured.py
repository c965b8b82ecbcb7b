"""Whether the settings that are claimed are in the record: its low-pass filter, and the samples that repeat others."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from allanite.core.fit import REJECTED, Fit
from allanite.core.limits import NOT_DECIDED
from allanite.core.record import Record
from allanite.core.validity import UNEXPLAINED, Finding
from allanite.phrases.phrase import Phrase, join, say
from allanite.prepare.held import was_held
from allanite.prepare.view import View
from allanite.study.results import Channel, Study

from .claim import CUTOFF, ClaimedSetting
from .result import DIFFERS, CheckedTerm, fit_of

HIGHEST = 0.45
"""Share of the sampling rate above which a cut-off is not decided on: near half of it the images of what a filter
passes fill in what it takes away."""

ROUGH = 0.2
"""Misfit of the power above which no cut-off is decided on: at the slope of a 2nd-order filter a tenth of it."""

VAGUE = 2.0  # ratio of the limits of a cut-off above which one between them is not confirmed: an octave, a definition


def setting_rows(
    study: Study, settings: Sequence[ClaimedSetting], alpha: float, tolerance: float
) -> Iterator[CheckedTerm]:
    """Every setting held against the channels of its sensor; `alpha` is the chance of a false alarm of them all."""
    pairs = [(c, s) for c in study for s in settings if s.holds_for(c.record.signal)]
    level = 1 - alpha / max(sum(s.quantity == CUTOFF for _, s in pairs), 1)
    for channel, setting in pairs:
        row = CheckedTerm(channel.record.name, channel.record.signal, setting.quantity, setting.value, None, "Hz")
        if setting.quantity == CUTOFF:
            yield _cutoff(row, channel, setting.value, level, tolerance)
        else:
            yield _rate(row, channel, setting.value, tolerance, study.findings)


def _cutoff(row: CheckedTerm, channel: Channel, claimed: float, level: float, tolerance: float) -> CheckedTerm:
    """A low-pass filter: the interval of its cut-off, whether one is claimed by the fit or not."""
    why = _hidden(channel, claimed)
    fit = fit_of(channel)
    if why or fit is None or fit.cutoff is None:
        return replace(row, outcome=NOT_DECIDED, reason=why)
    low, high = fit.cutoff(level)
    through = None if fit.scope is None else fit.scope.filter
    known = replace(row, low=low / claimed, high=high / claimed)
    if through is not None:
        known = replace(known, found=through.cutoff, ratio=through.cutoff / claimed)
    if low > claimed * (1 + tolerance) or high < claimed * (1 - tolerance):
        return replace(known, outcome=DIFFERS, reason=_differing(channel, low, high))
    if through is None:
        return replace(known, outcome=NOT_DECIDED, reason=say("a longer record would show whether there is a filter"))
    if high > VAGUE * low:
        return replace(known, outcome=NOT_DECIDED, reason=_differing(channel, low, high))
    return known


def _differing(channel: Channel, low: float, high: float) -> Phrase:
    """What the record shows in the place of the claimed cut-off."""
    if math.isfinite(high):
        return say("the low-pass of the record lies between {low:.3g} and {high:.3g} Hz", low=low, high=high)
    return say("the record shows no low-pass below {low:.3g} Hz", low=min(low, HIGHEST * channel.record.rate))


def _hidden(channel: Channel, claimed: float) -> str:
    """Why a record does not show a low-pass filter of this cut-off; empty if it does."""
    rate, fit = channel.record.rate, fit_of(channel)
    repeated = next((str(f.what) for f in channel.quality.findings if f.name == "resampled"), "")
    if repeated:
        return repeated
    if claimed > HIGHEST * rate:
        return say("above {limit:.3g} Hz a filter leaves no trace: a higher sampling rate is needed",
                   limit=HIGHEST * rate)  # fmt: skip
    return channel.refusal or say("no noise was identified") if fit is None else _undescribed(fit)


def _undescribed(fit: Fit) -> str:
    """Why a fit does not tell of filters; empty if it does."""
    if fit.cutoff is None:
        return say("filters are looked for where all frequencies are read, by the method whittle")
    if fit.validity == UNEXPLAINED:
        return REJECTED
    if fit.scope is not None and fit.scope.within > ROUGH:
        return say("no known filter describes the record: the power differs by {share:.2g} %",
                   share=100 * fit.scope.within)  # fmt: skip
    return ""


def _rate(row: CheckedTerm, channel: Channel, claimed: float, tolerance: float, told: Sequence[Finding]) -> CheckedTerm:
    """The samples of a sensor in a second: of the record, less those that were held."""
    record, rate = channel.record, channel.record.rate
    resampled = next((f for f in channel.quality.findings if f.name == "resampled"), None)
    if resampled is not None:
        return replace(row, outcome=NOT_DECIDED, reason=str(resampled.what))
    ratio = rate / claimed
    error = ratio / record.size
    known = replace(row, found=rate, ratio=ratio, low=ratio - error, high=ratio + error)
    if abs(ratio - 1) <= tolerance:
        return known
    if was_held(record):
        return replace(known, outcome=DIFFERS, reason=join("; ", (str(f.what) for f in told if f.name == "held")))
    if claimed > rate:
        return replace(
            known, outcome=NOT_DECIDED, ratio=math.nan, low=math.nan, high=math.nan,
            reason=say("the record has {rate:.6g} samples a second: it does not show whether the sensor has more",
                       rate=rate),
        )  # fmt: skip
    if isinstance(record, Record) and _coarse(View(record), claimed):
        return replace(row, outcome=NOT_DECIDED, reason=say("the samples are too coarse to tell repeated ones"))
    return replace(known, outcome=DIFFERS, reason=say("none of the {rate:.6g} samples a second is a repeated one",
                                                      rate=rate))  # fmt: skip


def _coarse(view: View, claimed: float) -> bool:
    """Whether so many neighbours are equal by chance that what a sensor of this rate repeats would not stand out."""
    share = float(np.mean(view.steps[1:] == view.steps[:-1])) if view.steps.size > 1 else 1.0
    return share >= (1 - claimed / view.rate) / 2
