"""Six channels of one body: which axes they are, rates and specific forces, checked before they are filtered."""

import math
from dataclasses import dataclass

import numpy as np

from allanite.extending import (  # isort: skip
    DataError, FloatArray, Record, Recording, UsageError, between, constructed, plural, spelled)  # fmt: skip

from .loop import GRAVITY, SENSORS

NAMES = "xyz"


@dataclass(frozen=True)
class Axes:
    """The axes of the file that are forward, to the left (right) and up (down); right-handed."""

    index: tuple[int, ...] = (0, 1, 2)  # 0, 1 or 2 for x, y or z of the file
    sign: tuple[int, ...] = (1, 1, 1)  # -1 for an axis that points the other way

    @classmethod
    def of(cls, text: str) -> "Axes":
        """Read three names with signs."""
        parts = [part.strip().lower() for part in text.split(",")]
        index = [NAMES.find(part.lstrip("+-")) for part in parts]
        if sorted(index) != [0, 1, 2] or any(len(part) > 2 for part in parts):
            raise UsageError("the axes that are forward, sideways and vertical are x, y and z in some order, each with "
                             f"or without a minus, such as {_spelled('y,-x,z')}, not {text!r}")  # fmt: skip
        axes = cls(tuple(index), tuple(-1 if part[0] == "-" else 1 for part in parts))
        if np.linalg.det(axes.matrix) < 0:
            a, b, c = axes.sign
            other = cls(axes.index, (a, -b, c))
            raise UsageError(f"the axes {text} are left-handed: the second is to the left of the first if the third is "
                             f"up, and to the right if it is down; {_spelled(other)} is right-handed")  # fmt: skip
        return axes

    @classmethod
    def upright(cls, force: FloatArray) -> "Axes":
        """Those with the largest mean specific force up, and forward along the first of the others."""
        up = int(np.abs(force).argmax())
        forward = 1 if up == 0 else 0
        vertical, ahead = np.sign(force[up]) * np.eye(3)[up], np.eye(3)[forward]
        leftward = np.cross(vertical, ahead)
        side = int(np.abs(leftward).argmax())
        return cls((forward, side, up), (1, int(leftward[side]), int(vertical[up])))

    def __str__(self) -> str:
        return ",".join(("-" if s < 0 else "") + NAMES[i] for i, s in zip(self.index, self.sign, strict=True))

    @property
    def matrix(self) -> FloatArray:
        """From the axes of the file to these, shape (3, 3)."""
        return np.asarray(np.eye(3)[list(self.index)] * np.array(self.sign)[:, None])

    def ordered(self, records: tuple[Record, ...]) -> tuple[Record, ...]:
        """The sensors that are forward, sideways and vertical; their samples keep their signs."""
        return tuple(records[i] for i in self.index)

    def turned(self, values: FloatArray) -> FloatArray:
        """Samples along the axes of the file, shape (n, 3), along these."""
        return np.asarray(values[:, list(self.index)] * np.array(self.sign, dtype=np.float64))


def _spelled(axes: Axes | str) -> str:
    """The option that gives these axes."""
    return spelled(f"--axes {axes}", f"axes='{axes}'")


FASTEST = 50.0  # rate, rad/s, above which the unit is doubted
PLAUSIBLE = 0.2  # deviation of the mean specific force from g, relative, beyond which the unit is doubted


@constructed
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

    def __post_init__(self) -> None:
        for name in ("gyro", "force"):
            values = np.ascontiguousarray(getattr(self, name), dtype=np.float64)
            if values.shape != (len(self.gyro), 3):
                raise DataError(f"gyro and force have one shape (n, 3), but {name} has {values.shape}")
            object.__setattr__(self, name, values)

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
    sensors = tuple(tuple(r for r in recording if r.signal.name == sensor) for sensor in SENSORS)
    counts = [plural(len(records), sensor) for records, sensor in zip(sensors, SENSORS, strict=True)]
    if any(len(records) != 3 for records in sensors):
        cure = "choose six channels with " + spelled("--channels gx,gy,gz,ax,ay,az", "channels=...")
        if not sensors[1]:
            cure = spelled("if the file has no units, give --unit gyro=deg/s,accel=g",
                           "add the accelerometers to the recording")  # fmt: skip
        raise DataError("roll and pitch need three gyros and three accelerometers, but there are "
                        f"{' and '.join(counts)}: {', '.join(recording.channels)}; {cure}")  # fmt: skip
    if len({(record.size, record.rate) for records in sensors for record in records}) > 1:
        sampling = ", ".join(f"{r.name} {r.size} samples at {r.rate:g} Hz" for records in sensors for r in records)
        raise DataError(f"the six channels must have one sampling rate and length, but these differ: {sampling}; "
                        "resample them first")  # fmt: skip
    return sensors[0], sensors[1]


def inertial(recording: Recording, axes: Axes | None = None) -> Inertial:
    """The six channels as arrays along `axes`, checked; by default x, y, z, of which z must be vertical."""
    gyros, accelerometers = six_channels(recording)
    for record in (*gyros, *accelerometers):
        record.demand_range()
        demand_whole(record)
    gyro, force = (np.stack([r.rate_values for r in records], axis=1) for records in (gyros, accelerometers))
    fastest = float(np.sqrt((gyro**2).mean(axis=0)).max())
    if fastest > FASTEST:
        raise DataError(f"the gyros read {fastest:.3g} rad/s (RMS), which no vehicle does: are they in deg/s? Give the "
                        f"unit with {spelled('--unit gyro=deg/s', 'unit=...')}")  # fmt: skip
    size = float(np.median(np.linalg.norm(force, axis=1)))
    if size < 0.1:
        raise DataError("the accelerometers read nothing (free fall): without specific force there is no vertical")
    for wrong, unit in ((1.0, "g"), (GRAVITY**2, "m/s^2")):
        if abs(size / wrong - 1) < PLAUSIBLE:
            raise DataError(f"the median specific force is {size:.4g} m/s^2, not {GRAVITY:.4g}: are the accelerometers "
                            f"in {unit}? Give the unit with {spelled(f'--unit accel={unit}', 'unit=...')}")  # fmt: skip
    mean = force.mean(axis=0)
    if axes is not None:
        gyro, force = axes.turned(gyro), axes.turned(force)
    elif (own := Axes.upright(mean)).index[2] != 2:
        up, share = str(own).split(",")[2], np.abs(mean).max() / np.linalg.norm(mean)
        raise DataError(f"gravity is along {up}, not z: {share:.0%} of the mean specific force; give {_spelled(own)}, "
                        "the axes that are forward, sideways and vertical (another one may be forward), or "
                        f"{_spelled('x,y,z')} if the body lies on its side")  # fmt: skip
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
    raise DataError(f"{plural(int(lost.sum()), 'sample')} of {record.name!r} are missing, the first at "
                    f"{record.cut + int(lost.argmax()) / record.rate:.6g} s, and an attitude cannot be carried across "
                    f"a gap; the longest stretch without a gap: {where}")  # fmt: skip
