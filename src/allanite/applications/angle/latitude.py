"""The latitude that the motion of h and q implies, whatever latitude is given."""

import math
from typing import NamedTuple

import numpy as np

from allanite.extending import Finding, FloatArray, UsageError, say, spelled

from .geometry import EARTH_RATE, Gimbals
from .motion import vector

VAGUE = math.radians(1)  # half width of a latitude that is too vague to be used
LONGEST_STEP = 600.0  # s; in a longer gap the motion is not followed
COVER = 6.0  # standard errors of its limits: simulated records with errors of 3 arcsec are beyond them 1 in 100
FALSE = 2.0  # half widths beyond which a latitude that is given is contradicted: of the same records 1 in 1000


class Latitude(NamedTuple):
    """A latitude and the half width of its limits, rad."""

    value: float
    half: float

    def __str__(self) -> str:
        digits = max(0, 1 - math.floor(math.log10(max(math.degrees(self.half), 1e-6))))
        return say("latitude {value} ± {half} deg", value=f"{math.degrees(self.value):.{digits}f}",
                   half=f"{math.degrees(self.half):.{digits}f}")  # fmt: skip


def latitude(gimbals: Gimbals) -> Latitude:
    """The latitude by the plane in which the equatorial vector moves; its limits reach to that by its rate, and beyond.

    On a base at rest the vector stays in the plane ``north cos(latitude) + up sin(latitude) = constant`` and turns by
    ``q' cos^2 h = W sin(latitude)``. The plane needs the zeros of h and q, the rate does not: where they differ, the
    angles are not those of a base at rest, or their zeros are wrong.
    """
    h, q = gimbals.base
    points = vector(h, q)[1:] - vector(h, q)[1:].mean(axis=1, keepdims=True)  # north and up
    _, axes = np.linalg.eigh(points @ points.T)
    along = axes[:, 1] * math.copysign(1.0, axes[1, 1])
    plane = math.atan2(-along[0], along[1])
    step, turned = np.diff(gimbals.time), np.diff(np.unwrap(q)) * np.cos((h[1:] + h[:-1]) / 2) ** 2
    used = step <= max(LONGEST_STEP, float(np.median(step)))
    by_rate = math.asin(np.clip(turned[used].sum() / (EARTH_RATE * step[used].sum()), -1.0, 1.0))
    error = math.sqrt(_spread(axes[:, 0] @ points) / max(float(((along @ points) ** 2).sum()), 1e-300))
    return Latitude(plane, abs(plane - by_rate) + COVER * error)


def _spread(residuals: FloatArray) -> float:
    """Variance of samples for the error of a mean: with their correlation up to where it is first negative."""
    size = 1 << (2 * residuals.size - 1).bit_length()
    correlation = np.fft.irfft(np.abs(np.fft.rfft(residuals, size)) ** 2, size)[: residuals.size]
    positive = int(np.argmax(correlation < 0)) or residuals.size
    return float(2 * correlation[:positive].sum() - correlation[0]) / residuals.size


def demand_latitude(gimbals: Gimbals) -> Latitude:
    """The latitude of these gimbals; refused where they hardly tell it."""
    implied = latitude(gimbals)
    if not implied.half <= VAGUE:
        cure = spelled("the latitude (--latitude DEG), or the polar gyro's inner angle (--h-polar COLUMN)", "h_polar")
        raise UsageError(f"the motion of h and q gives only the {implied}; give {cure}", choice="latitude")
    return implied


def contradiction(gimbals: Gimbals) -> tuple[Finding, ...]:
    """A finding where the motion of h and q contradicts the latitude at which the polar gyro stands."""
    given, still = float(gimbals.h_polar[0]), not np.ptp(gimbals.h_polar) and not gimbals.q_polar.any()
    if not still or abs(given - (implied := latitude(gimbals)).value) <= FALSE * implied.half:
        return ()
    before, after = (np.abs(g.partials["h"]).mean() for g in (gimbals, gimbals.moved(h_polar=implied.value)))
    what = say("the motion of h and q gives the {latitude}, not {given:.6g} deg", latitude=str(implied),
               given=math.degrees(given))  # fmt: skip
    effect = say("amplitudes of h become {share:.2g} times what they are", share=float(after / before))
    return (Finding("latitude", what, effect, say("give the latitude of the site, or omit it")),)
