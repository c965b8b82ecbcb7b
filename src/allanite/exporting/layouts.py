"""Forms of files: lines with comments above each field, and JSON."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from allanite.core.syntax import YAML, Syntax, json_text
from allanite.phrases.phrase import join, say

from .content import Content, Entry, number

JSON_COMMENT = r'(?s:"comment": \[.*?\n\s*\])'


def triple(values: Sequence[float]) -> str:
    """One number for each axis."""
    return ", ".join(map(number, spread(values)))


def diagonal(values: Sequence[float]) -> str:
    """The nine numbers of a 3 x 3 covariance, by rows."""
    x, y, z = map(number, spread(values))
    zero = number(0.0)
    return ", ".join((x, zero, zero, zero, y, zero, zero, zero, z))


def spread(values: Sequence[float]) -> tuple[float, float, float]:
    """The values of three axes, of three values or of one."""
    x, y, z = values if len(values) == 3 else (values[0],) * 3
    return x, y, z


@dataclass(frozen=True)
class LineLayout:
    """A file of lines."""

    line: str  # template of a field, with `name`, `value` (a single number), `triple` or `diagonal`
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
            forms = {"value": number(e.values[0]), "triple": triple(e.values), "diagonal": diagonal(e.values)}
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
            entries = content.of(section)
            values = {e.name: list(spread(e.values)) if self.each else e.values[0] for e in entries}
            sections[section] = {**values, **dict(self.extra)}
        if self.rate:
            sections[self.rate] = content.rate
        remarks = [f"{entry.section} {entry.name}: {told(entry)}" for entry in content.entries]
        whole = {self.root: sections} if self.root else sections
        return json_text({**whole, "comment": [*content.header, *remarks]}, indent=2) + "\n"
