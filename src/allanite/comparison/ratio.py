"""The ratio of two records' variances: its law, and the averaging times that both have (docs/derivations.md)."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from allanite.core.arrays import FloatArray, IntArray
from allanite.core.curve import Curve
from allanite.core.errors import DataError, UsageError
from allanite.core.fit import Fit
from allanite.core.model import Model
from allanite.core.record import Record
from allanite.phrases.phrase import join, say
from allanite.statistics import deviation
from allanite.statistics.confidence.chisquares import MIN_DEVIATE, ChiSquareSum, cumulants
from allanite.statistics.confidence.limits import mixtures
from allanite.statistics.estimator import integrated
from allanite.statistics.grids import grid_named
from allanite.statistics.table import CurvePoints, statistic_named

SAME_TIME = 0.005  # relative difference up to which two averaging times count as the same
HALVINGS, STEPS = 45, 40  # steps of the search for a saddlepoint, and maximum number of steps for a quantile
CONVERGED = 1e-5  # accuracy of a quantile, as a normal deviate


@dataclass(frozen=True, eq=False)
class RatioLaw:
    """Law of the ratio (second over first) of two independent variances, each over its expectation."""

    first: ChiSquareSum
    second: ChiSquareSum
    edf: tuple[FloatArray, FloatArray]  # shape (k,); their equivalent degrees of freedom

    def below(self, ratio: FloatArray) -> FloatArray:
        """Probability of a smaller ratio, shape (k,)."""
        from scipy.special import ndtr

        ratio = np.asarray(ratio, dtype=np.float64)
        low, high = -1 / (2 * ratio * _largest(self.first)), 1 / (2 * _largest(self.second))
        for _ in range(HALVINGS):
            t = (low + high) / 2
            rising = self._difference(t, ratio)[1] > 0
            low, high = np.where(rising, low, t), np.where(rising, t, high)
        t = (low + high) / 2
        K, _, K2, K3 = self._difference(t, ratio)
        r, v = np.sign(t) * np.sqrt(np.maximum(-2 * K, 0)), t * np.sqrt(K2)
        with np.errstate(divide="ignore", invalid="ignore"):
            probability = ndtr(r) + np.exp(-r * r / 2) / math.sqrt(2 * math.pi) * (1 / r - 1 / v)
        at_mean = 0.5 + K3 / K2**1.5 / (6 * math.sqrt(2 * math.pi))
        return np.asarray(np.where(np.abs(v) < MIN_DEVIATE, at_mean, probability))

    def _difference(self, t: FloatArray, ratio: FloatArray) -> tuple[FloatArray, ...]:
        """Cumulant function of B - x A, and its derivatives."""
        plus, minus = cumulants(self.second, t), cumulants(self.first, -ratio * t)
        return tuple(b + a * (-ratio) ** order for order, (a, b) in enumerate(zip(minus, plus, strict=True)))

    def p(self, ratio: FloatArray) -> FloatArray:
        """Two-sided probability of a ratio as far from its centre, shape (k,)."""
        below = self.below(ratio)
        return np.asarray(2 * np.minimum(below, 1 - below).clip(0.0, 0.5))

    def quantile(self, p: float) -> FloatArray:
        """The ratio below which it lies with probability p, shape (k,)."""
        from scipy.special import ndtri

        wanted, scale = float(ndtri(p)), np.sqrt(2 / self.edf[0] + 2 / self.edf[1])
        low, high = np.full(scale.shape, -30.0), np.full(scale.shape, 30.0)
        x, slope = wanted * scale, 1 / scale
        before = deviate = np.zeros(scale.shape)
        # as a normal deviate the probability is nearly straight in the logarithm: secants, kept within a bracket
        for _ in range(STEPS):
            last, deviate = deviate, ndtri(self.below(np.exp(x)))
            far = np.abs(deviate - wanted) > CONVERGED
            if not far.any():
                break
            low, high = np.where(deviate < wanted, x, low), np.where(deviate < wanted, high, x)
            with np.errstate(divide="ignore", invalid="ignore"):
                slope = np.where(np.abs(x - before) > 0, (deviate - last) / (x - before), slope)
                step = x + (wanted - deviate) / slope
            middle = np.where((step > low) & (step < high), step, (low + high) / 2)
            before, x = x, np.where(far, middle, x)
        return np.asarray(np.exp(x))

    def limits(self, ratio: FloatArray, level: float) -> tuple[FloatArray, FloatArray]:
        """Limits of the ratio of the expectations, from a measured ratio."""
        return ratio / self.quantile((1 + level) / 2), ratio / self.quantile((1 - level) / 2)


def _largest(mixture: ChiSquareSum) -> FloatArray:
    return np.asarray(np.maximum(mixture.weight.max(axis=1), mixture.beside))


def ratio_law(
    records: tuple[Record, Record], statistic: str, m: Sequence[IntArray], models: Sequence[Model]
) -> RatioLaw:
    """The law of the ratio of two records' variances."""
    row = statistic_named(statistic)
    angles = [integrated(record, row.order) for record in records]
    points = [
        CurvePoints(row, factors, angle.runs, record.size, record.rate, places=angle.places)
        for record, angle, factors in zip(records, angles, m, strict=True)
    ]
    edf_a, first = mixtures(points[0], [models[0]])
    twins = models[0] == models[1] and _of(points[0]) == _of(points[1])
    edf_b, second = (edf_a, first) if twins else mixtures(points[1], [models[1]])
    return RatioLaw(first, second, (edf_a, edf_b))


