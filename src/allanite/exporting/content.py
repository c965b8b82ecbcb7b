"""Content: what a file says, and the noise of the axes that it is made of; forms: lines with comments, and JSON."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import isclose
from typing import Any

from allanite.core.curve import Curve
from allanite.core.estimate import Estimate
from allanite.core.fit import Fit
from allanite.core.plain import Value
from allanite.core.readings import Readings
from allanite.core.syntax import YAML, Syntax, json_text
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
        factor = self.values[0] / self.identified[0] if self.identified and self.identified[0] else 1.0
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


JSON_COMMENT = r'(?s:"comment": \[.*?\n\s*\])'


def spread(values: Sequence[float]) -> tuple[float, float, float]:
    """The values of three axes, of three values or of one."""
    x, y, z = values if len(values) == 3 else (values[0],) * 3
    return x, y, z


@dataclass(frozen=True)
class LineLayout:
    """A file of lines."""

    # template of a field, with `name`, `value` (a single number), `triple` or `diagonal` (a 3 x 3 covariance, by rows)
    line: str
    syntax: Syntax = YAML  # of its comments
    first: tuple[str, ...] = ()  # what must stand before any comment
    # start, end: LineLayout around the fields, templates with `rate`
    start: tuple[str, ...] = ()
    end: tuple[str, ...] = ()
    alone: tuple[str, ...] = ()  # fields with one number where the others have a list of three

    def __call__(self, content: Content) -> str:
        """The file."""
        rate = "" if content.rate is None else number(content.rate)
        lines = [*self.first, *(part for line in content.header for part in self.syntax.comments(line))]
        lines += [line.replace("{rate}", rate) for line in self.start]
        indent = self.line[: len(self.line) - len(self.line.lstrip())]
        for e in content.entries:
            line = self.line.replace("[{triple}]", "{value}") if e.name in self.alone else self.line
            x, y, z = map(number, spread(e.values))
            diagonal = ", ".join((x, *["0.0"] * 3, y, *["0.0"] * 3, z))
            forms = {"value": number(e.values[0]), "triple": f"{x}, {y}, {z}", "diagonal": diagonal}
            lines += [indent + part for part in self.syntax.comments(told(e))]
            lines.append(line.format(name=e.name, **forms))
        return "\n".join([*lines, *(line.replace("{rate}", rate) for line in self.end)]) + "\n"


def told(entry: Entry) -> str:
    """The comment on a field: its unit, formula, channel, identified value, and interval or cover."""
    names = ", ".join(dict.fromkeys(entry.channels))
    identified = ", ".join(f"{value:.4g}" for value in entry.identified) if entry.factor else ""
    larger = say("identified {value}, x{factor:.3g}", value=identified, factor=entry.factor) if identified else ""
    remark = join(" ", filter(None, (larger, entry.remark)))
    return f"{entry.unit}, {entry.formula}{f' of {names}' if names else ''}: {remark}"


@dataclass(frozen=True)
class JsonLayout:
    """A JSON file: an object for each section, with `extra` keys, within `root`; comments are its last key."""

    root: str = ""
    extra: tuple[tuple[str, str], ...] = ()
    rate: str = ""
    each: bool = False

    def __call__(self, content: Content) -> str:
        """The file."""
        sections: dict[str, Any] = {}
        for section in dict.fromkeys(entry.section for entry in content.entries):
            values = {e.name: list(spread(e.values)) if self.each else e.values[0] for e in content.of(section)}
            sections[section] = {**values, **dict(self.extra)}
        if self.rate:
            sections[self.rate] = content.rate
        remarks = [f"{entry.section} {entry.name}: {told(entry)}" for entry in content.entries]
        whole = {self.root: sections} if self.root else sections
        return json_text({**whole, "comment": [*content.header, *remarks]}, indent=2) + "\n"
