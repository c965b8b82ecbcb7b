"""The first screen of a result: the answer, what limits it, how the file was read, and what next."""

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import count
from typing import TypeGuard

from allanite.core.validity import Finding
from allanite.phrases.phrase import Phrase, join, say

from .digits import digits, printed_unit
from .sheet import Code, Column, Face, Note, Part, Table

_OPTION = re.compile(r"(?:\(|: )(--[a-z][^);]*)")

MAX_NAMES_LENGTH = 32  # characters that the names of channels may take in a remark

DETAILS, FIGURES = ("--details", say("all numbers")), ("--report page.html", say("figures"))
"""What next, after any result."""

ABOVE = Note(say("no result: see above"), "alert")
"""Stands in the sheet of a channel whose refusal stands with those of the others."""

PLUS_MINUS = r"±|\+-"  # what finds this sign in a line of text


@dataclass(frozen=True)
class Remark:
    """A line of what limits an answer; a narrow screen leaves out clauses at the end, never the command."""

    about: str  # the channels
    clauses: Sequence[str]
    command: str = ""  # what helps
    grave: bool = False
    name: str = ""  # that of a finding

    @classmethod
    def of(cls, about: str, text: str, *more: str, grave: bool = False, name: str = "") -> "Remark":
        """A remark with the first option that its text names in brackets as its command."""
        option = _OPTION.search("; ".join((text, *more)))
        return cls(about, (text, *filter(None, more)), option[1] if option else "", grave, name)

    @classmethod
    def about_finding(cls, about: str, finding: Finding, *, grave: bool = False) -> "Remark":
        """What was found in the data."""
        return cls.of(about, finding.what, finding.consequence, finding.remedy, grave=grave, name=finding.name)


@dataclass(frozen=True)
class ChannelRow:
    """A row of a table of channels, with a cell for each."""

    title: str
    symbol: str
    unit: str
    cells: Sequence[str]
    rank: int = 0  # how soon it is left out where there is too little room: 0 never
    short: str = ""  # its name where there is none for symbols
    narrow: Sequence[str] = ()  # its cells where there is less room, in a row for each channel
    marks: Sequence[str] = ()  # of each cell on a page: the status of a coefficient, the level of a verdict

    @property
    def label(self) -> str:
        """What it is called in the fewest letters."""
        return self.symbol or self.short or self.title


@dataclass(frozen=True)
class Channels:
    """Quantities by channel: channels side by side, or below each other if there are many."""

    names: Sequence[str]
    rows: Sequence[ChannelRow]
    sensor: str = ""
    whole: bool = False  # titles are left out where there is too little room, not cut

    @classmethod
    def of(cls, names: Sequence[str], cells: Iterable[tuple[str, str, str, str]], sensor: str = "") -> "Channels":
        """Those of cells, each with its channel, quantity and unit before it."""
        rows: dict[tuple[str, str], dict[str, str]] = {}
        for name, title, unit, cell in cells:
            rows.setdefault((title, unit), {})[name] = cell
        shown = [ChannelRow(t, "", unit, [row.get(name, "") for name in names]) for (t, unit), row in rows.items()]
        return cls(names, shown, sensor)

    def table(self, *, titles: bool = True) -> Table:
        """The channels side by side, with or without the titles of the quantities."""
        leads = [[row.symbol, row.title] if titles else [row.label] for row in self.rows]
        if titles and not any(row.symbol for row in self.rows):
            leads = [lead[1:] for lead in leads]
        blank = [Column("", "name")] * len(leads[0])
        heads = [
            *blank[1:], Column(self.sensor, "name"), Column("", "name"), *(Column(name, "name") for name in self.names),
        ]  # fmt: skip
        rows = [[*lead, printed_unit(row.unit), *row.cells] for lead, row in zip(leads, self.rows, strict=True)]
        return Table(heads, rows)

    def only(self, part: slice) -> "Channels":
        """Those of some channels."""
        rows = [replace(row, cells=row.cells[part], narrow=row.narrow[part]) for row in self.rows]
        return replace(self, names=self.names[part], rows=rows)

    def listed(self, *, narrow: bool = False) -> Table:
        """A row for each channel; where that is too wide, without what is no coefficient and no grade."""
        units = [join(" ", filter(None, (row.label, printed_unit(row.unit)))) for row in self.rows]
        read = [bool(row.unit) and not row.symbol for row in self.rows]
        columns = (Column(unit, "name", aside) for unit, aside in zip(units, read, strict=True))
        heads = [Column(say("channel"), "name"), *columns]
        cells = [row.narrow if narrow and row.narrow else row.cells for row in self.rows]
        return Table(heads, [[name, *(cell[i] for cell in cells)] for i, name in enumerate(self.names)])

    def lines(self) -> list[Phrase]:
        """A line for each channel."""
        heads = [join(" ", filter(None, (row.label, printed_unit(row.unit)))) for row in self.rows]
        shown = [(head, row.cells) for head, row in zip(heads, self.rows, strict=True) if row.rank < 2]
        return [
            join("  ", (name, *(join(": ", (head, cells[i])) for head, cells in shown if cells[i])))
            for i, name in enumerate(self.names)
        ]


