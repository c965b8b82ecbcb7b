"""Definition of a row of the table of statistics."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from allanite.core.arrays import FloatArray, IntArray
from allanite.terms.row import NoiseTerm

Window = tuple[FloatArray, FloatArray]
"""Weights, shape (r,), and filters, shape (r, points): ``sum_r weights[r] (filters[r] . x)^2`` of a window's points."""


def interleaved(points: int, m: IntArray, threads: int) -> list[IntArray]:
    """Places in m, the same number of small and of large ones for each thread."""
    return [np.arange(i, m.size, threads) for i in range(min(threads, m.size))]


@dataclass(frozen=True)
class Sharp:
    """How the ratios of white angle noise with the other terms, and with itself, depend on m."""

    # `levels` as for `Scheme`; ratios fall as 1 / (m scale(m)); `itself`, (m, count) -> ratio, is that with itself
    # where it follows no power of m.
    levels: tuple[int, ...]
    scale: Callable[[int], float]
    itself: Callable[[int, int], float] | None = None


@dataclass(frozen=True)
class Scheme:
    """How a long window is replaced by a window of few points that lasts as long."""

    # averaging factors of the reduced windows for even m; odd m takes the next ones
    levels: tuple[int, ...] = (10, 20)
    power: int = 2  # the extrapolation is a polynomial in ``m^-power``
    # for white angle noise, where the window holds single points of the angle; None where it averages them, so that
    # this noise scales as the other terms do
    sharp: Sharp | None = None
    # expectation of one window, where it is known for any m
    response: Callable[[NoiseTerm, int], float] | None = None
    leading: int = 6  # averaging factor of the reduced window from which the largest eigenvalues are taken
    # shape (points,); for a window of many filters, half the gradient of its sum of squares at ``x_j = j^2 / 2`` but
    # for a line: ``sum_r weights[r] (filters[r] . x) filters[r]``.
    ramp: Callable[[int], FloatArray] | None = None


@dataclass(frozen=True)
class PublishedBias:
    """The bias factors of a statistic as published, and where (`limits`) they are known to fail."""

    # ``factor(coefficients, m, size)`` is E[estimate] / E[target] at averaging factors m of a record of `size`
    # intervals; a power law whose exponent alpha has no `coefficients` has no published factor.
    reference: str
    limits: str
    factor: Callable[[tuple[float, ...], IntArray, int], FloatArray]
    coefficients: dict[int, tuple[float, ...]]


