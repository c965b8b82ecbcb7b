"""A comparison or a pool as text for the terminal."""

from collections.abc import Iterator

import numpy as np
from rich.text import Text

from allanite.comparison.change import OUTCOMES
from allanite.comparison.comparison import Comparison
from allanite.reporting.sheet import printable
from allanite.reporting.text import LABEL, printed, prose

from .sheets import Sheet, Table, Value, sheets

STYLES = {"smaller": "green", "larger": "red", "no change": "", "not resolvable": "dim", "": ""}

MOST_ROWS = 28
"""Rows of a table that are printed."""


def render(value: Value, *, width: int = 120, color: bool = False) -> str:
    """The result as text; see `allanite.reporting.table`."""
    return printed(_lines(value, width), width=width, color=color)


def _lines(value: Value, width: int) -> Iterator[Text]:
    made = value.provenance or {}
    lines = [("compared" if i == 0 else "with", name) for i, name in enumerate(value.names)]
    lines += [("" if i else "assumed", note) for i, note in enumerate(value.notes)]
    lines += [("made by", f"allanite {made['allanite']}")] if "allanite" in made else []
    for label, text in lines:
        yield from prose(text, width, first=f"{label:<{LABEL}}", indent=LABEL)
    for sheet in sheets(value):
        yield Text()
        yield from _sheet(sheet, width)
    if isinstance(value, Comparison):
        yield Text()
        met = {change.outcome for change in value.terms}
        for outcome in (word for word in OUTCOMES if word in met):
            yield from prose(f"{outcome}: {OUTCOMES[outcome]}", width, style="dim", indent=2)


def _sheet(sheet: Sheet, width: int) -> Iterator[Text]:
    yield Text(printable(sheet.name) or "channel", style="bold")
    for line in sheet.about:
        yield from prose(line, width, first="  ", indent=4, style="dim")
    for alert in sheet.alerts:
        yield from prose(alert, width, first="  ! ", indent=4, style="bold red")
    style = "bold red" if sheet.refusal else "bold"
    yield from prose(sheet.verdict, width, first="  ! " if sheet.refusal else "  ", indent=4, style=style)
    for table in sheet.tables:
        yield Text()
        yield from _table(table)


def _table(table: Table) -> Iterator[Text]:
    widths = [max(map(len, column)) for column in zip(table.headings, *table.rows, strict=True)]
    yield Text(f"  {table.title}", style="dim")
    yield Text(_line(table.headings, widths, table.left), style="dim")
    kept = [round(i) for i in np.linspace(0, len(table.rows) - 1, min(MOST_ROWS, len(table.rows)))]
    for i in kept:
        yield Text(_line([printable(c) for c in table.rows[i]], widths, table.left), style=STYLES[table.marks[i]])
    if len(kept) < len(table.rows):
        yield Text(f"  {len(kept)} of {len(table.rows)} rows; --csv writes all", style="dim")


def _line(cells: list[str], widths: list[int], left: int) -> str:
    shown = [c.ljust(w) if i < left else c.rjust(w) for i, (c, w) in enumerate(zip(cells, widths, strict=True))]
    return ("  " + "  ".join(shown)).rstrip()
