"""Settings of a drift: what was calibrated, what is constant, how the sensors are mounted, and what is required."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from allanite.core.choices import described
from allanite.core.errors import UnitError, UsageError, given
from allanite.core.names import demand_name
from allanite.core.plain import Value
from allanite.core.ranges import POSITIVE, SIZE
from allanite.core.syntax import split_quantities
from allanite.core.units import Signal, convert, seconds_of, signal_named, unit_of
from allanite.exporting.target import ACCELEROMETER, GYRO
from allanite.phrases.phrase import say, spelled
from allanite.planning.drift import GRAVITY, Response, flat, schuler
from allanite.study.settings import UNAIDED, DriftChoices

CALIBRATION = 60.0  # usual time over which the bias is averaged, s


class QuantityUnits(NamedTuple):
    """What a quantity is called, and its units: SI, and that in which it is shown."""

    title: str
    si: str
    unit: str


QUANTITIES: dict[str, QuantityUnits] = {
    "heading": QuantityUnits(say("heading"), "rad", "deg"), "attitude": QuantityUnits(say("attitude"), "rad", "deg"),
    "velocity": QuantityUnits(say("velocity"), "m/s", "m/s"), "position": QuantityUnits(say("position"), "m", "m"),
}  # fmt: skip


class DriftPath(NamedTuple):
    """A sensor in a quantity: how often its integral is integrated; `coupled` if it acts through a tilt."""

    quantity: str
    sensor: str
    order: int
    coupled: bool = False

    @property
    def signal(self) -> Signal:
        """The output of the sensor."""
        return signal_named(self.sensor)


PATHS = (DriftPath("heading", GYRO, 0), DriftPath("attitude", GYRO, 0, coupled=True),
         DriftPath("velocity", ACCELEROMETER, 0), DriftPath("velocity", GYRO, 1, coupled=True),
         DriftPath("position", ACCELEROMETER, 1), DriftPath("position", GYRO, 2, coupled=True))  # fmt: skip

PLATFORMS = {"strapdown": PATHS, "level": tuple(path for path in PATHS if not path.coupled)}


class Requirement(NamedTuple):
    """A quantity that must not err more than `limit`, SI, after `time`, s; `unit` is that of the text."""

    text: str
    quantity: str
    limit: float
    unit: str
    time: float

    @classmethod
    def of(cls, text: str) -> "Requirement":
        """Read ``1 deg in 10 min`` or ``attitude 1 deg in 10 min``."""
        size, _, time = text.partition(" in ")
        words = size.split()
        name = words.pop(0) if words and words[0] in QUANTITIES else ""
        try:
            ((limit, unit),) = split_quantities(words)
            seconds = seconds_of(time)
        except ValueError:
            limit, unit, seconds = 0.0, "", 0.0
        if not (unit and UNAIDED.holds(seconds) and POSITIVE.holds(limit)):
            raise UsageError(f"a requirement has the form '1 deg in 10 min' or '100 m in 1 min', not {text!r}")
        dimension = unit_of(unit).dimension
        fitting = [q for q, row in QUANTITIES.items() if unit_of(row.si).dimension == dimension]
        if not fitting or (name and name not in fitting):
            raise UnitError(f"a required drift is an angle, a velocity or a distance as '1 deg', not {size.strip()!r}")
        quantity = name or fitting[0]
        return cls(text, quantity, convert(limit, unit, QUANTITIES[quantity].si), unit, seconds)


@described
@dataclass(frozen=True, repr=False)
class DriftSettings(DriftChoices, Value):
    """Choices of a drift.

    Raises
    ------
    UsageError
        A time is not positive or too long, or a text is of another form.
    """

    def __post_init__(self) -> None:
        super().__post_init__()
        demand_name("platform", self.platform, PLATFORMS)
        UNAIDED.demand(self.calibration or None, "a time of calibration that is not 0")
        if not self.times:
            raise UsageError("give at least one time without aid, in s")
        object.__setattr__(self, "times", tuple(sorted(set(self.times))))
        if bool(self.scale_factor) != bool(self.maneuver):
            both = spelled("--scale-error 0.1% --maneuver '90 deg'", "scale_factor=0.001, maneuver=['90 deg']")
            raise UsageError(f"an error of the scale factor acts on a maneuver: give both, e.g. {both}")
        assert self.requirements is not None  # noqa: S101 - texts are read now
        for text in self.turn_on:
            self._size(text, "a turn-on bias", "3 deg/h", (0,))
        for text in self.maneuver:
            self._size(text, "a maneuver", "90 deg", (0, 1))

    @staticmethod
    def _size(text: str, what: str, example: str, powers: tuple[int, ...]) -> tuple[str, float, int]:
        """Sensor, size in SI and power of time of a quantity."""
        try:
            ((value, unit),) = split_quantities(text.split())
        except (ValueError, AttributeError):
            value, unit = math.nan, ""
        if not unit or not SIZE.holds(value):
            raise UsageError(f"{what} has the form '{example}', not {given(text)}")
        for sensor in (GYRO, ACCELEROMETER):
            for power in powers:
                si = signal_named(sensor).si[power]
                if unit_of(si).dimension == unit_of(unit).dimension:
                    return sensor, convert(value, unit, si), power
        raise UnitError(f"{what} of a gyro or an accelerometer has the form '{example}'; {unit!r} is not a unit of it")

    @property
    def averaged(self) -> float:
        """The time of calibration, s."""
        if self.calibration is not None:
            return float(self.calibration)
        return 0.0 if self.turn_on else CALIBRATION

    @cached_property
    def requirements(self) -> tuple[Requirement, ...]:
        """What is required."""
        return tuple(map(Requirement.of, self.require))

    @property
    def paths(self) -> tuple[DriftPath, ...]:
        """How the sensors act on this platform."""
        return PLATFORMS[self.platform]

    def response(self, path: DriftPath) -> Response:
        """What the integral of a sensor does to a quantity."""
        gain = GRAVITY if path.sensor == GYRO and path.order else 1.0
        round_earth = self.schuler and path.quantity != "heading"
        return (schuler if round_earth else flat)(path.order, gain)

    def bias(self, sensor: str) -> float:
        """Standard deviation of the turn-on bias, SI."""
        sizes = (self._size(text, "a turn-on bias", "3 deg/h", (0,)) for text in self.turn_on)
        return math.hypot(*(size for of, size, _ in sizes if of == sensor))

    def scaled(self, sensor: str) -> tuple[float, float]:
        """Errors that the scale factor makes of the motion: of the rate and of its integral, SI."""
        sizes = [self._size(text, "a maneuver", "90 deg", (0, 1)) for text in self.maneuver]
        rate, integral = (sum(s for of, s, p in sizes if of == sensor and p == power) for power in (0, 1))
        return self.scale_factor * rate, self.scale_factor * integral
