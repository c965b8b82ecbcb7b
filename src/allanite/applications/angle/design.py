"""How the measured cosine depends on what is estimated: harmonics of the sensors, and what else drifts and turns."""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from allanite.extending import FloatArray, UsageError, demand_name, say, spelled

from .checks import demand_motion
from .geometry import ANGLES, EARTH_RATE, Gimbals, demand_angles
from .harmonics import orders_of, waves

Orders = Sequence[int] | Mapping[str, Sequence[int]]

EQUATORIAL = ("h", "q")
"""The sensors that are estimated unless others are named."""


class Nuisance(NamedTuple):
    """A constant that is estimated jointly: its meaning, its power of time beyond an angle, and its column."""

    meaning: str
    per_time: int
    column: Callable[[Gimbals], FloatArray]


def _turning(g: Gimbals) -> tuple[FloatArray, FloatArray]:
    if g.rho is None:
        raise UsageError(
            spelled(
                "ax and az need the angle rho of the auto-compensating rotation (--rho or --turn-period); without "
                "one omit them: --nuisance A1,A2,A3",
                "ax and az need the angle rho of the auto-compensating rotation (turn_period=...); without one omit "
                "them: nuisance=('A1', 'A2', 'A3')",
            )
        )
    return np.sin(g.rho), np.cos(g.rho)


NUISANCES: dict[str, Nuisance] = {
    "ax": Nuisance(
        say("misalignment of the rotor's optical sensor in the rotating frame, x"),
        0,
        lambda g: g.partials["h"] * _turning(g)[1] + g.g * _turning(g)[0],
    ),
    "az": Nuisance(say("the same, z"), 0, lambda g: g.g * _turning(g)[1] - g.partials["h"] * _turning(g)[0]),
    "A1": Nuisance(say("daily sine of the gyros' unknown drift"), 0, lambda g: np.sin(EARTH_RATE * g.time)),
    "A2": Nuisance(say("daily cosine of it"), 0, lambda g: np.cos(EARTH_RATE * g.time)),
    "A3": Nuisance(say("linear growth of it"), 1, lambda g: g.time),
    "A0": Nuisance(say("a constant"), 0, lambda g: np.ones(g.time.size)),
}
"""Constants estimated jointly with the harmonics; by default all but A0.

The rows of ax and az, ``f1 cos(rho) + g sin(rho)`` and ``-f1 sin(rho) + g cos(rho)``, are an assumption: a small vector
fixed in the turning frame, seen along the measured direction. The literature names the two constants only.
"""

POLAR = (
    "The polar gyro's gimbals do not move on a fixed base (they stay at the latitude and 0): its sensors can be "
    "estimated under sway only"
)
EARTHLY = "Choose a longer interval, another part of the day, a latitude off the pole, or sway the base"
REMEDIES = {"h_polar": POLAR, "q_polar": POLAR, "mu": "Turn the outer ring"}
"""What makes an angle move: of the equatorial gyro, and of those that do not move with the earth."""

USUAL = ("ax", "az", "A1", "A2", "A3")


def harmonic_set(orders: Orders) -> dict[str, tuple[int, ...]]:
    """Angle: orders, from a mapping or from orders for both sensors of the equatorial gyro."""
    if isinstance(orders, Mapping):
        chosen = {angle: orders_of(k, f"orders of {angle}") for angle, k in orders.items()}
    else:
        chosen = dict.fromkeys(EQUATORIAL, orders_of(orders))
    demand_angles(chosen)
    if not chosen:
        raise UsageError(f"no angle is selected; angles: {', '.join(ANGLES)}")
    return chosen


def amplitude_names(harmonics: Mapping[str, tuple[int, ...]]) -> tuple[str, ...]:
    """``S128 h``, ``C128 h``, ...: sine and cosine amplitudes in the order of the columns."""
    return tuple(f"{wave}{k} {angle}" for angle, orders in harmonics.items() for k in orders for wave in "SC")


def design(
    gimbals: Gimbals, harmonics: Mapping[str, tuple[int, ...]], nuisance: Sequence[str]
) -> tuple[tuple[str, ...], FloatArray]:
    """Names of the constants, and the rows by which the measured cosine depends on them, shape (n, p)."""
    for name in nuisance:
        demand_name("nuisance", name, NUISANCES)
    if len(set(nuisance)) < len(nuisance):
        raise UsageError(f"a nuisance is given twice: {', '.join(nuisance)}")
    for angle, orders in harmonics.items():
        demand_motion(f"the angle {angle}", gimbals.span(angle), orders, REMEDIES.get(angle, EARTHLY))
    f = gimbals.partials
    blocks = [f[a][:, None] * waves(getattr(gimbals, a), orders) for a, orders in harmonics.items()]
    columns = [NUISANCES[name].column(gimbals) for name in nuisance]
    return (*amplitude_names(harmonics), *nuisance), np.column_stack([*blocks, *columns])
