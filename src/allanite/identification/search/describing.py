"""What a fit says besides its numbers: the filter, vibration and undescribed power in it, and rivals of its terms."""

import math
from collections.abc import Iterator

import numpy as np

from allanite.core.arrays import BoolArray, FloatArray, IntArray
from allanite.core.estimate import Estimate
from allanite.core.fit import Component
from allanite.core.kinds import title_of
from allanite.core.model import Term, coefficient_factor
from allanite.core.validity import LowPass, Scope
from allanite.identification.likelihood.filters import FILTERS
from allanite.identification.likelihood.spectrum import WELL_KNOWN, surroundings
from allanite.phrases.phrase import join, say, spelled
from allanite.terms import TERMS

from .components import CLAIMED, COMPONENTS, LONGEST_MARKOV, Part
from .cutoffs import errors_in, quantile_of
from .estimates import Answer, shaped_terms
from .fitting import Fitted, factor_basis, fitted
from .frame import Frame
from .refining import refined

VISIBLE_DEVIATE = 2.0  # standard deviations by which a factor must differ from 1 to be said
LOUD = 0.5  # share of the power from which vibration, or what nothing describes, hides the terms
RISE_AT_LIMITS = 3.84  # rise of the value at the 95 % limits


def scope_of(
    answer: Answer, choice: str, asked: tuple[float, float] | None, masks: tuple[tuple[float, float], ...]
) -> Scope:
    """Which frequencies were used, and what stands between the terms and the samples."""
    f, spectrum = answer.shown, answer.result.frame.spectrum
    used = f.frame.used
    bare = bare_power(answer)
    ratio = spectrum.power / np.maximum(bare, 1e-300)
    around = surroundings(ratio * spectrum.count).sum(axis=1) / surroundings(spectrum.count).sum(axis=1)
    level = np.where(spectrum.count > WELL_KNOWN, ratio, around)
    level[used] = f.m / np.maximum(bare[used], 1e-300)
    whole = not f.state.parts or not any(p.name in ("filter", "floor", "resonance", "factor") for p in f.state)
    if whole:
        level[used] = 1.0
    first, last = np.flatnonzero(used)[[0, -1]]
    low = float(spectrum.frequency(spectrum.first[first])) if first else 0.0
    high = spectrum.first[last] + spectrum.count[last] - 0.5
    band = asked or (low, spectrum.rate / 2 if last == used.size - 1 else float(spectrum.frequency(high)))
    misfit, within = misfit_of(answer)
    return Scope(choice=choice, band=band, masks=masks, filter=low_pass(answer), misfit=misfit, within=within,
                 frequency=spectrum.frequency(spectrum.first + (spectrum.count - 1) / 2), level=level, remarks=(),
                 disturbed=disturbed(f))  # fmt: skip


def bare_power(answer: Answer) -> FloatArray:
    """Power of the terms of the fit that is shown in every bin, without filter and factors, shape (all bins,)."""
    f = answer.shown
    frame, everywhere = f.frame, f.frame
    if not frame.used.all():
        everywhere = Frame(frame.spectrum, frame.powers, (), np.ones_like(frame.used))
    power = np.zeros(everywhere.count.size)
    columns = [everywhere.table(s) for s in f.frame.powers]
    columns += [everywhere.column(symbol if symbol != "GML" else "GM", shape) for symbol, shape in shaped_terms(f)]
    for column, theta in zip(columns, f.theta.tolist(), strict=False):
        power = power + theta * column
    return power


