"""Covariance between averaging times of every statistic, of hybrids with the scatter of their bias ratio."""

import numpy as np

from allanite.core.aliases import public
from allanite.core.model import ModelLike, model_of
from allanite.statistics.grids import checked, part_of
from allanite.statistics.row import FloatArray, IntArray, Statistic
from allanite.statistics.table import STATISTICS

from .moments import by_term, covariance_by_term, noise_of

RATIOS = 12
"""Number of ratios that are evaluated; the bias ratio is the mean of up to thousands, which vary smoothly."""


@public
def covariance(
    row: Statistic, model: ModelLike, m: IntArray, size: int, rate: float, *, join: float = 0.2, divisor: int = 30
) -> FloatArray:
    """Covariance between the variances at averaging factors `m` of one record without gaps, SI, shape (k, k).

    Exact for overlapping differences (oadev, ohdev, mdev, tdev), except for the quadrature, and for windows of up to
    750 points; for longer ones (theo1, pdev, mtotdev, ttotdev, htotdev) within 1 % of the two standard deviations, and
    within 0.1 % but for white angle noise. What noise and a ramp add together is exact for windows of up to 2^19
    points. That of theobr and theoh is of first order in the scatter of their bias ratio. Of a model with sinusoids,
    that of its noise.

    Raises
    ------
    UsageError
        It is not known: of totdev, maxima and windows that do not overlap.

    Examples
    --------
    >>> from allanite import N
    >>> C = covariance(STATISTICS["theo1"], N(1.0, "rad/sqrt(s)"), np.array([10, 20]), 1000, 1.0)
    >>> (np.sqrt(np.diag(C)) * [7.5, 15]).round(3).tolist()
    [0.068, 0.089]
    """
    noise, m = noise_of(model_of(model)), checked(m, row, size, join)
    if not row.parts:
        return np.asarray(covariance_by_term([row] * m.size, noise, m, size, rate).sum(axis=(2, 3)))
    which = part_of(row, m, size, join)
    late = which == len(row.parts) - 1
    # some of the ratios i = 0 .. last, and the weight of each in their mean
    last = max((size + 1) // divisor - 3, 0)
    i = np.unique(np.rint(np.linspace(0, last, RATIOS)).astype(np.int64))
    weight = np.array([np.interp(np.arange(last + 1), i, row) for row in np.eye(i.size)]).mean(axis=1)
    allan, theo = STATISTICS[row.parts[-1].target], row.parts[-1]
    rows = [row.parts[k] for k in which] + [allan] * i.size + [theo] * i.size
    factors = np.concatenate((m, 9 + 3 * i, 12 + 4 * i))
    E = np.array([by_term(part, noise, int(k), size, rate).sum() for part, k in zip(rows, factors, strict=True)])
    a, t = E[m.size : m.size + i.size], E[m.size + i.size :]
    ratio = float(weight @ (a / t))
    slopes = np.zeros((m.size, E.size))
    slopes[:, : m.size] = np.diag(np.where(late, ratio, 1.0))
    slopes[:, m.size :] = np.outer(E[: m.size] * late, np.concatenate((weight / t, -weight * a / t**2)))
    C = covariance_by_term(rows, noise, factors, size, rate).sum(axis=(2, 3))
    return np.asarray(slopes @ C @ slopes.T)
