"""The confidence law of a curve: degrees of freedom and limits, worked out when first asked."""

from functools import cache

import numpy as np

from allanite.curve import Law
from allanite.model import Model

from .grids import part_of
from .moments import RANDOM_RATIO, Runs, edf
from .row import FloatArray, IntArray, Statistic


def law(row: Statistic, model: Model, m: IntArray, runs: Runs, *, size: int, rate: float, join: float) -> Law:
    """Chi-square with the exact degrees of freedom of the model's mixture."""

    @cache
    def degrees() -> FloatArray:
        return degrees_of(row, model, m, runs, size=size, rate=rate, join=join)

    def limits(level: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        from scipy.special import gammaincinv

        e = degrees()
        low, high = (e / (2 * gammaincinv(e / 2, p)) for p in ((1 + level) / 2, (1 - level) / 2))
        return e, low, high

    return limits


def degrees_of(
    row: Statistic, model: Model, m: IntArray, runs: Runs, *, size: int, rate: float, join: float
) -> FloatArray:
    """EDF at averaging factors of any row, hybrids included."""
    if not row.parts:
        return edf(row, model, m, runs, rate)
    which, result = part_of(row, m, size, join), np.empty(m.size)
    for i, part in enumerate(row.parts):
        here = which == i
        result[here] = edf(part, model, m[here], runs, rate)
        if i == len(row.parts) - 1:
            share = m[here] / size
            result[here] *= np.select([share < edge for edge, _ in RANDOM_RATIO], [f for _, f in RANDOM_RATIO])
    return np.maximum(result, 1.0)
