"""Sheets as text for the terminal, in ASCII where it has no other signs."""

import io
import re
import textwrap
from collections.abc import Iterable, Iterator
from contextvars import ContextVar
from typing import Literal

import numpy as np
from rich.cells import cell_len
from rich.console import Console, RenderableType
from rich.padding import Padding
from rich.text import Text

from allanite.core.estimate import STATUSES
from allanite.phrases.phrase import say

from .digits import in_ascii, printable, printed_heading, with_units
from .language import tr
from .sheet import Code, Column, Face, Note, Part, Table

STYLES = {"good": "green", "weak": "yellow", "alarm": "red", "quiet": "dim", "strong": "bold", "struck": "dim", "": ""}
NOTES = {"alert": "bold red", "warning": "bold red", "remark": "", "good": "green", "fair": "yellow", "note": "",
    "strong": "bold", "quiet": "dim"}  # fmt: skip
LABEL_COLUMNS = 10  # columns of the header's labels
_COLUMNS = 10_000  # columns of the console that tables are laid out in: a number is never torn in two

_IN_ASCII = ContextVar("_IN_ASCII", default=False)

_BROAD = "\u2e80-\u9fff\uf900-\ufaff\uff00-\uff60"
_CHUNK = re.compile(rf"\s+|[（「《【“]*[{_BROAD}][，。；：、！？）」》】”]*|[^\s{_BROAD}]+")


def pad(text: str, width: int, right: bool = False) -> str:
    """The text, filled with blanks to so many cells; `right`, it is at their end."""
    blanks = " " * (width - cell_len(text))
    return blanks + text if right else text + blanks


def wrapped(text: str, width: int, first: str, rest: str) -> list[str]:
    """Lines of at most `width` cells, which begin with `first` and `rest`; words longer than that are not torn."""
    if len(text) == cell_len(text):
        return textwrap.wrap(
            text, width, initial_indent=first, subsequent_indent=rest, break_on_hyphens=False, break_long_words=False
        )
    lines, line, empty = list[str](), first, True
    for chunk in _CHUNK.findall(text):
        if not empty and cell_len(line + chunk.rstrip()) > width:
            lines.append(line.rstrip())
            line, empty = rest, True
        if not (empty and chunk.isspace()):
            line, empty = line + (" " if chunk.isspace() else chunk), False
    return lines if empty else [*lines, line.rstrip()]


def render(face: Face, *, width: int = 120, color: bool = False, ascii: bool = False) -> str:  # noqa: A002 - as in repr
    """A result as text for a terminal of `width` columns; with `color`, ANSI codes in it, with `ascii`, no signs."""
    token = _IN_ASCII.set(ascii)
    try:
        return printed_lines(_lines(face, width), color=color)
    finally:
        _IN_ASCII.reset(token)


def text_of(parts: Iterable[Part], width: int) -> str:
    """Parts of a result as text."""
    return printed_lines(_parts(parts, width))


def printed_lines(lines: Iterable[RenderableType], *, color: bool = False) -> str:
    """Lines as text, with ANSI codes in `color`."""
    out = io.StringIO()
    system: Literal["standard"] | None = "standard" if color else None
    console = Console(file=out, width=_COLUMNS, force_terminal=color, color_system=system, markup=False, emoji=False)
    for item in lines:
        console.print(item, soft_wrap=isinstance(item, Text), highlight=False)
    return "".join(f"{line.rstrip()}\n" for line in out.getvalue().splitlines())


def _lines(face: Face, width: int) -> Iterator[RenderableType]:
    labels = [_plain(label) for label, _ in face.header]
    wide = max([LABEL_COLUMNS, *(cell_len(label) + 1 for label in labels)])
    for label, (_, text) in zip(labels, face.header, strict=True):
        yield from prose(text, width, first=pad(label, wide), indent=wide)
    yield from _parts(face.parts, width)
    for sheet in face.sheets:
        yield Text()
        first, *rest = sheet.about or ("",)
        name = Text(_plain(sheet.name or say("channel")), style="bold")
        yield name + Text(f"  {_plain(first)}" if first else "", style="not bold dim")
        for line in rest:
            yield from prose(line, width, first="  ", indent=2, style="dim")
        yield from _parts(sheet.parts, width)
    if face.close:
        yield Text()
    yield from _parts(face.close, width)


