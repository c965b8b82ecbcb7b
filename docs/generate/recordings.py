"""The table of public recordings in two parts: grades and ratios, and below them what the fit found in each file."""

import re
from collections.abc import Iterator
from pathlib import Path

from generate.markdown import table, table_of

FIGURES = {
    "file": "file", "channel": "channel", "grade": "grade",
    "N over deviation at 1 s": "N", "0.664 B over least upper limit": "0.664 B",
}  # fmt: skip
"""Columns, with the headings that fit a small screen."""


def recordings_page(results: Path) -> Iterator[str]:
    """What is included by docs/recordings.md."""
    rows = table_of(results)
    yield from table(FIGURES.values(), [[_short(row[name]) for name in FIGURES] for row in rows])
    yield from ("### What was found in each channel", "")
    for row in rows:
        if row["read"]:
            findings = re.sub(r"; (?=\w)", ". ", row["read"])
            yield f"- **{_short(row['file'])}, {row['channel']}**: {findings}."
    yield ""


def _short(cell: str) -> str:
    """Without the folder, and without a ratio that there is not."""
    return "" if cell == "nan" else cell.rpartition("/")[2]
