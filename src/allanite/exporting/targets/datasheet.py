"""Data sheet: the quantities and units of data sheets, for Markdown, CSV and LaTeX."""

import csv
import io
from collections.abc import Iterator

from allanite.core.datasheet import data_sheet
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
    lines = [HEADINGS, ("---",) * len(HEADINGS), *rows(content)]
    table = [f"| {' | '.join(cell.replace('|', '/') for cell in line)} |" for line in lines]
    return "\n".join([*table, "", *(f"- {line}" for line in content.header)]) + "\n"


def comma_separated(content: Content) -> str:
    """Comments, headings and rows."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(HEADINGS)
    writer.writerows(rows(content))
    return "".join(f"# {line}\n" for line in content.header) + out.getvalue()


def latex(content: Content) -> str:
    """A tabular."""
    lines = [f"% {line}" for line in content.header]
    lines += [r"\begin{tabular}{llrrrlrl}", " & ".join(map(_escaped, HEADINGS)) + r" \\ \hline"]
    lines += [" & ".join(map(_escaped, row)) + r" \\" for row in rows(content)]
    return "\n".join([*lines, r"\end{tabular}"]) + "\n"


SIGNS = {sign: f"\\{sign}" for sign in "&%$#_{}"} | {"^": r"\textasciicircum{}", "\\": r"\textbackslash{}"}


def _escaped(text: str) -> str:
    return "".join(SIGNS.get(sign, sign) for sign in text)


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
