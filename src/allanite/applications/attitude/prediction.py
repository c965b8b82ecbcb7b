"""Predicted error of a gyro-vertical, and its parts by source."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from allanite.extending import (  # isort: skip
    POSITIVE, FloatArray, Model, ModelLike, Term, UnitError, UsageError, Value, public, say, split_quantities, unit_of
)  # fmt: skip

from .loop import SENSORS, Loop, SensorNoise, scale


@dataclass(frozen=True, repr=False)
class Source(Value):
    """What one source of error contributes.

    Attributes
    ----------
    sensor : str
    symbol : str
        That of the term, or "bias".
    text : str
    rms : float
        rad.
    """

    sensor: str
    symbol: str
    text: str
    rms: float


@dataclass(frozen=True, eq=False, repr=False)
class Prediction(Value):
    """Predicted error of one angle of a gyro-vertical.

    Attributes
    ----------
    gyro, accelerometer : Model
    loop : Loop
        The filter.
    duration, rate : float or None
        Horizon, s, and sampling rate, Hz; None for no horizon and for continuous time.
    sources : tuple of Source
        The RMS error from each source; their squares add.

    Examples
    --------
    >>> from allanite import N
    >>> found = predicted_error(N(0.3, "deg/sqrt(h)"), N(100, "ug/sqrt(Hz)"), 1.1459)
    >>> f"{found.to('arcsec'):.2f}"
    '19.27'
    """

    _also = ("rms",)

    gyro: Model
    accelerometer: Model
    loop: Loop
    duration: float | None
    rate: float | None
    sources: tuple[Source, ...]

    @property
    def rms(self) -> float:
        """RMS error, rad: the standard deviation if there is no constant bias."""
        return math.hypot(*(source.rms for source in self.sources))

    @property
    def floor(self) -> float:
        """The part of accelerometer flicker and bias, rad, which hardly depends on the time constant."""
        return math.sqrt(sum(s.rms**2 for s in self.sources if s.sensor == "accelerometer" and s.symbol in FLOOR))

    def to(self, unit: str) -> float:
        """The RMS error in another unit.

        Raises
        ------
        UnitError
            It is not a unit of an angle.
        """
        size = unit_of(unit)
        if size.dimension != unit_of("rad").dimension:
            raise UnitError(f"{unit!r} is not a unit of an angle, such as arcsec, deg or mrad")
        return self.rms / size.factor

    def _summary(self) -> str:
        return f"{self.to('arcsec'):.4g} arcsec with {self.loop._summary()}"


FLOOR = ("B", "bias")  # sources of the accelerometer that no time constant removes


@public
def predicted_error(
    gyro: ModelLike, accelerometer: ModelLike, time_constant: float | Loop, *, duration: float | None = None,
    rate: float | None = None, gyro_bias: str | float = 0.0, accelerometer_bias: str | float = 0.0,
) -> Prediction:  # fmt: skip
    r"""Predict the error of roll or pitch from the noise of one gyro and one accelerometer.

    For small angles and a body without acceleration. The density of the error with the time constant tau is

    .. math:: [S_g(f) \tau^2 + S_a(f) / g^2] / (1 + (2 \pi f \tau)^2),

    integrated from 1 / (2 T), T being the duration.

    Parameters
    ----------
    gyro, accelerometer : Model, Term or Fit
    time_constant : float or Loop
        Time constant of a filter of first order, s, or any complementary filter.
    duration : float, optional
        Horizon, s; needed if the noise has flicker, random walk or a ramp.
    rate : float, optional
        Sampling rate of the filter, Hz; by default continuous time.
    gyro_bias, accelerometer_bias : str or float, optional
        Constant biases, as ``"10 deg/h"``, or in SI.

    Returns
    -------
    Prediction

    Raises
    ------
    UsageError, UnitError
        A model is of another sensor, a needed horizon or rate is missing, or the time constant is not above the sample
        interval.
    """
    noise = SensorNoise.of(gyro, accelerometer, duration, rate)
    loop = Loop.of(time_constant)
    if noise.interval is not None:
        loop.demand_sampled(noise.interval)
    return predict(noise, loop, biases(gyro_bias, accelerometer_bias))


def biases(gyro: str | float, accelerometer: str | float) -> tuple[float, float]:
    """Constant biases in SI, from texts with units or numbers."""
    return _bias(gyro, "rad/s", "10 deg/h"), _bias(accelerometer, "m/s^2", "50 ug")


def _bias(value: str | float, si: str, example: str) -> float:
    if not isinstance(value, str):
        return float(value)
    quantities = split_quantities(value.split())
    if len(quantities) != 1 or not quantities[0][1]:
        raise UsageError(f"a bias has the form {example!r}, not {value!r}")
    number, unit = quantities[0]
    if unit_of(unit).dimension != unit_of(si).dimension:
        raise UnitError(f"a bias has the form {example!r}; {unit!r} is a unit of something else")
    return number * unit_of(unit).factor


def noise_errors(noise: SensorNoise, loop: Loop) -> Iterator[tuple[str, Term, float]]:
    """Sensor, term and the standard deviation of the angle from it, rad."""
    f, weight = noise.nodes
    gain = [np.abs(response) ** 2 * weight for response in loop.responses(f, noise.interval)]
    for sensor, t, power in noise.noise:
        yield sensor, t, math.sqrt(float(gain[SENSORS.index(sensor)] @ power))


def predict(noise: SensorNoise, loop: Loop, bias: tuple[float, float] = (0.0, 0.0)) -> Prediction:
    """`predicted_error` of densities that were checked, with biases in SI."""
    sources = [Source(sensor, t.symbol, text_of(t), rms) for sensor, t, rms in noise_errors(noise, loop)]
    for i, (sensor, model) in enumerate(zip(SENSORS, (noise.gyro, noise.accelerometer), strict=True)):
        constant = steady(loop, sensor, noise.interval)
        for t in (t for t in model if t.row.waveform is not None):
            if t.row.periodic:  # averaged over its phase
                rms = abs(t.value) * float(np.abs(loop.responses(np.array([t.shape[0]]), noise.interval)[i][0]))
                rms /= math.sqrt(2)
            elif sensor == "gyro" and loop.k2:
                rms = abs(t.value) / loop.k2
            else:  # a ramp, zero in the middle of the run; it demands a duration
                rms = abs(t.value) * (noise.duration or math.nan) / math.sqrt(12) * constant
            sources.append(Source(sensor, t.symbol, text_of(t), scale(sensor) * rms))
        if bias[i]:
            unit = model.signal.sheet[0]
            words = say("bias {value:.4g} {unit}", value=bias[i] / unit_of(unit).factor, unit=unit)
            sources.append(Source(sensor, "bias", words, abs(bias[i]) * scale(sensor) * constant))
    rate = None if noise.interval is None else 1 / noise.interval
    return Prediction(noise.gyro, noise.accelerometer, loop, noise.duration, rate, tuple(sources))


def text_of(t: Term) -> str:
    """A term as text; white noise of an accelerometer as data sheets give it."""
    unit = t.signal.density[0]
    if t.signal.name == "gyro" or unit_of(unit).dimension != unit_of(t.unit).dimension:
        return str(t)
    return f"{t.symbol} = {t.to(unit):.4g} {unit}"


def texts(model: Model) -> str:
    """A model as text, with its terms as `text_of` writes them."""
    return ", ".join(map(text_of, model))


def steady(loop: Loop, sensor: str, interval: float | None) -> float:
    """Response of the error to a constant rate, s, or a constant tilt."""
    if sensor == "accelerometer":
        return 1.0
    if loop.k2:
        return 0.0
    return loop.time_constant if interval is None else interval / math.expm1(loop.k1 * interval)


@public
def error_density(found: Prediction, f: FloatArray) -> dict[str, FloatArray]:
    """Root of the one-sided density of the error by source, rad/sqrt(Hz), at frequencies in Hz, without sinusoids."""
    noise, f = SensorNoise.of(found.gyro, found.accelerometer, found.duration, found.rate), np.asarray(f, np.float64)
    POSITIVE.demand(f, "f")
    gains = dict(zip(SENSORS, map(np.abs, found.loop.responses(f, noise.interval)), strict=True))
    return {f"{sensor} {t.symbol}": gains[sensor] * np.sqrt(2 * own) for sensor, t, own in noise.densities(f)}
