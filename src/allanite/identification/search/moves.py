"""The neighbours of a state: what may be added, left out or exchanged, judged first by one step of scoring.

The gain of a direction c of the expected power, from the score b = sum nu/2 c (I/m - 1) / m and its information G with
all sizes and shapes projected out, is b^2 / G in 2 L. It costs one product of matrices for all candidates at a time;
those that could not come within `REACH` of the best state are not fitted. Far from a fit one step is no guide, and the
candidates themselves are fitted.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from allanite.core.arrays import BoolArray, FloatArray
from allanite.identification.likelihood.filters import FILTERS
from allanite.identification.likelihood.whittle import Pair, step_coefficients, warm_up_direction

from .components import (
    AT_BOUND,
    BROAD,
    COMPONENTS,
    FACTORS,
    HIDING,
    LEAST_MARKOV,
    LONGEST_MARKOV,
    LONGEST_WARM_UP,
    PERIODS,
    QUICKEST_MARKOV,
    SHORTEST_WARM_UP,
    SIZES,
    Part,
    cost_of,
)
from .factors import SLOW
from .fitting import Fitted, column_of_part, factor_basis, fitted, refined
from .frame import LOW, Frame
from .state import State

REACH = 8.0
"""States up to this above the least score are kept: a weight of e^-4."""

FAR = 60.0
"""Gain in 2 L above which one step is no guide."""

PER_DECADE, INSIDE = 4, 1.05
"""Time constants a decade that are tried, and the factor by which they stay inside their bounds."""

PLACES, FINE = 512, 61
"""Places at which a step is looked for, and places between the neighbours of the best."""

QUALITIES = (2.5, 6.0, 15.0, 40.0, 120.0)
"""Qualities with which resonances are looked for."""

CANDIDATES = 3
"""Candidates of a row that are fitted, at most."""

MISSED = 40.0
"""Rise of the value by one step above which a part is not left out, or its numerator exchanged: what is refined beside
it makes up for less."""

EQUAL = 0.5
"""Change of the value up to which the numerators of a resonance are the same: those of a sharp one are."""

BINS = 8
"""Bins that stand out at which resonances are looked for."""

FACTOR_SIZES = np.array([0.01, 0.02, 0.04, 0.08, 0.16, 0.32, 0.64, 1.28, 2.56])
"""Sizes of a factor that are tried, RMS of the logarithm of the power."""

CHANCE = 6.0
"""Standard deviations of a bin's power above which a residual is a misfit."""

SHORT, LEAST_EVIDENCE = 4.0, 1.5
"""Evidence for a factor, in 2 L, from which it is fitted: so much below its price, where it weighs e^-1 of the state
without it, and at least so much, as a factor of no size has none."""

WIDE_SIZES, MANY = (0.64, 2.56), 14
"""Sizes of a factor that are fitted where one step is no guide, and rounds of scoring of these fits: each
divides the power by e^2 at most."""

WARM_UPS = 11
"""Time constants of a warm-up that are tried, from a hundredth of the record on."""


