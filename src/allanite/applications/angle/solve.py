"""Constants from samples: sample by sample, or all at once; the solution, and tests of its residuals."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, ClassVar, NamedTuple

import numpy as np

from allanite.extending import (  # isort: skip
    BoolArray, DataError, Finding, FloatArray, IntArray, Value, chance, demand_level, demand_name, join,
    say, say_count)  # fmt: skip

from .squareroot import SquareRoot, batch

PASSED = 0.01  # p-value below which a test has failed
FALSE_ALARM = 1e-3  # probability, for a whole record of white noise, that a sample is omitted or a harmonic is named
BROKEN = 1e-5  # p-value of a test below which limits would not hold
MISSING = "order"  # name of a finding about a harmonic that the model lacks
MOST_OMITTED = 0.1  # part of the samples beyond which what deviates is no outlier, but the noise


@dataclass(frozen=True, repr=False)
class InnovationTest(Value):
    """Result of a test of the innovations: `p` is the p-value."""

    _also: ClassVar[tuple[str, ...]] = ("passed",)

    name: str
    title: str
    statistic: float
    p: float
    failed: str

    @property
    def passed(self) -> bool:
        """Whether the test is passed."""
        return self.p >= PASSED

    def __str__(self) -> str:
        return join("", (self.title if self.passed else self.failed, f" ({chance(self.p)})"))


def white(innovations: FloatArray) -> tuple[float, float, str]:
    """Ljung and Box: sum of squared autocorrelations at up to 20 lags."""
    from scipy.special import gammaincc

    n, lags = innovations.size, max(1, min(20, innovations.size // 5))
    centred = innovations - innovations.mean()
    r = np.array([centred[k:] @ centred[: n - k] for k in range(1, lags + 1)]) / (centred @ centred)
    q = float(n * (n + 2) * (r**2 / (n - np.arange(1, lags + 1))).sum())
    words = say("successive innovations are correlated ({correlation:+.2f}), so that the standard deviations are too "
                "small; model what is missing (another harmonic, a drift), or sample at longer intervals",
                correlation=float(r[0]))  # fmt: skip
    return q, float(gammaincc(lags / 2, q / 2)), words


def steady(innovations: FloatArray) -> tuple[float, float, str]:
    """Brown, Durbin and Evans: the running sum of innovations against its two slanted limits."""
    from scipy.special import ndtr

    r = np.arange(1, innovations.size + 1) / innovations.size
    way = np.abs(np.cumsum(innovations)) / math.sqrt(innovations.size) / (1 + 2 * r)
    a = float(way.max())
    p = 2 * (ndtr(-3 * a) + math.exp(-4 * a * a) * ndtr(a))
    words = say("the running sum of the innovations exceeds its limits after {sample} of {samples} samples: the "
                "constants changed, or the samples drift", sample=int(way.argmax()) + 1, samples=r.size)  # fmt: skip
    return a, float(min(p, 1.0)), words


TESTS: dict[str, tuple[str, Callable[[FloatArray], tuple[float, float, str]]]] = {
    "white": (say("the innovations are uncorrelated"), white), "steady": (say("the constants do not change"), steady),
}  # fmt: skip
"""Name: title, and innovations of unit variance -> (statistic, p, words if it fails)."""


def checks(innovations: FloatArray, squares: float, freedom: int, *, given: bool) -> tuple[InnovationTest, ...]:
    """Every test of `TESTS`; of noise that was given, also whether `squares`, what is left, are as many."""
    tests = tuple(InnovationTest(name, title, *test(innovations)) for name, (title, test) in TESTS.items())
    if not given:
        return tests
    from scipy.special import gammainc, gammaincc

    # whether the noise is as large as was said: chi-square of what is left, both ways
    low, high = float(gammainc(freedom / 2, squares / 2)), float(gammaincc(freedom / 2, squares / 2))
    ratio = math.sqrt(squares / freedom)
    words = say("the residuals are {ratio:.3g} times the sigma given; correct sigma, or omit it to have it estimated",
                ratio=ratio)  # fmt: skip
    title = say("the noise is as large as sigma states")
    return InnovationTest("level", title, ratio, min(1.0, 2 * min(low, high)), words), *tests


@dataclass(frozen=True, eq=False, repr=False)
class History(Value):
    """The estimates after `count` samples, at `time`, shape (c,); values and errors, shape (c, p)."""

    count: IntArray
    time: FloatArray
    values: FloatArray
    errors: FloatArray


@dataclass(frozen=True, eq=False, repr=False)
class Solution(Value):
    """Estimated constants.

    Attributes
    ----------
    names, values : tuple and array, shape (p,)
    covariance : array, shape (p, p)
    sigma : float
        Standard deviation of a sample's noise; `given` says whether the user gave it, or it was estimated.
    freedom : float
        Degrees of freedom that intervals have: infinite where sigma was given.
    condition : float
        Condition number of the samples alone, columns scaled.
    prior : array, shape (p,), or None
        Standard deviations before the samples, where they were said.
    history, innovations, checks, findings
        How the estimate was reached; what each reading added, in standard deviations, shape (n,); whether that is
        noise; what must be known beside the numbers.
    known : SquareRoot
        What further samples (divided by sigma) can be added to.
    omitted : array of int
        Samples that were omitted as outliers.
    """

    _keys: ClassVar[dict[str, str]] = {"given": "sigma_given"}
    _alike = ("names values covariance",)

    names: tuple[str, ...]
    values: FloatArray
    covariance: FloatArray
    sigma: float
    given: bool
    freedom: float
    condition: float
    prior: FloatArray | None
    history: History
    innovations: FloatArray
    checks: tuple[InnovationTest, ...]
    known: SquareRoot
    findings: tuple[Finding, ...] = ()
    omitted: IntArray = field(default_factory=lambda: np.empty(0, np.int64))

    @property
    def complete(self) -> bool:
        """Whether limits can be stated: no harmonic is missing, and no test fails beyond doubt."""
        return all(f.name != MISSING for f in self.findings) and all(c.p >= BROKEN for c in self.checks)

    def limits(self, name: str, level: float = 0.95) -> tuple[float | None, float | None]:
        """The interval of a constant; None where the model is not complete, so that it would not hold."""
        return self.interval(name, level) if self.complete else (None, None)

    @property
    def errors(self) -> FloatArray:
        """Standard errors, shape (p,)."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def correlation(self) -> FloatArray:
        """Shape (p, p)."""
        return correlation_of(self.covariance)

    def index(self, name: str) -> int:
        """Place of a constant."""
        demand_name("constant", name, self.names)
        return self.names.index(name)

    def __getitem__(self, name: str) -> float:
        return float(self.values[self.index(name)])

    def error(self, name: str) -> float:
        """Standard error of a constant."""
        return float(self.errors[self.index(name)])

    def interval(self, name: str, level: float = 0.95) -> tuple[float, float]:
        """Two-sided confidence limits; Student's where sigma was estimated."""
        half = quantile(level, self.freedom) * self.error(name)
        return self[name] - half, self[name] + half

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings to report with the results: findings, and checks that failed."""
        return (*map(str, self.findings), *(str(check) for check in self.checks if not check.passed))

    def shown(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data of the result alone, SI: the constants with limits at `level`, without the way to them."""
        keys = ("name", "value", "standard_error", "low", "high")
        rows = ((name, self[name], self.error(name), *self.limits(name, level)) for name in self.names)
        return {"sigma": self.sigma, "sigma_given": self.given, "readings": self.innovations.size,
                "condition": self.condition, "level": level, "omitted": self.omitted.tolist(),
                "constants": [dict(zip(keys, row, strict=True)) for row in rows],
                "correlation": self.correlation.tolist(), "checks": [check.to_dict() for check in self.checks],
                "findings": [finding.to_dict() for finding in self.findings]}  # fmt: skip

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data, SI."""
        return super().to_dict(level) | self.shown(level)

    def _summary(self) -> str:
        return f"{', '.join(self.names)} of {self.innovations.size} readings"


def correlation_of(covariance: FloatArray) -> FloatArray:
    """Correlation from covariance, both of shape (p, p)."""
    errors = np.sqrt(np.diag(covariance))
    return np.asarray(covariance / np.outer(errors, errors))


def quantile(level: float, freedom: float) -> float:
    """Half width of an interval of this level, in standard errors."""
    from scipy.special import ndtri, stdtrit

    demand_level(level)
    above = 0.5 + level / 2
    return float(ndtri(above) if math.isinf(freedom) else stdtrit(freedom, above))


VAGUE = 1e7  # a prior deviation, in units of what one reading tells of a constant, that no result notices
SINGULAR = 1e-12  # singular value over the largest, below which a combination of constants is not seen at all
SEPARATE = 1e5  # condition above which that prior deviation grows with it, for the least certain combination
ROBUST = 1.4826  # standard deviation of normal noise over its median size
ROUNDS = 20  # times that the gate is applied again to what it has left
CHECKPOINTS = 200  # instants of the history that are kept


class System(NamedTuple):
    """Samples ``values = rows x + noise`` of constants x called `names`; `time` orders them."""

    names: tuple[str, ...]
    rows: FloatArray
    values: FloatArray
    time: FloatArray


def solve(
    system: System, *, sigma: float | None = None, prior: FloatArray | None = None, method: str = "recursive"
) -> Solution:
    """Constants from samples without outliers."""
    whole, (alone, spread, freedom) = system, _alone(system, sigma, prior)
    kept = within_gate(system, alone, sigma)
    if not kept.all():
        system = System(system.names, *(part[kept] for part in system[1:]))
        alone, spread, freedom = _alone(system, sigma, prior)
    wide = VAGUE * max(1.0, alone.condition / SEPARATE) * spread / np.sqrt((system.rows**2).mean(axis=0))
    vague = wide if prior is None else prior
    rows, values = system.rows / spread, system.values / spread
    demand_name("method", method, METHODS)
    end, history, innovations = METHODS[method](SquareRoot.before(vague), rows, values, system.time)
    return Solution(names=system.names,
                    values=end.values, covariance=end.covariance, sigma=spread, given=sigma is not None,
                    freedom=math.inf if sigma is not None else freedom, condition=alone.condition,
                    prior=prior, history=history, innovations=innovations, known=end, omitted=np.flatnonzero(~kept),
                    checks=checks(innovations, alone.squares / spread**2, freedom, given=sigma is not None),
                    findings=omission(whole.time[~kept], kept.size, gate(kept.size)))  # fmt: skip


def within_gate(system: System, known: SquareRoot, sigma: float | None) -> BoolArray:
    """Which samples are within the gate: the innovation of each, given all others that are."""
    n, p = system.rows.shape
    kept, limit = np.ones(n, dtype=bool), gate(n)
    for _ in range(ROUNDS):
        scale, direction = known.singular
        length = np.linalg.norm(known.factor[:, :-1], axis=0)
        used = scale > SINGULAR * scale[0]
        basis = system.rows @ ((direction[used] / scale[used, None]) / np.where(length > 0, length, 1.0)).T
        weight = (basis**2).sum(axis=1)
        rest = system.values - basis @ (basis.T @ np.where(kept, system.values, 0.0))
        rest /= np.sqrt(np.maximum(1 + np.where(kept, -weight, weight), 1e-6))
        inside = np.abs(rest) <= limit * max(sigma or 0.0, ROBUST * float(np.median(np.abs(rest[kept]))))
        if (inside == kept).all():
            return kept
        if inside.sum() <= max(p + 2, (1 - MOST_OMITTED) * n):
            break
        kept = inside
        known = batch(system.rows[kept], system.values[kept])
    return np.ones(n, dtype=bool)


def gate(count: int) -> float:
    """Standard deviations that white noise exceeds once in a thousand records of so many samples."""
    from scipy.special import ndtri

    return float(-ndtri(FALSE_ALARM / (2 * count)))


def omission(at: FloatArray, count: int, threshold: float) -> tuple[Finding, ...]:
    """A finding about outliers at these times, of a record of so many samples."""
    if not at.size:
        return ()
    what = say_count(at.size, "{count} of {all} samples is omitted as an outlier (at {when:.6g} s)",
                     "{count} of {all} samples are omitted as outliers (the first at {when:.6g} s)", all=count,
                     when=float(at[0]))  # fmt: skip
    effect = say("their innovations exceed {threshold:.2g} standard deviations, as noise does in one of 1000 records",
                 threshold=threshold)  # fmt: skip
    return (Finding("outliers", what, effect),)


def _alone(system: System, sigma: float | None, prior: FloatArray | None) -> tuple[SquareRoot, float, int]:
    """What the samples tell without a prior; the noise of one; the degrees of freedom that are left."""
    n, p = system.rows.shape
    if n <= p:
        raise DataError(f"{n} samples are too few for {p} constants and their noise; record for longer")
    if np.ptp(system.values) == 0:
        raise DataError(f"the samples are constant (always {system.values[0]:.10g}); check the column")
    alone = batch(system.rows, system.values)
    values, directions = alone.singular
    rank = int((values > SINGULAR * values[0]).sum())
    if rank < p and prior is None:
        mixed = [name for name, part in zip(system.names, np.abs(directions[-1]), strict=True) if part > 0.1]
        raise DataError(f"the samples determine {rank} combinations of {p} constants; {', '.join(mixed)} cannot be "
                        "separated: omit one of them, let the angles move further, or give a prior")  # fmt: skip
    # a column in the span of others leaves rounding noise on the diagonal; least squares proper ignores it
    columns, rest = alone.factor[:, :-1], alone.factor[:, -1]
    columns = columns / np.where((length := np.linalg.norm(columns, axis=0)) > 0, length, 1.0)
    x, *_ = np.linalg.lstsq(columns, rest, rcond=SINGULAR)
    squares = alone.squares + float(((rest - columns @ x) ** 2).sum())
    spread = math.sqrt(squares / (n - rank)) if sigma is None else sigma
    if spread == 0:
        raise DataError("the constants explain every sample exactly, so that the noise cannot be estimated; give sigma")
    return SquareRoot(alone.factor, squares, n), spread, n - rank


Run = tuple[SquareRoot, History, FloatArray]


def _recursive(start: SquareRoot, rows: FloatArray, values: FloatArray, time: FloatArray) -> Run:
    marks = np.unique(np.linspace(0, values.size, min(CHECKPOINTS, values.size) + 1).astype(np.int64))
    known, innovations, estimates = start, [], []
    for first, last in pairwise(marks.tolist()):
        known, part = known.absorb(rows[first:last], values[first:last])
        innovations.append(part)
        estimates.append((known.values, known.errors))
    history = History(marks[1:], time[marks[1:] - 1], *map(np.array, zip(*estimates, strict=True)))
    return known, history, np.concatenate(innovations)


def _batch(start: SquareRoot, rows: FloatArray, values: FloatArray, time: FloatArray) -> Run:
    known = batch(rows, values, 1 / np.diag(start.factor))
    history = History(np.array([values.size]), time[-1:], known.values[None], known.errors[None])
    return known, history, values - rows @ known.values


METHODS = {"recursive": _recursive, "batch": _batch}