def low_pass(answer: Answer) -> LowPass | None:
    """The filter of the heaviest models that have one, if they outweigh the others; its cut-off over all its rows."""
    having = [e for e in answer.entries if e.f.state.filter is not None]
    if sum(e.weight for e in having) < CLAIMED:
        return None
    part = having[0].f.state.filter
    assert part is not None  # noqa: S101 - they have one
    if answer.result.frame.common:
        common = answer.result.frame.common[0]  # in all channels the same
        cutoff, least, most = (c * answer.scale.rate for c in (common.cutoff, common.low, common.high))
        return LowPass(common.row, FILTERS[common.row].title, cutoff, least, most, answer.scale.rate)
    w = np.array([e.weight for e in having])
    centre, spread = np.log([p.shape[0] for e in having for p in e.f.state.of("filter")]), errors_in(having)
    low, high = (quantile_of(w / w.sum(), centre, spread, p) for p in (0.025, 0.975))
    rate, widest = answer.scale.rate, FILTERS[part.label].widest
    c = part.shape[0]
    return LowPass(part.label, FILTERS[part.label].title, c * rate, min(math.exp(low), c) * rate,
                   max(math.exp(min(high, math.log(widest))), c) * rate, rate)  # fmt: skip


def misfit_of(answer: Answer) -> tuple[float, float]:
    """Size of the largest claimed factor, and its largest visible effect on the power; 0 without one."""
    f = answer.shown
    factors = f.state.of("factor")
    if not factors or answer.weights.get("factor", 0.0) < CLAIMED:
        return 0.0, 0.0
    u, error = factor_of(f)
    beyond = np.maximum(np.abs(u) - VISIBLE_DEVIATE * error, 0.0)
    return max(p.shape[2] for p in factors), float(np.expm1(min(beyond.max(), 20.0)))


def factor_of(f: Fitted) -> tuple[FloatArray, FloatArray]:
    """The logarithm u of the factors of a fit in the bins, and its standard error."""
    A = factor_basis(f.frame, f.state)
    k = f.v.size
    C = f.covariance[-k:, -k:]
    return A @ f.v, np.sqrt(np.maximum(np.einsum("bi,ij,bj->b", A, C, A), 0.0))


def loud_in(f: Fitted) -> BoolArray:
    """Bins in which resonances have most of the power, shape (bins,)."""
    count = len(f.state.of("resonance"))
    if not count:
        return np.zeros(f.m.size, dtype=bool)
    return np.asarray((f.likelihood.S[:, -count:] @ f.theta[-count:]) / f.m > LOUD)


def disturbed(f: Fitted) -> tuple[tuple[float, float], ...]:
    """Frequencies, Hz, at which resonances have most of the power: the terms cannot be compared there."""
    return _runs(f.frame, loud_in(f))


def _runs(frame: Frame, which: BoolArray) -> tuple[tuple[float, float], ...]:
    """Runs of bins, Hz."""
    ends = np.flatnonzero(np.diff(np.concatenate(([0], which.astype(np.int8), [0])))).reshape(-1, 2)
    spectrum, first = frame.spectrum, frame.first
    count = spectrum.count[frame.used]
    return tuple(
        (float(spectrum.frequency(first[a] - 0.5)), float(spectrum.frequency(first[b - 1] + count[b - 1] - 0.5)))
        for a, b in ends
    )


def components_of(answer: Answer) -> tuple[Component, ...]:
    """Every component of the models, with the weight of those that hold it and what it is in the heaviest of them."""
    each = []
    for name, weight in answer.weights.items():
        f = next(e.f for e in answer.entries if e.f.state.of(name))
        for part in f.state.of(name):
            low, high = _span(f, part)
            each.append(Component(name, weight, _words(answer, f, part), low, high))
    return tuple(each)


def _span(f: Fitted, part: Part) -> tuple[float, float]:
    """Frequencies, Hz, between which a part changes the spectrum."""
    rate = f.frame.spectrum.rate
    if part.name == "resonance":
        centre, half = part.shape[0] * rate / (2 * math.pi), 0.5 / part.shape[1]
        return centre * (1 - min(half, 0.9)), min(centre * (1 + half), rate / 2)
    if part.name == "factor":
        u, error = factor_of(f)
        runs = _runs(f.frame, np.abs(u) > VISIBLE_DEVIATE * error)
        return (min(a for a, _ in runs), max(b for _, b in runs)) if runs else (0.0, rate / 2)
    if part.name == "filter":
        return part.shape[0] * rate, max(rate / 2, part.shape[0] * rate)
    return 0.0, 0.0


