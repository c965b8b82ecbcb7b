"""Two records of the same noise, such as raw and corrected samples, compared as a pair.

Two series of equal variance have a sum and a difference that do not correlate, whatever the correlation of the two
themselves (E. J. G. Pitman, W. A. Morgan, Biometrika 31 (1939) 9, 13). Independent records are distinguished by their
own scatter; these by that of their difference only.
"""

from dataclasses import dataclass, replace

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.curve import Curve
from allanite.core.record import Record
from allanite.statistics import deviation

from .change import Homogeneity
from .contrast import chi_square

ALIKE = 0.7
"""Correlation of the steps from which on two records are a pair."""

FEWEST = 8
"""Coefficients of the cosine transform in the lowest range of frequencies; the others are octaves above it."""


BLOCKS = (1, 8, 64, 512)
"""Samples of the means whose steps are correlated: records that share their noise only below some frequency, such as
raw and smoothed ones, are seen in the longer ones.
"""

MEANS = 100
"""Means that there must be: of so few independent ones, no correlation reaches `ALIKE`."""


def resemblance(records: tuple[Record, Record]) -> float:
    """Largest correlation of the steps of two records' means; 0 where they are not sample by sample.

    Steps, because levels correlate by chance: two random walks often do, two ramps always.
    """
    if records[0].size != records[1].size or records[0].rate != records[1].rate:
        return 0.0
    first, second = _together(records)
    if first.size < FEWEST:
        return 0.0
    lengths = [m for m in BLOCKS if m == 1 or first.size // m >= MEANS]
    return max(float(np.corrcoef(_steps(first, m), _steps(second, m))[0, 1]) for m in lengths)


def _steps(values: FloatArray, m: int) -> FloatArray:
    """Differences of successive means over m samples."""
    return np.asarray(np.diff(values[: values.size // m * m].reshape(-1, m).mean(axis=1)))


def _together(records: tuple[Record, Record]) -> tuple[FloatArray, FloatArray]:
    """The rates of both where both are there."""
    first, second = (record.rate_values for record in records)
    there = np.isfinite(first) & np.isfinite(second)
    return first[there], second[there]


def paired_homogeneity(records: tuple[Record, Record]) -> Homogeneity:
    """Whether the two have equal power in every octave of frequency: the likelihood ratio of no correlation."""
    from scipy.fft import dct

    first, second = (dct(values - values.mean(), norm="ortho")[1:] for values in _together(records))
    total, gone = first + second, second - first
    edges = FEWEST * 2 ** np.arange(int(np.log2(total.size / FEWEST)))
    starts = np.concatenate(([0], edges))
    product, square, other = (np.add.reduceat(v, starts) for v in (total * gone, total**2, gone**2))
    count = np.diff(np.concatenate((starts, [total.size])))
    r2 = product**2 / np.maximum(square * other, np.finfo(float).tiny)
    # with this factor the mean is that of a chi-square down to few coefficients
    statistic = float(-((count - 1.5) * np.log1p(-np.minimum(r2, 1 - 1e-15))).sum())
    return Homogeneity(statistic, starts.size, chi_square(statistic, starts.size), 0)


@dataclass(frozen=True, eq=False)
class PairedLaw:
    """Law of the ratio of two variances that correlate by `correlation`, with `edf` degrees of freedom, shape (k,)."""

    correlation: FloatArray
    edf: FloatArray

    def p(self, ratio: FloatArray) -> FloatArray:
        """Two-sided probability of a ratio as far from 1."""
        from scipy.special import stdtr

        t = np.abs(ratio - 1) / np.sqrt(4 * ratio * self._apart / self._dof)
        return np.asarray(2 * stdtr(self._dof, -t))

    def limits(self, ratio: FloatArray, level: float) -> tuple[FloatArray, FloatArray]:
        """Limits of the ratio of the expectations, from a measured ratio."""
        from scipy.special import stdtrit

        K = 1 + 2 * self._apart * stdtrit(self._dof, (1 + level) / 2) ** 2 / self._dof
        wide = K + np.sqrt(K * K - 1)
        return ratio / wide, ratio * wide

    @property
    def _dof(self) -> FloatArray:
        return np.asarray(np.maximum(self.edf - 1, 0.5))

    @property
    def _apart(self) -> FloatArray:
        return np.asarray(np.maximum(1 - self.correlation**2, 1e-15))


def paired_law(records: tuple[Record, Record], curves: tuple[Curve, Curve]) -> PairedLaw:
    """The law of the ratio of two curves' variances, from the curves of the records' sum and difference."""
    first, second = (record.rate_values for record in records)
    before, after = curves
    both = []
    for values in (first + second, first - second):
        record = replace(
            records[0], values=values, unit=records[0].signal.unit, kind=records[0].signal.kind, scale=None
        )
        both.append(deviation(record, before.statistic, m=before.m.tolist(), noise=None).variance)
    correlation = (both[0] - both[1]) / 4 / np.sqrt(before.variance * after.variance)
    return PairedLaw(np.clip(correlation, -1, 1), np.minimum(before.edf, after.edf))
