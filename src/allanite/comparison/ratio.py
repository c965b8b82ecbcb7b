"""Laws of ratios of two records: of their variances at averaging times that both have, of ramps, and of sinusoids."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from allanite.core.arrays import LARGEST, FloatArray, IntArray
from allanite.core.curve import Curve
from allanite.core.errors import DataError, UsageError
from allanite.core.estimate import Estimate
from allanite.core.fit import Fit
from allanite.core.limits import Below, Normal, NormalMixture, quantile
from allanite.core.model import Model
from allanite.core.record import Record
from allanite.core.units import Signal
from allanite.identification.likelihood.law import Subset, ThetaProfile
from allanite.phrases.phrase import join, say, spelled
from allanite.statistics import deviation
from allanite.statistics.confidence.chisquares import MIN_DEVIATE, ChiSquareSum, cumulants
from allanite.statistics.confidence.limits import mixtures
from allanite.statistics.estimator import places_of
from allanite.statistics.grids import grid_named
from allanite.statistics.table import CurvePoints, statistic_named
from allanite.terms import TERMS

from .common_likelihood import Joint
from .contrast import IntervalContrast

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

        ratio = np.clip(np.asarray(ratio, dtype=np.float64), 1 / LARGEST, LARGEST)  # of nothing it is 0 or infinite
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


def ratio_law(records: tuple[Record, Record], statistic: str, m: Sequence[IntArray],
              models: Sequence[Model]) -> RatioLaw:  # fmt: skip
    """The law of the ratio of two records' variances."""
    row = statistic_named(statistic)
    places = [places_of(record) for record in records]
    points = [CurvePoints(row, factors, [(size, 1) for _, size in each], record.size, record.rate, places=each)
              for record, each, factors in zip(records, places, m, strict=True)]  # fmt: skip
    edf_a, first = mixtures(points[0], [models[0]])
    twins = models[0] == models[1] and _of(points[0]) == _of(points[1])
    edf_b, second = (edf_a, first) if twins else mixtures(points[1], [models[1]])
    return RatioLaw(first, second, (edf_a, edf_b))


def _of(points: CurvePoints) -> tuple[object, ...]:
    """What the law depends on beside the model."""
    return points.m.tolist(), list(points.places), points.size, points.rate


def shared_curves(records: Sequence[Record], fits: Sequence[Fit], statistic: str,
                  taus: str | Sequence[float]) -> tuple[list[IntArray], tuple[Curve, ...]]:  # fmt: skip
    """Averaging factors of each record, and its curve, at the same averaging times; see `shared_factors`."""
    m = shared_factors(records, statistic, taus)
    curves = tuple(deviation(r, statistic, m=k.tolist(), noise=fit) for r, k, fit in zip(records, m, fits, strict=True))
    known = np.all([curve.variance > 0 for curve in curves], axis=0)
    if known.all():
        return m, curves
    if not isinstance(taus, str) or not known.any():
        raise UsageError(f"{statistic} is zero at {curves[0].tau[~known][0]:.6g} s, where there is no ratio: choose "
                         f"other averaging times ({spelled('--taus', 'taus=')})", choice="taus")  # fmt: skip
    return shared_curves(records, fits, statistic, curves[0].tau[known].tolist())


def shared_factors(records: Sequence[Record], statistic: str, taus: str | Sequence[float]) -> list[IntArray]:
    """Averaging factors of each record, at the same averaging times."""
    row = statistic_named(statistic)
    if row.parts or row.extreme or row.order < 2:
        raise UsageError(f"the ratio of curves of {row.name} has no known distribution; compare oadev, ohdev, mdev, "
                         "totdev or theo1")  # fmt: skip
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


def ramp_law(joint: Joint, i: int) -> NormalMixture | None:
    """The ramp of record i of several, SI; None where the band leaves nothing of it."""
    # A normal law for each strength of the noise of the longest memory, which is known from a few powers only:
    # averaging over it gives the wide tails of Student's t.
    part, spectrum = joint.parts[i], joint.spectra[i]
    if not part.flat.any():
        return None
    slope = [np.nan_to_num(TERMS[symbol].slope, nan=-math.inf) for symbol in joint.symbols]
    free = np.ones(part.S.shape[1], dtype=bool)
    thetas, weight = ThetaProfile(Subset(part, free, *part.minimise(free)), int(np.argmax(slope))).weighted()
    directions = [part.directions(theta)[:2] for theta in thetas]
    size = spectrum.unit_factor * spectrum.rate
    centre = np.array([eta[-1] for eta, _ in directions]) + spectrum.slope
    return NormalMixture(size * centre, size * np.sqrt([V[-1, -1] for _, V in directions]), weight)


