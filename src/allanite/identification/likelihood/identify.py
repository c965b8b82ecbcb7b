"""Identification by likelihood: which terms are present, their sizes and their uncertainties."""

from collections.abc import Sequence
from functools import partial

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.errors import DataError
from allanite.core.estimate import Estimate
from allanite.core.fit import Alternative, Fit, Line
from allanite.core.limits import Remembered
from allanite.core.model import Model, Term
from allanite.core.record import Record
from allanite.core.titles import title_of
from allanite.core.units import Signal
from allanite.core.validity import Band, Scope
from allanite.identification.checks.exponent import exponent_finding, other_law
from allanite.identification.checks.goodness import goodness
from allanite.phrases.phrase import say
from allanite.prepare.gaps import refusal
from allanite.terms import TERMS

from .estimates import CoefficientScale, noise_estimate, observable, ramp_estimate, under
from .model_selection import DISTINGUISHABLE, SLOW, Found, lacking, look, looked
from .nodes import nodes
from .removal import without_lines
from .scope import steady
from .scope_text import scope_of
from .selection import correlation
from .spectrum import BinnedSpectrum
from .steps import steps_in
from .transient import warm_up_estimate
from .warmup import WarmUp

WALKS = [symbol for symbol, row in TERMS.items() if row.slope > 0 and row.waveform is None]
"""Noise that grows with time, for which steps of the bias are taken."""


def whittle(
    record: Record,
    symbols: Sequence[str],
    band: Band = "auto",
    *,
    masks: Sequence[tuple[float, float]] = (),
    lines: bool = True,
    rival: bool = False,
) -> Fit:
    """Identify terms by the binned DCT-II Whittle likelihood.

    Sinusoids are detected and removed; the noise terms are selected by 2 L + 4 per term over all subsets, with the ramp
    integrated out; each coefficient is averaged over the subsets, with upper limits for what is absent; the signed ramp
    is estimated by generalized least squares, averaged over what hides it.

    Parameters
    ----------
    record : Record
    symbols : sequence of str
        Keys of `TERMS`.
    band : {"auto", "all"} or (low, high)
        Frequencies to use, Hz; "auto" finds those that the terms explain, and a low-pass filter.
    masks : sequence of (low, high)
        Frequencies that are not used, Hz.
    lines : bool
        Whether sinusoids are detected and removed.
    rival : bool
        Whether Gauss-Markov noise may replace flicker although it was not requested.
    """
    why = refusal(record)
    if why:
        raise DataError(say("{channel}: {reason}", channel=record.name or say("the record"), reason=why))
    terms, (_, asked) = _scattering(symbols), _frequencies(band)
    found = look(record, terms, asked, masks, rival=rival)
    taken: tuple[Line, ...] = ()
    if lines:
        taken, left = without_lines(record, found, asked)
        found = look(left, terms, asked, masks, rival=rival) if taken else found
    return _concluded(found, (record.name, record.signal), symbols, band, rival=rival, taken=taken)


def whittle_of(
    seen: BinnedSpectrum,
    channel: tuple[str, Signal],
    symbols: Sequence[str],
    band: Band = "auto",
    *,
    masks: Sequence[tuple[float, float]] = (),
    rival: bool = False,
) -> Fit:
    """Identify terms in a spectrum, of a channel of this name and signal; sinusoids are not looked for."""
    found = looked(seen, _scattering(symbols), _frequencies(band)[1], masks, rival=rival)
    return _concluded(found, channel, symbols, band, rival=rival)


def _scattering(symbols: Sequence[str]) -> list[str]:
    return [symbol for symbol in symbols if TERMS[symbol].scatters]


def _frequencies(band: Band) -> tuple[str, tuple[float, float] | None]:
    """How the frequencies are chosen, and those that were asked for."""
    return (band, None) if isinstance(band, str) else ("asked", band)


def _concluded(
    plain: Found,
    channel: tuple[str, Signal],
    symbols: Sequence[str],
    band: Band,
    *,
    rival: bool,
    taken: tuple[Line, ...] = (),
) -> Fit:
    """The fit, from what every subset of the terms makes of a spectrum."""
    (name, signal), (choice, asked) = channel, _frequencies(band)
    warm, found = steady(plain, signal, rival=rival, choice=choice)
    law = None if warm else other_law(found, plain)
    stepped = None if warm or law else steps_in(found, signal)
    slow = [exponent_finding(law, found, signal)] if law else [each.finding for each in (warm, stepped) if each]
    scope = scope_of(found, choice, asked)
    scale = CoefficientScale(signal, found.seen.rate, found.seen.unit_factor, found.seen.slope)
    estimates = _estimates(symbols, found, scope, scale, warm=warm)
    if stepped is not None:
        estimates |= {s: e.invalid(say("the bias steps")) for s, e in estimates.items() if s in WALKS and e.claimed}
    elif law is not None:
        estimates = {s: under(law, e) for s, e in estimates.items()}
    model = _model(estimates, found, scale)
    deterministic = tuple(t for t in model if t.row.waveform is not None and t.row.scatters)
    good = goodness(found.seen, found.full.likelihood, found.full.theta, found.used, taken)
    return Fit(
        estimates=tuple(estimates.values()),
        method="whittle",
        signal=signal,
        name=name,
        model=Model((*model, *(line.term for line in taken))),
        goodness=good,
        correlation=_correlation(list(estimates), found),
        notes=(*(f.what for f in slow), *_quick(found), *_unclear(estimates, found), *_ambiguous(found)),
        lines=taken,
        rivals=Remembered(partial(_alternatives, found, scale)),
        nodes=Remembered(partial(nodes, found, scale, deterministic)),
        scope=scope,
        findings=tuple(slow),
    )