@dataclass(frozen=True, eq=False)
class Statistic:
    """A statistic as a mean of squares over windows of the angle x."""

    # ``variance(m) = sums / (count norm(m) (m tau0)^2) tau^(2 power)`` with ``tau = tau_factor m tau0``.
    # name, title, formula, reference: name used in the field, full name, LaTeX formula of the variance, source
    name: str
    title: str
    formula: str
    reference: str
    # meaning, use, limits, cost: for the documentation: what it measures, when to use it, its limitations, time and
    # memory
    meaning: str
    use: str
    limits: str
    cost: str
    order: int  # differences of x it takes: 1 removes a constant angle, 2 a constant rate, 3 a ramp of the rate too
    norm: Callable[[IntArray | FloatArray], FloatArray]
    # a window covers ``span[0] m + span[1]`` sample intervals; 0 m where it is folded back at the record's ends
    span: tuple[int, int]
    sums: Callable[[FloatArray, IntArray], FloatArray]
    # the quadratic form whose mean over the windows is the sum; None where there is none (a maximum)
    window: Callable[[int], Window] | None
    # what threads can deal with apart, so that the numbers stay the same
    split: Callable[[int, IntArray, int], list[IntArray]] = interleaved
    # time of a window, ns, where every tau takes that of all its windows; 0 where there is a faster form for many
    pace: float = 0.0
    target: str = ""  # the statistic whose expectation this one estimates; empty if its own
    overlapped: bool = True  # whether windows start at every sample or every m samples
    step: int = 1  # averaging factors are multiples of it
    tau_factor: float = 1.0
    power: int = 0  # 0 for a deviation of the rate, 1 for one of the angle
    # a window is the difference of this order at stride m: of x, or of its running sum if `summed`; 0 if it is none
    differences: int = 0
    summed: bool = False
    extreme: bool = False  # whether the windows' largest value counts, not their mean
    gaps: bool = True  # whether it is defined for a record with missing samples
    # what a hybrid consists of, by ascending tau; the last one is multiplied by the bias ratio kf
    parts: tuple["Statistic", ...] = ()
    join: float = 0.2  # for a hybrid: share of the record beyond which the last part makes the points
    # for a hybrid: the part of the last one's degrees of freedom that is left, as kf scatters too, under a term whose
    # Allan deviation has this slope, where m is this share of the record
    kept: Callable[[float, float], float] = lambda slope, share: 1.0
    scheme: Scheme = Scheme()  # how long windows are reduced; for a row with a `window` that is no difference
    published: PublishedBias | None = None  # the bias factors as published; None where there is no bias
    # as published; KeyError for a power law that the publication does not treat
    published_edf: Callable[[int, int, int], float] | None = None
    synonyms: tuple[str, ...] = ()  # other names by which it is asked for; they are suggested, not taken

    @property
    def sliding(self) -> bool:
        """Whether windows of a record share its squares: those of second or third differences at every sample."""
        return self.overlapped and self.differences in (2, 3) and not self.summed

    @property
    def readable(self) -> bool:
        """Whether its curve can be fitted: its expectation is known for every term and any length of the record."""
        # That of a hybrid is, once its bias ratio is divided out.
        return self.order > 1 and not self.power and self.window is not None

    @property
    def allan(self) -> bool:
        """Whether its expectation is the Allan variance: every term a straight line of the textbook's slope."""
        plain = self.differences == 2 and not self.summed and not self.power
        return plain and float(self.norm(np.ones(1, dtype=np.int64))[0]) == 2.0

    def joined(self, join: float) -> "Statistic":
        """The hybrid whose last part makes the points beyond this share of the record; any other statistic as it is."""
        return replace(self, join=join) if self.parts and join != self.join else self

    def part_of(self, m: IntArray, size: int) -> IntArray:
        """Which part of a hybrid makes the point, 0 for any other statistic, shape of m."""
        return np.asarray((m > self.join * size) & (len(self.parts) > 1), dtype=np.int64)

    def part_at(self, m: int, size: int) -> "Statistic":
        """The part of a hybrid that makes a point; any other statistic itself."""
        return self.parts[int(self.part_of(np.array([m]), size)[0])] if self.parts else self

    @property
    def longest(self) -> float:
        """The longest averaging time, as a share of the record."""
        return self.tau_factor / max(self.span[0], 1)

    def largest(self, n: int) -> int:
        """The largest averaging factor of a record of n intervals; 0 if there is none."""
        if self.parts:
            return self.parts[-1].largest(n)
        per, fixed = self.span
        most = (n - fixed) // per if per else n - 1
        return max(0, most - most % self.step)

    def count(self, n: int | IntArray, m: IntArray) -> IntArray:
        """Number of windows in n intervals, shape of m; 0 where none fits."""
        per, fixed = self.span
        room = n - (per * m + fixed)
        return np.maximum(0, (room if self.overlapped else room // m) + 1)


def seconds(row: Statistic, n: int, m: IntArray) -> float:
    """About how long a statistic of n intervals takes at averaging factors m, s."""
    if row.parts:
        return sum(seconds(part, n, m[m % part.step == 0]) for part in row.parts[-1:]) + 4e-12 * n**2
    return 1e-9 * row.pace * float(row.count(n, m).sum())


def constant(value: float) -> Callable[[IntArray | FloatArray], FloatArray]:
    """A norm that is the same for every averaging factor."""
    return lambda m: np.full(np.shape(m), value)


def binomials(order: int) -> FloatArray:
    """Coefficients of a difference: 1, -2, 1 or 1, -3, 3, -1 (up to its sign)."""
    return np.array([(-1.0) ** k * math.comb(order, k) for k in range(order + 1)])


def binomial_window(order: int) -> Callable[[int], Window]:
    """The window of a difference of the angle at stride m."""

    def window(m: int) -> Window:
        row = np.zeros((1, order * m + 1))
        row[0, ::m] = binomials(order)
        return np.ones(1), row

    return window
