"""Bias factors as published: what tables and other programs divide a variance by.

They are for comparison. The exact expectation of a statistic under the noise at hand is `allanite.expected`.
"""

import numpy as np

from allanite.core.errors import UsageError
from allanite.statistics.row import FloatArray, IntArray, Statistic


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
    published = row.published
    if published is None:
        return result
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
