"""Identification by likelihood: which terms are present, their sizes and their uncertainties."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from typing import Any

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.errors import DataError, UsageError
from allanite.core.estimate import Estimate
from allanite.core.fit import Alternative, Fit, Goodness, Line
from allanite.core.limits import Remembered
from allanite.core.model import Model, Term
from allanite.core.plain import Portable
from allanite.core.record import Record
from allanite.core.validity import Band, Finding, Scope
from allanite.identification.checks.goodness import cells_of, goodness
from allanite.identification.likelihood.law import correlation
from allanite.identification.likelihood.lines import levels, suspected, waves_of
from allanite.identification.likelihood.spectrum import BinnedSpectrum, spectrum
from allanite.phrases.phrase import join, say, say_count
from allanite.prepare.gaps import known_rates, refusal
from allanite.prepare.rounding import rounding_of
from allanite.terms import TERMS

from .components import CLAIMED, COMPONENTS, Part
from .cutoffs import cutoff_law
from .describing import components_of, lost_freedom, loud_in, notes_of, scope_of
from .estimates import Answer, Scale, claims, noise_estimate, observable, ramp_estimate, under
from .fitting import Fitted, fitted
from .frame import Frame, frame_of
from .laws import entries_of, subset_of
from .moves import MOVES, filters, floors, less, markov, resonances, warm_ups_of
from .pooling import Together, behind
from .refining import Move, pruned
from .search import Searched, search, shows_white

from .slow import (  # isort: skip
    RESONANCES, WarmUp, exponent_finding, steps_finding, steps_of, vibration_finding, warm_up_estimate, wave_finding,
    wave_of
)  # fmt: skip
from .state import State

SMOOTH: tuple[Move, ...] = (less, floors, markov, filters)
"""What lifts the level of noise beside sinusoids before these are removed."""

MOST_ASKED = 2  # terms with a shape that are looked for together
LEAST_SHOWN = 1e-3  # weight of a model from which it takes part in the expected power that is tested


@dataclass(frozen=True, eq=False)
class Pending(Portable):
    """A search that is not concluded: other channels may have a filter in common with it."""

    result: Searched
    scale: Scale
    symbols: tuple[str, ...]  # terms that were asked for
    name: str  # of the channel
    # band, masks: as they were asked for
    band: Band
    masks: Sequence[tuple[float, float]]
    automatic: bool  # whether all was left to the search, so that its filter may be one in common
    taken: tuple[Line, ...] = ()  # sinusoids removed before

    def fit(self, shared: Together | None = None) -> Fit:
        """The fit, behind a filter in common if there is one."""
        result = behind(self.result, shared.common) if shared else self.result
        answer = Answer(result, entries_of(result), self.scale, self.symbols)
        fit = _concluded(answer, self.name, self.band, self.masks, self.taken)
        if not shared:
            return fit
        note = say("one low-pass filter is shared by the channels {channels}", channels=join(", ", shared.channels))
        return replace(fit, notes=(*fit.notes, note))


def whittle(record: Record, symbols: Sequence[str], band: Band = "auto", **options: Any) -> Fit:
    """Identify terms by the binned DCT-II Whittle likelihood: a concluded search; parameters as for `pending`."""
    # Sinusoids are detected and removed. The components of the record, its low-pass filter, vibration, steps, a
    # warm-up, Gauss-Markov noise, are searched for by 2 L and a price for each (`search`); each coefficient is averaged
    # over the models that are consistent with the record (`laws`), with upper limits for what is absent; the signed
    # ramp is estimated by generalized least squares, averaged over what hides it.
    return pending(record, symbols, band, **options).fit()


def pending(
    record: Record, symbols: Sequence[str], band: Band = "auto", *, masks: Sequence[tuple[float, float]] = (),
    lines: bool = True, rival: bool = False,
) -> Pending:  # fmt: skip
    """The search in a record without its sinusoids."""
    why = refusal(record)
    if why:
        raise DataError(say("{channel}: {reason}", channel=record.name or say("the record"), reason=why))
    bins, taken = spectrum(record, detrend=deterministic(symbols)), tuple[Line, ...]()
    if lines:
        bins, taken = _without_lines(record, bins, symbols, band, masks)
    moves = None
    if rounding_of(record).sparse:
        # what rounding without dither adds follows the signal: no vibration, nor anything else that is to be described
        moves = tuple(move for move in moves_for(band, rival=rival) if move is not resonances)
    return pending_of(bins, record, symbols, band, masks=masks, rival=rival, taken=taken, moves=moves)


def deterministic(symbols: Sequence[str]) -> bool:
    """Whether there is a ramp among the terms."""
    return any(TERMS[s].scatters and TERMS[s].waveform is not None for s in symbols)


def explaining(record: Record, symbols: Sequence[str]) -> Fit | None:
    """The fit of the terms to all frequencies of a record without sinusoids; None if they do not explain it."""
    fit = whittle(record, symbols, "all", lines=False)
    good = fit.goodness
    return fit if good is not None and good.explained and not fit.findings else None


def pending_of(
    bins: BinnedSpectrum, like: Record, symbols: Sequence[str], band: Band = "auto", *,
    masks: Sequence[tuple[float, float]] = (), rival: bool = False, taken: tuple[Line, ...] = (),
    moves: Sequence[Move] | None = None,
) -> Pending:  # fmt: skip
    """The search in the spectrum of a record, or of a stream of such; `taken` are sinusoids removed before."""
    bins = bins.near_one()  # so that no unit and no size of a record changes a digit
    result = searched(bins, symbols, band, masks, rival=rival, moves=moves)
    scale = Scale(like.signal, bins.rate, bins.unit_factor, bins.slope)
    automatic = band == "auto" and rival and not masks and moves is None
    return Pending(result, scale, tuple(symbols), like.name, band, masks, automatic, taken)


def searched(
    bins: BinnedSpectrum, symbols: Sequence[str], band: Band, masks: Sequence[tuple[float, float]] = (), *,
    rival: bool, moves: Sequence[Move] | None = None,
) -> Searched:  # fmt: skip
    """The search in a spectrum for what a user asked for."""
    choice, asked = _frequencies(band)
    frame = frame_of(bins, [s for s in symbols if TERMS[s].scatters], bins.read(asked, masks))
    if len(frame.asked) > MOST_ASKED:
        raise UsageError(
            f"at most two noises with a time constant or a frequency can be looked for at a time, not "
            f"{', '.join(frame.asked)}",
            choice="terms",
        )
    ways = tuple(moves or moves_for(band, rival=rival))
    if any(len(TERMS[s].parameters) > 1 for s in frame.asked):  # an oscillation is a resonance by another name
        ways = tuple(move for move in ways if move is not resonances)
    return search(
        frame, starts_for(frame, symbols), moves=ways,
        unexplained=choice == "auto" and moves is None,
    )  # fmt: skip


def moves_for(band: Band, *, rival: bool) -> tuple[Move, ...]:
    """What is looked for: everything; in a band no filter; with all frequencies asked for, no vibration either."""
    choice, _ = _frequencies(band)
    omitted = {"auto": (), "asked": ("filters", "floors"), "all": ("filters", "floors", "resonances")}[choice]
    without = (*omitted, *(() if rival else ("markov", "exponents")))
    return tuple(move for move in MOVES if move.__name__ not in without)


def starts_for(frame: Frame, symbols: Sequence[str]) -> list[State]:
    """Where the search begins: without a shape, and with each of those asked for, at the best of a grid."""
    starts = [State()] if frame.powers else []
    parts = [shapes_of(frame, symbol) for symbol in frame.asked]
    for own in parts:
        starts += [State().having(part) for part in _best_of(frame, own, State())]
    if len(parts) == 2:
        for first in _best_of(frame, parts[0], State()):
            beside = State().having(first)
            starts += [beside.having(part) for part in _best_of(frame, parts[1], beside)]
    if any(TERMS[s].transient for s in symbols) and frame.able_to_warm_up:
        starts += [start.having(*_best_of(frame, warm_ups_of(frame), start, 1)) for start in starts[:1]]
    return starts


def shapes_of(frame: Frame, symbol: str) -> list[Part]:
    """Shapes of a term on a grid of its parameters."""
    fast = next((s for s in TERMS if TERMS[s].second == symbol), symbol)
    axes = [
        np.geomspace(low, high, max(2, round(p.steps * np.log10(high / low)))).tolist()
        for p in TERMS[symbol].parameters if p.search is not None for low, high in [p.search(frame.size)]
    ]  # fmt: skip
    return [Part("noise", fast, shape) for shape in product(*axes)]


def _best_of(frame: Frame, parts: list[Part], beside: State, most: int = 3) -> list[Part]:
    """The parts of a grid beside a state of the least value."""
    fits = [(fitted(frame, beside.having(part)).value, i) for i, part in enumerate(parts)]
    return [parts[i] for _, i in sorted(fits)[:most]]


def _without_lines(
    record: Record, bins: BinnedSpectrum, symbols: Sequence[str], band: Band, masks: Sequence[tuple[float, float]]
) -> tuple[BinnedSpectrum, tuple[Line, ...]]:
    """The spectrum of a record without its sinusoids, and these; its own spectrum if there are none."""
    asked = _frequencies(band)[1]
    frame = frame_of(bins, [s for s in symbols if TERMS[s].scatters], bins.read(asked, masks))
    if not frame.powers:
        return bins, ()
    level = _level(pruned(fitted(frame, State())))
    if not suspected(bins, level, frame.used):
        return bins, ()
    # between the lobes of a filter the noise is low, and what is at their tops is no line
    level = _level(searched(bins, symbols, band, masks, rival=True, moves=SMOOTH).best)
    if not suspected(bins, level, frame.used):
        return bins, ()
    rates = known_rates(record)
    mean = float(np.nanmean(rates))
    low, high = (0.0, record.rate / 2) if asked is None else asked
    waves, _ = waves_of(rates - mean, bins, level, (low / record.rate, high / record.rate))
    if not waves:
        return bins, ()
    scale = [bins.unit_factor / float(np.sinc(wave.frequency)) for wave in waves]
    lines = tuple(
        Line(wave.frequency * record.rate, wave.amplitude * s, wave.error * s, wave.phase, record.signal)
        for wave, s in zip(waves, scale, strict=True)
    )
    # the record without sinusoids; an angle stays one, which knows more of its gaps; counts become increments
    total = np.sum([wave.values(record.size) for wave in waves], axis=0)
    if record.kind == "angle":
        total = np.concatenate(([0.0], np.cumsum(total)))
    removed = say_count(len(waves), "{count} sinusoid removed", "{count} sinusoids removed")
    rest = record.with_values(record.values - total, removed, start=record.start)
    return spectrum(rest, detrend=bins.detrended), tuple(sorted(lines, key=lambda line: line.frequency))


def _level(f: Fitted) -> FloatArray:
    """The power of the noise in every bin."""
    m = f.frame.spectrum.power.copy()
    m[f.frame.used] = f.m
    return levels(f.frame.spectrum, m)


def _frequencies(band: Band) -> tuple[str, tuple[float, float] | None]:
    """How the frequencies are chosen, and those that were asked for."""
    return (band, None) if isinstance(band, str) else ("asked", band)


def _concluded(
    answer: Answer, name: str, band: Band, masks: Sequence[tuple[float, float]], taken: tuple[Line, ...]
) -> Fit:
    """The fit, from the models of the average."""
    choice, asked = _frequencies(band)
    scope = scope_of(answer, choice, asked, tuple((float(a), float(b)) for a, b in masks))
    weights, best = answer.weights, answer.best
    warm = WarmUp(answer, best) if weights.get("warm-up", 0.0) >= CLAIMED and best.state.of("warm-up") else None
    estimates = _estimates(answer, scope, warm)
    findings: list[Finding] = [warm.finding] if warm else []
    steps = steps_of(answer, best) if weights.get("step", 0.0) >= CLAIMED else ()
    if steps:
        findings.append(steps_finding(answer, best, steps))
    lines = taken
    if weights.get("wave", 0.0) >= CLAIMED and best.state.of("wave"):
        lines = (wave := wave_of(answer, best), *taken)
        findings.append(wave_finding(wave))
    if weights.get("exponent", 0.0) >= CLAIMED and best.state.of("exponent"):
        findings.append(exponent_finding(answer, best))
        a = best.state.of("exponent")[0].shape[0]
        estimates = {s: under(a, e) for s, e in estimates.items()}
    hidden = not shows_white(best)
    if hidden or len(best.state.of("resonance")) >= RESONANCES:
        findings.append(vibration_finding(hidden=hidden))
    model = _model(estimates, answer)
    deterministic_terms = tuple(t for t in model if t.row.waveform is not None and t.row.scatters)
    return Fit(estimates=tuple(estimates.values()), method="whittle", signal=answer.scale.signal, name=name,
               model=Model((*model, *(line.term for line in lines))), goodness=_goodness(answer, taken),
               correlation=_correlation(list(estimates), answer.shown),
               notes=(*(f.what for f in findings), *notes_of(answer, estimates)), lines=lines,
               rivals=Remembered(partial(alternatives, answer)),
               nodes=Remembered(partial(answer.nodes, deterministic_terms)), scope=scope, findings=tuple(findings),
               warm_up=warm.term if warm else None, steps=steps, components=components_of(answer),
               cutoff=Remembered(cutoff_law(answer)) if choice == "auto" else None)  # fmt: skip


def _estimates(answer: Answer, scope: Scope, warm: WarmUp | None) -> dict[str, Estimate]:
    """Estimates of the terms that were asked for, and of Gauss-Markov noise that is beside them."""
    terms = [s for s in answer.symbols if TERMS[s].scatters]
    estimates = {s: noise_estimate(s, answer) for s in terms if TERMS[s].waveform is None}
    estimates |= {s: ramp_estimate(s, answer) for s in terms if TERMS[s].waveform is not None}
    if not answer.result.frame.asked:
        more = (noise_estimate(s, answer) for s in ("GM", "GML") if claims(s, answer))
        estimates |= {e.symbol: e for e in more if e.claimed}
    estimates = {s: observable(e, scope, answer) for s, e in estimates.items()}
    return estimates | {s: warm_up_estimate(s, warm, answer) for s in answer.symbols if TERMS[s].transient}


def _model(estimates: dict[str, Estimate], answer: Answer) -> Model:
    """The best model: its noise terms, claimed or not, and a ramp and a warm-up that are claimed."""
    known = [e for s, e in estimates.items() if TERMS[s].waveform is not None]
    given = [Term(e.symbol, e.value, answer.scale.signal, e.shape) for e in known if e.value is not None]
    return Model((*answer.scale.terms(answer.shown), *given))


def _correlation(shown: Sequence[str], f: Fitted) -> FloatArray:
    """Correlation of the estimates of the selected noise terms, shape (terms, terms); NaN for the others."""
    names = [*f.frame.powers, *(p.label for p in f.state if COMPONENTS[p.name].inside)]
    free = [s for s, is_free in zip(names, f.free, strict=False) if is_free]
    known = [(i, free.index(s)) for i, s in enumerate(shown) if s in free]
    matrix = np.full((len(shown), len(shown)), np.nan)
    if known:
        at, which = map(list, zip(*known, strict=True))
        matrix[np.ix_(at, at)] = correlation(subset_of(f))[np.ix_(which, which)]
    return matrix


def _goodness(answer: Answer, taken: tuple[Line, ...]) -> Goodness:
    """Goodness of fit, once, of the averaged model: it refuses, and it never chooses."""
    f = answer.best
    heavy = [e for e in answer.entries if e.weight > LEAST_SHOWN]
    m = np.sum([e.weight * e.f.m for e in heavy], axis=0) / sum(e.weight for e in heavy)
    power = f.completed[0][: m.size]
    cell, bounds = cells_of(f.frame.spectrum, f.frame.used)
    lost = lost_freedom(f, cell, bounds.size - 1)
    return goodness(
        f.frame.spectrum, f.frame.used, power=power, m=m, count=f.trusted.count, lost=lost, loud=loud_in(f), taken=taken
    )


def alternatives(answer: Answer) -> tuple[Alternative, ...]:
    """The other models of the average, one of each set of terms, the best first."""
    shown = answer.scale.terms(answer.shown)
    known = {tuple(t.symbol for t in shown)}
    others = []
    for f in sorted((e.f for e in answer.entries), key=lambda f: f.score):
        terms = answer.scale.terms(f)
        symbols = tuple(t.symbol for t in terms)
        if terms and symbols not in known and not f.state.lacks_flicker:
            known.add(symbols)
            others.append(Alternative(Model(terms), f.score - answer.shown.score))
    return tuple(others)
