"""The complementary loop: how gyro and accelerometer errors, of any spectral density, reach the angle."""

# Derivation: docs/derivations.md.

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from allanite.extending import (  # isort: skip
    POSITIVE, SIZE, TIME, FloatArray, Model, ModelLike, Term, UnitError, UsageError, Value, constructed, convert,
    public, spelled, usable_model)  # fmt: skip

GRAVITY = convert(1.0, "g", "m/s^2")
SENSORS = ("gyro", "accelerometer")

WIDTH, ORDER = 0.5, 8  # width of a panel in the logarithm of the frequency, and Gauss nodes in it
LOWEST, HIGHEST = 1e-13, 1e13  # frequencies, Hz, which replace 0 and infinity
FINE = 1e-4  # sample interval, in periods, at which a sampled spectrum is that of continuous time


@dataclass(frozen=True, eq=False)
class SensorNoise:
    """Noise of both sensors, its horizon, and the sample interval; None for continuous time or no horizon."""

    gyro: Model
    accelerometer: Model
    duration: float | None = None
    interval: float | None = None

    @classmethod
    def of(
        cls, gyro: ModelLike, accelerometer: ModelLike, duration: float | None = None, rate: float | None = None
    ) -> "SensorNoise":
        """Both noises, checked."""
        models = usable_model(gyro), usable_model(accelerometer)
        for model, sensor in zip(models, SENSORS, strict=True):
            if model.signal.name != sensor:
                raise UnitError(f"the noise of the {sensor} is that of another sensor ({model.signal.name}): {model}")
        TIME.demand(duration, "the duration")
        POSITIVE.demand(rate, "the sampling rate")
        for t in (t for model in models for t in model if t.value):
            if rate is None and (t.row.alpha or 0) > 0:  # its power is infinite in continuous time
                raise UsageError(f"{t.symbol} ({t.row.title}) depends on the sampling rate: give it with "
                                 + spelled("--rate HZ", "rate=..."))  # fmt: skip
            if duration is None and t.row.slope >= 0:
                raise UsageError(f"the error that {t.symbol} ({t.row.title}) causes grows with time: give a horizon "
                                 + spelled("with --duration TIME", "with duration=..."))  # fmt: skip
        return cls(*models, duration, None if rate is None else 1 / rate)

    @property
    def lowest(self) -> float:
        """The lowest frequency that a run of this duration contains, Hz."""
        return LOWEST if self.duration is None else 1 / (2 * self.duration)

    @property
    def highest(self) -> float:
        """Half the sampling rate, Hz."""
        return HIGHEST if self.interval is None else 1 / (2 * self.interval)

    @cached_property
    def nodes(self) -> tuple[FloatArray, FloatArray]:
        """Nodes, Hz, and weights of the integral over all frequencies of both signs."""
        low, high = math.log(self.lowest), math.log(self.highest)
        if low >= high:
            raise UsageError("the duration must be longer than one sample interval")
        edges = np.linspace(low, high, max(2, math.ceil((high - low) / WIDTH) + 1))
        x, w = np.polynomial.legendre.leggauss(ORDER)
        half = np.diff(edges)[:, None] / 2
        f = np.exp(edges[:-1, None] + half * (1 + x)).ravel()
        return f, 2 * f * (half * w).ravel()

    @cached_property
    def noise(self) -> tuple[tuple[str, Term, FloatArray], ...]:
        """The densities at the nodes."""
        return tuple(self.densities(self.nodes[0]))

    def densities(self, f: FloatArray) -> Iterator[tuple[str, Term, FloatArray]]:
        """Sensor, term and two-sided density at frequencies, of rate in rad^2/s and of tilt in rad^2 s."""
        terms = [(s, t) for s, m in zip(SENSORS, (self.gyro, self.accelerometer), strict=True) for t in m]
        return ((s, t, scale(s) ** 2 * density(t, f, self.interval)) for s, t in terms if t.row.waveform is None)

    def total(self, sensor: str, f: FloatArray) -> FloatArray:
        """Density of all noise of a sensor at other frequencies."""
        model = self.gyro if sensor == "gyro" else self.accelerometer
        noise = [density(t, f, self.interval) for t in model if t.row.waveform is None]
        return np.asarray(scale(sensor) ** 2 * sum(noise, np.zeros(np.shape(f))))


def scale(sensor: str) -> float:
    """Factor from the unit of a sensor to that of the angle's equations: of an accelerometer, tilt."""
    return 1.0 if sensor == "gyro" else 1 / GRAVITY


