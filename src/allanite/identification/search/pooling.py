"""One filter for the channels of one device: the score summed over them, the cut-off in common."""

# Derivation: docs/derivations.md.

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import scipy

from allanite.core.arrays import FloatArray
from allanite.core.splines import cubic, valued
from allanite.identification.likelihood.filters import FILTERS

from .components import COMPONENTS, ODDS, Part
from .cutoffs import errors_of
from .fitting import Fitted, fitted
from .frame import LOWEST_CUTOFF, Common, Frame
from .moves import less
from .refining import REACH, pruned, refined
from .search import Searched, search
from .state import State

if TYPE_CHECKING:
    from .identify import Pending

APART = ODDS  # cost of a channel that is left out
BASES = 2  # states of a channel whose parts are tried behind a filter, beside the best one that has a filter
STARTS = 6  # states of a channel that are tried behind the filter in common, at most
SAME_ERRORS = 3.0  # standard errors within which the cut-offs of two channels are one start

WHOLE = 0.2
"""Distance of a cut-off, in its logarithm, from that of a whole length that is tried beside it: half from 2 to 3."""

NEAR_ERRORS = 4.0  # standard errors of the common cut-off within which it is looked for
FINE_ERRORS = 0.05  # standard errors to which it is found: 0.0025 in the score

LEAST_ERROR = 5e-4
"""Standard error of the logarithm of a cut-off, at least: a moving average changes its slope at whole lengths."""

FOLLOWING_ROUNDS, FOLLOWING = 3, 1  # rounds in which the other shapes follow a filter, and its cut-off
SCAN_POINTS = 13  # cut-offs at which the summed score is known

RIVALS, NEXT = 4.0, 1.0
"""Summed score over that of the best row up to which another one is an alternative: a weight of e^-2; what is added to
it, so that all channels name the same row first."""


class Together(NamedTuple):
    """A filter in common, as one channel knows it, its rows by their totals; and the channels that have it."""

    common: tuple[Common, ...]
    channels: tuple[str, ...]


def together(searches: "Sequence[Pending]") -> "list[Together | None]":
    """The filter in common of each search, None where it has one of its own or none: of one signal and rate."""
    kinds: dict[object, list[int]] = {}
    for i, each in enumerate(searches):
        if each.automatic:
            kinds.setdefault((each.scale.signal.name, each.scale.rate), []).append(i)
    shared: list[Together | None] = [None] * len(searches)
    for alike in kinds.values():
        at = alike
        while len(at) > 1 and (pool := in_common([searches[i].result for i in at])):
            names = tuple(searches[at[j]].name for j in pool)
            for j, common in pool.items():
                shared[at[j]] = Together(common, names)
            at = [i for j, i in enumerate(at) if j not in pool]
    return shared


@dataclass(frozen=True, eq=False)
class Behind:
    """Channels behind a filter of one row and cut-off."""

    row: str
    cutoff: float
    fits: list[Fitted]  # the best state of each channel
    total: float

    def over(self, best: "Behind", channels: Sequence[int]) -> float:
        """Summed score of some channels over that behind the best filter."""
        return sum(self.fits[i].score - best.fits[i].score for i in channels)

    def ends(self, channels: Sequence[int]) -> tuple[float, float]:
        """Logarithms of the cut-offs between which some channels have it in common."""
        errors = [errors_of(f, f.state.filter)[0] for f in (self.fits[j] for j in channels) if f.state.filter]
        error = max(float(np.sum(np.array(errors) ** -2.0)) ** -0.5, LEAST_ERROR)
        x, low, high = (math.log(c) for c in (self.cutoff, LOWEST_CUTOFF, FILTERS[self.row].widest))
        return max(x - NEAR_ERRORS * error, low), min(x + NEAR_ERRORS * error, high)


