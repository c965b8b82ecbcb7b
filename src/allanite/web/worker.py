"""The process that does the work: does jobs, keeps what it has read, and answers questions about results."""

import os
import re
from collections.abc import Callable
from dataclasses import replace
from multiprocessing.connection import Connection
from typing import Any

from allanite.cli import main as allanite
from allanite.cli.forms import encoded
from allanite.cli.tasks import Reports
from allanite.core.choices import choices_of, read_given
from allanite.core.errors import UsageError
from allanite.parallel.processes import ANSWER
from allanite.parallel.processors import IDENTIFICATION, imported, importing, processes
from allanite.phrases.wording import command_line
from allanite.study.recipe import Recipe

from . import faces
from .held import Answer, Held
from .requests import Request, problem_of
from .workers import PROBLEM


def run(
    held: Held,
    job: str,
    *,
    verb: str,
    paths: list[str],
    choices: dict[str, Any],
    shown: str,
    lang: str,
    kept: tuple[dict[str, tuple[str, str, str]], float, int],
) -> Answer:
    """Do a job; its result as JSON, and as it is shown.

    `kept` are id, folder and name of each path, the bytes of the quota that are not taken yet, and the quota.
    """
    from allanite.reporting.json import to_json

    (held.files, held.room, held.quota), held.lang = kept, lang
    request = Request.of(verb, choices)
    with processes(None), importing(IDENTIFICATION, kernels=True):
        value = request.task.run(paths, request.recipe, request.settings, Reports(held.tell, held.event, held.source))
    held.values[job] = value, shown
    return {"json": to_json(value), "faces": faces.described(value, lang), "exit": request.task.code(value)}


def prepare(held: Held) -> Answer:
    """Load the kernels, or compile them and report it."""
    with importing(IDENTIFICATION, kernels=True):
        imported(held.tell)
    return {}


def example(held: Held, line: list[str]) -> Answer:
    """Write a simulated recording."""
    with allanite.make_context("allanite", line) as context:
        allanite.invoke(context)
    return {}


def described(held: Held, job: str, lang: str) -> Answer:
    """The sheets of a result, in a language."""
    return faces.described(held.values[job][0], lang)


def deviation(held: Held, job: str, channel: str, statistic: str, lang: str) -> Answer:
    """A curve of a channel, with its band and model."""
    value, _ = held.values[job]
    key = (job, channel, statistic)
    if key not in held.drawn:
        held.drawn[key] = faces.panel_of(*faces.curve_of(value, channel, statistic))
    return faces.drawn(held.drawn[key], value.recipe.level, lang)


def refit(held: Held, job: str, *, channel: str, choices: dict[str, Any], statistics: list[str], lang: str) -> Answer:
    """A channel with other terms or another band, and its curves."""
    from allanite.study.analysis import refitted
    from allanite.study.results import Study

    value, _ = held.values[job]
    if not isinstance(value, Study):
        raise UsageError("only the result of analyze has a fit that can be changed: run analyze first")
    recipe = replace(value.recipe, **read_given(choices_of(Recipe), choices))
    found = refitted(value[channel], recipe)
    shown = replace(value, channels=(found,), recipe=recipe)
    names = list(dict.fromkeys(statistics or [recipe.statistic]))
    curves = [faces.curve_of(shown, channel, name) for name in names]
    assert found.fit is not None  # noqa: S101 - `refitted` raises else
    return {
        "fit": replace(found.fit, curve=None).to_dict(recipe.level),
        "curve": [faces.drawn(faces.panel_of(curve, fit), recipe.level, lang) for curve, fit in curves],
        **faces.described(shown, lang)["channels"][0],
    }


def export(held: Held, job: str, *, channels: list[str], target: str, choices: dict[str, Any], form: str) -> Answer:
    """The file of a target, for the channels of a study."""
    from allanite.exporting.export import exported, prepared
    from allanite.exporting.fields import How

    value, _ = held.values[job]
    how = How(**read_given(choices_of(How), choices))
    row, suffix = prepared(target, how, form)
    chosen = replace(value, channels=tuple(value[name] for name in channels)) if channels else value
    made = exported(row, chosen, how, suffix)
    return {
        "text": made.text, "binary": made.binary, "filename": f"{row.name}{made.suffix}",
        "notes": [str(note) for note in made.notes], "alerts": [str(alert) for alert in made.alerts],
    }  # fmt: skip


FORMS: dict[str, tuple[str, str, str]] = {
    "report": ("report", "report.html", "text/html; charset=utf-8"),
    "pdf": ("report", "report.pdf", "application/pdf"),
    "json": ("json", "results.json", "application/json"),
    "csv": ("csv", "curves.csv", "text/csv; charset=utf-8"),
    "coefficients": ("coefficients", "coefficients.csv", "text/csv; charset=utf-8"),
    "figure.svg": ("plot", "figure.svg", "image/svg+xml"),
    "figure.png": ("plot", "figure.png", "image/png"),
}
"""What can be saved: option of the command line, name of the file, media type."""


def save(held: Held, job: str, form: str, lang: str, dark: bool = False) -> Answer:
    """A file as the command line writes it; a `dark` figure is for a dark ground."""
    value, shown = held.values[job]
    name, path, _ = FORMS[form]
    data = encoded(value, name, path, lang, shown)
    if dark and isinstance(data, bytes):
        from allanite.reporting.style import DARK

        colors = {light.encode(): other.encode() for light, other in DARK.items()}
        data = _HEX.sub(lambda found: colors.get(found[0].lower(), found[0]), data)
    return {"data": data.encode("utf-8", "backslashreplace") if isinstance(data, str) else data}


_HEX = re.compile(b"#[0-9a-fA-F]{6}")


def has(held: Held, job: str) -> Answer:
    """Whether the result of a job is in memory."""
    return {"there": job in held.values}


TASKS: dict[str, Callable[..., Answer]] = {
    "run": run, "prepare": prepare, "example": example, "described": described, "deviation": deviation, "refit": refit,
    "export": export, "save": save, "has": has,
}  # fmt: skip
"""What a worker can be asked."""


def main(connection: Connection) -> None:
    """Answer requests until the server has ended."""
    os.setsid() if hasattr(os, "setsid") else None
    held = Held(connection)
    while True:
        task, arguments = connection.recv()
        try:
            with command_line():
                held.send(ANSWER, TASKS[task](held, **arguments))
        except Exception as error:  # the server hears of every defect, and this process goes on
            held.send(PROBLEM, held.named(problem_of(error)))
