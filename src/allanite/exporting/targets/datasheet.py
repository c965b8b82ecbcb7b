"""Data sheet: the quantities and units of data sheets, for Markdown, CSV and LaTeX."""

import csv
import io
from collections.abc import Iterator

from allanite.core.datasheet import data_sheet
from allanite.core.syntax import CSV, LATEX, MARKDOWN, Syntax
from allanite.exporting.content import Content
from allanite.exporting.target import Target
from allanite.phrases.phrase import say

HEADINGS = ("channel", "quantity", "value", "low", "high", "unit", "tau, s", "remark")


def rows(content: Content) -> Iterator[tuple[str, ...]]:
    """The cells of the table; of a term that was not identified only the upper limit."""
    for axis in content.axes:
        for entry in data_sheet(axis.fit, axis.readings, axis.rate or 0.0, axis.level):
            numbers = (entry.value, entry.low, entry.high)
            tau = "" if entry.tau is None else f"{entry.tau:.4g}"
            cells = ("" if v is None else f"{v:.6g}" for v in numbers)
            yield (axis.label, entry.quantity, *cells, entry.unit, tau, entry.remark)


def markdown(content: Content) -> str:
    """A table with the comments below it."""
    head, *cells = _cells(content, MARKDOWN)
    table = [f"| {' | '.join(line)} |" for line in (head, ("---",) * len(head), *cells)]
    return "\n".join([*table, "", *(f"- {MARKDOWN.cell(line.strip())}" for line in content.header)]) + "\n"


def comma_separated(content: Content) -> str:
    """Comments, headings and rows."""
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows(_cells(content, CSV))
    return "".join(f"{part}\n" for line in content.header for part in CSV.comments(line)) + out.getvalue()


def latex(content: Content) -> str:
    """A tabular."""
    head, *cells = (" & ".join(row) + r" \\" for row in _cells(content, LATEX))
    comments = [part for line in content.header for part in LATEX.comments(line)]
    return "\n".join([*comments, r"\begin{tabular}{llrrrlrl}", rf"{head} \hline", *cells, r"\end{tabular}"]) + "\n"


def _cells(content: Content, syntax: Syntax) -> list[list[str]]:
    return [list(map(syntax.cell, row)) for row in (HEADINGS, *rows(content))]


DATASHEET = Target(
    name="datasheet",
    synonyms=("table",),
    title=say("table of the quantities that data sheets quote, each with its interval"),
    fields=(),
    forms={".md": markdown, ".csv": comma_separated, ".tex": latex},
    source="the page Reading a data sheet",
    notes=(say("of a term that was not identified, high is the 95 % upper limit"),),
    inflatable=False,
)