def in_common(results: Sequence[Searched]) -> dict[int, tuple[Common, ...]]:
    """The filter of several searches by their numbers; empty where the scores are better without one in common."""
    alone = [result.best.score for result in results]
    tried = [_evaluated(results, alone, row, c) for row in _rows(results) for c in _starts(results, row)]
    least = min((b.total for b in tried), default=math.inf)
    tried = [_best_cutoff(b, alone) for b in tried if b.total < least + 2 * REACH]
    best = min(tried, key=lambda b: b.total, default=None)
    if best is None or best.total + ODDS > sum(alone):
        return {}
    members = [j for j, f in enumerate(best.fits) if f.score < alone[j] + APART]
    if len(members) < 2:
        return {}
    rows = {best.row: best}
    for b in sorted(tried, key=lambda b: b.over(best, members)):
        if b.over(best, members) < RIVALS:
            rows.setdefault(b.row, b)
    return _told([Scan.of(b, members, b.over(best, members)) for b in rows.values()], best, members)


@dataclass(frozen=True, eq=False)
class Scan:
    """Scores of channels behind a row of filters: `scores`, shape (channels, cut-offs), `at` logarithms of cut-offs."""

    # `over` is the least sum of them over that of the best row.
    row: str
    cutoff: float
    at: FloatArray
    scores: FloatArray
    over: float

    @staticmethod
    def of(b: Behind, members: Sequence[int], over: float) -> "Scan":
        """The scores around the best cut-off, other shapes following a little."""
        at = np.linspace(*b.ends(members), SCAN_POINTS)
        scores = [
            [_behind(b.fits[j], b.row, math.exp(x), FOLLOWING).score for x in at.tolist()] for j in members
        ]  # fmt: skip
        return Scan(b.row, b.cutoff, at, np.array(scores), over + (NEXT if over else 0.0))

    @property
    def weights(self) -> tuple[FloatArray, FloatArray]:
        """Logarithms of cut-offs, closely, and the weight of each, all that of the row."""
        total = self.scores.sum(axis=0)
        x = np.linspace(self.at[0], self.at[-1], 20 * SCAN_POINTS)
        w = np.exp((total.min() - valued(self.at, cubic(self.at, total), x)) / 2)
        return x, w / w.sum() * math.exp(-self.over / 2)


def _told(scans: Sequence[Scan], best: Behind, members: Sequence[int]) -> dict[int, tuple[Common, ...]]:
    """What the others tell each channel of the filter."""
    x, w = (np.concatenate(each) for each in zip(*(scan.weights for scan in scans), strict=True))
    order = np.argsort(x)
    below = np.cumsum(w[order]) - w[order] / 2
    low, high = np.exp(np.interp([0.025 * w.sum(), 0.975 * w.sum()], below, x[order])).tolist()
    told: dict[int, list[Common]] = {j: [] for j in members}
    for scan in scans:
        for k, j in enumerate(members):
            least = sum(best.fits[i].score for i in members if i != j)
            others = scan.scores.sum(axis=0) - scan.scores[k] - least + (NEXT if scan.over else 0.0)
            ends = min(low, scan.cutoff), max(high, scan.cutoff)
            told[j].append(Common(scan.row, scan.cutoff, *ends, tuple(scan.at.tolist()), tuple(others.tolist())))
    return {j: tuple(each) for j, each in told.items()}


def _rows(results: Sequence[Searched]) -> list[str]:
    """Rows of filters in the states of any channel that are within reach."""
    names = {f.state.filter.label for result in results for f in result.kept if f.state.filter}
    return [row for row in FILTERS if row in names]


def _starts(results: Sequence[Searched], row: str) -> Iterator[float]:
    """Cut-offs of the channels, averages of those that agree; whole lengths beside them."""
    own = []
    for result in results:
        fits = [f for f in result.kept if f.state.filter and f.state.filter.label == row]
        if fits and (through := fits[0].state.filter):
            own.append((float(errors_of(fits[0], through)[0]), math.log(through.shape[0])))
    groups: list[tuple[float, float]] = []  # information, and the centre
    for error, x in sorted(own):
        w = 1 / max(error, 1e-6) ** 2
        i = next((i for i, (v, y) in enumerate(groups) if abs(x - y) < SAME_ERRORS * math.hypot(error, v**-0.5)), None)
        if i is None:
            groups.append((w, x))
        else:
            v, y = groups[i]
            groups[i] = v + w, (v * y + w * x) / (v + w)
    for _, y in groups:
        yield math.exp(y)
        if FILTERS[row].whole:
            starts = FILTERS[row].starts[1:]
            apart = np.abs(np.log(starts) - y)
            if apart.min() < WHOLE:
                yield float(starts[apart.argmin()])


