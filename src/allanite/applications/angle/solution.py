"""Solution: constants estimated from samples, the convergence of the estimates, and tests of the residuals."""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from allanite.extending import Finding, FloatArray, IntArray, UsageError, Value, demand_level

from .residuals import InnovationTest
from .squareroot import SquareRoot


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
    """

    _keys: ClassVar[dict[str, str]] = {"given": "sigma_given"}

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
        if name not in self.names:
            raise UsageError(f"no constant {name!r}; constants: {', '.join(self.names)}")
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
        rows = ((name, self[name], self.error(name), *self.interval(name, level)) for name in self.names)
        return {
            "sigma": self.sigma,
            "sigma_given": self.given,
            "readings": self.innovations.size,
            "condition": self.condition,
            "level": level,
            "constants": [dict(zip(keys, row, strict=True)) for row in rows],
            "correlation": self.correlation.tolist(),
            "checks": [check.to_dict() for check in self.checks],
            "findings": [finding.to_dict() for finding in self.findings],
        }

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
