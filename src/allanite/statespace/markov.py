"""Flicker approximated by a sum of Gauss-Markov processes over a range of averaging times."""

import math
from dataclasses import dataclass

import numpy as np

from allanite.core.errors import UsageError
from allanite.statistics.row import FloatArray
from allanite.terms import TERMS
from allanite.terms.markov import gauss_markov

PER_DECADE = 40
"""Averaging times at which the sum is compared with flicker."""

MOST = 40
"""Processes beyond which no ripple is requested."""

TOP = 1.892
"""A process has the top of its Allan deviation at this multiple of its time constant."""


@dataclass(frozen=True, eq=False)
class MarkovSum:
    """Processes whose sum has the Allan variance of flicker with B = 1 between two averaging times.

    `time_constants` in s, RMS values `sizes` relative to B; `ripple` is the largest relative deviation from the Allan
    deviation of flicker in the range.
    """

    time_constants: FloatArray
    sizes: FloatArray
    ripple: float


def flicker_sum(tau: tuple[float, float], *, ripple: float = 0.02, order: int | None = None) -> MarkovSum:
    """The sum of Gauss-Markov processes that approximates flicker between two averaging times.

    Time constants are evenly spaced in the logarithm, over a span that is searched for; the powers are found by
    non-negative least squares of the logarithm of the Allan variance, and scaled so that the sum errs as far upwards as
    downwards.

    Examples
    --------
    >>> found = flicker_sum((1.0, 1000.0), ripple=0.05)
    >>> found.time_constants.size, found.ripple < 0.05
    (3, True)
    """
    low, high = tau
    if not 0 < low < high < math.inf:
        raise UsageError(f"a range of averaging times must be two numbers of s, 0 < low < high, not {low:g},{high:g}")
    if order is not None and not 1 <= order <= MOST:
        raise UsageError(
            f"the number of processes that approximate flicker must be between 1 and {MOST}, not {order!r}"
        )
    if not ripple > 0:
        raise UsageError(f"the ripple must be above 0, not {ripple!r}")
    for k in range(1, MOST + 1) if order is None else (order,):
        found = _best_span(low, high, k)
        if order is not None or found.ripple <= ripple:
            return found
    raise UsageError(
        f"{MOST} processes leave a ripple of {100 * found.ripple:.2g} % between {low:g} and {high:g} s; allow a "
        "larger ripple, or use a shorter range"
    )


def _best_span(low: float, high: float, k: int) -> MarkovSum:
    """The best of `k` processes: those at the ends may lie beyond the range, or within."""
    from scipy.optimize import minimize_scalar

    grid = np.geomspace(low, high, max(40, round(PER_DECADE * math.log10(high / low))))

    def fitted(beyond: float) -> MarkovSum:
        first, last = low / TOP * math.exp(-beyond), high / TOP * math.exp(beyond)
        T = np.geomspace(first, last, k) if k > 1 else np.array([math.sqrt(first * last)])
        from scipy.optimize import nnls

        columns = np.column_stack([allan_variance(grid, constant) for constant in T]) / TERMS["B"].level
        weight, power = np.ones(grid.size), np.zeros(T.size)
        for _ in range(12):
            power = nnls(columns * weight[:, None], weight)[0]
            ratio = columns @ power
            # the square of weight (ratio - 1) becomes that of ln(ratio)
            off = np.where(ratio == 1, 1.0, ratio - 1)
            weight = np.where(ratio == 1, 1.0, np.log(np.maximum(ratio, 1e-6)) / off)
        logs = np.log(columns @ power)
        middle = (logs.max() + logs.min()) / 2
        # of the deviation: half of the variance's
        return MarkovSum(T, np.sqrt(power * math.exp(-middle)), math.expm1((logs.max() - logs.min()) / 4))

    if k == 1:
        return fitted(0.0)
    # beyond the range a process helps little; within it, at most so far that the two ends meet
    limit = 0.45 * math.log(high / low)
    found = minimize_scalar(
        lambda x: fitted(float(x)).ripple, bounds=(-min(limit, 2.0), 2.0), method="bounded", options={"xatol": 0.01}
    )
    return fitted(float(found.x))


def allan_variance(tau: FloatArray, T: float) -> FloatArray:
    """For a Gauss-Markov process of RMS 1, ``(4 D(tau) - D(2 tau)) / (2 tau^2)``."""
    D = gauss_markov(1.0).structure
    u = tau / T
    return np.asarray((4 * D(u) - D(2 * u)) / (2 * u**2))