def bases(result: Searched, most: int) -> list[State]:
    """The best states without their filters, and that of the best one with a filter."""
    fits = sorted(result.every.values(), key=lambda f: f.score)
    chosen: dict[object, State] = {}
    least = fits[0].score
    for f in fits:
        if f.score > least + REACH or len(chosen) == most:
            break
        base = without_filter(f.state)
        chosen.setdefault(base.kind, base)
    filtered = next((f for f in fits if f.state.filter), None)
    if filtered is not None:
        base = without_filter(filtered.state)
        chosen.setdefault(base.kind, base)
    return list(chosen.values())


def without_filter(state: State) -> State:
    """The other parts of a state."""
    return state.lacking(*state.of("filter"))


def _fixed(frame: Frame, row: str, cutoff: float) -> Frame:
    """Behind a filter that does not change."""
    return frame.behind(Common(row, cutoff, cutoff, cutoff))


def _behind(f: Fitted, row: str, cutoff: float, rounds: int = 0) -> Fitted:
    """A fit behind another filter, the other shapes refined."""
    state = without_filter(f.state).having(Part("filter", row, (cutoff,)))
    return pruned(refined(fitted(_fixed(f.frame, row, cutoff), state), rounds))


def _evaluated(results: Sequence[Searched], alone: Sequence[float], row: str, cutoff: float) -> Behind:
    """The channels behind a filter, the shapes of their best states refined."""
    fits = []
    for result in results:
        frame = _fixed(result.frame, row, cutoff)
        states = [base.having(Part("filter", row, (cutoff,))) for base in bases(result, BASES)]
        tries = [pruned(refined(fitted(frame, s), FOLLOWING_ROUNDS)) for s in states if s.admitted(frame)]
        fits.append(min(tries, key=lambda f: f.score))
    return Behind(row, cutoff, fits, _total(fits, alone))


def _total(fits: Sequence[Fitted], alone: Sequence[float]) -> float:
    price = COMPONENTS["filter"].cost(fits[0].frame.size)
    return price + sum(min(f.score, score + APART) for f, score in zip(fits, alone, strict=True))


def _best_cutoff(b: Behind, alone: Sequence[float]) -> Behind:
    """The same at the cut-off of the least total, other shapes being kept."""
    known: dict[float, Behind] = {math.log(b.cutoff): b}

    def total(x: float) -> float:
        if x not in known:
            c = math.exp(x)
            fits = [_behind(f, b.row, c) for f in b.fits]
            known[x] = Behind(b.row, c, fits, _total(fits, alone))
        return known[x].total

    members = [j for j, f in enumerate(b.fits) if f.score < alone[j] + APART] or range(len(b.fits))
    ends = b.ends(members)
    fine = FINE_ERRORS * (ends[1] - ends[0]) / (2 * NEAR_ERRORS)
    scipy.optimize.minimize_scalar(total, bounds=ends, method="bounded", options={"xatol": fine, "maxiter": 20})
    return min(known.values(), key=lambda each: each.total)


def behind(result: Searched, common: Sequence[Common]) -> Searched:
    """The states of a search behind a filter in common, and those that lack parts which stood in its place."""
    frame, parts = result.frame.behind(*common), bases(result, STARTS)
    parts.append(parts[0].lacking(*parts[0].of("exponent")))  # which the terms can express
    starts = [base.having(Part("filter", each.row, (each.cutoff,))) for each in common for base in dict.fromkeys(parts)]
    return search(frame, [s for s in starts if s.admitted(frame)], moves=(less,), unexplained=False)
