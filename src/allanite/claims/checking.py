"""Whether a record has the noise that is claimed of it: every number of the claim held against the record."""

import math
import os
from collections.abc import Iterator, Sequence
from dataclasses import fields, replace
from typing import Annotated

import numpy as np

from allanite.batch.specification import Limit, seen_of
from allanite.core.aliases import public
from allanite.core.errors import DataError
from allanite.core.fit import REJECTED, Fit
from allanite.core.limits import FAIL, NOT_DECIDED, PASS, held
from allanite.core.model import Model
from allanite.core.record import Record
from allanite.core.threads import one_thread
from allanite.core.validity import UNEXPLAINED, Finding
from allanite.phrases.phrase import Phrase, join, say
from allanite.prepare.held import was_held
from allanite.prepare.view import View
from allanite.study.analysis import analyzed
from allanite.study.channels import Progress, Source
from allanite.study.recipe import Recipe
from allanite.study.results import Channel, Study
from allanite.study.settings import TOLERANCES

from .claim import CUTOFF, KINDS, ClaimedNoise, ClaimedSetting, claim_of
from .convention import causes_of
from .exact import Counts, by_sensor, curve_row, exact_rows
from .result import AGREES, DIFFERS, EXCEEDS, CheckedTerm, ClaimCheck

HIGHEST = 0.45
"""Share of the sampling rate above which a cut-off is not decided on: near half of it the images of what a filter
passes fill in what it takes away."""

ROUGH = 0.2
"""Misfit of the power above which no cut-off is decided on: at the slope of a 2nd-order filter a tenth of it."""

VAGUE = 2.0  # ratio of the limits of a cut-off above which one between them is not confirmed: an octave, a definition


def setting_rows(study: Study, settings: Sequence[ClaimedSetting], alpha: float,
                 tolerance: float) -> Iterator[CheckedTerm]:  # fmt: skip
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
    fit = channel.fit
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
    rate, fit = channel.record.rate, channel.fit
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
        why = say("the record has {rate:.6g} samples a second: it does not show whether the sensor has more", rate=rate)
        return replace(known, outcome=NOT_DECIDED, ratio=math.nan, low=math.nan, high=math.nan, reason=why)
    # so many neighbours may be equal by chance that what a sensor of this rate repeats would not stand out
    steps = View(record).steps if isinstance(record, Record) else np.empty(0)
    if steps.size and float(np.mean(steps[1:] == steps[:-1]) if steps.size > 1 else 1.0) >= (1 - claimed / rate) / 2:
        return replace(row, outcome=NOT_DECIDED, reason=say("the samples are too coarse to tell repeated ones"))
    return replace(known, outcome=DIFFERS, reason=say("none of the {rate:.6g} samples a second is a repeated one",
                                                      rate=rate))  # fmt: skip


TOLERANCE = 0.02  # relative difference that is accepted: files state two or three digits

SHARES = 5
"""Kinds of comparisons that share the chance of a false alarm: terms, times, other noise, curves, distributions."""