def _words(answer: Answer, f: Fitted, part: Part) -> str:  # noqa: PLR0911 - one sentence a row
    """A part as text."""
    rate = answer.scale.rate
    if part.name == "filter" and answer.result.frame.common:
        part = part._replace(label=answer.result.frame.common[0].row, shape=(answer.result.frame.common[0].cutoff,))
    if part.name == "filter":
        return say("{filter}, -3 dB at {cutoff:.3g} Hz", filter=FILTERS[part.label].title, cutoff=part.shape[0] * rate)
    if part.name == "floor":
        return say("white noise behind the filter")
    if part.name == "resonance":
        return say("vibration at {frequency:.3g} Hz (quality {quality:.2g})",
                   frequency=part.shape[0] * rate / (2 * math.pi), quality=part.shape[1])  # fmt: skip
    if part.name == "noise":
        term = Term(part.label, 0.0, answer.scale.signal, answer.scale.shape(part.label, part.shape))
        return say("{term} with {shape}", term=TERMS[part.label].title, shape=term.shape_words)
    if part.name == "exponent":
        return say("noise of density f^-{exponent:.2f}", exponent=part.shape[0])
    if part.name == "step":
        return say("step at {time:.4g} s", time=f.frame.spectrum.cut + part.shape[0] / rate)
    if part.name == "warm-up":
        return say("warm-up with a time constant of {time:.3g} s", time=part.shape[0] / rate)
    if part.name == "wave":
        return say("slow wave with a period of {time:.3g} s", time=f.frame.spectrum.size / part.shape[0] / rate)
    return _factor_words(f)


def _factor_words(f: Fitted) -> str:
    """Where the power differs from that of the terms."""
    u, error = factor_of(f)
    spans = []
    for sign in (1, -1):
        for a, b in _runs(f.frame, sign * u > VISIBLE_DEVIATE * error):
            first = f.frame.spectrum.frequency(f.frame.centre)
            inside = (first >= a) & (first <= b)
            at = float(np.max(sign * u[inside])) * sign
            change = 100 * math.expm1(min(at, 20.0))
            spans.append(say("{change:+.0f} % from {low:.2g} to {high:.2g} Hz", change=change, low=a, high=b))
    size = max(p.shape[2] for p in f.state.of("factor"))
    if not spans:
        return say("the power differs by some {size:.2g} % an octave from that of the terms", size=100 * size)
    return say("the power differs from that of the terms: {spans}", spans=join(", ", spans))


def notes_of(answer: Answer, estimates: dict[str, Estimate]) -> list[str]:
    """Two explanations of one record, and which terms others could replace."""
    return [*_two_explanations(answer, estimates), *_undecided(answer, estimates), *_no_walk(answer, estimates)]


def _two_explanations(answer: Answer, estimates: dict[str, Estimate]) -> Iterator[str]:
    frame, scale = answer.result.frame, answer.scale
    for symbol in (s for s, e in estimates.items() if s in frame.powers and e.claimed):
        law = answer.laws[frame.powers.index(symbol)]
        if law is not None and law.modes:
            unit = scale.signal.sheet[TERMS[symbol].power]
            size = coefficient_factor(symbol, unit, scale.signal)
            first, second = (f"{scale.coefficient(symbol, root) / size:.3g}" for root in law.modes)
            yield say("{symbol}: two explanations of the record, {first} or {second} {unit}; a longer record would "
                      "decide", symbol=symbol, first=first, second=second, unit=unit)  # fmt: skip


