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
from allanite.core.units import Signal
from allanite.core.validity import Band, Scope
from allanite.identification.checks.exponent import exponent_finding, other_law, under
from allanite.identification.checks.goodness import goodness
from allanite.phrases.phrase import say, say_count
from allanite.prepare.gaps import known_rates, refusal
from allanite.terms import TERMS, WHITE

from .estimates import CoefficientScale, nodes, noise_estimate, observable, ramp_estimate
from .lines import levels, suspected, waves_of
from .model_selection import Found, look, looked
from .remarks import notes_of, scope_of
from .scope import behind_filter, explains, scoped
from .selection import correlation
from .spectrum import BinnedSpectrum
from .steps import steps_in
from .warmup import WarmUp, warm_up_estimate, without_warm_up

SLOW = [symbol for symbol, row in TERMS.items() if not row.slope <= WHITE and row.waveform is None]
"""Noise whose power is at low frequencies."""

WALKS = [symbol for symbol in SLOW if TERMS[symbol].slope > 0]
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
    plain, taken = _seen(record, symbols, band, masks, lines=lines, rival=rival)
    return _concluded(plain, (record.name, record.signal), symbols, band, rival=rival, taken=taken)


def explaining(record: Record, symbols: Sequence[str]) -> Fit | None:
    """The fit of the terms to all frequencies of a record without sinusoids; None if they do not explain it."""
    plain, _ = _seen(record, symbols, "all", (), lines=False, rival=False)
    _, found = _steady(plain, record.signal, rival=False, choice="all")
    return _concluded(plain, (record.name, record.signal), symbols, "all", rival=False) if explains(found) else None


def _seen(
    record: Record,
    symbols: Sequence[str],
    band: Band,
    masks: Sequence[tuple[float, float]],
    *,
    lines: bool,
    rival: bool,
) -> tuple[Found, tuple[Line, ...]]:
    """What every subset of the terms makes of a record without its sinusoids, and those."""
    why = refusal(record)
    if why:
        raise DataError(say("{channel}: {reason}", channel=record.name or say("the record"), reason=why))
    terms, (_, asked) = _scattering(symbols), _frequencies(band)
    found = look(record, terms, asked, masks, rival=rival)
    taken, left = _without_lines(record, found, asked) if lines else ((), record)
    return (look(left, terms, asked, masks, rival=rival) if taken else found), taken


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


def _without_lines(record: Record, found: Found, band: tuple[float, float] | None) -> tuple[tuple[Line, ...], Record]:
    """The sinusoids of a record whose noise was looked at, and the rest of it; the record itself if there are none."""
    seen, level = found.seen, _level(found)
    if not suspected(seen, level, found.used):
        return (), record
    # between the lobes of a filter the noise is low, and what is at their tops is no line
    level = _level(behind_filter(found.base))
    if not suspected(seen, level, found.used):
        return (), record
    rates = known_rates(record)
    mean = float(np.nanmean(rates))
    low, high = (0.0, record.rate / 2) if band is None else band
    waves, _ = waves_of(rates - mean, seen, level, (low / record.rate, high / record.rate))
    if not waves:
        return (), record
    scale = [seen.unit_factor / float(np.sinc(wave.frequency)) for wave in waves]
    lines = tuple(
        Line(wave.frequency * record.rate, wave.amplitude * s, wave.error * s, wave.phase, record.signal)
        for wave, s in zip(waves, scale, strict=True)
    )
    # the record without sinusoids; an angle stays one, which knows more of its gaps; counts become increments
    total = np.sum([wave.values(record.size) for wave in waves], axis=0)
    if record.kind == "angle":
        total = np.concatenate(([0.0], np.cumsum(total)))
    return tuple(sorted(lines, key=lambda line: line.frequency)), record.with_values(
        record.values - total,
        say_count(len(waves), "{count} sinusoid removed", "{count} sinusoids removed"),
        start=record.start,
    )


def _level(found: Found) -> FloatArray:
    """The power of the noise in every bin."""
    m = found.seen.power.copy()
    m[found.used] = found.chosen.likelihood.expectation(found.chosen.theta)
    return levels(found.seen, m)


def _steady(found: Found, signal: Signal, *, rival: bool, choice: str) -> tuple[WarmUp | None, Found]:
    """What explains the spectrum beside a warm-up, if there is one, and that; see `scoped`."""
    first = scoped(found, rival=rival, choice=choice)
    warm, best = without_warm_up(first, signal)
    if warm and explains(first) and not explains(best):  # it stands in for a part of what explains the record
        warm, best = None, first
    if warm or choice != "auto" or (first.used[0] and explains(first)):
        return warm, best
    warm, best = without_warm_up(found, signal)
    second = scoped(best, rival=rival) if warm else first
    return (warm, second) if warm and second.used[0] and explains(second) else (None, first)


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
    warm, found = _steady(plain, signal, rival=rival, choice=choice)
    stepped = steps_in(warm.found, signal, warm) if warm else None
    if warm and stepped:  # a step near the start falls like a warm-up, but at once
        found, warm = warm.found, None
    law = None if warm or stepped else other_law(found, plain)
    stepped = stepped or (None if warm or law else steps_in(found, signal))
    slow = [exponent_finding(law, found, signal)] if law else [each.finding for each in (warm, stepped) if each]
    scope = scope_of(found, choice, asked)
    scale = CoefficientScale(signal, found.seen.rate, found.seen.unit_factor, found.seen.slope)
    estimates = _estimates(symbols, found, scope, scale, warm=warm)
    if stepped is not None:
        stained = SLOW if found.chosen.constants else WALKS  # what has taken the power of the steps
        estimates |= {s: e.invalid(say("the bias steps")) for s, e in estimates.items() if s in stained and e.claimed}
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
        notes=(*(f.what for f in slow), *notes_of(estimates, found)),
        lines=taken,
        rivals=Remembered(partial(_alternatives, found, scale)),
        nodes=Remembered(partial(nodes, found, scale, deterministic)),
        scope=scope,
        findings=tuple(slow),
        warm_up=warm.term if warm else None,
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


def _alternatives(found: Found, scale: CoefficientScale) -> tuple[Alternative, ...]:
    """The other families, the best first."""
    others = sorted((s for s in found.rivals() if s is not found.chosen), key=lambda s: s.aic)
    return tuple(Alternative(Model(scale.terms(found.noise, s)), s.aic - found.chosen.aic) for s in others)