def density(t: Term, f: FloatArray, interval: float | None) -> FloatArray:
    """Two-sided density of a term, SI; of continuous time without an interval."""
    if interval is not None:
        return np.asarray(t.value**2 * t.sampled(1 / interval).spectrum(f, interval))
    # the limit of short intervals, taken for ten octaves at once
    power = np.empty_like(f)
    decade = np.floor(np.log10(f) / 3)
    for which in np.unique(decade):
        at = decade == which
        fine = FINE / float(f[at].max())
        row = t.row.shaped(t.shape, 1 / fine) if t.row.shaped else t.row  # of its functions only one without rounding
        power[at] = t.value**2 * row.spectrum(f[at], fine)
    return power


ComplexArray = NDArray[np.complex128]


@constructed
@dataclass(frozen=True, repr=False)
class Loop(Value):
    """A complementary filter.

    Attributes
    ----------
    k1 : float
        Gain of the angle, 1/s.
    k2 : float
        Gain of the gyro bias, 1/s^2; 0 for the filter of first order.

    Examples
    --------
    >>> Loop.of(1.5).time_constant, Loop(0.9, 0.016).order, round(Loop(0.89099, 0.016160).damping, 2)
    (1.5, 2, 3.5)
    """

    _also = ("order", "time_constant")

    k1: Annotated[float, POSITIVE]
    k2: Annotated[float, SIZE] = 0.0

    @classmethod
    def of(cls, time_constant: "float | Loop") -> "Loop":
        """The filter of first order with this time constant, s; a filter is returned as it is."""
        if isinstance(time_constant, Loop):
            return time_constant
        return cls(1 / TIME.demand(time_constant, "a time constant"))

    @property
    def order(self) -> int:
        """1, or 2 if the filter estimates the gyro bias."""
        return 2 if self.k2 else 1

    @property
    def time_constant(self) -> float:
        """1 / k1, s."""
        return 1 / self.k1

    @property
    def frequency(self) -> float:
        """Natural frequency of the filter of second order, rad/s."""
        return math.sqrt(self.k2)

    @property
    def damping(self) -> float:
        """Damping ratio of the filter of second order."""
        return self.k1 / (2 * self.frequency) if self.k2 else math.inf

    def scaled(self, factor: float) -> "Loop":
        """The filter whose time constants are longer by a factor."""
        return Loop(self.k1 / factor, self.k2 / factor**2)

    def responses(self, f: FloatArray, interval: float | None = None) -> tuple[ComplexArray, ComplexArray]:
        """Responses of the error to rate noise (s) and to tilt noise, at frequencies in Hz.

        With a sample interval, those of the recursion

            prediction = theta + (omega - b) dt,    theta = alpha prediction + (1 - alpha) tilt,
            b = b - k2 dt (tilt - prediction),      alpha = exp(-k1 dt).
        """
        if interval is None:
            s = 2j * math.pi * np.asarray(f, dtype=np.float64)
            pull = self.k1 + self.k2 / s
            return np.reciprocal(s + pull), pull / (s + pull)
        alpha = math.exp(-self.k1 * interval)
        back = np.exp(-2j * math.pi * np.asarray(f, dtype=np.float64) * interval)
        # 1 - back without cancellation
        rise = 2j * np.sin(math.pi * np.asarray(f) * interval) * np.exp(-1j * math.pi * np.asarray(f) * interval)
        bias = self.k2 * interval**2 * back / rise
        loop: ComplexArray = 1 - alpha + alpha * rise + bias
        gain: ComplexArray = alpha * interval / loop
        return gain, (1 - alpha + bias) / loop

    def demand_sampled(self, interval: float) -> None:
        """Refuse a time constant that is not above the sample interval."""
        if self.time_constant <= interval:
            raise UsageError(f"the time constant must be above the sample interval of {interval:g} s, not "
                             f"{self.time_constant:g} s: the angle would be that of the accelerometer alone; give a "
                             f"longer one with {spelled('--time-constant', 'time_constant=...')}")  # fmt: skip

    def _summary(self) -> str:
        second = f", k2 = {self.k2:.4g} 1/s^2" if self.k2 else ""
        return f"k1 = {self.k1:.4g} 1/s{second}"


@public
def kalman(N: Annotated[float, SIZE], tilt: Annotated[float, POSITIVE], K: Annotated[float, SIZE] = 0.0) -> Loop:
    """The steady Kalman filter for white noises and a rate random walk, in closed form.

    Parameters
    ----------
    N : float
        Angle random walk of the gyro, rad/sqrt(s).
    tilt : float
        White noise of the tilt, rad/sqrt(Hz).
    K : float
        Rate random walk of the gyro, rad/s^1.5.

    Returns
    -------
    Loop
        k1 = sqrt(N^2 + 2 K tilt) / tilt, k2 = K / tilt; without K the complementary filter of first order with the time
        constant tilt / N, which is also the Wiener filter of these noises.

    Examples
    --------
    >>> round(kalman(8.7266e-5, 1e-4).time_constant, 3)
    1.146
    """
    return Loop(math.sqrt(N**2 + 2 * K * tilt) / tilt, K / tilt)
