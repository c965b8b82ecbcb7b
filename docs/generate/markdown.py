"""Parts of pages."""

import re
from collections.abc import Iterable
from pathlib import Path


def table(headings: Iterable[str], rows: Iterable[Iterable[object]]) -> list[str]:
    """A table."""
    head = list(headings)
    lines = [head, ["---"] * len(head), *rows]
    return ["| " + " | ".join(str(cell).replace("|", r"\|") for cell in line) + " |" for line in lines] + [""]


def table_of(results: Path, section: str) -> list[dict[str, str]]:
    """Rows of the table of a section of a benchmark, by heading."""
    part = results.read_text(encoding="utf-8").partition(f"\n## {section}\n")[2].partition("\n## ")[0]
    lines = (line for line in part.splitlines() if line.startswith("| "))
    head, *rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    return [dict(zip(head, row, strict=True)) for row in rows]


def sections(row: object, columns: Iterable[tuple[str, str]]) -> list[str]:
    """A heading and the words of each column that the row has."""
    lines = []
    for column, heading in columns:
        words = getattr(row, column, "")
        lines += [f"## {heading}", "", typeset(words), ""] if words else []
    return lines


LETTERS = {
    r"\btau0\b": "τ₀", r"\btau\b": "τ", r"\bPhi\b": "Φ", r"\^2\b": "²", r"\^3\b": "³", r"slope -": "slope −",
    r"sqrt\((\w+)\)": r"√\1", r"sqrt\(([^()]*)\)": r"√(\1)",
}  # fmt: skip
"""What formulas in the tables' plain text are in print, in this order."""


def typeset(words: str) -> str:
    """Plain text of a table as it is printed."""
    for plain, printed in LETTERS.items():
        words = re.sub(plain, printed, words)
    return words


def shown(number: float) -> str:
    """Six digits."""
    return f"{number:.6g}"


def figure(path: Path, title: str) -> list[str]:
    """A figure of the page's own folder."""
    return [f"![{title}]({path.name})", ""]
