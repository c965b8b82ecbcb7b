"""The gimbal angles of two free gyros: the geometry of the earth's rotation and of a ship's sway.

Local axes are east, north, up. A momentum vector is (cos h sin q, cos h cos q, sin h): h is the angle of the inner
gimbal above the base, q that of the intermediate one. The equatorial gyro's vector lies in the plane of the equator;
time is counted from its passage of h = 0 upwards, towards the east. The polar gyro's points along the earth's axis.
"""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from allanite.extending import DataError, FloatArray, UnitError, UsageError, Value, demand_name

from .checks import column, demand_increasing

EARTH_RATE = 7.292115e-5
"""Rate of the earth against the stars, rad/s."""

QUARTER = 0.5 * math.pi / EARTH_RATE
"""Time from h = 0 to the extreme of h, s."""

Q_LAWS: dict[str, Callable[[FloatArray, float], FloatArray]] = {
    "exact": lambda H, latitude: np.unwrap(np.arctan2(np.cos(H), -math.sin(latitude) * np.sin(H))),
    "linear": lambda H, latitude: 0.5 * math.pi + H,
}
"""q of the equatorial gyro by H, the angle that the earth has turned: as geometry gives it, and as the paper states."""

ANGLES = ("h", "q", "h_polar", "q_polar")
"""The four angle sensors: of the equatorial and of the polar gyro."""


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


def demand_angles(names: Iterable[str]) -> None:
    """Refuse names that are none of `ANGLES`."""
    for name in names:
        demand_name("angle", name, ANGLES)


@dataclass(frozen=True, eq=False, repr=False)
class Gimbals(Value):
    """Angles of both gyros' gimbals over time.

    Attributes
    ----------
    time : array, shape (n,)
        s, increasing, counted from the equatorial gyro's passage of h = 0.
    h, q : arrays, shape (n,)
        Gimbal angles of the equatorial gyro, rad.
    h_polar, q_polar : arrays, shape (n,), or float
        Gimbal angles of the polar gyro, rad; on a still base the latitude and 0.
    rho : array, shape (n,), optional
        Angle of the auto-compensating rotation, rad; without it its errors cannot be estimated.

    Raises
    ------
    DataError
        Values are not finite, of unequal lengths, or time does not increase.
    UnitError
        An elevation h exceeds a right angle: it is in degrees.
    """

    time: FloatArray
    h: FloatArray
    q: FloatArray
    h_polar: FloatArray
    q_polar: FloatArray
    rho: FloatArray | None = None

    def __post_init__(self) -> None:
        time = column("time", self.time)
        if time.size < 2:
            raise DataError(f"{time.size} samples are too few; the angles must move during the record")
        demand_increasing(time)
        object.__setattr__(self, "time", time)
        for name in (*ANGLES, *(["rho"] if self.rho is not None else [])):
            values = np.asarray(getattr(self, name))
            whole = np.full(time.size, values.item()) if values.ndim == 0 and "polar" in name else values
            object.__setattr__(self, name, column(name, whole, time.size))
        for name in ("h", "h_polar"):
            if (worst := np.abs(getattr(self, name)).max()) > math.pi / 2 + 1e-9:
                raise UnitError(f"{name} reaches {worst:.6g} rad, beyond a right angle: is it in degrees?")

    @property
    def cosine(self) -> FloatArray:
        """Cosine of the angle between the two momentum vectors, shape (n,); 0 except for errors."""
        flat = np.cos(self.h) * np.cos(self.h_polar) * np.cos(self.q - self.q_polar)
        return np.asarray(flat + np.sin(self.h) * np.sin(self.h_polar))

    @property
    def g(self) -> FloatArray:
        """Change of the cosine with a turn of the equatorial vector about the vertical, over cos h."""
        return np.asarray(-np.cos(self.h_polar) * np.sin(self.q - self.q_polar))

    @property
    def partials(self) -> dict[str, FloatArray]:
        """Partial derivative of the cosine by each of `ANGLES`, shape (n,) each."""
        h, p = (np.sin(self.h), np.cos(self.h)), (np.sin(self.h_polar), np.cos(self.h_polar))
        c, s = np.cos(self.q - self.q_polar), np.sin(self.q - self.q_polar)
        return {
            "h": h[1] * p[0] - h[0] * p[1] * c,
            "q": -h[1] * p[1] * s,
            "h_polar": h[0] * p[1] - h[1] * p[0] * c,
            "q_polar": h[1] * p[1] * s,
        }

    def _summary(self) -> str:
        return f"{self.time.size} readings from {self.time[0]:g} to {self.time[-1]:g} s"

    def span(self, angle: str) -> float:
        """How far an angle moves, rad."""
        return float(np.ptp(np.unwrap(getattr(self, angle))))

    def period(self, angle: str, order: int) -> FloatArray:
        """Period of a harmonic at each instant, s, shape (n,); infinite where the angle stands still."""
        rate = np.abs(np.gradient(np.unwrap(getattr(self, angle)), self.time))
        return np.where(rate > 0, 2 * math.pi / (order * np.where(rate > 0, rate, 1.0)), math.inf)

    def moved(self, **angles: FloatArray) -> "Gimbals":
        """The same with some angles replaced."""
        return replace(self, **angles)


