"""A study for machines: JSON and CSV."""

import csv
import io
import json
import math
from typing import Any, Protocol

from allanite.study import Study

from .words import readable_unit

COLUMNS = ("channel", "statistic", "m", "tau_s", "deviation", "low", "high", "unit", "edf", "count")


class Plain(Protocol):
    """Whatever can become plain data."""

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""


def to_json(value: Plain) -> str:
    """Strictly valid JSON: what is no number is null."""
    return json.dumps(_strict(value.to_dict()), allow_nan=False, ensure_ascii=False) + "\n"


def _strict(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _strict(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_strict(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def to_csv(study: Study) -> str:
    """The curves of all channels below each other, in the units of data sheets, limits at the recipe's level."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(COLUMNS)
    for channel in study.channels:
        if channel.curve is None:
            continue
        unit = readable_unit(channel.curve.unit)
        data = channel.curve.to(unit).to_dict(study.recipe.level)
        none = [""] * len(data["m"])
        columns = [data["m"], data["tau"], data["deviation"], data.get("low", none), data.get("high", none)]
        for m, tau, value, low, high, edf, count in zip(*columns, data.get("edf", none), data["count"], strict=True):
            writer.writerow([channel.record.name, channel.curve.statistic, m, tau, value, low, high, unit, edf, count])
    return out.getvalue()
