"""Six channels of one body: rates and specific forces, checked before they are filtered."""

import math
from dataclasses import dataclass

import numpy as np

from allanite.extending import DataError, FloatArray, Record, Recording, between, plural, spelled

from .axes import Axes, demand_upright
from .density import GRAVITY, SENSORS

FASTEST = 50.0
"""Rate, rad/s, above which the unit is doubted."""

PLAUSIBLE = 0.2
"""Deviation of the mean specific force from g, relative, beyond which the unit is doubted."""

STEEP = math.cos(math.radians(89.0))


@dataclass(frozen=True, eq=False)
class Inertial:
    """Rates and specific forces of one body.

    Attributes
    ----------
    gyro, force : arrays, shape (n, 3)
        Mean rates over each interval, rad/s, and specific forces, m/s^2, about and along the axes that are forward,
        sideways and vertical. The specific force points up at rest: where the vertical axis points down it has been
        turned around.
    rate : float
        Sampling rate, Hz.
    downward : bool
        Whether the vertical axis points down.
    aligned : (roll, pitch) or None
        Where the filters start, rad; by default at the mean specific force of the first second.
    """

    gyro: FloatArray
    force: FloatArray
    rate: float
    downward: bool = False
    aligned: tuple[float, float] | None = None

    @property
    def interval(self) -> float:
        """Sample interval, s."""
        return 1 / self.rate

    @property
    def gravity(self) -> float:
        """Median size of the specific force, m/s^2."""
        return float(np.median(np.linalg.norm(self.force, axis=1)))

    @property
    def start(self) -> FloatArray:
        """Roll and pitch at the start, rad."""
        if self.aligned is not None:
            return np.array(self.aligned)
        x, y, z = self.force[: max(1, round(self.rate))].mean(axis=0)
        return np.array([math.atan2(y, z), math.atan2(-x, math.hypot(y, z))])


def six_channels(recording: Recording) -> tuple[tuple[Record, ...], tuple[Record, ...]]:
    """The three gyros and the three accelerometers of a recording, in the order of their channels."""
    found = tuple(tuple(r for r in recording if r.signal.name == sensor) for sensor in SENSORS)
    counts = [plural(len(records), sensor) for records, sensor in zip(found, SENSORS, strict=True)]
    if any(len(records) != 3 for records in found):
        cure = "choose six channels with " + spelled("--channels gx,gy,gz,ax,ay,az", "channels=...")
        if not found[1]:
            cure = spelled("if the file has no units, give --unit gyro=deg/s,accel=g",
                           "add the accelerometers to the recording")  # fmt: skip
        raise DataError(
            f"roll and pitch need three gyros and three accelerometers, but there are {' and '.join(counts)}: "
            f"{', '.join(recording.channels)}; {cure}"
        )
    sizes = {(record.size, record.rate) for records in found for record in records}
    if len(sizes) > 1:
        said = ", ".join(f"{r.name} {r.size} samples at {r.rate:g} Hz" for records in found for r in records)
        raise DataError(f"the six channels must have one sampling rate and length, but these differ: {said}; resample "
                        "them first")  # fmt: skip
    return found[0], found[1]


def inertial(recording: Recording, axes: Axes | None = None) -> Inertial:
    """The six channels as arrays along `axes`, checked; by default x, y, z, of which z must be vertical."""
    gyros, accelerometers = six_channels(recording)
    for record in (*gyros, *accelerometers):
        demand_whole(record)
    gyro, force = (np.stack([r.rate_values for r in records], axis=1) for records in (gyros, accelerometers))
    fastest = float(np.sqrt((gyro**2).mean(axis=0)).max())
    if fastest > FASTEST:
        raise DataError(
            f"the gyros read {fastest:.3g} rad/s (RMS), which no vehicle does: are they in deg/s? Give the unit with "
            f"{spelled('--unit gyro=deg/s', 'unit=...')}"
        )
    size = float(np.median(np.linalg.norm(force, axis=1)))
    if size < 0.1:
        raise DataError("the accelerometers read nothing (free fall): without specific force there is no vertical")
    for wrong, unit in ((1.0, "g"), (GRAVITY**2, "m/s^2")):
        if abs(size / wrong - 1) < PLAUSIBLE:
            raise DataError(
                f"the median specific force is {size:.4g} m/s^2, not {GRAVITY:.4g}: are the accelerometers in {unit}? "
                f"Give the unit with {spelled(f'--unit accel={unit}', 'unit=...')}"
            )
    if axes is None:
        demand_upright(force.mean(axis=0))
    else:
        gyro, force = axes.turned(gyro), axes.turned(force)
    downward = bool(force[:, 2].mean() < 0)
    return Inertial(gyro, -force if downward else force, gyros[0].rate, downward)


def demand_whole(record: Record) -> None:
    """Refuse missing samples, and name the longest stretch without."""
    lost = ~np.isfinite(record.rate_values)
    if not lost.any():
        return
    runs = np.flatnonzero(np.diff(np.concatenate(([1], lost.astype(np.int8), [1])))).reshape(-1, 2)
    first, last = runs[np.diff(runs, axis=1)[:, 0].argmax()] if runs.size else (0, 0)
    where = between(record.cut + first / record.rate, record.cut + last / record.rate)
    raise DataError(
        f"{plural(int(lost.sum()), 'sample')} of {record.name!r} are missing, the first at "
        f"{record.cut + int(lost.argmax()) / record.rate:.6g} s, and an attitude cannot be carried across a gap; the "
        f"longest stretch without a gap: {where}"
    )
