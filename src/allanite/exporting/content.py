"""Content: what a file says, before it has a form, and the noise of the axes that it is made of."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import isclose

from allanite.core.curve import Curve
from allanite.core.estimate import Estimate
from allanite.core.fit import Fit
from allanite.core.plain import Value
from allanite.core.readings import Readings
from allanite.phrases.phrase import join, say


@dataclass(frozen=True, eq=False)
class Axis:
    """The noise of one axis."""

    name: str  # name of the channel; empty for a given model
    fit: Fit
    rate: float | None = None  # sampling rate, Hz
    doubt: str = ""  # why the coefficients are not to be used; empty if the model explains the record
    readings: Readings | None = None
    level: float = 0.95  # confidence level of the intervals
    alerts: tuple[str, ...] = ()
    curve: Curve | None = None  # the measured Allan deviation, with intervals
    source: Mapping[str, str] = field(default_factory=dict)  # name and digest of its file

    @property
    def sensor(self) -> str:
        """Type of sensor."""
        return self.fit.signal.name

    @property
    def label(self) -> str:
        """Its name, also of a given model."""
        return self.name or (say("given gyro") if self.sensor == "gyro" else say("given accelerometer"))

    def estimate(self, symbol: str) -> Estimate | None:
        """The estimate of a term; None if it was not looked for."""
        return next((e for e in self.fit if e.symbol == symbol), None)


def by_sensor(axes: Sequence[Axis]) -> dict[str, list[Axis]]:
    """The axes of each sensor."""
    return {sensor: [a for a in axes if a.sensor == sensor] for sensor in dict.fromkeys(a.sensor for a in axes)}


@dataclass(frozen=True, repr=False)
class Entry(Value):
    """A field with its value."""

    # name, sensor, section, unit, formula: as in the row of the target
    name: str
    sensor: str
    section: str
    unit: str
    formula: str
    values: tuple[float, ...]  # one value, or one for each axis, in `unit`
    channels: tuple[str, ...]  # the channel whose coefficient each value is
    remark: str  # interval, or why the value is a limit; stands in the file
    measured: bool = True  # whether every value comes from an identified coefficient, not from a limit
    covers: bool = False  # whether the value is that of a model that covers what was identified
    # the same without cover, inflation and limits of the target; empty if there is none
    identified: tuple[float, ...] = ()

    @property
    def full(self) -> str:
        """Its name with that of its section."""
        return f"{self.section}.{self.name}".strip(".")

    @property
    def factor(self) -> float | None:
        """By how much the written value is larger than the identified one; None if it is the same."""
        factor = self.values[0] / self.identified[0] if self.identified else 1.0
        return None if isclose(factor, 1.0, rel_tol=1e-6) else factor

    @property
    def why(self) -> str:
        """In a few words why the value is not the identified one; empty where it is."""
        reason = say("cover") if self.covers else "" if self.measured else say("upper limit")
        return join(", ", filter(None, (f"×{self.factor:.3g}" if self.factor else "", reason)))

    def _summary(self) -> str:
        return f"{self.full} = {', '.join(map(number, self.values))} {self.unit}"


@dataclass(frozen=True, eq=False)
class Content:
    """What a file says: comments, fields (inflated already), and the axes for targets that take whole models."""

    header: tuple[str, ...]
    entries: tuple[Entry, ...]
    axes: tuple[Axis, ...]
    rate: float | None
    inflate: float = 1.0

    def of(self, section: str) -> list[Entry]:
        """The fields of one section."""
        return [entry for entry in self.entries if entry.section == section]


def number(value: float) -> str:
    """A number with all its digits and a point, without which YAML reads 1e-05 as text and ROS an integer."""
    text = repr(float(value))
    mantissa, exponent, power = text.partition("e")
    return text if "." in mantissa or not exponent else f"{mantissa}.0e{power}"
