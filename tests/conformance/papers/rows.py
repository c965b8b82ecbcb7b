"""A row of the papers: the claim, the command as anybody can type it, and where its number stands."""

import csv
import io
import json
import math
from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Row:
    """A claim, the command and its cells, the number that is printed, its relative tolerance, and ours.

    A cell is a column of the CSV output and the row it is read in, ``value @ term=N``, the last row, ``tau_s @ last``,
    ``all value @ term=N`` in all channels, or, from ``/``, a path into the JSON output. Of several commands, each has
    its cell. `wrong`: the number of the paper is not ours.
    """

    item: str
    command: str | tuple[str, ...]
    cells: str | tuple[str, ...]
    published: float | Callable[[], float]
    tolerance: float
    ours: float | None = None
    wrong: bool = False
    read: Callable[..., float] = float


def number(path, cell):
    """The number of a cell in a CSV or JSON file; those of all rows if the cell begins with ``all``."""
    text = path.read_text(encoding="utf-8")
    if cell.startswith("/"):
        found = json.loads(text)
        for key in cell[1:].split("/"):
            found = found[int(key) if isinstance(found, list) else key]
        return found
    rows = list(csv.DictReader(io.StringIO(text)))
    if cell.startswith("blank "):
        return sum(not math.isfinite(float(row[cell[6:]] or "nan")) for row in rows)
    column, _, where = cell.removeprefix("all ").partition(" @ ")
    if where == "last":
        return float(rows[-1][column])
    wanted = dict(pair.split("=") for pair in where.split(" & ")) if where else {}
    found = [row[column] for row in rows if all(alike(row[key], value) for key, value in wanted.items())]
    return [float(text or "nan") for text in found] if cell.startswith("all ") else float(found[0])


def alike(shown, wanted):
    try:
        return math.isclose(float(shown), float(wanted), rel_tol=1e-9)
    except ValueError:
        return shown == wanted


def ratio(one, other):
    return one / other


def walk(hadamard, tau):
    """The coefficient of a random walk from its Hadamard deviation."""
    return hadamard * math.sqrt(6 / tau)


def percent(edf):
    """Relative standard error of a deviation."""
    return 100 / math.sqrt(2 * edf)


def arcsec(rad):
    return math.degrees(rad) * 3600


def rms(values):
    values = list(values)
    return math.sqrt(sum(value**2 for value in values) / len(values))


def minutes(seconds):
    return seconds / 60
