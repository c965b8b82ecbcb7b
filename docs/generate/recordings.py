"""The table of public recordings in two parts: what is claimed beside an expert's figures, and what the fit found."""

import re
from collections.abc import Iterator
from pathlib import Path

from generate.markdown import table, table_of

FIGURES = {
    "file": "file", "channel": "channel", "grade": "grade", "unit": "unit", "N (95 %)": "N (95 %)",
    "white level": "white level", "deviation at 1 s": "at 1 s", "last octave": "last octave", "data sheet": "sheet",
    "verdict": "verdict",
}  # fmt: skip
"""Columns, with the headings that fit a small screen."""


def recordings_page(results: Path) -> Iterator[str]:
    """What is included by docs/recordings.md."""
    rows = table_of(results, "Channels")
    yield from table(FIGURES.values(), [[_short(row[name]) for name in FIGURES] for row in rows])
    yield from ("### What was found in each channel", "")
    for row in rows:
        if row["read"]:
            findings = re.sub(r"; (?=\w)", ". ", row["read"])
            yield f"- **{_short(row['file'])}, {row['channel']}**: {findings}."
    yield ""


def _short(cell: str) -> str:
    """Without the folder."""
    return re.sub(r"^\w+/(?=\w+\.)", "", cell)
