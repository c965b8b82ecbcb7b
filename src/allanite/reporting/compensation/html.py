"""A compensation as one HTML page that needs nothing else."""

from pathlib import PurePath
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from allanite.compensation.study import Compensated, CompensationStudy
from allanite.reporting.html import svg
from allanite.reporting.sheet import printable
from allanite.reporting.words import about, percent

from .figures import plot
from .numbers import CURVES, curve_rows, lines, verdict


def page(study: CompensationStudy) -> str:
    """The page as text."""
    env = Environment(
        loader=PackageLoader("allanite", "reporting"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    env.filters["clean"], env.filters["minus"] = printable, _minus
    level = study.recipe.level
    content = {
        "name": PurePath(study.provenance.get("source", "")).name or "data in memory",
        "fitted": [_channel(channel, level, f"fit{i}") for i, channel in enumerate(study.fitted)],
        "applied": [_channel(channel, level, f"use{i}") for i, channel in enumerate(study.applied)],
        "headings": CURVES,
        "level": percent(level),
        "notes": study.notes,
        "choices": {k: _said(v) for k, v in study.choices.to_dict().items() if v not in ([], False)},
        "provenance": study.provenance,
    }
    return env.get_template("compensation/page.html.j2").render(content)


def _minus(number: str) -> str:
    return number.replace("-", "−")


def _said(value: Any) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{k} {_said(v)}" for k, v in value.items())
    return ", ".join(map(str, value)) if isinstance(value, list) else str(value)


def _channel(channel: Compensated, level: float, key: str) -> dict[str, Any]:
    regression = channel.regression
    unit, rows = curve_rows(channel, level)
    return {
        "name": channel.record.name or "channel",
        "about": about(channel.record),
        "verdict": verdict(channel),
        "doubt": regression is None or _doubtful(channel),
        "alerts": [*channel.notes, *(regression.notes if regression and channel.gain is None else ())],
        "lines": list(lines(regression, level)) if regression and channel.gain is None else [],
        "noise": "" if regression is None else str(regression.noise),
        "effective": "" if regression is None else f"{regression.effective:.4g}",
        "condition": "" if regression is None else f"{regression.condition:.3g}",
        "figure": svg(plot(channel, level), key, "deviation and rate before and after") if regression else "",
        "unit": unit,
        "rows": rows,
    }


def _doubtful(channel: Compensated) -> bool:
    if channel.gain is not None:
        return channel.gain.met is False or channel.gain.explained < 0
    regression = channel.regression
    return regression is None or not regression.significant or bool(regression.held and regression.held.explained < 0)
