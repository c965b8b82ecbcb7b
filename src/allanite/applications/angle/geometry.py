"""The gimbal angles of two free gyros: the geometry of the earth's rotation and of a ship's sway."""

# Derivation: docs/derivations.md.

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

from allanite.extending import TIME, DataError, FloatArray, UnitError, Value, demand_name, public

from .motion import Ring, Sway, angles_of, horizontal, sway_of, turned, vector

MIN_MOTION = 0.01
"""Part of the shortest harmonic's period that an angle must move for its harmonics to be estimated at all."""


def column(name: str, values: ArrayLike, size: int | None = None) -> FloatArray:
    """Finite float64 of shape (n,)."""
    array = np.asarray(values)
    if array.ndim != 1 or array.dtype.kind not in "fiu":
        raise DataError(f"{name} must be real numbers of shape (n,), not {array.dtype} of shape {array.shape}")
    if size is not None and array.size != size:
        raise DataError(f"{name} has {array.size} samples instead of {size}, as many as the others")
    bad = ~np.isfinite(array)
    if bad.any():
        first = int(bad.argmax())
        raise DataError(f"{int(bad.sum())} of {bad.size} samples of {name} are not finite, the first at sample "
                        f"{first}; omit those rows: the samples need not be evenly spaced")  # fmt: skip
    return np.ascontiguousarray(array, dtype=np.float64)


def demand_motion(name: str, span: float, orders: tuple[int, ...], remedy: str) -> None:
    """Refuse an angle that stands still; `span` is how far it moves, rad."""
    period = 2 * math.pi / max(orders)
    if span < MIN_MOTION * period:
        raise DataError(f"{name} stays within {math.degrees(span):.3g} deg, but a period of its harmonic {max(orders)} "
                        f"is {math.degrees(period):.3g} deg: the harmonics of an angle that does not move cannot be "
                        f"separated from a constant. {remedy}")  # fmt: skip


EARTH_RATE = 7.292115e-5  # rate of the earth against the stars, rad/s
QUARTER = 0.5 * math.pi / EARTH_RATE  # time from h = 0 to the extreme of h, s

Q_LAWS: dict[str, Callable[[FloatArray, float], FloatArray]] = {
    "exact": lambda H, latitude: np.unwrap(np.arctan2(np.cos(H), -math.sin(latitude) * np.sin(H))),
    "linear": lambda H, latitude: 0.5 * math.pi + H,
}
"""q of the equatorial gyro by H, the angle that the earth has turned: as geometry gives it, and as the paper states."""

ANGLES = ("h", "q", "h_polar", "q_polar", "mu")
"""The angle sensors: of the equatorial and of the polar gyro, and of the equatorial gyro's outer ring."""


def demand_angles(names: Iterable[str]) -> None:
    """Refuse names that are none of `ANGLES`."""
    for name in names:
        demand_name("angle", name, ANGLES)


Pair = tuple[FloatArray, FloatArray]


