"""A ship's sway: the rotation of the base."""

import math
from dataclasses import dataclass

import numpy as np

from allanite.extending import FloatArray, UnitError, UsageError, Value


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
            raise UnitError(
                f"sway of {max(abs(self.roll), abs(self.pitch)):g} rad: is that in degrees? rad is expected"
            )

    def turn(self, vectors: FloatArray, time: FloatArray) -> FloatArray:
        """Vectors of the local axes, shape (3, n), as the swaying base sees them at `time`, s."""
        phase = 2 * math.pi / self.period * time
        forward = np.array([math.sin(self.heading), math.cos(self.heading), 0.0])
        starboard = np.array([math.cos(self.heading), -math.sin(self.heading), 0.0])
        rotation = np.outer(forward, self.roll * np.sin(phase)) + np.outer(starboard, self.pitch * np.cos(phase))
        size = np.linalg.norm(rotation, axis=0)
        axis = rotation / np.where(size > 0, size, 1.0)
        # Rodrigues' formula; the base turns by +size, so that what stands still turns by -size in its axes
        along = axis * (axis * vectors).sum(axis=0) * (1 - np.cos(size))
        return np.asarray(vectors * np.cos(size) - np.cross(axis, vectors, axis=0) * np.sin(size) + along)


def sway_of(sway: "Sway | tuple[float, float] | None") -> Sway | None:
    """Sway given as (amplitude, period) is roll and pitch of that amplitude."""
    if sway is None or isinstance(sway, Sway):
        return sway
    if not isinstance(sway, (tuple, list)) or len(sway) != 2:
        raise UsageError(f"sway must be (amplitude in rad, period in s) or a Sway, not {sway!r}")
    return Sway(float(sway[0]), float(sway[0]), float(sway[1]))
