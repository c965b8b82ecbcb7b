"""Sheets: the neutral form of every result, which the terminal, the page and the notebook render."""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, Protocol

from allanite.core.names import sources_of
from allanite.phrases.phrase import join, say

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .first import First
    from .sketch.chart import Chart
    from .style import NewFigure

Kind = Literal["name", "symbol", "number", "interval", "unit", "text", "status", "formula"]
Mark = Literal["", "good", "weak", "alarm", "quiet", "strong", "struck"]
Where = Literal["", "page", "text"]  # where a part is shown: everywhere, on the page only, in the terminal only
Form = str | Callable[[Any], str]  # how the numbers of a column are written: a format such as ".4g", or a function


@dataclass(frozen=True)
class Column:
    """Heading, kind and form of a column; `aside` columns follow below the others where a terminal is narrow."""

    heading: str
    kind: Kind = "number"
    aside: bool = False
    form: Form = ""

    def cell(self, value: Any) -> str:
        """A value as it stands in the column: text as it is, and nothing where there is no value."""
        if isinstance(value, str):
            return value
        if callable(self.form):
            return self.form(value)
        return "" if value is None else format(value, self.form)


@dataclass(frozen=True)
class Table:
    """Cells in plain ASCII, as they can be copied into a command."""

    columns: Sequence[Column]
    rows: Sequence[Sequence[Any]]  # the cells; numbers are written by the forms of the columns
    title: str = ""
    marks: Sequence[Mark] = ()
    key: str = ""  # what the columns mean; stands below the table on the page
    details: bool = False  # whether the page folds the table away
    most: int = 28  # rows that a terminal shows at most, spread evenly over all
    where: Where = ""

    def __post_init__(self) -> None:
        rows = [[column.cell(value) for column, value in zip(self.columns, row, strict=True)] for row in self.rows]
        object.__setattr__(self, "rows", rows)

    def only(self, kept: Sequence[int]) -> "Table":
        """The table of some of its columns."""
        rows = [[row[i] for i in kept] for row in self.rows]
        return replace(self, columns=[self.columns[i] for i in kept], rows=rows)

    def mark(self, row: int) -> Mark:
        """The mark of a row."""
        return self.marks[row] if self.marks else ""


@dataclass(frozen=True)
class Note:
    """A sentence, with `points` below it, a line each."""

    text: str
    # by an alert a number is wrong or missing, a warning affects the numbers, a remark does not; quiet is small print
    level: Literal["alert", "warning", "remark", "good", "fair", "note", "strong", "quiet"] = "note"
    where: Where = ""
    points: Sequence[str] = ()  # on a page also the warnings and remarks that follow


class Plot(Protocol):
    """A figure that is yet to be drawn."""

    @property
    def draw(self) -> "Callable[[NewFigure], Figure]":
        """Draws it on what is given: for print, by `printing.printed`."""

    def sketched(self, room: float = math.inf) -> "Chart":
        """It for a page, by `sketch`."""


@dataclass(frozen=True)
class Picture:
    """A figure as SVG, before the page around it is known: `wide` points; the same for narrow screens."""

    text: str
    wide: float
    narrow: "Picture | None" = None


@dataclass(frozen=True)
class Drawing:
    """A figure that is drawn only where it is shown."""

    draw: Callable[[], Plot | Picture]
    label: str
    caption: str = ""
    title: str = ""
    where: Where = "page"


@dataclass(frozen=True)
class Code:
    """Lines that can be copied into a program."""

    text: str
    title: str = ""
    where: Where = ""


class Deferred(Sequence["Part"]):
    """Parts that are made where they are shown, once."""

    def __init__(self, make: "Callable[[], Iterable[Part]]") -> None:
        self.make = make

    @cached_property
    def parts(self) -> "tuple[Part, ...]":
        """The parts."""
        return tuple(self.make())

    def __getitem__(self, at: Any) -> Any:
        return self.parts[at]

    def __len__(self) -> int:
        return len(self.parts)


@dataclass(frozen=True)
class Fold:
    """Parts of a page that can be folded away; `shut`: they are until somebody opens them."""

    title: str
    parts: "Sequence[Part]"
    shut: bool = False
    where: Where = "page"


Part = Table | Note | Drawing | Code | Fold


def on_page(parts: "Iterable[Part]") -> "Iterator[Part]":
    """Those that are on a page; warnings and remarks in a row are points of one note, below the grade."""
    box: Note | None = None
    for part in (part for part in parts if part.where != "text"):
        if isinstance(part, Note) and part.level in ("warning", "remark"):
            box = box or Note("", "fair" if part.level == "warning" else "note")
            box = replace(box, points=(*box.points, part.text))
            continue
        if box is not None:
            yield box
        box = part if isinstance(part, Note) and part.level in ("good", "fair", "alert") else None
        if box is None:
            yield part
    if box is not None:
        yield box


@dataclass(frozen=True)
class Sheet:
    """The results of one channel."""

    name: str
    about: Sequence[str] = ()
    parts: Sequence[Part] = ()
    verdicts: Sequence[str] = ()  # at the top of the page, with the name before them
    level: str = ""  # how verdicts are marked: "alert", "fair"


@dataclass(frozen=True)
class Face:
    """A whole result."""

    # title, brand: of the page
    title: str
    brand: str
    sheets: Sequence[Sheet] = ()
    header: Sequence[tuple[str, str]] = ()  # where the numbers come from: the first lines of the terminal
    parts: Sequence[Part] = ()  # before the sheets
    close: Sequence[Part] = ()  # after the sheets
    how: Sequence[Part] = ()  # how the result was computed, for the page
    choices: str = ""  # the recipe that was really used, as TOML
    provenance: dict[str, str] = field(default_factory=dict)
    notes: Sequence[str] = ()  # what was assumed when reading
    # what the user says of the device: serial number, operator, date, temperature
    device: dict[str, str] = field(default_factory=dict)
    facts: Sequence[str] = ()  # sensor, sampling rate, length: one line below the title of the page
    command: str = ""  # the command line that made the page; empty if none did
    data: bytes = b""  # the whole result as JSON, compressed
    summary: "First | None" = None  # the first screen, whose tables begin the page


def one_sheet(
    title: str, brand: str, name: str, parts: Iterable[Part], *, about: Sequence[str] = (), **rest: Any
) -> Face:
    """A face of one sheet called `name`; `rest` are further fields of the face."""
    return Face(title, brand, (Sheet(name, about, tuple(parts)),), **rest)


def known(form: str, otherwise: str = "", unit: str = "") -> Callable[[float | None], str]:
    """The form of numbers that need not be known: where one is missing or not finite stands `otherwise`."""
    return lambda value: otherwise if value is None or not math.isfinite(value) else f"{value:{form}}{unit}"


def header_of(provenance: dict[str, str], notes: Iterable[str], method: str = "") -> list[tuple[str, str]]:
    """The first lines of a result: its file, what was assumed, its digest, what made it."""
    files = sources_of(provenance) or [say("(data in memory)")]
    lines: list[tuple[str, str]] = [("" if i else say("file"), file) for i, file in enumerate(files)]
    lines += [("" if i else say("assumed"), note) for i, note in enumerate(notes)]
    lines += [("sha256", provenance["sha256"])] if provenance.get("sha256") else []
    return [*lines, (say("made by"), join("", [f"allanite {provenance.get('allanite', '')}", method]))]
