"""Regressor: a column on which an error may depend, derived from a channel and resampled to its times."""

import math
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from allanite.extending import (  # isort: skip
    REAL, DataError, FloatArray, Range, Record, Recording, UnitError, UsageError, Value, constructed, convert, public,
    say, say_count, spelled
)  # fmt: skip

MIN_WINDOW = 60.0  # seconds of a window; in a shorter one the steps of a digital thermometer are what changes


def local_slope(x: FloatArray, rate: float, window: float) -> FloatArray:
    """Slope of the least-squares line in a Hann window around each sample, per second; shape of `x`."""
    # At the ends the window is cut off, and the line fitted to what is left. A reading that is NaN counts for nothing
    # in its neighbours' windows, and has no slope of its own.
    half = int(window * rate / 2)
    if not (np.isfinite(window) and window >= MIN_WINDOW and half >= 1):
        raise UsageError(f"the window of a derivative must have at least {MIN_WINDOW:g} s and 3 samples, not "
                         f"{window!r} s")  # fmt: skip
    from scipy.signal import oaconvolve

    j = np.arange(-half, half + 1, dtype=np.float64)
    weight = 0.5 + 0.5 * np.cos(np.pi * j / (half + 1))
    finite = np.isfinite(x)
    centre = float(np.mean(x[finite])) if finite.any() else 0.0
    values = np.where(finite, x - centre, 0.0)

    def around(y: FloatArray, power: int) -> FloatArray:
        """Sum of weight * j^power * y[i + j]."""
        return np.asarray(oaconvolve(y, (weight * (j / half) ** power)[::-1], mode="full")[half : half + y.size])

    ones = finite.astype(np.float64)
    w, t, tt = (around(ones, power) for power in (0, 1, 2))
    y, ty = around(values, 0), around(values, 1)
    spread = w * tt - t * t
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = (w * ty - t * y) / spread
    # fewer than two samples in the window: the spread is rounding
    return np.where(finite & (spread > 1e-9 * np.sum(weight) ** 2), slope * rate / half, np.nan)


@public
def aligned(along: Recording, record: Record) -> Recording:
    """The channels at the intervals of `record`: means if they are faster, otherwise linear interpolation.

    Values before the first sample or after the last one are NaN, and so are values next to a missing sample. Times are
    those of `start`, or zero.

    Raises
    ------
    DataError
        A channel does not overlap the record, or is an angle.

    Examples
    --------
    >>> temp = Record([20.0, 22.0, 24.0], rate=0.5, unit="degC", name="temp")
    >>> gyro = Record(np.zeros(6), rate=1.0, unit="deg/h", name="z")
    >>> aligned(Recording((temp,)), gyro)["temp"].values.tolist()
    [20.0, 21.0, 22.0, 23.0, 24.0, nan]
    """
    at = np.arange(record.size) / record.rate
    records = []
    for other in along:
        if other.integrated:
            raise DataError(say("{name!r} is of kind {kind}; only plain samples can be resampled", name=other.name,
                                kind=other.kind))  # fmt: skip
        x, faster = np.asarray(other.values, dtype=np.float64), other.rate > record.rate
        when = at + ((record.start or 0.0) - (other.start or 0.0))
        if faster:
            values = _means(x, other.rate, when, record.rate)
        else:
            values = np.interp(when, np.arange(x.size) / other.rate, x, left=np.nan, right=np.nan)
        if np.isnan(values).all():
            raise DataError(say("{first!r} and {second!r} do not overlap in time", first=other.name,
                                second=record.name))  # fmt: skip
        way = say("means") if faster else say("linear interpolation")
        what = say("resampled from {rate:.9g} Hz to the times of {name!r} by {way}",
                   rate=other.rate, name=record.name, way=way)  # fmt: skip
        records.append(Record(values, record.rate, other.unit, scale=other.scale, name=other.name, start=record.start,
                              history=(*other.history, what)))  # fmt: skip
    return replace(along, records=tuple(records))


