"""Numbers in the files that commands write."""

import csv
import io
import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

READ: dict[str, Callable[..., list[float]]] = {
    "": lambda *numbers: list(numbers),
    "ratio": lambda one, other: [one / other],
    "ratios": lambda *numbers: [number / numbers[-1] for number in numbers[:-1]],
    "difference": lambda one, other: [one - other],
    "reduction": lambda after, before: [100 * (1 - after / before)],
    "slope": lambda *numbers: [math.log10(b / a) for a, b in zip(numbers[::2], numbers[1::2], strict=True)],
    "ramp": lambda allan, hadamard, tau: [math.sqrt(2 * (allan**2 - hadamard**2)) / tau],
    "percent": lambda *edf: [100 / math.sqrt(2 * each) for each in edf],
}
"""What is made of the numbers of cells: slopes of pairs over a decade, a ramp from two deviations, percent from edf."""


def number(path: Path, cell: str) -> float:
    """The number of a cell in a CSV or JSON file."""
    text = path.read_text("utf-8")
    if cell.startswith("/"):
        found: Any = json.loads(text)
        for key in cell[1:].split("/"):
            found = found[int(key) if isinstance(found, list) else key]
        return float(found)
    rows = list(csv.DictReader(io.StringIO(text)))
    column, _, where = cell.partition(" @ ")
    if where == "last":
        return float(rows[-1][column])
    wanted = dict(pair.split("=") for pair in where.split(" & ")) if where else {}
    for row in rows:
        if all(_alike(row[key], value) for key, value in wanted.items()):
            return float(row[column])
    raise LookupError(f"{path.name} has no row {where}")


def _alike(shown: str, wanted: str) -> bool:
    try:
        return math.isclose(float(shown), float(wanted), rel_tol=1e-9)
    except ValueError:
        return shown == wanted