def _parts(parts: Iterable[Part], width: int) -> Iterator[RenderableType]:
    for part in parts:
        if part.where == "page":
            continue
        if isinstance(part, Note):
            first = "  ! " if part.level in ("alert", "warning") else "  "
            yield from prose(part.text, width, first=first, indent=4, style=NOTES[part.level])
            for point in part.points:
                yield from prose(point, width, first="    - ", indent=6)
        elif isinstance(part, Table) and part.rows:
            yield from _table(part, width)
        elif isinstance(part, Code):
            lines = ("", *filter(None, (part.title,)), *part.text.splitlines())
            yield from (Text(f"  {_plain(line)}") for line in lines)


def _plain(text: str) -> str:
    shown = printable(tr(text))
    return in_ascii(shown) if _IN_ASCII.get() else shown


def _heading(column: Column) -> str:
    return _plain(printed_heading(tr(column.heading)))


def _cell(column: Column, cell: str) -> str:
    return _plain(with_units(tr(cell), column.kind))


def prose(text: str, width: int, *, first: str = "", indent: int = 0, style: str = "") -> Iterator[Text]:
    """Wrapped text; lines after the first begin with `indent` blanks."""
    yield from (Text(line, style=style) for line in wrapped(_plain(text), max(width, 40), first, " " * indent))


def _table(table: Table, width: int) -> Iterator[RenderableType]:
    from rich.table import Table as Grid

    if table.title:
        yield Text()
        yield Text(f"  {_plain(table.title)}", style="dim")
    kept = spread(len(table.rows), table.most)
    for which in _blocks(table, width):
        grid = Grid(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="dim")
        for column in (table.columns[i] for i in which):
            justify: Literal["left", "right"] = "right" if column.kind == "number" else "left"
            grid.add_column(Text(_heading(column)), justify=justify, no_wrap=True)
        for i in kept:
            mark, cells = table.mark(i), []
            for column, cell in ((table.columns[j], table.rows[i][j]) for j in which):
                shown = _cell(column, cell)
                shown = f"({shown})" if mark == "struck" and column.kind == "number" and cell else shown
                status = STATUSES.get(cell) if column.kind == "status" else None
                cells.append(Text(shown, style=status.color if status else ""))
            grid.add_row(*cells, style=STYLES[mark])
        yield Padding(grid, (0, 0, 0, 2))
    if len(kept) < len(table.rows):
        omitted = say("{shown} of {total} rows; --csv writes all", shown=len(kept), total=len(table.rows))
        yield Text(f"  {_plain(omitted)}", style="dim")


def _blocks(table: Table, width: int) -> list[list[int]]:
    """Columns that stand side by side: all, or the main ones and below them those aside."""
    every = list(range(len(table.columns)))
    aside = [i for i in every if table.columns[i].aside]
    widths = [max(cell_len(text) for text in (_heading(column), *(_cell(column, row[i]) for row in table.rows)))
        for i, column in enumerate(table.columns)]  # fmt: skip
    if not aside or 2 * len(every) + sum(widths) <= width:
        return [every]
    return [[i for i in every if i not in aside], [0, *aside]]


def spread(count: int, most: int) -> list[int]:
    """Indices of every so many of the items, and of the last one; of very many by ratio."""
    if count > 1000:
        return (np.unique(np.rint(np.geomspace(1, count, most))).astype(np.int64) - 1).tolist()  # type: ignore[no-any-return]
    step = max(-(-(count - 1) // max(most - 1, 1)), 1)
    return sorted({*range(0, count, step), count - 1})