@dataclass(frozen=True, eq=False)
class RampContrast:
    """The second ramp against the first."""

    first: NormalMixture
    second: NormalMixture

    @property
    def ratio(self) -> float:
        """The second ramp over the first, with the sign."""
        return self.second.value / self.first.value

    @property
    def p(self) -> float:
        """Probability of such a difference by chance, where there is none."""
        return self.second.minus(self.first).p

    def limits(self, level: float) -> tuple[float, float]:
        """Limits of the ratio: what the second less ratio times the first leaves near zero (E. C. Fieller, 1954)."""
        # From minus to plus infinity where the first ramp itself is not distinguished from zero.
        if self.first.p >= 1 - level:
            return -math.inf, math.inf
        # where the mean is, the median need not be: each end is sought on both sides of it
        ends = [self._quantile((1 - level) / 2), self._quantile((1 + level) / 2)]
        return min(ends), max(ends)

    def _quantile(self, share: float) -> float:
        """The ratio at which the probability is `share` that the second less ratio times the first is below zero."""
        from scipy.optimize import brentq

        def off(ratio: float) -> float:
            return self.second.minus(self.first, ratio).below(0.0) - share

        best = self.ratio
        step = 0.1 * max(abs(best), 1.0)
        while off(best - step) * off(best + step) > 0:
            step *= 2
        return float(brentq(off, best - step, best + step, rtol=1e-6))


WIDTH = 1.5  # bins of the shorter record within which two frequencies are one
AROUND = (4, 40)  # bins on either side of a frequency from which the noise there is known
SEEN = 4.0  # standard errors from which on an amplitude that was looked for at a known frequency is one


def _upper(value: float, error: float, level: float) -> float:
    """One-sided upper limit of an amplitude."""
    return value + quantile(level) * error


def sine(value: float, error: float, signal: Signal, frequency: float, *, significant: bool = True) -> Estimate:
    """The amplitude of a sinusoid in one record, SI, as the estimate of a term, or its limit."""
    upper = partial(_upper, value, error)
    if not significant:
        return Estimate("Sine", signal, None, None, "absent", upper(0.95), "whittle", Below(upper))
    return Estimate("Sine", signal, value, error, "identified", upper(0.95), "whittle", Normal(value, error),
                    shape=(frequency, 0.0))  # fmt: skip


def line_contrasts(records: Sequence[Record], fits: Sequence[Fit]) -> Iterator[tuple[float, IntervalContrast]]:
    """The sinusoids of two records, each looked for in the other."""
    # One that lies beyond the frequencies of the other record is omitted.
    width = WIDTH / min(record.duration for record in records)
    frequencies = sorted(line.frequency for fit in fits for line in fit.lines)
    apart = [f for i, f in enumerate(frequencies) if not i or f - frequencies[i - 1] > width]
    for frequency in apart:
        if all(AROUND[0] / r.duration < frequency < r.rate / 2 - AROUND[0] / r.duration for r in records):
            first, second = (_amplitude(r, fit, frequency, width) for r, fit in zip(records, fits, strict=True))
            yield frequency, IntervalContrast(first, second)


def _amplitude(record: Record, fit: Fit, frequency: float, width: float) -> Estimate:
    near = [line for line in fit.lines if abs(line.frequency - frequency) <= width]
    if near:
        line = max(near, key=lambda line: line.amplitude)
        return sine(line.amplitude, line.standard_error, fit.signal, frequency)
    rates = record.rate_values
    finite = np.isfinite(rates)
    window = np.where(finite, np.sin(np.pi * (np.arange(rates.size) + 0.5) / rates.size) ** 2, 0.0)
    weighted = np.where(finite, rates - rates[finite].mean(), 0.0) * window
    power = np.abs(np.fft.rfft(weighted)) ** 2
    at = round(frequency * record.duration)
    beside = np.abs(np.arange(power.size) - at)
    noise = float(np.median(power[(beside >= AROUND[0]) & (beside <= AROUND[1])])) / math.log(2)
    # the highest of the bins that the frequency may lie in; the mean of the rate over a sample interval is smaller
    size = 2 / float(window.sum()) / float(np.sinc(frequency / record.rate))
    value, error = (size * math.sqrt(v) for v in (float(power[max(at - 1, 1) : at + 2].max()), noise / 2))
    return sine(value, error, fit.signal, frequency, significant=value > SEEN * error)
