"""Numbers of the committed tables, by section, row and column, or by a pattern in what a page says above its table."""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "benchmarks"), str(ROOT / "tools")]

import table  # noqa: E402  the number of threads
from table import RESULTS, Page  # noqa: E402

READ: list[str] = []
"""Tables that have been read since it was emptied."""


class NotMadeError(LookupError):
    """A table, a section, a row or a sentence of it that has not been made yet."""


def read(name: str) -> Page:
    """A committed table, which is noted."""
    READ.append(name)
    if not (RESULTS / name).exists():
        raise NotMadeError(name)
    return table.read(name)


def rows(file: str, section: str, *columns: str) -> list[dict[str, str]]:
    """Rows of all tables of a section that have these columns."""
    page = read(file)
    if section and not re.search(rf"^#+ {re.escape(section)}", page.text, re.MULTILINE):
        raise NotMadeError(f"{file}, section {section}")
    kept = [row for each in page.tables(section) for row in each if set(columns) <= set(row)]
    if not kept:
        raise NotMadeError(f"{file}, {section or 'any section'}: rows with {', '.join(columns)}")
    return kept


def number(cell: str) -> float:
    """The first number of a cell."""
    return float(re.findall(r"[-+]?[\d.]+(?:e[-+]?\d+)?", cell)[0])


def figures(file: str, section: str, column: str, /, **where: object) -> list[float]:
    """A column of a table as numbers, of the rows whose cells are as given."""
    wanted = {name.replace("_", " "): cells for name, cells in where.items()}
    kept = [row for row in rows(file, section, column, *wanted) if row[column] not in ("", "-", "nan")]
    cells = [row[column] for row in kept if all(row[name] in among for name, among in wanted.items())]
    if not cells:
        raise NotMadeError(f"{file}, {section or 'any section'}: {column} of {wanted}")
    return [number(cell) for cell in cells]


def span(numbers):
    """The least and the largest."""
    numbers = list(numbers)
    return min(numbers), max(numbers)


def mean(numbers):
    """Their mean."""
    return sum(numbers) / len(numbers)


def single(*cell, **where):
    """The only number of a column where the cells of its row are as given."""
    (value,) = figures(*cell, **where)
    return value


def stated(file: str, pattern: str) -> list[float]:
    """Numbers in what a page says above its table."""
    words = re.search(pattern, read(file).text)
    if not words:
        raise NotMadeError(f"{file}: {pattern}")
    return [float(value.replace(",", "")) for value in words.groups()]
