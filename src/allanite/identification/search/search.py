"""The search: the neighbours of the best states, until none within reach of the best has neighbours left to try.

First without factors, which explain whatever they hide; then with them. Every state is refined before it is compared,
and all within `REACH` of the best are kept. No random numbers, and no test of fit.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.plain import Portable
from allanite.identification.likelihood.spectrum import WELL_KNOWN

from .components import COMPONENTS, FACTORS, SIZES, Part
from .fitting import Fitted, factor_basis, fitted, refined_values
from .frame import SLOWEST_OCTAVE, Frame
from .moves import MOVES, resonances, steps, warm_ups, waves
from .refining import CANDIDATES, FAR, REACH, Local, Move, pruned, refined, resized
from .state import State, alike

FACTOR_SIZES = np.array([0.01, 0.02, 0.04, 0.08, 0.16, 0.32, 0.64, 1.28, 2.56])
"""Sizes of a factor that are tried, RMS of the logarithm of the power."""

SHORT_OF_PRICE, LEAST_EVIDENCE = 4.0, 1.5
"""Evidence for a factor, in 2 L, from which it is fitted: so much below its price, where it weighs e^-1 of the state
without it, and at least so much, as a factor of no size has none."""

WIDE_SIZES, MANY = (0.64, 2.56), 14
"""Sizes of a factor that are fitted where one step is no guide, and rounds of scoring of these fits: each
divides the power by e^2 at most."""


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
            if gain[best] > max(FACTORS[place[0]] - SHORT_OF_PRICE, LEAST_EVIDENCE):
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
    return fitted(at.f.frame, state, v=nearest(A, at.h[: A.shape[0]], at.logs))


def nearest(A: FloatArray, h: FloatArray, u: FloatArray) -> FloatArray:
    """Coefficients v ~ N(0, 1) with A v as near to u as they allow, h being half the counts."""
    v = np.linalg.solve(np.eye(A.shape[1]) + (A * h[:, None]).T @ A, A.T @ (h * u))
    return np.asarray(v, dtype=np.float64)


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
        if ("above" in part.label and b != high) or a < SLOWEST_OCTAVE:
            continue
        if 0 <= a < b - 1 and b <= top + 1e-9 and (a <= top - 1e-9):
            yield part._replace(shape=(a, b, size))


EXPANDED = (4.0, 1.0)
"""States up to this above the least score are expanded, without and with factors: weights of e^-2 and e^-0.5."""

EXPANSIONS = 40  # states that are expanded, at most, in either pass
FOLLOWED = 2  # neighbours of a start by one way that are expanded, whatever the others gain, if they gain `REACH`

BETTER = 0.3
"""By how much the score of a state must be less than that of one which differs in numerators and row of the filter, so
that it is expanded too."""

SAME = 0.1  # difference of the scores of two states that are the same within the grain of their shapes
FITS = 400  # neighbours that are fitted, at most: a record that needs more is described by none of them
MOST = 0.5  # share of the power of a half octave that a noise term has where it is visible: the greater part
TUNED = 2  # other sizes and places of the factors of a fit that are refined in a round, at most
FIRST = 3  # rounds of refinement before the hopeless are dropped


MEANS: tuple[Callable[[Local], Iterator[State]], ...] = (steps, warm_ups, waves)
"""Ways to components that change the mean of the coefficients, as slow noise does."""


@dataclass
class Searched(Portable):
    """The best fit of each kind of state, and how many were expanded and fitted."""

    frame: Frame
    every: dict[object, Fitted] = field(default_factory=dict)
    expanded: int = 0
    fits: int = 0

    @property
    def best(self) -> Fitted:
        """The fit of the least score."""
        return min(self.every.values(), key=lambda f: f.score)

    @property
    def kept(self) -> list[Fitted]:
        """Those within reach of the best, the best first."""
        least = self.best.score
        return sorted((f for f in self.every.values() if f.score < least + REACH), key=lambda f: f.score)

    def add(self, f: Fitted) -> bool:
        """Keep a fit if it is the best of its kind; whether it is."""
        key = f.state.kind
        if key in self.every:
            new = f.score < self.every[key].score - 1e-6
        else:
            new = not any(abs(f.score - g.score) < SAME and alike(f.state, g.state) for g in self.every.values())
        if new:
            self.every[key] = f
        return new


def search(
    frame: Frame, starts: Sequence[State] = (State(),), *, moves: Sequence[Move] = MOVES, unexplained: bool = True
) -> Searched:
    """Expand the best states until none of those within reach of the best is left unexpanded."""
    result, done = Searched(frame), dict[object, float]()
    for start in starts:
        first = pruned(refined(fitted(frame, start)))
        if result.add(first) and first.state.form not in done:
            _follow(result, first, moves, done)
    _expand(result, moves, EXPANDED[0], done)
    if resonances in moves:
        for other in _recast(result.best):
            result.add(other)
        _expand(result, moves, EXPANDED[0], done)
    for other in _stilled(result.best, moves):
        result.add(other)
    if unexplained and shows_white(result.best):  # else nothing is known of the noise
        for f in [f for f in result.every.values() if f.score < result.best.score + EXPANDED[1]]:
            _add_beside(result, f, (factors,))
        for bare in _bare(result.best):
            _follow(result, bare, (factors,), done, moves)
        _expand(result, (*moves, factors), EXPANDED[1], done)
    return result


def shows_white(f: Fitted) -> bool:
    """Whether white noise has most of the power of a half octave, where vibration or a factor stands beside it."""
    white, beside = f.frame.white, f.state.of("resonance") or f.state.of("factor")
    return white is None or not beside or shows(f, white)


def shows(f: Fitted, term: int) -> bool:
    """Whether a noise term has most of the power of a half octave, and a factor changes it little there."""
    # Else what stands beside it makes its value: it is known from a difference only.
    share = f.likelihood.S[:, term] * f.theta[term] / f.m
    if f.v.size:
        share *= np.exp(-np.abs(factor_basis(f.frame, f.state) @ f.v))
    half = np.floor(2 * np.log2(f.frame.centre)).astype(int)
    own, count = np.bincount(half, share * f.frame.count), np.bincount(half, f.frame.count)
    return bool((own > MOST * count)[count > WELL_KNOWN].any())


def _recast(f: Fitted) -> list[Fitted]:
    """A fit with one numerator for all its resonances, and without its filter: no single exchange leads there."""
    # The skirts of resonances towards low frequencies are those of white noise behind a filter.
    loud, through = f.state.of("resonance"), (*f.state.of("filter"), *f.state.of("floor"))
    if not loud:
        return []
    rest = f.state.lacking(*loud)
    cast = [tuple(part._replace(label=label) for part in loud) for label in ("flat", "high-pass")]
    bases = [rest, rest.lacking(*through)] if through else [rest]
    states = [base.having(*parts) for base in bases for parts in cast]
    fits = [pruned(refined(fitted(f.frame, state))) for state in states if state != f.state and state.admitted(f.frame)]
    return [g for g in fits if g.state.admitted(f.frame)]


def _stilled(f: Fitted, moves: Sequence[Move]) -> list[Fitted]:
    """A fit with a step, a warm-up or a wave in the place of its slow noise."""
    # Beside that noise none of them gains enough to be fitted, and without both the state is worse than either.
    still = f.free.copy()
    still[: f.frame.slow.size] &= ~f.frame.slow
    if (still == f.free).all() or not still.any():
        return []
    at = Local(resized(f, still))
    states = [state for move in MEANS if move in moves for state in move(at) if state.admitted(f.frame)]
    return [refined(fitted(f.frame, state, still)) for state in states]


def _bare(f: Fitted) -> list[Fitted]:
    """A fit without its resonances, and without its filter too, that may stand in the place of a factor."""
    # Several broad resonances do, and angle noise behind a filter, which rises and falls again.
    loud, through = f.state.of("resonance"), (*f.state.of("filter"), *f.state.of("floor"))
    rises = bool(through) and bool((f.free[: f.frame.angle.size] & f.frame.angle).any())
    states = ([f.state.lacking(*loud)] if loud else []) + ([f.state.lacking(*loud, *through)] if loud or rises else [])
    return [pruned(refined(fitted(f.frame, state))) for state in dict.fromkeys(states)]


def _follow(
    result: Searched, start: Fitted, ways: Sequence[Move], done: dict[object, float], moves: Sequence[Move] = ()
) -> None:
    """Expand a start and then the best that each way from it leads to, whatever the others gain."""
    # Far from a fit what gains most at first need not lead to the best state: a broad resonance may gain more than the
    # filter that was there, but for what stands behind it.
    done.setdefault(start.state.form, start.score)
    result.expanded += 1
    for move in ways:
        beside = sorted(_add_beside(result, start, (move,)), key=lambda f: f.score)[:FOLLOWED]
        for f in beside:
            if f.score < start.score - REACH and f.state.form not in done:
                done[f.state.form] = f.score
                result.expanded += 1
                _add_beside(result, f, (*moves, *ways))


def _expand(result: Searched, moves: Sequence[Move], reach: float, done: dict[object, float]) -> None:
    for _ in range(EXPANSIONS):
        least = result.best.score
        waiting = [f for f in result.every.values()
                   if f.score < least + reach and f.score < done.get(f.state.form, math.inf) - BETTER]  # fmt: skip
        if not waiting or result.fits > FITS:
            break
        best = min(waiting, key=lambda f: (f.score, repr(f.state.kind)))
        done[best.state.form] = best.score
        result.expanded += 1
        _add_beside(result, best, moves)


def _add_beside(result: Searched, f: Fitted, moves: Sequence[Move]) -> list[Fitted]:
    """Keep the neighbours of a state."""
    beside = _beside(result, f, moves)
    for g in beside:
        result.add(g)
    return beside


def _worth(f: Fitted) -> float:
    """2 L and the costs of the parts, but not of the powers."""
    return f.value + f.state.cost(f.frame)


def _beside(result: Searched, f: Fitted, moves: Sequence[Move]) -> list[Fitted]:
    """The fitted neighbours of a state that may come within reach."""
    frame, at = f.frame, Local(f)
    ways = [way for move in moves for way in move(at)]
    fits = [way for way in ways if isinstance(way, Fitted)]
    states = dict.fromkeys(way for way in ways if isinstance(way, State) and way.admitted(frame))
    fits += [_first(frame, f, state) for state in states]
    result.fits += len(fits)
    for rounds in (0, 8):
        least = min([_worth(f), *map(_worth, fits)])
        fits = [g for g in fits if _worth(g) < least + 2 * REACH]
        if not rounds:
            fits = [g for g in (_tuned(refined(g)) for g in fits) if g.state.admitted(frame)]
    return [pruned(g) for g in fits]


def _first(frame: Frame, f: Fitted, state: State) -> Fitted:
    """A neighbour, its shapes refined a little; beside other resonances that of a new one alone at first."""
    g, new = fitted(frame, state), [p for p in state if p not in f.state.parts]
    if len(new) == 1 and new[0].name == "resonance" and f.state.of("resonance"):
        held = [p != new[0] for p in state for _ in range(refined_values(p))]
        g = refined(g, FIRST, held=np.array(held, dtype=bool))
    return refined(g, FIRST)


def _as_high(f: Fitted, state: State) -> Fitted:
    """A state with other factors, that begins with as nearly the same power as these allow."""
    A, h = factor_basis(f.frame, state), f.trusted.count[: f.m.size] / 2
    v = nearest(A, h, factor_basis(f.frame, f.state) @ f.v)
    return fitted(f.frame, state, f.free, f, v)


def _tuned(f: Fitted) -> Fitted:
    """The sizes and places of its factors, one after the other, as long as the score falls."""
    for _ in range(6):
        tries = []
        for part in f.state.of("factor"):
            rest = f.state.lacking(part)
            others = (*neighbours(part), *places_beside(part, f.frame.splines.top))
            tries += [_as_high(f, rest.having(other)) for other in others]
        tries = [refined(g, 3) for g in sorted(tries, key=lambda g: g.score)[:TUNED]]
        best = min(tries, key=lambda g: g.score, default=f)
        if best.score > f.score - 0.05:
            break
        f = best
    return f
