"""A study as text for the terminal: units and numbers in ASCII, so that they can be copied into a command."""

import io
import textwrap
from collections.abc import Iterator
from typing import Literal, NamedTuple

from rich.console import Console
from rich.text import Text

from allanite.core.fit import Estimate, Fit
from allanite.study.analysis import Channel, Study
from allanite.study.survey import Survey

from . import words

STYLES = {"identified": "green", "weak": "yellow", "absent": "dim", "reported": "cyan"}
LABEL = 10
"""Columns of the header's labels."""


class Cell(NamedTuple):
    """A coefficient in one unit: value, interval and unit, or a phrase in place of the first two."""

    value: str
    interval: str
    unit: str
    phrase: str = ""


class Columns(NamedTuple):
    """Widths of a cell's parts."""

    value: int
    interval: int
    unit: int


def render(study: Study, *, width: int = 120, color: bool = False) -> str:
    """The study as text; see `allanite.reporting.table`."""
    return printed(_lines(study, width), width=width, color=color)


def printed(lines: Iterator[Text], *, width: int, color: bool) -> str:
    """Lines as a terminal of `width` columns wants them; with `color`, ANSI codes in them."""
    out = io.StringIO()
    system: Literal["standard"] | None = "standard" if color else None
    console = Console(file=out, width=width, force_terminal=color, color_system=system, markup=False, emoji=False)
    for line in lines:
        # lines are already as long as they should be: a number is never torn in two
        line.rstrip()
        console.print(line, soft_wrap=True, highlight=False)
    return out.getvalue()


def _lines(study: Study, width: int) -> Iterator[Text]:
    yield from header(study, f", method {study.recipe.method}", width)
    level, fits = study.recipe.level, [channel.fit for channel in study.channels if channel.fit]
    wide = all(_width(fit, level) <= width for fit in fits)
    for channel in study.channels:
        yield Text()
        yield from _channel(channel, level, width=width, wide=wide)
    for finding in study.shared.findings if study.shared else ():
        yield Text()
        yield from prose(str(finding), width, first="! ", indent=2, style="bold red")
    statuses = {estimate.status for fit in fits for estimate in fit} - {"identified"}
    notes = [f"{status}: {meaning}" for status, meaning in words.STATUS.items() if status in statuses]
    yield from [Text()] if notes else []
    for note in notes:
        yield from prose(note, width, style="dim", indent=2)


def header(value: Study | Survey, method: str, width: int) -> Iterator[Text]:
    """Where the numbers come from, before them."""
    made = value.provenance
    lines = [("file", made.get("source") or "(data in memory)")]
    lines += [("" if i else "assumed", note) for i, note in enumerate(value.notes)]
    lines += [("sha256", made["sha256"])] if made.get("sha256") else []
    lines += [("made by", f"allanite {made.get('allanite', '')}{method}")]
    for label, text in lines:
        yield from prose(text, width, first=f"{label:<{LABEL}}", indent=LABEL)


def prose(text: str, width: int, *, first: str = "", indent: int = 0, style: str = "") -> Iterator[Text]:
    """Wrapped text; lines after the first begin with `indent` blanks."""
    lines = textwrap.wrap(
        words.printable(text),
        max(width, 40),
        initial_indent=first,
        subsequent_indent=" " * indent,
        break_on_hyphens=False,
        break_long_words=False,
    )
    for line in lines:
        yield Text(line, style=style)


def _channel(channel: Channel, level: float, *, width: int, wide: bool) -> Iterator[Text]:
    name = words.printable(channel.record.name) or "channel"
    yield Text(name, style="bold") + Text(f"  {words.about(channel.record)}", style="not bold dim")
    for step in channel.record.history:
        yield from prose(step, width, first="  ", indent=2, style="dim")
    for alert in words.alerts(channel):
        yield from prose(alert, width, first="  ! ", indent=4, style="bold red")
    if channel.refusal:
        yield from prose(f"no result: {channel.refusal}", width, first="  ! ", indent=4, style="bold red")
    if channel.fit is None:
        yield from prose(words.fitness(channel), width, first="  ", indent=2)
        return
    for note in channel.fit.notes:
        yield from prose(note, width, first="  ", indent=2)
    if channel.verdict and channel.explained:
        yield from prose(channel.verdict, width, first="  ", indent=2, style="green")
    yield from _table(channel.fit, level, wide=wide)


def _table(fit: Fit, level: float, *, wide: bool) -> Iterator[Text]:
    """One line a term where both units fit side by side, else the SI value below the data-sheet value."""
    names, sheet, si = _cells(fit, level)
    first, left, right = max(map(len, names)), _columns(sheet), _columns(si)
    if not wide:
        left = right = Columns(*map(max, left, right))
    interval = f"{words.percent(level)} interval"
    titles = [
        _join(Cell("value", interval, "unit"), left),
        *([_join(Cell("SI", interval, "unit"), right), "status"] * wide),
    ]
    yield Text(f"  {'':<{first}}  {'  '.join(titles)}".rstrip(), style="dim")
    for e, name, cell, in_si in zip(fit, names, sheet, si, strict=True):
        row = Text(f"  {name:<{first}}  ") + Text(_join(cell, left), style="bold" if e.claimed else "not bold")
        status, second = Text(e.status, style=STYLES.get(e.status, "")), Text(_join(in_si, right), style="dim")
        if wide:
            yield row + Text("  ") + second + Text("  ") + status
        else:
            yield row
            same = in_si.unit == cell.unit  # the data sheet is in SI already
            yield Text("     ") + status + Text(" " * (first - 1 - len(e.status))) + (Text() if same else second)
        yield from (Text(f"     {shape}") for shape in words.shapes(e, level))


def _width(fit: Fit, level: float) -> int:
    """Length of a line that has both units side by side."""
    names, sheet, si = _cells(fit, level)
    return 2 + max(map(len, names)) + sum(_columns(sheet)) + sum(_columns(si)) + 7 * 2 + len("identified")


def _cells(fit: Fit, level: float) -> tuple[list[str], list[Cell], list[Cell]]:
    names = [f"{e.symbol}  {words.title(e.symbol, e.signal)}" for e in fit]
    sheet = [_cell(e, e.sheet_unit, level, "not identified") for e in fit]
    return names, sheet, [_cell(e, e.unit, level, "") for e in fit]


def _cell(estimate: Estimate, unit: str, level: float, absent: str) -> Cell:
    number, most = words.shown(estimate, unit, level), words.limit(estimate, unit)
    if number is not None:
        return Cell(*number.plain(), unit)
    limit = f"{words.below(estimate)} {most.plain()[0]}" if most else ""
    return Cell("", "", unit if most else "", ", ".join(filter(None, (absent, limit))))


def _columns(cells: list[Cell]) -> Columns:
    """Widths; the interval's grows where a phrase needs more than value and interval."""
    value = max(len("value"), *(len(c.value) for c in cells))
    interval = max(len("95 % interval"), *(len(c.interval) for c in cells), *(len(c.phrase) - value - 2 for c in cells))
    return Columns(value, interval, max(len("unit"), *(len(c.unit) for c in cells)))


def _join(cell: Cell, columns: Columns) -> str:
    value, interval, unit = columns
    both = f"{cell.value:>{value}}  {cell.interval:<{interval}}"
    return f"{cell.phrase.ljust(len(both)) if cell.phrase else both}  {cell.unit:<{unit}}"