@dataclass(frozen=True, eq=False)
class Local:
    """A fit as one step of scoring knows it."""

    f: Fitted

    @cached_property
    def over(self) -> FloatArray:
        """Residuals; those beyond chance count by their logarithm: far from a fit their squares would decide."""
        r = self.f.residual
        return np.where(np.abs(r) * np.sqrt(self.h) > CHANCE, self.logs, r)

    @cached_property
    def logs(self) -> FloatArray:
        """Logarithms of the power over the expected one."""
        return np.asarray(np.log1p(np.maximum(self.f.residual, -1 + 1e-9)))

    @cached_property
    def h(self) -> FloatArray:
        """Half the counts."""
        return self.f.trusted.count / 2

    @cached_property
    def _own(self) -> tuple[FloatArray, FloatArray]:
        """Directions of the sizes and shapes, relative to m, and the root of their inverse information."""
        f = self.f
        H, active = f.information
        Z = np.column_stack((f.likelihood.S[:, active], f.slopes.T)) / f.m[:, None]
        size = np.sqrt(np.maximum(np.diag(H), 1e-300))
        values, vectors = np.linalg.eigh(H / np.outer(size, size))
        root = vectors / np.sqrt(np.maximum(values, 1e-9)) / size[:, None]
        return Z, root

    def projected(self, C: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Scores and informations of directions, relative to m, shape (k, bins): b (k,), G (k, k) by its rows."""
        Z, root = self._own
        rest = (C * self.h) @ Z @ root
        return C @ (self.h * self.over), rest

    def gains(self, C: FloatArray, *, signed: bool = False) -> FloatArray:
        """Gains of directions, shape (k,)."""
        b, rest = self.projected(C)
        G = np.maximum((C * C) @ self.h - (rest * rest).sum(axis=1), 1e-9 * ((C * C) @ self.h) + 1e-300)
        gain = b * b / G
        return gain if signed else np.where(b > 0, gain, 0.0)

    def loss(self, part: Part) -> float:
        """What the value would rise by without a part whose size is a column, by one step; 0 for others."""
        f = self.f
        which = column_of_part(f.state, f.frame, part)
        if which is None or f.theta[which] <= 0:
            return 0.0
        H, active = f.information
        at = int(active[:which].sum())
        size = np.sqrt(np.maximum(np.diag(H), 1e-300))
        variance = np.linalg.pinv(H / np.outer(size, size), hermitian=True)[at, at] / size[at] ** 2
        return float(f.theta[which] ** 2 / max(variance, 1e-300))

    def able(self, gain: float, cost: float) -> bool:
        """Whether a candidate may come within reach of the best state."""
        return gain > cost - REACH


Move = Callable[[Local], Iterator[State | Fitted]]
"""From a fit to the states beside it that are worth fitting, or to their fits where these are known already."""


def less(at: Local) -> Iterator[State]:
    """Without each of its parts that may be missed; a filter takes its floor along."""
    for part in dict.fromkeys(at.f.state):
        if at.loss(part) > cost_of(part, at.f.frame) + MISSED:
            continue
        rest = at.f.state.lacking(part)
        yield rest.lacking(*rest.of("floor")) if part.name == "filter" else rest


def exchanged(at: Local) -> Iterator[State]:
    """With another numerator of a resonance, beyond `BROAD` where it stops there, or another filter of that cut-off."""
    state = at.f.state
    for part in state.of("resonance"):
        other = "flat" if part.label == "high-pass" else "high-pass"
        flipped = state.lacking(part).having(part._replace(label=other))
        if abs(rise := fitted(at.f.frame, flipped, at.f.free).value - at.f.value) > EQUAL and rise < MISSED:
            yield flipped
        if abs(math.log(part.shape[1] / BROAD)) < AT_BOUND:
            beyond = BROAD / INSIDE if part.shape[1] >= BROAD else BROAD * INSIDE
            yield state.lacking(part).having(part._replace(shape=(part.shape[0], beyond)))
    if state.filter is None:
        return
    rest, cutoff = state.lacking(state.filter), state.filter.shape[0]
    tries = []
    for row, filter_ in FILTERS.items():
        if row != state.filter.label:
            near = [c for c in (0.8 * cutoff, cutoff, 1.25 * cutoff) if LOW_CUT < c < filter_.widest]
            tries += [fitted(at.f.frame, rest.having(Part("filter", row, (c,)))) for c in near]
    for f in sorted(tries, key=lambda f: f.value)[:CANDIDATES]:
        yield f.state


LOW_CUT = 0.0101
"""Cycles a sample: just above the lowest cut-off."""


def floors(at: Local) -> Iterator[State]:
    """White noise behind the filter."""
    state, part = at.f.state, Part("floor", "", ())
    if state.filter is None or state.of("floor") or state.filter.shape[0] < HIDING:
        return
    passed = at.f.frame.gain(state.filter.label, state.filter.shape[0])
    if at.able(float(at.gains(((1 - passed) / at.f.m)[None])[0]), cost_of(part, at.f.frame)):
        yield state.having(part)


def time_constants(n: int) -> FloatArray:
    """Of Gauss-Markov noise, that are tried first."""
    high = max(LONGEST_MARKOV * n, 2 * LEAST_MARKOV)
    steps = max(4, round(PER_DECADE * math.log10(high / QUICKEST_MARKOV)))
    return np.geomspace(QUICKEST_MARKOV * INSIDE, high / INSIDE, steps)


def markov(at: Local) -> Iterator[State]:
    """Gauss-Markov noise."""
    frame, state = at.f.frame, at.f.state
    if len(state.of("noise")) >= COMPONENTS["noise"].most or any(len(p.shape) > 1 for p in state.of("noise")):
        return
    parts = [Part("noise", "GM", (T,)) for T in time_constants(frame.size).tolist()]
    yield from _promising(at, parts, np.array([frame.column("GM", p.shape) for p in parts]) * _acting(at.f))


def _acting(f: Fitted) -> FloatArray:
    """What the filter and the factors make of noise in the sensor, over m."""
    frame, first = f.frame, next((p for p in f.state if COMPONENTS[p.name].inside), None)
    if frame.powers:
        bare = frame.table(frame.powers[0])
    else:  # one noise with a shape was asked for, at least
        power = COMPONENTS[first.name].power if first else None
        bare = power(frame, first) if first and power else np.ones(1)
    return np.asarray(f.likelihood.S[:, 0] / np.maximum(bare, 1e-300) / f.m)


def _promising(at: Local, parts: list[Part], C: FloatArray, *, signed: bool = False, most: int = 2) -> Iterator[State]:
    """The best parts by one step; by a fit of each where that is no guide."""
    state, gain = at.f.state, at.gains(C, signed=signed)
    able = [i for i in np.argsort(-gain) if at.able(float(gain[i]), cost_of(parts[i], at.f.frame))]
    if not able:
        return
    if gain[able[0]] > FAR:
        tries = [fitted(at.f.frame, state.having(part), None, None) for part in parts]
        yield from (f.state for f in sorted(tries, key=lambda f: f.value)[:most])
        return
    for i in able[:most]:
        yield state.having(parts[i])


def exponents(at: Local) -> Iterator[State]:
    """A power law in the place of flicker, where there is noise at low frequencies."""
    frame, state = at.f.frame, at.f.state
    if frame.flicker is None or state.of("exponent") or not (at.f.theta[: frame.slow.size][frame.slow] > 0).any():
        return
    tries = [fitted(frame, state.having(Part("exponent", "", (a,)))) for a in (0.75, 0.85, 1.2, 1.4, 1.55)]
    yield min(tries, key=lambda f: f.value).state


def filters(at: Local) -> Iterator[State]:
    """A low-pass filter: the best cut-off of each row, as their shapes are rivals."""
    frame, state = at.f.frame, at.f.state
    if state.filter is not None:
        return
    tries, logs = frame.log_gains
    gain = at.gains(logs * (at.f.inside / at.f.m), signed=True)
    cost = COMPONENTS["filter"].cost(frame.size)
    if not at.able(float(gain.max()), cost):
        return
    best: dict[str, tuple[float, float]] = {}
    far = gain.max() > FAR
    for (row, cutoff), g in zip(tries, gain.tolist(), strict=True):
        if not far and not at.able(g, cost):
            continue
        value = fitted(frame, state.having(Part("filter", row, (cutoff,)))).value if far else -g
        best[row] = min(best.get(row, (math.inf, 0.0)), (value, cutoff))
    for row in sorted(best, key=lambda row: best[row])[: 5 if not state.of("resonance") else 2]:
        yield state.having(Part("filter", row, (best[row][1],)))


def peaks(at: Local) -> list[tuple[float, Part]]:
    """Resonances by their gains: the bins that stand out, with several qualities and both numerators."""
    frame = at.f.frame
    able = (frame.first >= 2 * PERIODS) & (at.over > 0) & (frame.centre * np.pi / frame.size < 3.05)
    three = np.ones(3)
    z = np.convolve(at.over * at.h, three, "same") / np.sqrt(np.convolve(at.h, three, "same") + 1e-9)
    order = [int(i) for i in np.argsort(-np.where(able, z, -np.inf)) if able[i]]
    places: list[int] = []
    for i in order:
        if all(abs(math.log(frame.centre[i] / frame.centre[j])) > 0.03 for j in places):
            places.append(i)
        if len(places) == BINS:
            break
    if not places:
        return []
    parts = [
        Part("resonance", label, (float(np.pi / frame.size * frame.centre[i]), q))
        for i in places for q in QUALITIES for label in ("flat", "high-pass")
    ]  # fmt: skip
    power = COMPONENTS["resonance"].power
    assert power is not None  # noqa: S101 - its row has one
    gain = at.gains(np.array([power(frame, p) for p in parts]) / at.f.m)
    return sorted(zip(gain.tolist(), parts, strict=True), key=lambda pair: -pair[0])


def resonances(at: Local) -> Iterator[State]:
    """The best resonances that differ, and all that stand out at once."""
    frame, state = at.f.frame, at.f.state
    room = COMPONENTS["resonance"].most - len(state.of("resonance"))
    cost = COMPONENTS["resonance"].cost(frame.size)
    if room <= 0:
        return
    chosen: list[tuple[float, Part]] = []
    for gain, part in peaks(at):
        if not at.able(gain, cost):
            break
        if all(_apart(part, other) for _, other in chosen):
            chosen.append((gain, part))
    yield from (state.having(part) for _, part in chosen[:CANDIDATES])
    strong = [part for gain, part in chosen if gain > COMPONENTS["resonance"].price(frame.size)]
    distinct: list[Part] = []
    for part in strong:
        if all(
            abs(math.log(part.shape[0] / other.shape[0])) > 0.5 / min(part.shape[1], other.shape[1])
            for other in distinct
        ):
            distinct.append(part)
    if len(distinct) > 1:
        yield state.having(
            *(p if p.shape[1] >= BROAD else p._replace(shape=(p.shape[0], 2 * BROAD)) for p in distinct[:room])
        )


def _apart(one: Part, other: Part) -> bool:
    """Whether two resonances differ."""
    ratio = one.shape[1] / other.shape[1]
    return abs(math.log(one.shape[0] / other.shape[0])) > 0.08 or not 1 / 3 < ratio < 3


def _both(pair: Pair) -> FloatArray:
    """Coefficients of even and of odd index."""
    return pair[0] + pair[1]


def _lowest(at: Local) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The lowest coefficients, their standard deviations, and an orthonormal basis of what is loose in them."""
    frame = at.f.frame
    k = min(LOW, frame.count.size)
    c, root = (frame.spectrum.even + frame.spectrum.odd)[:k], np.sqrt(at.f.m[:k])
    loose = [step_coefficients(frame.size, p.shape[0])[:k] for p in at.f.state.of("step")]
    loose += [_both(warm_up_direction(frame.spectrum, p.shape[0]))[:k] for p in at.f.state.of("warm-up")]
    if frame.ramps:
        ramp = np.zeros(k)
        ramp[: min(k, frame.spectrum.ramp.size)] = frame.spectrum.ramp[:k]
        loose.append(ramp)
    Q = np.linalg.qr((np.array(loose) / root).T)[0] if loose else np.zeros((k, 0))
    return c / root, root, Q


def steps(at: Local) -> Iterator[State]:
    """One more step of the bias, where it gains most beside those of the state and a ramp."""
    frame, state = at.f.frame, at.f.state
    if not frame.able_to_step or len(state.of("step")) >= COMPONENTS["step"].most:
        return
    y, root, Q = _lowest(at)
    apart = frame.size / (PLACES + 1)
    places, gain = apart * np.arange(1, PLACES + 1), np.zeros(1)
    for _ in range(2):
        D = step_coefficients(frame.size, places)[:, : y.size] / root
        D = D - D @ Q @ Q.T
        gain = (D @ y) ** 2 / np.maximum((D**2).sum(axis=1), 1e-9)
        best = float(places[int(gain.argmax())])
        places = best + apart * np.linspace(-1, 1, FINE + 2)[1:-1]
        places = places[(places > 1) & (places < frame.size - 1)]
    if at.able(float(gain.max()), COMPONENTS["step"].cost(frame.size)):
        yield state.having(Part("step", "", (best,)))


def warm_ups_of(frame: Frame) -> list[Part]:
    """Warm-ups that are tried first."""
    return [
        Part("warm-up", "", (tau,))
        for tau in (frame.size * np.geomspace(1 / 100, LONGEST_WARM_UP / INSIDE, WARM_UPS)).tolist()
    ]


def _tuned_warm_up(f: Fitted, rest: State, part: Part) -> State:
    """The state with the best time constant near that of a warm-up."""
    from scipy.optimize import minimize_scalar

    n = f.frame.size
    low, high = max(part.shape[0] / 2, SHORTEST_WARM_UP * n), min(part.shape[0] * 2, LONGEST_WARM_UP * n)

    def value(x: float) -> float:
        return fitted(f.frame, rest.having(Part("warm-up", "", (math.exp(x),))), f.free).value

    best = minimize_scalar(value, bounds=(math.log(low), math.log(high)), method="bounded", options={"xatol": 2e-3})
    return rest.having(Part("warm-up", "", (math.exp(float(best.x)),)))


def warm_ups(at: Local) -> Iterator[State]:
    """A warm-up, or the one of the state with another time constant."""
    frame, state = at.f.frame, at.f.state
    if not frame.able_to_warm_up:
        return
    n, own, steps_ = frame.size, state.of("warm-up"), state.of("step")
    if steps_ and not own:  # steps near the start, that fall like a warm-up
        bare = state.lacking(*steps_)
        tries = [(fitted(frame, bare.having(part)).value, i) for i, part in enumerate(warm_ups_of(frame))]
        yield _tuned_warm_up(at.f, bare, warm_ups_of(frame)[min(tries)[1]])
    rest = state.lacking(*own)
    if own:
        yield _tuned_warm_up(at.f, rest, own[0])
        return
    y, root, Q = _lowest(at)
    taus = n * np.geomspace(1 / 100, LONGEST_WARM_UP / INSIDE, WARM_UPS)
    D = np.array([_both(warm_up_direction(frame.spectrum, float(tau)))[: y.size] for tau in taus]) / root
    D = D - D @ Q @ Q.T
    gain = (D @ y) ** 2 / np.maximum((D**2).sum(axis=1), 1e-9)
    if at.able(float(gain.max()), COMPONENTS["warm-up"].cost(n)):
        yield _tuned_warm_up(at.f, rest, Part("warm-up", "", (float(taus[int(gain.argmax())]),)))


MOVES: tuple[Move, ...] = (less, exchanged, floors, steps, warm_ups, markov, exponents, resonances, filters)
"""All ways from a state to its neighbours. Their order decides nothing."""


def factors(at: Local) -> Iterator[State | Fitted]:
    """What no component describes: by the evidence of one step, and by a fit of each where that is no guide."""
    frame, state = at.f.frame, at.f.state
    if frame.white is None or len(state.of("factor")) >= COMPONENTS["factor"].most:
        return
    splines, taken = frame.splines, {(p.label, *p.shape[:2]) for p in state.of("factor")}
    base = splines.B.T * (at.f.inside / at.f.m)
    b, rest = at.projected(base)
    G = (base * at.h) @ base.T - rest @ rest.T
    ranked = []
    for place in splines.places:
        if place not in taken:
            L = splines.root(place)
            size, vectors = np.linalg.eigh(L.T @ G @ L)
            size, y = np.maximum(size, 0.0), (vectors.T @ (L.T @ b)) ** 2
            t2 = FACTOR_SIZES[:, None] ** 2
            gain = (t2 * y / (1 + t2 * size)).sum(axis=1) - np.log1p(t2 * size).sum(axis=1)
            best = int(gain.argmax())
            if gain[best] > max(FACTORS[place[0]] - SHORT, LEAST_EVIDENCE):
                ranked.append((float(gain[best]) - FACTORS[place[0]], place, float(FACTOR_SIZES[best])))
    ranked.sort(key=lambda each: -each[0])
    if not ranked:
        return
    tries = [
        state.having(Part("factor", place[0], (place[1], place[2], size))) for _, place, size in ranked[:CANDIDATES]
    ]
    if ranked[0][0] > FAR and not taken:
        wide = [p for p in splines.places if p[0] != "between" and p not in taken]
        parts = [Part("factor", p[0], (p[1], p[2], size)) for p in wide for size in WIDE_SIZES]
        each = sorted((_raised(at, part) for part in parts), key=lambda f: f.score)[: 2 * CANDIDATES]
        yield from sorted((refined(f, MANY) for f in each), key=lambda f: f.score)[:CANDIDATES]
    yield from tries


def _raised(at: Local, part: Part) -> Fitted:
    """The fit beside a factor that begins where it fits the logarithms of the residuals best."""
    state = at.f.state.having(part)
    A = factor_basis(at.f.frame, state) * (at.f.inside / at.f.m)[:, None]
    v = np.linalg.solve(np.eye(A.shape[1]) + (A * at.h[: A.shape[0], None]).T @ A, A.T @ (at.h[: A.shape[0]] * at.logs))
    return fitted(at.f.frame, state, v=np.asarray(v, dtype=np.float64))


def neighbours(part: Part) -> Iterator[Part]:
    """A factor with another size, or a place beside its own."""
    low, high, size = part.shape
    for other in (size / 2, size / 2**0.5, size * 2**0.5, size * 2):
        if SIZES[0] < other < SIZES[1]:
            yield part._replace(shape=(low, high, other))


def places_beside(part: Part, top: float) -> Iterator[Part]:
    """The same beginning or ending elsewhere."""
    low, high, size = part.shape
    step = 0.5 if "above" in part.label else 1.0
    if part.label == "all":
        return
    for a, b in ((low - step, high), (low + step, high), (low, high - step), (low, high + step)):
        if ("above" in part.label and b != high) or a < SLOW:
            continue
        if 0 <= a < b - 1 and b <= top + 1e-9 and (a <= top - 1e-9):
            yield part._replace(shape=(a, b, size))


def unread_start(used: BoolArray) -> bool:
    """Whether the lowest bins are not read."""
    return not bool(used[0])
