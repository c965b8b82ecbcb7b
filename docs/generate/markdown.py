"""Parts of pages."""

from collections.abc import Iterable
from pathlib import Path


def table(headings: Iterable[str], rows: Iterable[Iterable[object]]) -> list[str]:
    """A table."""
    head = list(headings)
    lines = [head, ["---"] * len(head), *rows]
    return ["| " + " | ".join(str(cell).replace("|", r"\|") for cell in line) + " |" for line in lines] + [""]


def sections(row: object, columns: Iterable[tuple[str, str]]) -> list[str]:
    """A heading and the words of each column that the row has."""
    lines = []
    for column, heading in columns:
        words = getattr(row, column, "")
        lines += [f"## {heading}", "", words, ""] if words else []
    return lines


def shown(number: float) -> str:
    """Six digits."""
    return f"{number:.6g}"


def figure(path: Path, title: str) -> list[str]:
    """A figure of the page's own folder."""
    return [f"![{title}]({path.name})", ""]