@dataclass(frozen=True)
class Section:
    """A part of an answer that shares the room with others: its name, sentences, and the beginning of its tables."""

    name: str
    sentences: Sequence[str] = ()
    tables: Sequence[Table] = ()


Answer = Channels | Section | Table | str


@dataclass(frozen=True)
class First:
    """The first screen."""

    # title, verdict: what it is about, and the answer in a few words: the first line
    title: str
    verdict: str = ""
    answer: Sequence[Answer] = ()
    remarks: Sequence[Remark] = ()  # one line each, the most important first; what does not fit is counted
    # a regular expression that finds the sign in the lines of the answer, in any language and in ASCII; an empty one
    # for what is always told
    legend: Sequence[tuple[str, str]] = ()
    read: Sequence[str] = ()  # how the file was read, the most important first
    after: Sequence[tuple[str, str]] = (DETAILS,)  # what next

    @property
    def tables(self) -> "list[Channels]":
        """The tables of channels in the answer."""
        return [part for part in self.answer if isinstance(part, Channels)]

    def key(self, lines: Iterable[str]) -> list[str]:
        """What the signs in these lines mean."""
        shown = list(lines)
        return [meaning for sign, meaning in self.legend if any(re.search(sign, line) for line in shown)]

    @property
    def signs(self) -> Phrase:
        """What the signs in its tables mean."""
        return join(" ", self.key(cell for table in self.tables for row in table.rows for cell in row.cells))

    def brief(self) -> list[str]:
        """A line for each channel, or for each row of the answer."""
        lines: list[str] = []
        for part in self.answer:
            if isinstance(part, Channels):
                lines += part.lines()
            elif isinstance(part, Table):
                lines += [join("  ", filter(None, row)) for row in part.rows]
            elif isinstance(part, Section):
                rows = [join("  ", filter(None, row)) for table in part.tables[:1] for row in table.rows]
                lines += [join("  ", filter(None, (part.name, text))) for text in (part.sentences[:1] or rows)]
            else:
                lines.append(part)
        return [*(lines or [self.title]), *(shown(remark) for remark in self.remarks if remark.grave)]


def condensed(face: Face, *, drawn: bool = False) -> First:
    """The first screen of a result that is shown as sheets: sentences and the first table of each, warnings."""
    after = [DETAILS, *([FIGURES] if drawn else [])]
    sections = [_section("", face.parts)] if any(map(_told, face.parts)) else []
    verdicts = [text for sheet in face.sheets for text in sheet.verdicts]
    if sections and not sections[0].sentences and verdicts:  # tables of all, and below what follows from them
        sections[0] = replace(sections[0], sentences=verdicts)
    alone = len(face.sheets) == 1
    sheets = [("" if alone and isinstance(sheet.name, Phrase) else sheet.name, sheet.parts) for sheet in face.sheets]
    own = [_section(name, parts) for name, parts in sheets]
    sections += [section for section in own if section.sentences or section.tables]
    notes = [(name, part) for name, parts in [("", face.parts), *sheets, ("", face.close)] for part in parts]
    alerts = merged(Remark.of(name, part.text, grave=part.level == "alert") for name, part in notes if _warns(part))
    assumed = face.notes or [text for label, text in face.header if label == "assumed"]
    remarks = sorted(alerts, key=lambda remark: not remark.grave)
    return First(face.title, answer=sections, remarks=remarks, read=list(assumed), after=after)