def _slopes(first: Pair, second: Pair) -> Pair:
    """Partial derivatives of the cosine between two vectors by h and q of the first."""
    (h, q), (p, r) = first, second
    by_h = np.cos(h) * np.sin(p) - np.sin(h) * np.cos(p) * np.cos(q - r)
    return np.asarray(by_h), np.asarray(-np.cos(h) * np.cos(p) * np.sin(q - r))


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
    mu : array, shape (n,), or float
        Angle of the equatorial gyro's outer ring, rad.
    ring_heading : float
        Direction of the ring's axis, from north to east, rad.

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
    mu: FloatArray | float = 0.0
    ring_heading: float = 0.0

    def __post_init__(self) -> None:
        time = column("time", self.time)
        if time.size < 2:
            raise DataError(f"{time.size} samples are too few; the angles must move during the record")
        steps = np.diff(time)
        if (steps <= 0).any():
            at = int((steps <= 0).argmax())
            raise DataError(f"time {'decreases' if steps[at] < 0 else 'does not increase'} at sample {at + 1} "
                            f"({time[at + 1]:.9g} s after {time[at]:.9g} s), {int((steps <= 0).sum())} such steps in "
                            "all; sort the rows by time and remove repeated ones")  # fmt: skip
        object.__setattr__(self, "time", time)
        for name in (*ANGLES, *(["rho"] if self.rho is not None else [])):
            values = np.asarray(getattr(self, name))
            whole = np.full(time.size, values.item()) if values.ndim == 0 and name in ANGLES[2:] else values
            object.__setattr__(self, name, column(name, whole, time.size))
        for name in ("h", "h_polar"):
            if (worst := np.abs(getattr(self, name)).max()) > math.pi / 2 + 1e-9:
                raise UnitError(f"{name} reaches {worst:.6g} rad, beyond a right angle: is it in degrees?")

    @property
    def _polar(self) -> Pair:
        """The polar vector's h and q as seen from the equatorial gyro's ring."""
        return self._seen(self.h_polar, self.q_polar, self.mu)

    @property
    def base(self) -> Pair:
        """The equatorial vector's h and q as they would be with the outer ring at 0."""
        return self._seen(self.h, self.q, -np.asarray(self.mu))

    def _seen(self, h: FloatArray, q: FloatArray, mu: FloatArray | float) -> Pair:
        if not np.any(mu):
            return h, q
        return angles_of(turned(vector(h, q), np.outer(horizontal(self.ring_heading), mu)))

    @property
    def cosine(self) -> FloatArray:
        """Cosine of the angle between the two momentum vectors, shape (n,); 0 except for errors."""
        h, q = self._polar
        return np.asarray(np.cos(self.h) * np.cos(h) * np.cos(self.q - q) + np.sin(self.h) * np.sin(h))

    @property
    def g(self) -> FloatArray:
        """Change of the cosine with a turn of the equatorial vector about the axis of q, over cos h."""
        h, q = self._polar
        return np.asarray(-np.cos(h) * np.sin(self.q - q))

    @property
    def partials(self) -> dict[str, FloatArray]:
        """Partial derivative of the cosine by each of `ANGLES`, shape (n,) each."""
        base, polar = self.base, (self.h_polar, self.q_polar)
        across = np.cross(horizontal(self.ring_heading), vector(*base), axisb=0)
        slopes = (*_slopes((self.h, self.q), self._polar), *_slopes(polar, base),
                  (across * vector(*polar).T).sum(axis=1))  # fmt: skip
        return dict(zip(ANGLES, slopes, strict=True))

    def _summary(self) -> str:
        return f"{self.time.size} readings from {self.time[0]:g} to {self.time[-1]:g} s"

    def span(self, angle: str) -> float:
        """How far an angle moves, rad."""
        return float(np.ptp(np.unwrap(getattr(self, angle))))

    def period(self, angle: str, order: int) -> FloatArray:
        """Period of a harmonic at each instant, s, shape (n,); infinite where the angle stands still."""
        rate = np.abs(np.gradient(np.unwrap(getattr(self, angle)), self.time))
        return np.where(rate > 0, 2 * math.pi / (order * np.where(rate > 0, rate, 1.0)), math.inf)

    def mean_period(self, angle: str, order: int) -> float:
        """Mean period of a harmonic, s: time over the number of periods that the angle passes, to and fro."""
        passed = order * float(np.abs(np.diff(np.unwrap(getattr(self, angle)))).sum()) / (2 * math.pi)
        return float(self.time[-1] - self.time[0]) / passed if passed else math.inf

    def moved(self, **angles: Any) -> "Gimbals":
        """The same with some angles replaced."""
        return replace(self, **angles)


@public
def gimbals(
    time: ArrayLike, *, latitude: float, q_law: str = "exact", sway: Sway | tuple[float, float] | None = None,
    turn_period: Annotated[float | None, TIME] = 300.0, ring: Ring | None = None,
) -> Gimbals:  # fmt: skip
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
    ring : Ring, optional
        Motion of the equatorial gyro's outer ring, from the first sample.

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
    H = EARTH_RATE * clock
    h, q = np.arcsin(math.cos(latitude) * np.sin(H)), Q_LAWS[q_law](H, latitude)
    still = Gimbals(clock, h, q, np.full(H.size, latitude), np.zeros(H.size),
                    rho=None if turn_period is None else 2 * math.pi / turn_period * clock)  # fmt: skip
    swaying = sway_of(sway)
    if swaying is not None:
        swayed = [swaying.turn(vector(*pair), clock) for pair in ((h, q), (still.h_polar, still.q_polar))]
        (h, q), (h_polar, q_polar) = map(angles_of, swayed)
        still = still.moved(h=h, q=q, h_polar=h_polar, q_polar=q_polar)
    if ring is None:
        return still
    mu = ring.angle(clock - clock[0])
    h, q = angles_of(turned(vector(h, q), np.outer(horizontal(ring.heading), mu)))
    return replace(still, h=h, q=q, mu=mu, ring_heading=ring.heading)