def _means(x: FloatArray, rate: float, when: FloatArray, wanted: float) -> FloatArray:
    """Means over the intervals that begin at `when`: differences of the integral; NaN where a reading is missing."""
    edges = np.arange(x.size + 1) / rate
    lost = np.concatenate(([0.0], np.cumsum(np.isnan(x))))
    integral = np.concatenate(([0.0], np.cumsum(np.nan_to_num(x)))) / rate
    spans = (when, when + 1 / wanted)
    begin, end = (np.interp(t, edges, integral, left=np.nan, right=np.nan) for t in spans)
    missing = np.interp(spans[1], edges, lost) - np.interp(spans[0], edges, lost)
    return np.where(missing > 0, np.nan, (end - begin) * wanted)


SIGNIFICANT = 0.05  # p-value below which an effect is significant
TREND = "time"  # name of the regressor that is no channel: seconds, counted from the middle of the record


@constructed
@dataclass(frozen=True, repr=False)
class Regressor(Value):
    """One column of a regression: a power of a channel minus its centre, optionally with a lag, or its time derivative.

    Attributes
    ----------
    channel, unit : str
        Name of the channel, and the unit of its samples.
    centre : float
        Value at which the column is zero, in `unit`; 0 for a derivative.
    power : int
        1, 2, 3 ...
    lag : float
        Lag, s.
    smooth : float or None
        Length of the Hann window in which the derivative is estimated, s; None for samples.
    span : (least, most) or None
        Readings of the channel in the record that was fitted, in `unit`.

    Examples
    --------
    >>> square = Regressor("temp", "degC", centre=20.0, power=2)
    >>> square.label, square.column_unit
    ('temp^2', 'degC^2')
    >>> temp = Record([20.0, 21.0, 23.0], rate=1.0, unit="degC", name="temp")
    >>> gyro = Record([1.0, 2.0, 3.0], rate=1.0, unit="deg/h", name="z")
    >>> square.column(gyro, Recording((temp,))).tolist()
    [0.0, 1.0, 9.0]
    """

    _also = ("label", "column_unit")

    channel: str
    unit: str
    centre: Annotated[float, REAL] = 0.0
    power: Annotated[int, Range(1, 100)] = 1
    lag: Annotated[float, REAL] = 0.0
    smooth: float | None = None
    span: tuple[float, float] | None = None

    @property
    def is_trend(self) -> bool:
        """Whether it is time itself, which is estimated jointly and never subtracted."""
        return self.channel == TREND

    @property
    def label(self) -> str:
        """Its name in tables."""
        name = self.channel if self.power == 1 else f"{self.channel}^{self.power}"
        name = name if self.smooth is None else f"d {name}/dt"
        if self.is_trend:
            return say("time")
        return say("{name}, {lag:g} s before", name=name, lag=self.lag) if self.lag else name

    @property
    def column_unit(self) -> str:
        """Unit of its values."""
        if self.smooth is not None:
            return "1/s" if self.unit == "1" else f"{self.unit}/s"
        return self.unit if self.power == 1 or self.unit == "1" else f"{self.unit}^{self.power}"

    def column(self, record: Record, along: Recording | None) -> FloatArray:
        """Its values at the intervals of `record`, shape (record.size,); NaN where the channel has none.

        Raises
        ------
        UsageError
            The channel is missing.
        UnitError
            It measures something else than it did.
        DataError
            It is not on the record's clock.
        """
        if self.is_trend:
            return np.asarray((np.arange(record.size) - (record.size - 1) / 2) / record.rate, dtype=np.float64)
        x = readings(self.channel, self.unit, record, along)
        if self.smooth is not None:
            x = local_slope(x, record.rate, self.smooth)
        steps = round(self.lag * record.rate)
        if steps >= x.size:
            raise DataError(say("a lag of {lag:g} s is longer than {name!r}", lag=self.lag, name=record.name))
        if steps:
            x = np.concatenate((np.full(steps, np.nan), x[:-steps]))
        return np.asarray((x - self.centre) ** self.power)