def _section(name: str, parts: Iterable[Part]) -> Section:
    told = [part for part in parts if _told(part)]
    notes = [part for part in told if isinstance(part, Note)]
    tables = sorted((part for part in told if isinstance(part, Table)), key=lambda table: table.details)
    strong = [part for part in notes if part.level == "strong"] or [part for part in notes if part.where == "text"]
    strong = strong or notes[: not tables]
    codes = [line for part in told if isinstance(part, Code) and not tables for line in part.text.splitlines() if line]
    sentences = [text for note in strong for text in (note.text, *note.points)]
    return Section(name, [*sentences, *codes], tables[:1])


def _told(part: Part) -> bool:
    """Whether a part is an answer, and not a warning, a grade of the noise or small print."""
    shown = isinstance(part, (Table, Code)) or (isinstance(part, Note) and part.level in ("note", "strong"))
    return shown and part.where != "page"


def _warns(part: Part) -> TypeGuard[Note]:
    return isinstance(part, Note) and part.level in ("alert", "warning") and part.where != "page" and part != ABOVE


def shown(remark: Remark) -> Phrase:
    """A remark as text."""
    text: Phrase = join("; ", remark.clauses)
    if remark.about:
        text = say("{channel}: {warning}", channel=remark.about, warning=text)
    return say("{what}. Try {command}", what=text, command=remark.command) if remark.command else text


def kinds(remarks: Iterable[Remark]) -> list[list[Remark]]:
    """Remarks of one finding, or of the same words but for numbers, together; not two of one channel that differ."""
    alike: dict[tuple[object, ...], list[Remark]] = {}
    for remark in remarks:
        words = getattr(remark.clauses[0], "templates", remark.clauses[0])  # of a stored result, the text
        kind = (remark.name or words, remark.command, remark.grave)
        # those of one channel that differ in their words stand apart
        text = str(remark.clauses[0])
        same = next(n for n in count() if not any(other.about == remark.about and str(other.clauses[0]) != text
                                                  for other in alike.get((*kind, n), ())))  # fmt: skip
        alike.setdefault((*kind, same), []).append(remark)
    return list(alike.values())


def merged(remarks: Iterable[Remark], every: int = 0) -> list[Remark]:
    """Remarks, of which those of one kind are one, about all their channels."""
    groups = ((alike[0], [(r.about, str(r.clauses[0])) for r in alike]) for alike in kinds(remarks))
    return [replace(first, about=channels_named(places, every)) for first, places in groups]


def told_of(notes: Iterable[tuple[str, Finding]], every: int) -> list[Remark]:
    """Findings of several channels, one of each kind, with the names of all channels that have it."""
    return merged((Remark.about_finding(name, finding) for name, finding in notes), every)


def channels_named(places: Sequence[tuple[str, str]], every: int) -> str:
    """The channels that a remark is about: all with the same one, or the first and others with one of its kind."""
    names = list(dict.fromkeys(name for name, _ in places))
    if len({what for _, what in places}) == 1:
        return say("all channels") if len(names) == every > 1 else listed(names)
    return say("{channel} (also {others})", channel=names[0], others=listed(names[1:])) if names[1:] else names[0]


def listed(names: Sequence[str]) -> str:
    """The names, or where they are long the first and how many more."""
    every = ", ".join(names)
    if len(every) <= MAX_NAMES_LENGTH or len(names) == 1:
        return every
    return say("{names} and {count} more", names=names[0], count=len(names) - 1)


def plus_minus(value: float, low: float, high: float, *, signed: bool = False) -> str:
    """A value and the half width of its interval as a share of it: ``0.119 ± 1 %``."""
    number = digits(value, low, high, signed=signed).plain()[0]
    half = 50 * (high - low) / abs(value) if value else float("nan")
    return f"{number} ± {half:.2g} %" if math.isfinite(half) else number
