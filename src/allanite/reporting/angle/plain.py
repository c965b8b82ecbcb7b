"""Harmonics and plans for machines: JSON and CSV."""

import csv
import io
import json
from collections.abc import Mapping, Sequence
from typing import Any

from allanite.angle import Plan, Scan
from allanite.reporting.plain import _strict

from .numbers import Result, solution_of


def to_json(value: "Result | Plan | Scan", *, level: float, provenance: dict[str, str]) -> str:
    """Strictly valid JSON, SI."""
    data = value.to_dict() if isinstance(value, (Plan, Scan)) else value.to_dict(level)
    return json.dumps(_strict(data | {"provenance": provenance}), allow_nan=False, ensure_ascii=False) + "\n"


def to_csv(value: "Result | Plan | Scan", *, level: float) -> str:
    """All constants with limits, or the windows of a scan, SI."""
    if isinstance(value, (Plan, Scan)):
        return table(*value.rows())
    solution = solution_of(value)
    rows = [
        [name, estimate, error, *solution.interval(name, level)]
        for name, estimate, error in zip(
            solution.names, solution.values.tolist(), solution.errors.tolist(), strict=True
        )
    ]
    return table(["constant", "value", "standard_error", "low", "high"], rows)


def columns(data: Mapping[str, Any]) -> str:
    """Arrays of one length side by side; floats keep every digit."""
    return table(list(data), list(zip(*(values.tolist() for values in data.values()), strict=True)))


def table(headings: Sequence[str], rows: Sequence[Sequence[Any]]) -> str:
    """Headings and rows as CSV."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(headings)
    writer.writerows(rows)
    return out.getvalue()
