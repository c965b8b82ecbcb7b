"""The earth as a reference: its rate at a latitude, and north from the rate that a gyro measures."""

import math
from dataclasses import dataclass
from typing import Annotated

from allanite.extending import LATITUDE, DataError, UsageError, Value, demand_name, public, say, say_count

from .estimates import RateEstimate

EARTH = 7.292115e-5  # rate of the earth, rad/s (WGS 84)


@public
def earth_rate(latitude: Annotated[float, LATITUDE], axis: str = "vertical") -> float:
    """Component of the earth's rate at a latitude, rad/s.

    Parameters
    ----------
    latitude : float
        Geodetic, degrees, north positive.
    axis : {"vertical", "north"}
        Up, or horizontally to the north.

    Examples
    --------
    >>> round(earth_rate(55.793) * 206264.80624709636, 3)
    12.439
    """
    angle = math.radians(latitude)
    parts = {"vertical": math.sin(angle), "north": math.cos(angle)}
    demand_name("direction", axis, parts)
    return EARTH * parts[axis]


@dataclass(frozen=True, repr=False)
class North(Value):
    """Heading of a horizontal sensitive axis, degrees from north, clockwise from above.

    Attributes
    ----------
    heading : float
        The one of the two possible headings that is nearer to the approximate heading.
    other : float
        The other one, which has the same cosine.
    standard_error : float
        Degrees, linearized; infinite where the rate does not change with the heading.
    low, high : float
        Interval of the heading at `level`, degrees, including the nonlinearity of the arc cosine.
    level : float
    positions : int
        Number of positions measured.
    """

    heading: float
    other: float
    standard_error: float
    low: float
    high: float
    level: float
    positions: int

    def words(self) -> str:
        """The heading in a sentence."""
        error = (f"{60 * self.standard_error:.3g} arcmin" if self.standard_error < 1
                 else f"{self.standard_error:.3g} deg")  # fmt: skip
        return say_count(self.positions, "heading {heading:.4f} deg ({low:.4f} .. {high:.4f}), standard error {error}; "
                         "{count} position; {other:.4f} deg would give the same rate",
                         "heading {heading:.4f} deg ({low:.4f} .. {high:.4f}), standard error {error}; {count} "
                         "positions; {other:.4f} deg would give the same rate", heading=self.heading, low=self.low,
                         high=self.high, error=error, other=self.other)  # fmt: skip


@public
def north(
    rate: RateEstimate, latitude: float, *, second: RateEstimate | None = None, turned: float = 180.0,
    near: float = 90.0, level: float = 0.95,
) -> North:  # fmt: skip
    r"""Find north from the rate about a horizontal axis.

    An axis with the heading psi measures H cos(psi) + bias, with H the earth's rate towards north. One position gives
    psi = arccos(rate / H), where the bias is known and subtracted. A second one, turned by an angle d clockwise,
    removes the bias:

        rate - second = 2 H sin(d / 2) sin(psi + d / 2)

    Half a turn (d = 180) is the most sensitive. The standard error is that of the rate over abs(H sin psi): an axis
    that points east or west determines the heading best, one that points north hardly at all.

    Parameters
    ----------
    rate : RateEstimate
        Rate in the first position; without a second position, with the known bias subtracted.
    latitude : float
        Degrees.
    second : RateEstimate, optional
        Rate in the second position.
    turned : float
        Angle from the first position to the second, degrees clockwise.
    near : float
        Approximate heading, degrees; the nearer of two solutions is chosen.
    level : float
        Confidence level of the interval.

    Raises
    ------
    DataError
        The rate is larger than the earth's at this latitude.
    UsageError
        The latitude is a pole, or the second position is the first.

    Examples
    --------
    >>> from allanite import N
    >>> gyro = N(0.001, "deg/sqrt(h)").signal
    >>> measured = RateEstimate(0.0, 1e-8, "mean", "", gyro, "mean", 120.0)
    >>> north(measured, 60.0).words()[:56]
    'heading 90.0000 deg (89.9692 .. 90.0308), standard error'
    """
    if any(position is not None and position.signal.name != "gyro" for position in (rate, second)):
        raise UsageError("north is found from the rates of a gyro")
    H = earth_rate(latitude, "north")
    if second is None:
        half, scale, value, error = math.pi / 2, H, rate.value, rate.standard_error
    else:
        half = math.radians(turned) / 2
        scale, value = 2 * H * math.sin(half), rate.value - second.value
        error = math.hypot(rate.standard_error, second.standard_error)
    if abs(scale) < 1e-3 * EARTH:
        why = "at a pole there is no north" if H < 1e-3 * EARTH else f"a rotation by {turned:g} deg is no rotation"
        raise UsageError(f"the heading cannot be found: {why}")
    reach = (rate.interval(level)[1] - rate.value) * error / rate.standard_error if error > 0 else 0.0
    if abs(value) > abs(scale) + reach:
        unit = rate.signal.sheet[0]
        raise DataError(say("the rate {rate:.6g} {unit} is more than the earth turns about a horizontal axis at "
                            "latitude {latitude:g}; subtract the gyro's bias, or measure in two positions",
                            rate=rate.to(unit), unit=unit, latitude=latitude))  # fmt: skip
    # of the two solutions of sin(psi + half) = sine the one nearest to `near`, and its limits
    sine, reach = value / scale, reach / abs(scale)
    s = max(-1.0, min(1.0, sine))
    rising = math.degrees(math.asin(s) - half) % 360
    falling = math.degrees(math.pi - math.asin(s) - half) % 360
    first, other = sorted((rising, falling), key=lambda psi: abs((psi - near + 180) % 360 - 180))
    slope = 1.0 if first == rising else -1.0
    low, high = (math.degrees(math.asin(max(-1.0, min(1.0, sine + k * reach)))) for k in (-1, 1))
    # limits that contain the largest rate go on beyond it, where the heading turns back
    low, high = -180 - high if sine - reach < -1 else low, 180 - low if sine + reach > 1 else high
    ends = [slope * (end - math.degrees(math.asin(s))) for end in (low, high)]
    cosine = math.sqrt(1 - s * s)
    spread = math.degrees(error / abs(scale) / cosine) if cosine > 0 else math.inf
    return North(first, other, spread, first + min(ends), first + max(ends), level, 1 if second is None else 2)
