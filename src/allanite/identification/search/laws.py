"""Laws of the coefficients: averages over the states that were kept, with the weights exp(-score / 2)."""

# Derivation: docs/derivations.md.

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.plain import Portable
from allanite.identification.likelihood.law import Subset, traced

from .components import CLAIMED, Part
from .fitting import Fitted, admissible, column_of_part, refined_values
from .refining import REACH, SETTLED, resized
from .search import Searched

TRACED_SHARE = 0.985  # share of all weight that the entries have whose profiles are traced: the heaviest
LEAST_WEIGHT = 1e-4  # weight of an entry, over the heaviest, below which it is omitted
MEMBERS = 8  # states of one family that take part, at most: they weigh together as much as the best of them
POINTS = 1001  # values of a coefficient at which its law is tabulated
FARTHEST_DEVIATE = 5.0  # deviates to which a profile is continued
WIDEST = 30.0  # factor by which unknown shapes widen a profile, at most: beyond it the coefficient is not known at all


@dataclass(frozen=True, eq=False)
class Entry(Portable):
    """One model of the average: a fit, and its weight."""

    f: Fitted
    weight: float

    @cached_property
    def subset(self) -> Subset:
        """The fit as a subset of its likelihood."""
        return subset_of(self.f)

    @cached_property
    def stretch(self) -> FloatArray:
        """Factors by which shapes that are known from the same record widen the errors of the sizes, shape (sizes,)."""
        factor = np.ones(self.f.theta.size)
        if not self.f.v.size and not any(map(refined_values, self.f.state)):
            return factor
        H, active = self.f.information
        size = np.sqrt(np.maximum(np.diag(H), 1e-300))
        H = H / np.outer(size, size) + 1e-10 * np.eye(size.size)
        a = int(active.sum())
        wide, narrow = np.diag(np.linalg.inv(H))[:a], np.diag(np.linalg.inv(H[:a, :a]))
        factor[active] = np.clip(np.sqrt(abs(wide / narrow)), 1.0, WIDEST)
        return factor


def subset_of(f: Fitted) -> Subset:
    """A fit as a subset of its likelihood."""
    return Subset(f.trusted, f.free, f.theta, f.trusted.value(f.theta))


def entries_of(result: Searched) -> list[Entry]:
    """Every subset of the powers beside each state that was kept, with its weight, the heaviest first."""
    models: dict[tuple[object, bytes], Fitted] = {}
    highest = result.best.score + 2 * REACH
    for f in _some_of_each_family(result.kept):
        models[f.state.kind, f.free.tobytes()] = f
        full, known = resized(f, np.ones(f.theta.size, dtype=bool)), [free for k, free in models if k == f.state.kind]
        fits = sorted(_subsets(full, known, highest), key=lambda each: each[0])
        models |= {(f.state.kind, g.free.tobytes()): g for _, g in fits if -math.inf < g.score < highest}
    return weighted(list(models.values()))


def _subsets(full: Fitted, known: Sequence[bytes], highest: float) -> Iterator[tuple[int, Fitted]]:
    """Subsets of the powers that are not `known`, the largest first, without those that are too high for certain."""
    own, places = full.state.cost(full.frame), 1 << np.arange(len(full.frame.powers))
    least: dict[int, float] = {}  # value of a subset, at least: that of one which holds it
    for bits in sorted(range(2**places.size), key=int.bit_count, reverse=True):
        may = admissible(full.frame, full.state, bits & places > 0, full.theta.size)
        code = int(may[: places.size] @ places)
        if code in least or not may.any():
            continue
        least[code] = max([value for more, value in least.items() if more & code == code], default=full.value)
        if may.tobytes() not in known and least[code] - SETTLED + own + 2 * code.bit_count() <= highest:
            fit = resized(full, may)
            least[code] = max(least[code], fit.value)
            yield code, fit


def _some_of_each_family(kept: Sequence[Fitted]) -> list[Fitted]:
    """The best members of each family."""
    counts: Counter[object] = Counter()
    chosen = []
    for f in kept:
        counts[f.state.family] += 1
        if counts[f.state.family] <= MEMBERS:
            chosen.append(f)
    return chosen


def weighted(models: Sequence[Fitted]) -> list[Entry]:
    """Models with their weights."""
    score = np.array([f.score for f in models])
    near = score < score.min() + 2 * REACH  # the subsets of one state may be better than all that were searched
    models, score = [f for f, may in zip(models, near.tolist(), strict=True) if may], score[near]
    w = np.exp(-0.5 * (score - score.min()))
    families = [(f.free[: len(f.frame.powers)].tobytes(), f.state.family) for f in models]
    best: dict[object, float] = {}
    total: dict[object, float] = {}
    for family, x in zip(families, w.tolist(), strict=True):
        best[family], total[family] = max(best.get(family, 0.0), x), total.get(family, 0.0) + x
    w = w * np.array([best[family] / total[family] for family in families])
    order = np.argsort(-w, kind="stable")
    order = order[w[order] > LEAST_WEIGHT * w.max()]
    return [Entry(models[i], float(w[i] / w[order].sum())) for i in order]