def _estimates(
    symbols: Sequence[str], found: Found, scope: Scope, scale: CoefficientScale, *, warm: WarmUp | None
) -> dict[str, Estimate]:
    """Estimates of the terms that were asked for, and of Gauss-Markov noise that is in their place."""
    terms = _scattering(symbols)
    shown = list(dict.fromkeys([*terms, *found.noise])) if found.chosen.constants else terms
    estimates = {s: noise_estimate(s, i, found, scale) for i, s in enumerate(found.noise) if s in shown}
    estimates |= {s: ramp_estimate(s, found, scale) for s in terms if TERMS[s].waveform is not None}
    estimates = {s: observable(s, estimates.get(s), found, scope, scale) for s in shown}
    return estimates | {s: warm_up_estimate(s, warm, scale.signal) for s in symbols if TERMS[s].transient}


def _model(estimates: dict[str, Estimate], found: Found, scale: CoefficientScale) -> Model:
    """The best model: the selected noise terms, claimed or not, and the ramp if it is claimed."""
    terms = scale.terms(found.noise, found.chosen)
    ramps = [e for s, e in estimates.items() if s not in found.noise and e.value is not None]
    return Model((*terms, *(Term(e.symbol, e.value, scale.signal, e.shape) for e in ramps if e.value is not None)))


def _correlation(shown: Sequence[str], found: Found) -> FloatArray:
    """Correlation of the estimates of the selected noise terms, shape (terms, terms); NaN for the others."""
    there = [s for s, free in zip(found.noise, found.chosen.free, strict=True) if free]
    known = [(i, there.index(s)) for i, s in enumerate(shown) if s in there]
    matrix = np.full((len(shown), len(shown)), np.nan)
    if known:
        at, which = map(list, zip(*known, strict=True))
        matrix[np.ix_(at, at)] = correlation(found.chosen)[np.ix_(which, which)]
    return matrix


def _unclear(estimates: dict[str, Estimate], found: Found) -> list[str]:
    """Terms of the best model that are not claimed, because others could take their place."""
    return [
        say(
            "{term} ({symbol}) is in the best model, but other terms could take its place: a longer record would "
            "decide",
            term=title_of(s, estimates[s].signal),
            symbol=s,
        )
        for s, there in zip(found.noise, found.chosen.free, strict=True)
        if there and s in estimates and estimates[s].status == "absent"
    ]


def _quick(found: Found) -> list[str]:
    """What Gauss-Markov noise of a few samples is."""
    time = found.chosen.constants[0] if len(found.chosen.constants) == 1 else SLOW
    if time >= SLOW:
        return []
    return [
        say(
            "the Gauss-Markov noise has a time constant of {count:.2g} samples: noise that a filter or a vibration "
            "correlates, no drift of the bias",
            count=time,
        )
    ]


def _ambiguous(found: Found) -> list[str]:
    """How well Gauss-Markov noise instead of flicker, or the reverse, would describe the record."""
    if found.search is None or found.markov is None or found.flicker is None:
        return []
    if found.search.symbol not in {TERMS[symbol].substitute for symbol in found.noise}:
        return []
    gain = found.flicker.aic - found.markov.aic
    size, time = f"{-gain:+.1f}", found.markov.constants[0] / found.seen.rate
    if found.chosen is found.markov:
        return [
            say("Gauss-Markov noise with a time constant of {time:.2g} s describes the record better than flicker does",
                time=time)
        ]  # fmt: skip
    if abs(gain) < DISTINGUISHABLE:
        return [
            say(
                "Gauss-Markov noise with a time constant of {time:.2g} s instead of flicker would describe the record "
                "equally well: they cannot be distinguished (AIC {gain})",
                time=time, gain=size,
            )
        ]  # fmt: skip
    needed = gain + lacking(found.plain, found.markov, found.part)
    if gain < 0 or needed <= gain:  # it is not missed, or it does not explain the record
        return []
    return [
        say(
            "Gauss-Markov noise with a time constant of {time:.2g} s would describe the record better (AIC {gain}; it "
            "is claimed from -{needed:.0f} on): a longer record would decide",
            time=time, gain=size, needed=needed,
        )
    ]  # fmt: skip


def _alternatives(found: Found, scale: CoefficientScale) -> tuple[Alternative, ...]:
    """The other families, the best first."""
    others = sorted((s for s in found.rivals() if s is not found.chosen), key=lambda s: s.aic)
    return tuple(Alternative(Model(scale.terms(found.noise, s)), s.aic - found.chosen.aic) for s in others)
