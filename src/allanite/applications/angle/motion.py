"""What turns the gimbals beside the earth: the sway of a ship, and the outer ring of the equatorial gyro."""

import math
from dataclasses import dataclass

import numpy as np

from allanite.extending import FloatArray, UnitError, UsageError, Value, constructed


def vector(h: FloatArray, q: FloatArray) -> FloatArray:
    """Unit vector at gimbal angles, shape (3, n)."""
    return np.array([np.cos(h) * np.sin(q), np.cos(h) * np.cos(q), np.sin(h)])


def angles_of(vectors: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Angles h and q of unit vectors of shape (3, n); q without jumps."""
    east, north, up = vectors
    return np.arcsin(np.clip(up, -1.0, 1.0)), np.unwrap(np.arctan2(east, north))


def horizontal(heading: float) -> FloatArray:
    """Horizontal unit vector in a direction, rad from north to east, shape (3,)."""
    return np.array([math.sin(heading), math.cos(heading), 0.0])


def turned(vectors: FloatArray, rotation: FloatArray) -> FloatArray:
    """Vectors as seen in axes that have turned by these rotation vectors, rad, both of shape (3, n)."""
    size = np.linalg.norm(rotation, axis=0)
    axis = rotation / np.where(size > 0, size, 1.0)
    # Rodrigues' formula; the axes turn by +size, so that what stands still turns by -size in them
    along = axis * (axis * vectors).sum(axis=0) * (1 - np.cos(size))
    return np.asarray(vectors * np.cos(size) - np.cross(axis, vectors, axis=0) * np.sin(size) + along)


@constructed
@dataclass(frozen=True, repr=False)
class Sway(Value):
    """A ship's sway: roll and pitch of one period, a quarter of it apart.

    Attributes
    ----------
    roll, pitch : float
        Amplitudes, rad.
    period : float
        s.
    heading : float
        Heading of the ship, from north to east, rad.
    """

    roll: float
    pitch: float
    period: float
    heading: float = 0.0

    def __post_init__(self) -> None:
        if not np.isfinite([self.roll, self.pitch, self.period, self.heading]).all() or self.period <= 0:
            raise UsageError(f"sway must be two finite amplitudes in rad and a period in s above 0, not {self}")
        if max(abs(self.roll), abs(self.pitch)) > math.pi / 4:
            raise UnitError(f"sway of {max(abs(self.roll), abs(self.pitch)):g} rad: is that in degrees? rad is "
                            "expected")  # fmt: skip

    def turn(self, vectors: FloatArray, time: FloatArray) -> FloatArray:
        """Vectors of the local axes, shape (3, n), as the swaying base sees them at `time`, s."""
        phase = 2 * math.pi / self.period * time
        forward, starboard = horizontal(self.heading), horizontal(self.heading + math.pi / 2)
        rolled, pitched = self.roll * np.sin(phase), self.pitch * np.cos(phase)
        return turned(vectors, np.outer(forward, rolled) + np.outer(starboard, pitched))


def sway_of(sway: "Sway | tuple[float, float] | None") -> Sway | None:
    """Sway given as (amplitude, period) is roll and pitch of that amplitude."""
    if sway is None or isinstance(sway, Sway):
        return sway
    if not isinstance(sway, (tuple, list)) or len(sway) != 2:
        raise UsageError(f"sway must be (amplitude in rad, period in s) or a Sway, not {sway!r}")
    return Sway(float(sway[0]), float(sway[0]), float(sway[1]))


@dataclass(frozen=True, repr=False)
class Ring(Value):
    """Motion of a gimbal's outer ring, which is turned to and fro between two angles to tell the harmonics apart.

    The periods of the errors of h and q nearly coincide in parts of the day. Turning the outer ring changes them: where
    the momentum vector is across the ring's axis, h follows the ring and q does not. The source [1] names a "special
    law" without giving it; this one is the simplest, a constant rate, or steps of it. The ring's axis is horizontal and
    fixed in the base (our assumption): it carries the axis of q.

    Attributes
    ----------
    rate : float
        Mean rate, rad/s.
    low, high : float
        Limits of the angle, rad; it begins at `low`.
    step : float
        Size of a step, rad, after which the ring stands until the next; 0: it turns continuously.
    heading : float
        Direction of the ring's axis, from north to east, rad.

    References
    ----------
    .. [1] A. Yu. Sokolov and A. A. Stolbov, Control of the angle sensors of gimbals of an inertial navigation system on
       free gyros with an autonomous measurement (in Russian), XIV conference of young scientists, 2012, 109-113.

    Examples
    --------
    >>> ring = Ring(rate=np.radians(0.1), low=np.radians(-1), high=np.radians(1), step=np.radians(0.5))
    >>> np.degrees(ring.angle(np.array([0.0, 4.9, 5.1, 20.0, 35.1]))).round(3).tolist()
    [-1.0, -1.0, -0.5, 1.0, -0.5]
    """

    rate: float
    low: float
    high: float
    step: float = 0.0
    heading: float = 0.0

    def __post_init__(self) -> None:
        numbers = [self.rate, self.low, self.high, self.step, self.heading]
        typed = all(isinstance(number, (int, float, np.number)) for number in numbers)
        if not typed or not np.isfinite(numbers).all() or self.rate <= 0 or self.high <= self.low or self.step < 0:
            raise UsageError("a ring needs a rate in rad/s above 0, an angle in rad below another, and no negative "
                             f"step, not {self}")  # fmt: skip
        if max(abs(self.low), abs(self.high)) >= math.pi / 2:
            raise UnitError(f"a ring turned by {max(abs(self.low), abs(self.high)):g} rad, a right angle or "
                            "more, may lay the momentum vector along the axis of q, where the gimbals fold: is it in "
                            "degrees?")  # fmt: skip
        if self.step > self.high - self.low:
            raise UsageError(f"a step of {self.step:g} rad exceeds the range of {self.high - self.low:g} rad")

    def angle(self, time: FloatArray) -> FloatArray:
        """Angle of the ring at `time`, s from the beginning of its motion, rad, shape (n,)."""
        span = self.high - self.low
        way = self.rate * time
        if self.step:
            way = self.step * np.floor(way / self.step + 1e-9)
        return np.asarray(self.low + span - np.abs(np.mod(way, 2 * span) - span))