@public
def check(source: Source, claims: "str | os.PathLike[str] | Model | ClaimedNoise", recipe: Recipe | None = None,
          *, claims_from: str | None = None, at_most: bool = False, tolerance: Annotated[float, TOLERANCES] = TOLERANCE,
          progress: Progress | None = None, **choices: object) -> ClaimCheck:  # fmt: skip
    """Check whether a recording has the noise that a configuration, a simulator or a data sheet claims.

    A model and the file of a filter or simulator claim exact values: each coefficient is estimated by likelihood in the
    form that is claimed, with profile limits; then come the correlation time of the bias, other noise, the Allan
    deviation at every octave of averaging times and the distribution of the residuals. Data sheets and limits are upper
    bounds: each number is held against the identified noise. The chance that a right record is contradicted in any of
    its channels is 1 - level. Settings, the cut-off of a low-pass filter and the rate of the sensor, are held against
    the filter that the samples show and the samples that repeat others.

    Parameters
    ----------
    source : Recording, Record, path, table or array
        As for `analyze`.
    claims : str, path, Model or ClaimedNoise
        See `claim_of`.
    recipe : Recipe, optional
    claims_from : str, optional
        The target whose file `claims` is, if its fields do not tell.
    at_most : bool
        Whether the values are upper bounds, whatever states them.
    tolerance : float
        Relative difference that is accepted.
    progress : callable, optional
    **choices
        Fields of `Recipe`.

    Returns
    -------
    ClaimCheck

    Raises
    ------
    DataError
        A file cannot be read, or nothing is claimed of any channel.
    UsageError
        The claim cannot be understood, or an option is wrong.

    Examples
    --------
    >>> import allanite as al
    >>> record = al.simulate(al.N(0.3, "deg/sqrt(h)"), 8192, 100.0, rng=1)
    >>> al.check(record, "N 0.3 deg/sqrt(h)").agrees
    True
    >>> found = al.check(record, "N 0.2121 deg/sqrt(h)")
    >>> found.causes[0].names
    ('sqrt(2)',)
    >>> al.check(record, "lowpass 30 Hz").causes
    (<Cause : the record shows no low-pass below 35.3 Hz>,)
    """
    recipe = (recipe or Recipe()).but(choices)
    claim_of(claims, claims_from, recipe.rate or 1.0)  # what cannot be read is refused before any work
    study = analyzed(source, recipe, progress)
    rates = dict.fromkeys(channel.record.rate for channel in study)
    of_rate = {rate: claim_of(claims, claims_from, rate) for rate in rates}
    first = next(iter(of_rate.values()))
    first = replace(first, bound=first.bound or at_most)
    with one_thread():
        terms = tuple(_checked(study, of_rate, first.bound, tolerance))
    if not terms:
        sensors = ", ".join(dict.fromkeys(channel.record.signal.sensor for channel in study))
        raise DataError(say("{claim} claims nothing of the channels of this record ({sensors})",
                            claim=first.title, sensors=sensors))  # fmt: skip
    known = {f.name: getattr(study, f.name) for f in fields(Study)}
    return ClaimCheck(**known, claim=first, terms=terms, causes=causes_of(study, first, terms), tolerance=tolerance)


def _checked(study: Study, claims: dict[float, ClaimedNoise], bound: bool, tolerance: float) -> Iterator[CheckedTerm]:
    """The rows of all channels, by kind of sensor."""
    settings, sensors = next(iter(claims.values())).settings, by_sensor(study, claims)
    noise = 1 if bound else SHARES * bool(sensors)
    alpha = (1 - study.recipe.level) / max(noise + bool(settings), 1)
    if bound:
        yield from _bounds(study, claims, alpha, tolerance)
    else:
        count = Counts(sensors, alpha, tolerance)
        for sensor in sensors:
            yield from exact_rows(sensor, count)
    yield from setting_rows(study, settings, alpha, tolerance)


def _bounds(study: Study, claims: dict[float, ClaimedNoise], alpha: float, tolerance: float) -> Iterator[CheckedTerm]:
    """The rows of all channels whose noise is claimed to be at most this, channel by channel."""
    # A configuration and a model claim all noise, so that no deviation may exceed theirs; data sheets and limits say
    # nothing of terms that they do not have.
    whole = next(iter(claims.values())).kind not in KINDS
    limits = [(c, claims[c.record.rate].limits_of(c.record.name, c.record.signal)) for c in study]
    each = alpha / max(sum(len(own) + whole for _, own in limits if own), 1)
    for channel, own in limits:
        for limit in own:
            yield _bounded(channel, limit, 1 - 2 * each, tolerance)
        model, fit = claims[channel.record.rate].of(channel.record.signal), channel.fit
        if whole and model is not None and fit is not None and isinstance(channel.record, Record):
            yield curve_row(channel, model, fit, 2 * each, lambda low, _: EXCEEDS if low > 1 + tolerance else AGREES)


BOUNDED = {PASS: AGREES, FAIL: EXCEEDS, NOT_DECIDED: NOT_DECIDED}
"""What a limit that is kept, exceeded or not decided says of a claim."""


def _bounded(channel: Channel, limit: Limit, level: float, tolerance: float) -> CheckedTerm:
    """A number that is an upper bound, held against what was identified."""
    reading, most, record = seen_of(channel, limit.symbol, level), limit.maximum, channel.record
    row = CheckedTerm(record.name, record.signal, limit.symbol, most, reading.value, limit.unit, reason=reading.reason)
    low, high = reading.limits
    row = replace(row, low=low / most, high=high / most, outcome=BOUNDED[held(low, high, most * (1 + tolerance))])
    if reading.value is None:
        return replace(row, reason=reading.reason or say("not identified"))
    return replace(row, ratio=reading.value / most)