def _of(points: CurvePoints) -> tuple[object, ...]:
    """What the law depends on beside the model."""
    return points.m.tolist(), list(points.places), points.size, points.rate


def shared_curves(
    records: Sequence[Record], fits: Sequence[Fit], statistic: str, taus: str | Sequence[float]
) -> tuple[list[IntArray], tuple[Curve, ...]]:
    """Averaging factors of each record, and its curve, at the same averaging times; see `shared_factors`."""
    m = shared_factors(records, statistic, taus)
    each = zip(records, m, fits, strict=True)
    return m, tuple(deviation(record, statistic, m=k.tolist(), noise=fit) for record, k, fit in each)


def shared_factors(records: Sequence[Record], statistic: str, taus: str | Sequence[float]) -> list[IntArray]:
    """Averaging factors of each record, at the same averaging times."""
    row = statistic_named(statistic)
    if row.parts or row.extreme or row.order < 2:
        raise UsageError(
            f"the ratio of curves of {row.name} has no known distribution; compare oadev, ohdev, mdev, totdev or theo1"
        )
    slow = min(records, key=lambda record: record.rate)
    if isinstance(taus, str):
        longest = min(row.largest(r.size) / r.rate for r in records)
        wanted = grid_named(taus)(max(int(longest * slow.rate + 1e-9) // row.step, 1)) * row.step / slow.rate
    else:
        wanted = np.asarray(taus, dtype=np.float64) / row.tau_factor
    steps = [np.maximum(np.rint(wanted * r.rate / row.step).astype(np.int64), 1) * row.step for r in records]
    fits = np.ones(wanted.shape, dtype=bool)
    for record, m in zip(records, steps, strict=True):
        fits &= (np.abs(m / record.rate / wanted - 1) <= SAME_TIME) & (m <= row.largest(record.size))
    if not fits.any():
        reach = [(row.step / r.rate, row.largest(r.size) / r.rate) for r in records]
        spans = join(", ", [say("{low:.3g} to {high:.3g} s", low=least, high=most) for least, most in reach])
        raise DataError(say("the records have no averaging time in common: {statistic} covers {spans}",
                            statistic=row.name, spans=spans))  # fmt: skip
    return [m[fits] for m in steps]
