"""The search: the neighbours of the best states, until none within reach of the best has neighbours left to try.

First without factors, which explain whatever they hide; then with them. Every state is refined before it is compared,
and all within `REACH` of the best are kept. No random numbers, and no test of fit.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from allanite.core.plain import Portable
from allanite.identification.likelihood.spectrum import WELL_KNOWN

from .factor_moves import factors, nearest, neighbours, places_beside
from .fitting import Fitted, factor_basis, fitted, refined_values
from .frame import Frame
from .local import REACH, Local, Move
from .moves import MOVES, resonances
from .refining import pruned, refined
from .state import State, alike

EXPANDED = (4.0, 1.0)
"""States up to this above the least score are expanded, without and with factors: weights of e^-2 and e^-0.5."""

EXPANSIONS = 40
"""States that are expanded, at most, in either pass."""

FOLLOWED = 2
"""Neighbours of a start by one way that are expanded, whatever the others gain, if they gain `REACH`."""

BETTER = 0.3
"""By how much the score of a state must be less than that of one which differs in numerators and row of the filter, so
that it is expanded too."""

SAME = 0.1
"""Difference of the scores of two states that are the same within the grain of their shapes."""

FITS = 400
"""Neighbours that are fitted, at most: a record that needs more is described by none of them."""

MOST_WHITE = 0.5
"""Share of the power of a half octave that white noise has where it is visible: the greater part."""

TUNED = 2
"""Other sizes and places of the factors of a fit that are refined in a round, at most."""

FIRST = 3
"""Rounds of refinement before the hopeless are dropped."""


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

    def add(self, f: Fitted) -> None:
        """Keep a fit if it is the best of its kind."""
        key = f.state.kind
        if key in self.every:
            if f.score < self.every[key].score - 1e-6:
                self.every[key] = f
        elif not any(abs(f.score - g.score) < SAME and alike(f.state, g.state) for g in self.every.values()):
            self.every[key] = f


def search(
    frame: Frame, starts: Sequence[State] = (State(),), *, moves: Sequence[Move] = MOVES, unexplained: bool = True
) -> Searched:
    """Expand the best states until none of those within reach of the best is left unexpanded."""
    result, done = Searched(frame), dict[object, float]()
    for start in starts:
        first = pruned(refined(fitted(frame, start)))
        result.add(first)
        if first.state.form not in done:
            _follow(result, first, moves, done)
    _expand(result, moves, EXPANDED[0], done)
    if resonances in moves:
        for other in _recast(result.best):
            result.add(other)
        _expand(result, moves, EXPANDED[0], done)
    if unexplained and shows_white(result.best):  # else nothing is known of the noise
        for f in [f for f in result.every.values() if f.score < result.best.score + EXPANDED[1]]:
            _add_beside(result, f, (factors,))
        for bare in _bare(result.best):
            _follow(result, bare, (factors,), done, moves)
        _expand(result, (*moves, factors), EXPANDED[1], done)
    return result


def shows_white(f: Fitted) -> bool:
    """Whether white noise has most of the power of a half octave, where vibration or a factor stands beside it."""
    # Else what stands beside it makes its value: it is known from a difference only.
    frame = f.frame
    if frame.white is None or not (f.state.of("resonance") or f.state.of("factor")):
        return True
    share = f.likelihood.S[:, frame.white] * f.theta[frame.white] / f.m
    half = np.floor(2 * np.log2(frame.centre)).astype(int)
    count = np.bincount(half, frame.count)
    white, known = np.bincount(half, share * frame.count), count > WELL_KNOWN
    return bool((white[known] > MOST_WHITE * count[known]).any())


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
