"""Spectral densities of a gyro's rate and an accelerometer's tilt, at nodes of an integral over frequency."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from allanite.extending import (
    LARGEST,
    FloatArray,
    Model,
    ModelLike,
    Term,
    UnitError,
    UsageError,
    convert,
    given,
    spelled,
    usable_model,
)

GRAVITY = convert(1.0, "g", "m/s^2")
SENSORS = ("gyro", "accelerometer")

WIDTH, ORDER = 0.5, 8
"""Width of a panel in the logarithm of the frequency, and Gauss nodes in it."""

LOWEST, HIGHEST = 1e-13, 1e13
"""Frequencies, Hz, which replace 0 and infinity."""

FINE = 1e-4
"""Sample interval, in periods, at which a sampled spectrum is that of continuous time."""


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
        for value, name, unit in ((duration, "duration", "s"), (rate, "rate", "Hz")):
            if not 1 / LARGEST <= (1.0 if value is None else value) <= LARGEST:
                raise UsageError(f"the {name} must be a number of {unit} from {1 / LARGEST:g} to {LARGEST:g}, "
                                 f"not {given(value)}")  # fmt: skip
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
        """Sensor, term and two-sided density at the nodes, of rate in rad^2/s and of tilt in rad^2 s."""
        f, _ = self.nodes
        terms = [(s, t) for s, m in zip(SENSORS, (self.gyro, self.accelerometer), strict=True) for t in m]
        return tuple((s, t, scale(s) ** 2 * density(t, f, self.interval)) for s, t in terms if t.row.waveform is None)

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
    found = np.empty_like(f)
    decade = np.floor(np.log10(f) / 3)
    for which in np.unique(decade):
        at = decade == which
        fine = FINE / float(f[at].max())
        found[at] = t.value**2 * t.sampled(1 / fine).spectrum(f[at], fine)
    return found