@dataclass(frozen=True, eq=False)
class Law(Portable):
    """The law of the root of a size, given that it is above zero."""

    # `root` and `below` are values and the probability of less; `weight` is that of the models that have it, and
    # `parts` are the models that make it with their shares and best values.
    root: FloatArray
    below: FloatArray
    weight: float
    parts: tuple[tuple[float, float, Fitted], ...] = ()

    def quantile(self, p: float) -> float:
        """The value below which the root lies with probability p."""
        return float(np.interp(p, self.below, self.root))

    def limits(self, level: float) -> tuple[float, float]:
        """Two-sided limits."""
        tail = (1 - level) / 2
        return self.quantile(tail), self.quantile(1 - tail)

    @property
    def claimed(self) -> bool:
        """Whether the models that have it outweigh the others."""
        return self.weight >= CLAIMED

    @cached_property
    def modes(self) -> tuple[float, ...]:
        """The two values of a law with two modes; empty for one."""
        if len(self.parts) < 2:
            return ()
        density = np.diff(self.below)
        middle = (self.root[1:] + self.root[:-1]) / 2
        values = sorted(root for _, root, _ in self.parts)
        gaps = [(b - a, (a + b) / 2) for a, b in pairwise(values)]
        _, cut = max(gaps)
        lower, upper = density[middle < cut], density[middle >= cut]
        if not lower.size or not upper.size or min(lower.sum(), upper.sum()) < MODE:
            return ()
        between = density[(middle > middle[lower.argmax()]) & (middle < middle[lower.size + upper.argmax()])]
        if not between.size or between.min() > VALLEY * min(lower.max(), upper.max()):
            return ()
        return float(middle[lower.argmax()]), float(middle[lower.size + upper.argmax()])


MODE, VALLEY = 0.1, 0.5
"""Probability of a mode, at least; density between two modes over that of the lower one, at most: a definition."""


def law_of(entries: Sequence[Entry], which: int, having: Sequence[bool] | None = None) -> Law | None:
    """The law of a size; None where no model has it. `having` says which models do, where columns differ."""
    chosen = [
        e for i, e in enumerate(entries)
        if which < e.f.free.size and e.f.free[which] and (having is None or having[i])
    ]  # fmt: skip
    weight = sum([e.weight for e in chosen])
    if not chosen or weight <= 0:
        return None
    cumulative = np.cumsum([e.weight / weight for e in chosen])
    heavy = chosen[: int(np.searchsorted(cumulative, TRACED_SHARE)) + 1]
    profiles = [_profile(e, which) for e in heavy]
    low, high = min(r[0] for r, _ in profiles), max(r[-1] for r, _ in profiles)
    root = np.linspace(low, high, POINTS)
    density, parts = np.zeros(POINTS), []
    share = sum([e.weight for e in heavy])
    for e, (r, d) in zip(heavy, profiles, strict=True):
        deviate = np.interp(root, r, d, left=-2 * FARTHEST_DEVIATE, right=2 * FARTHEST_DEVIATE)
        own = np.exp(-0.5 * deviate**2)
        density += e.weight / share * own / max(own.sum(), 1e-300)  # its own weight, however wide it is
        parts.append((e.weight / share, math.sqrt(max(float(e.f.theta[which]), 0.0)), e.f))
    below = np.concatenate(([0.0], np.cumsum(density[1:] + density[:-1])))
    return Law(root, below / below[-1], min(weight, 1.0), tuple(parts))


def _profile(entry: Entry, which: int) -> tuple[FloatArray, FloatArray]:
    """Values of the root, signed deviates with unknown shapes, continued as far as `FARTHEST_DEVIATE`, above zero."""
    trace = traced(entry.subset, which)
    root, deviate = trace.root, trace.deviate / entry.stretch[which]
    if root.size < 2:
        return np.array([0.0, max(2 * root[0], 1e-300)]), np.array([0.0, FARTHEST_DEVIATE])
    ends = []
    for i, j, sign in ((0, 1, -1.0), (-1, -2, 1.0)):
        slope = abs(root[i] - root[j]) / max(abs(deviate[i] - deviate[j]), 1e-3)
        ends.append(root[i] + sign * slope * max(FARTHEST_DEVIATE - abs(deviate[i]), 0.0))
    low, high = max(ends[0], 0.0), ends[1]
    if low < root[0]:
        slope = (root[1] - root[0]) / max(deviate[1] - deviate[0], 1e-3)
        first = deviate[0] - (root[0] - low) / max(slope, 1e-300)
        root, deviate = np.array([low, *root]), np.array([first, *deviate])
    if high > root[-1]:
        root, deviate = np.array([*root, high]), np.array([*deviate, max(FARTHEST_DEVIATE, deviate[-1])])
    return root, deviate


def noise_part(f: Fitted, symbol: str, number: int = 0) -> Part | None:
    """The `number`-th noise of a symbol in a fit by its time constant; None if there are not so many."""
    parts = [part for part in f.state.of("noise") if part.label == symbol]
    return parts[number] if number < len(parts) else None


def column_of(f: Fitted, symbol: str, number: int = 0) -> int | None:
    """The place of its size."""
    part = noise_part(f, symbol, number)
    return None if part is None else column_of_part(f.state, f.frame, part)
