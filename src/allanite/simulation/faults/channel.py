"""Faults of the channel: rounding, bias, roll-off, changing noise, outliers, saturation, missing samples."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from allanite.core.aliases import constructed, public
from allanite.core.arrays import FloatArray
from allanite.core.errors import UnitError, UsageError
from allanite.core.kinds import KINDS
from allanite.core.ranges import POSITIVE, SHARE, SIZE, STAMP, TIME, Range
from allanite.core.record import Record
from allanite.core.units import signal_with, unit_of

LOST = Range(0, 1, below=True)  # shares of samples that are missing: some are left
EXACT = 2.0**52  # steps beyond which a double cannot tell one from the next
LEAST_CUTOFF = 1e-7  # of the rate: below it the coefficients of a section lose half of their digits


@constructed
@dataclass(frozen=True)
class Dither:
    """What is added before rounding.

    Attributes
    ----------
    amplitude : float
        In steps of the quantizer: the half width of a uniform random dither, or the amplitude of a sinusoid.
    frequency : float, optional
        Frequency of the sinusoid, Hz; None for random dither.
    stripped : bool
        Taken off again after rounding, as it is known to the readout.
    """

    amplitude: Annotated[float, POSITIVE] = 0.5
    frequency: Annotated[float | None, POSITIVE] = None
    stripped: bool = True

    def at(self, n: int, rate: float, rng: "np.random.Generator | None") -> FloatArray:
        """The dither at n instants, in steps; the phase of a sinusoid is random if there is a generator."""
        if self.frequency is not None:
            phase = 0.0 if rng is None else rng.uniform(0, 2 * math.pi)
            return np.asarray(self.amplitude * np.sin(2 * math.pi * self.frequency / rate * np.arange(n) + phase))
        if rng is None:
            raise UsageError("random dither is drawn from a generator: pass rng=numpy.random.default_rng(1)")
        return rng.uniform(-self.amplitude, self.amplitude, n)

    def __str__(self) -> str:
        how = "random dither" if self.frequency is None else f"dither of {self.frequency:g} Hz"
        return f"{how}, amplitude {self.amplitude:g} steps, {'stripped' if self.stripped else 'not stripped'}"


@public
def quantize_rate(record: Record, lsb: Annotated[float, POSITIVE], unit: str, *, dither: Dither | None = None,
                  rng: "np.random.Generator | None" = None) -> Record:  # fmt: skip
    """Round the rate to steps, as the converter of a rate output does.

    Where the noise exceeds about half a step the error is white: it adds to N by ``lsb sqrt(tau0 / 12)``, and is not Q.

    Parameters
    ----------
    record : Record
        Record of kind "rate".
    lsb : float
        The step, in `unit`.
    unit : str
        Unit of a rate.
    dither : Dither, optional
    rng : numpy.random.Generator
        For random dither.

    Examples
    --------
    >>> quantize_rate(Record([0.26, -0.13, 0.4], rate=10.0, unit="deg/s"), 0.25, "deg/s").values.tolist()
    [0.25, -0.25, 0.5]
    """
    if record.integrated:
        raise UsageError(f"only a rate can be rounded by its converter; for {record.kind}s round the angle")
    size = unit_of(unit)
    if signal_with(size.dimension, values=True) is not record.signal:
        raise UnitError(f"{unit!r} is not a unit of {record.signal.unit} samples")
    step = lsb * size.factor / record.factor
    values = _rounded(np.asarray(record.values / step), record.rate, dither, rng)
    return record.with_values(values * step, _words("rate", lsb, unit, dither), start=record.start)


@public
def quantize_angle(record: Record, lsb: Annotated[float, POSITIVE], unit: str, *, dither: Dither | None = None,
                   rng: "np.random.Generator | None" = None) -> Record:  # fmt: skip
    """Round the angle to steps, as a pulse counter or an integrating readout does.

    Where the angle is dithered, or its own noise over an interval exceeds about half a step, this is quantization noise
    with ``Q = lsb / sqrt(12)``. A steady angle without dither makes a pattern of lines instead, which its mean rate
    gives their places: add that by `constant` first.

    Parameters
    ----------
    record : Record
        Record of kind "rate" or "increment".
    lsb : float
        The step, in `unit`.
    unit : str
        Unit of an angle (of a velocity for accelerometers).
    dither : Dither, optional
        Added to the angle.
    rng : numpy.random.Generator
        For random dither.

    Returns
    -------
    Record
        Record of kind "count", each of size `lsb`; of kind "increment" if a dither was subtracted.

    Examples
    --------
    >>> slow = Record([0.4, 0.4, 0.4, 0.4, 0.4], rate=1.0, unit="arcsec", kind="increment")
    >>> counts = quantize_angle(slow, 1.0, "arcsec")
    >>> counts.values.tolist(), counts.kind, counts.scale
    ([0, 1, 0, 1, 0], 'count', 1.0)
    """
    if record.kind in ("angle", "count"):
        raise UsageError(f"the angle of rates and increments can be rounded, not of kind {record.kind!r}")
    size = unit_of(unit)
    if signal_with(size.dimension, 1, values=True) is not record.signal:
        raise UnitError(f"{unit!r} is not a unit of the integral of {record.signal.unit}: for a gyro use arcsec")
    angle = record.angle / (lsb * size.factor)
    steps = _rounded(angle, record.rate, dither, rng)
    history = (*record.history, _words("angle", lsb, unit, dither))
    if dither is not None and dither.stripped:
        return replace(record, values=np.diff(steps) * lsb, unit=unit, kind="increment", scale=None, history=history)
    counts = np.diff(steps).astype(np.int64)
    return replace(record, values=counts, unit=unit, kind="count", scale=lsb, history=history)


def _rounded(values: FloatArray, rate: float, dither: Dither | None, rng: "np.random.Generator | None") -> FloatArray:
    """Whole steps, less the dither if it is stripped."""
    if not np.isfinite(values).all():
        raise UsageError("some samples are not finite; round the record before samples are removed")
    if values.size and np.abs(values).max() > EXACT:
        raise UsageError(f"the samples are up to {np.abs(values).max():.3g} steps: use a larger step")
    if dither is None:
        return np.rint(values)
    added = dither.at(values.size, rate, rng)
    return np.rint(values + added) - (added if dither.stripped else 0.0)


def _words(what: str, lsb: float, unit: str, dither: Dither | None) -> str:
    return f"{what} rounded to {lsb:g} {unit}" + ("" if dither is None else f", {dither}")


@public
def constant(record: Record, value: float, unit: str) -> Record:
    """Add a constant rate, such as a bias or the earth's rate.

    Examples
    --------
    >>> record = Record([1.0, 2.0], rate=10.0, unit="deg/s")
    >>> constant(record, 3600.0, "deg/h").values.tolist()
    [2.0, 3.0]
    """
    return _changed(record, _floats(record) + in_readings(record, value, unit), f"constant of {value:g} {unit} added")


@public
def low_pass(record: Record, cutoff: float, *, order: Annotated[int, Range(1, 10)] = 1) -> Record:
    """Apply a causal Butterworth low-pass filter, as in a sensor or logger.

    Parameters
    ----------
    record : Record
    cutoff : float
        Frequency at which half of the power is left, Hz; below half of the sampling rate.
    order : int
        1 rolls off as one time constant does.
    """
    least = LEAST_CUTOFF * record.rate
    if not least <= cutoff < record.rate / 2:
        raise UsageError(f"a cutoff must be between {least:g} and {record.rate / 2:g} Hz (half of the rate), not "
                         f"{cutoff!r} Hz")  # fmt: skip
    from scipy.signal import butter, sosfilt, sosfilt_zi

    values = _floats(record)
    if not np.isfinite(values).all():
        missing = int((~np.isfinite(values)).sum())
        raise UsageError(f"{missing} samples are not finite; filter the record before samples are removed")
    sections = butter(order, cutoff, fs=record.rate, output="sos")
    # as if the first reading had always been there: no jump at the start
    filtered, _ = sosfilt(sections, values, zi=sosfilt_zi(sections) * values[0])
    return _changed(record, filtered, f"low-pass filtered at {cutoff:g} Hz, order {order}")


@public
def noise_profile(record: Record, times: Annotated[Sequence[float] | FloatArray, STAMP],
                  factors: Annotated[Sequence[float] | FloatArray, SIZE]) -> Record:  # fmt: skip
    """Multiply the deviation from the mean by a factor that changes with time: any variance over time.

    The factor is interpolated linearly between `times`, and constant before the first and after the last; a time that
    is given twice is a step. The deviation from the mean of slow noise, such as a random walk, is multiplied like
    everything else.

    Parameters
    ----------
    record : Record
    times : array_like, shape (k,)
        Seconds from the start of the record, ascending.
    factors : array_like, shape (k,)
        Factor at each of them, not negative: the standard deviation over what it was.

    Examples
    --------
    >>> record = Record([1.0, -1.0, 1.0, -1.0], rate=1.0, unit="deg/s")
    >>> noise_profile(record, [0.0, 3.0], [1.0, 4.0]).values.tolist()
    [1.5, -2.5, 3.5, -4.0]
    """
    t, factor = np.asarray(times, dtype=np.float64), np.asarray(factors, dtype=np.float64)
    if t.shape != factor.shape or t.ndim != 1 or not t.size:
        raise UsageError("a noise profile needs as many factors as times, and at least one of each")
    if (np.diff(t) < 0).any():
        raise UsageError("a noise profile needs ascending times in s")
    values = _floats(record)
    mean = np.nanmean(values) if np.isfinite(values).any() else 0.0
    at = np.interp((np.arange(values.size) + 0.5) / record.rate, t, factor)
    story = f"noise multiplied by a profile of {t.size} points, {factor.min():g} to {factor.max():g}"
    return _changed(record, mean + at * (values - mean), story)


@public
def outliers(record: Record, share: Annotated[float, SHARE], size: float, unit: str = "",
             *, rng: "np.random.Generator") -> Record:  # fmt: skip
    """Add outliers of either sign to a random `share` of the samples.

    Parameters
    ----------
    record : Record
    share : float
        Probability of an outlier per sample, 0 to 1.
    size : float
        Size of the outliers, in `unit`; without a unit in standard deviations of the fast noise: those of the first
        differences over the square root of 2.
    unit : str
        Unit of rates, or of the samples.
    rng : numpy.random.Generator

    Examples
    --------
    >>> record = Record(np.zeros(1000), rate=10.0, unit="deg/h")
    >>> spiked = outliers(record, 0.01, 5.0, "deg/h", rng=np.random.default_rng(1))
    >>> sorted(set(np.abs(spiked.values).tolist())), spiked.history
    ([0.0, 5.0], ('9 outliers of 5 deg/h added',))
    """
    values = _floats(record)
    hit = np.flatnonzero(rng.random(values.size) < share)
    fast = float(np.nanstd(np.diff(values)) / np.sqrt(2))
    height = in_readings(record, size, unit) if unit else size * fast
    values[hit] += height * rng.choice((-1.0, 1.0), hit.size)
    return _changed(record, values, f"{hit.size} outliers of {size:g} {unit or 'standard deviations'} added")


@public
def clip(record: Record, limit: Annotated[float, POSITIVE], unit: str) -> Record:
    """Clip samples beyond +-`limit`: a sensor driven out of its range.

    Examples
    --------
    >>> clip(Record([1.0, -7.0, 2.0], rate=10.0, unit="deg/s"), 3.0, "deg/s").values.tolist()
    [1.0, -3.0, 2.0]
    """
    bound = in_readings(record, limit, unit)
    values = _floats(record)
    beyond = int((np.abs(values) > bound).sum())
    return _changed(record, np.clip(values, -bound, bound), f"{beyond} samples clipped at {limit:g} {unit}")


@public
def gaps(record: Record, share: Annotated[float, LOST], length: Annotated[float, TIME],
         *, rng: "np.random.Generator") -> Record:  # fmt: skip
    """Replace a random `share` of the samples by NaN, in stretches. The first and the last sample are kept.

    Parameters
    ----------
    record : Record
    share : float
        Average share of missing samples, 0 to 1, reduced by overlaps of stretches.
    length : float
        Mean length of a stretch, s; lengths are geometrically distributed, at least one sample.
    rng : numpy.random.Generator

    Examples
    --------
    >>> lossy = gaps(Record(np.zeros(1000), rate=10.0, unit="deg/h"), 0.05, 2.0, rng=np.random.default_rng(1))
    >>> lossy.history
    ('11 samples missing in 2 stretches',)
    """
    values = _floats(record)
    if values.size < 3:
        raise UsageError(f"there are no samples to remove between the first and the last of {values.size}")
    mean = max(1.0, length * record.rate)
    count = rng.poisson(share * values.size / mean)
    first = rng.integers(1, values.size - 1, count)
    last = np.minimum(first + rng.geometric(1 / mean, count), values.size - 1)
    steps = np.zeros(values.size, dtype=np.int64)
    np.add.at(steps, first, 1)
    np.add.at(steps, last, -1)
    lost = np.cumsum(steps) > 0
    values[lost] = np.nan
    stretches = int((np.diff(lost.astype(np.int8)) > 0).sum())
    return _changed(record, values, f"{int(lost.sum())} samples missing in {stretches} stretches")


def in_readings(record: Record, value: float, unit: str) -> float:
    """A rate, or what a rate gives in one interval, as the number that a reading of the record would be."""
    # UnitError if the unit is neither of this sensor's rate nor of these samples.
    size, signal = unit_of(unit), record.signal
    if signal_with(size.dimension, values=True) is signal:
        interval = record.interval if record.integrated else 1.0
        return value * size.factor * interval / record.factor
    if signal_with(size.dimension, KINDS[record.kind][0], values=True) is signal:
        return value * size.factor / record.factor
    raise UnitError(f"{unit!r} is neither a unit of a rate nor of samples in {record.unit!r}")


def _floats(record: Record) -> FloatArray:
    """A copy of the samples."""
    if record.kind == "angle":
        raise UsageError("faults apply to rates and increments, not to angles: simulate a rate first")
    return np.array(record.values, dtype=np.float64)


def _changed(record: Record, values: NDArray[Any], what: str) -> Record:
    """Counts, which are integers, become increments of the same size."""
    kind = "increment" if record.kind == "count" else record.kind
    return replace(record, values=values, kind=kind, history=(*record.history, what))
