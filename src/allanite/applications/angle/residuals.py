"""Whether the residuals are pure noise: tests of the innovations, as a table."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from allanite.extending import FloatArray, Value, chance, join, say

PASSED = 0.01
"""p-value below which a test has failed."""


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


def white(left: FloatArray) -> tuple[float, float, str]:
    """Ljung and Box: sum of squared autocorrelations at up to 20 lags."""
    from scipy.special import gammaincc

    n, lags = left.size, max(1, min(20, left.size // 5))
    centred = left - left.mean()
    r = np.array([centred[k:] @ centred[: n - k] for k in range(1, lags + 1)]) / (centred @ centred)
    q = float(n * (n + 2) * (r**2 / (n - np.arange(1, lags + 1))).sum())
    words = say(
        "successive innovations are correlated ({correlation:+.2f}), so that the standard deviations are too small; "
        "model what is missing (another harmonic, a drift), or sample at longer intervals",
        correlation=float(r[0]),
    )
    return q, float(gammaincc(lags / 2, q / 2)), words


def steady(left: FloatArray) -> tuple[float, float, str]:
    """Brown, Durbin and Evans: the running sum of innovations against its two slanted limits."""
    from scipy.special import ndtr

    r = np.arange(1, left.size + 1) / left.size
    way = np.abs(np.cumsum(left)) / math.sqrt(left.size) / (1 + 2 * r)
    a = float(way.max())
    p = 2 * (ndtr(-3 * a) + math.exp(-4 * a * a) * ndtr(a))
    words = say(
        "the running sum of the innovations exceeds its limits after {sample} of {samples} samples: the constants "
        "changed, or the samples drift",
        sample=int(way.argmax()) + 1,
        samples=left.size,
    )
    return a, float(min(p, 1.0)), words


def outlying(left: FloatArray) -> tuple[float, float, str]:
    """The largest residual, against as many normal ones: an early innovation is small, for nothing is expected yet."""
    from scipy.special import log_ndtr

    at = int(np.abs(left).argmax())
    worst = float(abs(left[at]))
    tail = math.exp(math.log(2.0) + float(log_ndtr(-worst)))
    p = -math.expm1(left.size * math.log1p(-min(tail, 1 - 1e-16)))
    words = say(
        "sample {sample} deviates by {deviation:.3g} standard deviations; inspect it, or omit it",
        sample=at,
        deviation=worst,
    )
    return worst, p, words


TESTS: dict[str, tuple[str, bool, Callable[[FloatArray], tuple[float, float, str]]]] = {
    "white": (say("the innovations are uncorrelated"), True, white),
    "steady": (say("the constants do not change"), True, steady),
    "outlying": (say("no sample is an outlier"), False, outlying),
}
"""Name: title, whether of innovations or of residuals, and these -> (statistic, p, words if it fails)."""


def checks(innovations: FloatArray, residuals: FloatArray) -> tuple[InnovationTest, ...]:
    """Every test of `TESTS`; innovations and residuals of shape (n,), with unit variance."""
    return tuple(
        InnovationTest(name, title, *test(innovations if innovating else residuals))
        for name, (title, innovating, test) in TESTS.items()
    )


def level_check(squares: float, freedom: int) -> InnovationTest:
    """Whether the noise is as large as was said: chi-square of what is left, both ways."""
    from scipy.special import gammainc, gammaincc

    low, high = float(gammainc(freedom / 2, squares / 2)), float(gammaincc(freedom / 2, squares / 2))
    ratio = math.sqrt(squares / freedom)
    words = say(
        "the residuals are {ratio:.3g} times the sigma given; correct sigma, or omit it to have it estimated",
        ratio=ratio,
    )
    title = say("the noise is as large as sigma states")
    return InnovationTest("level", title, ratio, min(1.0, 2 * min(low, high)), words)
