"""Bias factors as published: what tables and other programs divide a variance by.

They are for comparison. The exact expectation of a statistic under the noise at hand is `allanite.expected`.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from allanite.core.errors import UsageError
from allanite.statistics.row import FloatArray, IntArray, Statistic

Coefficients = tuple[float, ...]


@dataclass(frozen=True)
class PublishedBias:
    """A row of `PUBLISHED_BIAS`.

    Attributes
    ----------
    reference : str
    limits : str
        Where it is known to fail.
    factor : (coefficients, m, size) -> E[estimate] / E[target], shape of m
        For averaging factors m of a record of `size` intervals.
    coefficients : dict
        By alpha; a power law that is not here has no published factor.
    """

    reference: str
    limits: str
    factor: Callable[[Coefficients, IntArray, int], FloatArray]
    coefficients: dict[int, Coefficients]


def _theo1(c: Coefficients, m: IntArray, size: int) -> FloatArray:
    return np.asarray(1 / (c[0] + c[1] / (0.75 * m) ** c[2]))


def _total(c: Coefficients, m: IntArray, size: int) -> FloatArray:
    return np.asarray(1 - c[0] * m / size)


def _constant(c: Coefficients, m: IntArray, size: int) -> FloatArray:
    return np.full(m.shape, c[0])


def _beyond_one(c: Coefficients, m: IntArray, size: int) -> FloatArray:
    return np.where(m > 1, c[0], 1.0)


_MODIFIED_TOTAL = PublishedBias(
    reference="D. A. Howe & F. Vernotte, PTTI 1999; NIST SP 1065 section 5.2.12",
    limits="one number for every m: at m = 1 the statistic is half its target for any noise, and beyond m = 8 the "
    "published factors are 2 to 6 % low (high by 2 % for random walk)",
    factor=_constant,
    coefficients={2: (0.94,), 1: (0.83,), 0: (0.73,), -1: (0.70,), -2: (0.69,)},
)

PUBLISHED_BIAS: dict[str, PublishedBias] = {
    "totdev": PublishedBias(
        reference="C. A. Greenhall, D. A. Howe & D. B. Percival, IEEE UFFC 46, 1999; NIST SP 1065 section 5.2.11",
        limits="tau up to half the record; nothing for noise of the angle, where the variance is high by 1.34 tau/T",
        factor=_total,
        coefficients={0: (0.0,), -1: (0.481,), -2: (0.75,)},
    ),
    "mtotdev": _MODIFIED_TOTAL,
    "ttotdev": _MODIFIED_TOTAL,
    "htotdev": PublishedBias(
        reference="D. A. Howe et al., PTTI 2000; NIST SP 1065 section 5.2.14",
        limits="nothing for noise of the angle; m = 1 is the overlapped Hadamard variance, without bias",
        factor=_beyond_one,
        coefficients={0: (0.995,), -1: (0.851,), -2: (0.771,), -3: (0.717,), -4: (0.679,)},
    ),
    "theo1": PublishedBias(
        reference="D. A. Howe & T. N. Tasset, EFTF 2004; NIST SP 1065 section 5.2.15: AVAR = Theo1 (a + b/t^c), "
        "t = 0.75 m",
        limits="m of 10 or more",
        factor=_theo1,
        coefficients={
            2: (0.09, 0.74, 0.40),
            1: (0.14, 0.82, 0.30),
            0: (1.00, 0.00, 0.00),
            -1: (1.87, -1.05, 0.79),
            -2: (2.70, -1.53, 0.85),
        },
    ),
}


def published_bias(row: Statistic, alpha: int | IntArray, m: IntArray, size: int) -> FloatArray:
    """The published ratio of a statistic's expectation to that of its target: what a variance is divided by.

    Parameters
    ----------
    row : Statistic
        A statistic without bias, or whose bias is removed otherwise (theobr, theoh), has 1 for every noise.
    alpha : int or array of int, shape of m
        Exponent of the spectrum of the rate at each averaging time, `identify_power_law`.
    m : array of int, shape (k,)
        Averaging factors.
    size : int
        Sample intervals of the record.

    Returns
    -------
    array, shape (k,)

    Raises
    ------
    UsageError
        Nothing is published for this statistic and noise.

    Examples
    --------
    >>> from allanite.statistics import STATISTICS
    >>> published_bias(STATISTICS["totdev"], -2, np.array([100, 200]), 400).tolist()
    [0.8125, 0.625]
    """
    m = np.asarray(m)
    alphas = np.broadcast_to(alpha, m.shape)
    result = np.ones(m.shape)
    if row.name not in PUBLISHED_BIAS:
        return result
    published = PUBLISHED_BIAS[row.name]
    for law in np.unique(alphas).tolist():
        if law not in published.coefficients:
            known = ", ".join(map(str, sorted(published.coefficients)))
            raise UsageError(
                f"no bias of {row.name} is published for noise of alpha = {law}, only for {known}; "
                "divide by the exact expectation instead, or take a statistic without bias"
            )
        here = alphas == law
        result[here] = published.factor(published.coefficients[law], m[here], size)
    return result