def gimbals(
    time: ArrayLike,
    *,
    latitude: float,
    q_law: str = "exact",
    sway: Sway | tuple[float, float] | None = None,
    turn_period: float | None = 300.0,
) -> Gimbals:
    """The gimbal angles of an ideal pair of gyros.

    On a still base ``h = asin(cos(latitude) sin(W t))`` and ``q = atan2(cos(W t), -sin(latitude) sin(W t))`` with the
    earth's rate W; the polar gyro's angles are the latitude and 0.

    Parameters
    ----------
    time : array, shape (n,)
        s, counted from h = 0.
    latitude : float
        rad.
    q_law : {"exact", "linear"}
        "linear" is ``q = pi/2 + W t``, as the literature states it [1]; it is wrong except at the pole, and for
        reproducing its results only.
    sway : (amplitude, period) or Sway, optional
        rad and s. It moves the polar gyro's gimbals too.
    turn_period : float or None
        Period of the auto-compensating rotation, s; None for no rotation.

    Raises
    ------
    UnitError
        The latitude exceeds a right angle.
    UsageError
        Another choice is impossible.
    DataError
        Time does not increase.

    References
    ----------
    .. [1] The results of an algorithm to estimate the errors of the angle sensors of a gimballed inertial navigation
       system (in Russian), 2018, equations 2 and 3; see docs/angle_paper.md.

    Examples
    --------
    >>> hour = gimbals([0.0, 3600.0], latitude=np.radians(60))
    >>> np.degrees(hour.h).round(2).tolist(), np.degrees(hour.q).round(2).tolist()
    ([0.0, 7.46], [90.0, 103.1])
    """
    clock = column("time", time)
    if not math.isfinite(latitude) or abs(latitude) > math.pi / 2 + 1e-12:
        raise UnitError(f"a latitude must not exceed a right angle, as {latitude!r} rad does: is it in degrees?")
    demand_name("law", q_law, Q_LAWS)
    if turn_period is not None and not (math.isfinite(turn_period) and turn_period > 0):
        raise UsageError(
            f"the period of the auto-compensating rotation must be a positive number of s, not {turn_period!r}"
        )
    H = EARTH_RATE * clock
    h, q = np.arcsin(math.cos(latitude) * np.sin(H)), Q_LAWS[q_law](H, latitude)
    still = Gimbals(
        clock, h, q, np.full(H.size, latitude), np.zeros(H.size),
        rho=None if turn_period is None else 2 * math.pi / turn_period * clock,
    )  # fmt: skip
    swaying = sway_of(sway)
    if swaying is None:
        return still
    angles = {}
    for h_name, q_name in (("h", "q"), ("h_polar", "q_polar")):
        h, q = getattr(still, h_name), getattr(still, q_name)
        east, north, up = swaying.turn(np.array([np.cos(h) * np.sin(q), np.cos(h) * np.cos(q), np.sin(h)]), clock)
        angles[h_name], angles[q_name] = np.arcsin(np.clip(up, -1.0, 1.0)), np.unwrap(np.arctan2(east, north))
    return still.moved(**angles)