class Columns:
    """What has regressors: of a design, and of a regression."""

    regressors: tuple[Regressor, ...]

    @property
    def taken(self) -> list[int]:
        """Columns that a correction subtracts: all but a trend."""
        return [i for i, regressor in enumerate(self.regressors) if not regressor.is_trend]

    @property
    def trend(self) -> list[int]:
        """The column of a trend, if there is one."""
        return [i for i, regressor in enumerate(self.regressors) if regressor.is_trend]


@dataclass(frozen=True, repr=False)
class Effect(Value):
    """One coefficient: rate per unit of its regressor, SI.

    Attributes
    ----------
    regressor : Regressor
    value, standard_error : float
    unit : str
        Unit of both.
    p : float
        p-value of no dependence; for a column that was chosen among several, multiplied by their number.
    low, high : float
        Confidence interval at `level`.
    inflation : float
        Variance inflation factor: how much the other regressors widen its variance.
    chosen : bool
        Whether cross-validation chose the column; otherwise it was requested.
    """

    _also = ("label", "t", "significant", "taken_off")

    regressor: Regressor
    value: float
    standard_error: float
    unit: str
    p: float
    low: float
    high: float
    inflation: float
    chosen: bool
    level: float = 0.95

    @property
    def label(self) -> str:
        """Name of the column."""
        return self.regressor.label

    @property
    def t(self) -> float:
        """Value over its standard error."""
        return self.value / self.standard_error

    @property
    def significant(self) -> bool:
        """Whether it is significant."""
        return self.p < SIGNIFICANT

    @property
    def taken_off(self) -> bool:
        """Whether the correction subtracts it: all but a linear drift."""
        return not self.regressor.is_trend


def readings(channel: str, unit: str, record: Record, along: Recording | None) -> FloatArray:
    """Samples of a channel in `unit` at the intervals of `record`; errors as those of `Regressor.column`."""
    if along is None or channel not in along.channels:
        known = "no channels were given" if along is None else f"channels: {', '.join(along.channels)}"
        raise UsageError(f"the regressor {channel!r} is missing: {known}")
    measured = along[channel]
    apart = 0.0 if record.start is None or measured.start is None else abs(record.start - measured.start)
    lengths = (record.size, record.size + 1) if record.kind == "angle" else (record.size,)
    same_rate = math.isclose(record.rate, measured.rate, rel_tol=1e-9)
    if not same_rate or not apart < 0.5 / record.rate or measured.size not in lengths:
        raise DataError(say("{regressor!r} ({clock}) does not have the sample times of {name!r} ({own}); interpolate "
                            "it with {option}", regressor=measured.name, clock=_clock(measured), name=record.name,
                            own=_clock(record), option=spelled("--interpolate", "compensation.aligned")))  # fmt: skip
    own = measured.signal.unit if measured.integrated else measured.unit
    if unit != own and "degC" in (unit, own):
        raise UnitError(f"{channel!r} was in {unit} and is in {own}, whose zeros differ; give it in {unit}")
    x = np.asarray(measured.rate_values if measured.integrated else measured.values, dtype=np.float64)
    if not measured.integrated and measured.scale is not None:
        x = x * measured.scale
    factor = 1.0 if unit == own else convert(1.0, own, unit)
    x = x if factor == 1.0 else x * factor
    return np.asarray((x[1:] + x[:-1]) / 2) if x.size == record.size + 1 else x


def _clock(record: Record) -> str:
    rate, size = record.rate, record.size
    if record.start is None:
        return say_count(size, "{rate:.9g} Hz, {count} sample", "{rate:.9g} Hz, {count} samples", rate=rate)
    return say_count(size, "{rate:.9g} Hz, {count} sample from {start:.9g} s",
                     "{rate:.9g} Hz, {count} samples from {start:.9g} s", rate=rate, start=record.start)  # fmt: skip