def _undecided(answer: Answer, estimates: dict[str, Estimate]) -> Iterator[str]:
    """That something drifts, but none of the terms that do is claimed."""
    frame = answer.result.frame
    slow = [frame.powers[i] for i in np.flatnonzero(frame.slow)]
    names = [s for s in slow if s in estimates] + ["GM"]
    drifting = (e.f.theta[: len(frame.powers)][frame.slow].any() or e.f.state.of("noise") for e in answer.entries)
    weight = sum(e.weight for e, drifts in zip(answer.entries, drifting, strict=True) if drifts)
    likely = [s for s in names if _weight_of(answer, s) > 1 - CLAIMED]
    if slow and likely and weight >= CLAIMED and not any(estimates[s].claimed for s in names if s in estimates):
        yield say("the bias drifts, but the record does not decide between {terms}: a longer record would",
                  terms=join(", ", [f"{s} ({title_of(s, answer.scale.signal)})" for s in likely]))  # fmt: skip


def _no_walk(answer: Answer, estimates: dict[str, Estimate]) -> Iterator[str]:
    """That a random walk may as well be slow Gauss-Markov noise."""
    frame = answer.result.frame
    walks = (s for s, slow in zip(frame.powers, frame.slow.tolist(), strict=True) if slow and TERMS[s].slope > 0)
    walk = next(walks, None)
    if walk and walk in estimates and estimates[walk].claimed and "GM" not in frame.asked:
        least = least_time_constant(answer, frame.powers.index(walk))
        if least is not None and "GM" in estimates:
            terms = ",".join([s for s, e in estimates.items() if e.claimed and s != walk] + ["GM"])
            yield say("{walk} may as well be a second Gauss-Markov noise, with a time constant of more than {time:.2g} "
                      "s ({option})", walk=walk, time=least / answer.scale.rate,
                      option=spelled(f"--terms {terms}", f"terms={terms!r}"))  # fmt: skip
        elif least is not None:
            yield say("{walk} may as well be Gauss-Markov noise with a time constant of more than {time:.2g} s",
                      walk=walk, time=least / answer.scale.rate)  # fmt: skip


def _weight_of(answer: Answer, symbol: str) -> float:
    powers = answer.result.frame.powers
    if symbol in powers:
        return sum(e.weight for e in answer.entries if e.f.free[powers.index(symbol)])
    return sum(e.weight for e in answer.entries if e.f.state.of("noise"))


def least_time_constant(answer: Answer, walk: int) -> float | None:
    """The least time constant, in samples, of Gauss-Markov noise that could stand in the place of a random walk."""
    # None where none within the record could.
    f, frame = answer.shown, answer.result.frame
    if not f.free[walk] or len(f.state.of("noise")) >= COMPONENTS["noise"].most:
        return None
    free = np.ones(f.theta.size, dtype=bool)
    free[walk] = False
    with_walk = refined(fitted(frame, f.state, None, f, f.v), 2).value
    times = np.geomspace(LONGEST_MARKOV * frame.size, 30.0, 24)
    values = [fitted(frame, f.state.having(Part("noise", "GM", (T,))), free).value for T in times.tolist()]
    return min(
        (T for T, value in zip(times.tolist(), values, strict=True) if value < with_walk + RISE_AT_LIMITS), default=None
    )


def lost_freedom(f: Fitted, cell: IntArray, cells: int) -> float:
    """Degrees of freedom that sizes and shapes take of the cells: the trace of their hat matrix."""
    active = f.theta > 0
    m, h = f.m, f.trusted.count / 2
    Z = np.column_stack((f.likelihood.S[:, active], f.slopes.T)) / m[:, None] * np.sqrt(h)[:, None]
    nu = np.bincount(cell, h, cells)
    T = np.zeros((cells, Z.shape[1]))
    np.add.at(T, cell, Z * np.sqrt(h / nu[cell])[:, None])
    return float(np.einsum("ci,ij,cj->", T, f.covariance, T))
