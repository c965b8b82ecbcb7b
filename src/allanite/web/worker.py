"""The process that does the work: what it has in memory, and the jobs and questions that it answers."""

import json
import os
import re
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from multiprocessing.connection import Connection
from pathlib import Path, PurePath
from typing import Any

from allanite.cli import main as allanite
from allanite.cli.deliver import rendered
from allanite.cli.tasks import Reports
from allanite.core.choices import choices_of, read_given
from allanite.core.errors import AllaniteError, DataError, UsageError
from allanite.core.files import reason
from allanite.core.record import Recording
from allanite.exporting.export import exported, prepared
from allanite.exporting.fields import How
from allanite.exporting.imported import models_of
from allanite.parallel.processes import ANSWER
from allanite.parallel.processors import IDENTIFICATION, PREPARING, imported, importing, processes
from allanite.phrases.phrase import command_line
from allanite.reporting.figures.panels import panels_of
from allanite.reporting.json import to_json
from allanite.reporting.language import speaking
from allanite.reporting.style import DARK
from allanite.statistics import deviation as deviation_of
from allanite.study.analysis import refitted
from allanite.study.channels import whole_recording
from allanite.study.parts import in_parts
from allanite.study.recipe import READING, Recipe
from allanite.study.results import Study

from . import faces, trace
from .requests import PROBLEM, Request, problem_of
from .store import FullError, overfull

MAX_RECORDINGS = 2  # recordings that stay in memory
MAX_RESULTS = 8  # results that stay in memory, with their recordings; of an older one the job is done once more
PROGRESS_PERIOD_S = 0.05  # seconds between reports of progress

ASSUMED: dict[str, dict[str, Any]] = {"unit": {"unit": "deg/s", "kind": None}, "kind": {"unit": "deg/s", "kind": None},
                                      "rate": {"rate": 1.0}}  # fmt: skip
"""With what a file is read, to draw its numbers, whose unit, kind or rate is not known."""

CURVES_PERIOD_S = 1.0  # seconds between the curves of a stream

Answer = dict[str, Any]


class Held:
    """What the process has in memory, and where it reports to."""

    def __init__(self, connection: Connection) -> None:
        self.connection = connection
        self.values: dict[str, Any] = {}  # by job
        self.recordings: dict[tuple[str, str], Recording] = {}  # by path and choices
        self.files: Mapping[str, tuple[str, str, str]] = {}
        self.room, self.quota = 0.0, 0  # bytes that are left, and of all
        self.drawn: dict[tuple[Any, ...], Any] = {}
        self.said = self.seen = 0.0
        self.lang = "en"

    def tell(self, what: str, fraction: float) -> None:
        """Report progress, not too often."""
        now = time.monotonic()
        if now - self.said >= PROGRESS_PERIOD_S or fraction >= 1.0:
            self.said = now
            word = "preparing" if what == PREPARING else None
            self.send("progress", {"what": what, "word": word, "fraction": fraction})

    def event(self, words: str, watch: Any) -> None:
        """Report what happens in a stream, and its curves so far."""
        self.send("words", {"text": words})
        now = time.monotonic()
        if now - self.seen >= CURVES_PERIOD_S:
            self.seen = now
            curves = [channel.curve for channel in watch.latest or () if channel.curve is not None]
            self.send("live", {"channels": [faces.drawn(panels_of(curve)[0], 0.95, self.lang) for curve in curves]})

    def named(self, problem: Answer) -> Answer:
        """A problem with the names of files instead of where they are kept."""
        words = problem["error"]
        for path, (_, _, name) in self.files.items():
            words = words.replace(path, PurePath(name).name)
        return problem | {"error": words}

    def source(self, path: str, recipe: Recipe) -> Recording | str:
        """The recording of a file, read unless it is in memory; its path, if it does not fit into memory."""
        if in_parts(path, recipe) is not None:
            return path
        key = json.dumps(recipe.to_dict(READING), sort_keys=True, default=str)
        if (path, key) not in self.recordings:
            while len(self.recordings) >= MAX_RECORDINGS:
                self.recordings.pop(next(iter(self.recordings)))
            try:
                recording = whole_recording(path, recipe, progress=self.tell)
            except AllaniteError as error:
                self._draw_raw(path, recipe, error.choice)
                raise
            imported(self.tell)
            self.recordings[path, key] = replace(recording, source=self.files[path][2] if path in self.files else path)
            self._traced(path, key, self.recordings[path, key])
            drawn = []  # without their bands, which take longer
            for record in recording:
                with suppress(DataError):
                    curve = deviation_of(record, "oadev", taus="octave", noise=None)
                    drawn.append(faces.drawn(panels_of(curve)[0], 0.95, self.lang))
            self.send("curves", {"channels": drawn})
        else:
            self._traced(path, key, self.recordings[path, key])
        return self.recordings[path, key]

    def _draw_raw(self, path: str, recipe: Recipe, missing: str) -> None:
        """Draw the numbers of a file that cannot be analyzed before its unit, kind or rate is given."""
        given: dict[str, Any] = {}
        raw: list[str] = []
        while missing in ASSUMED and missing not in raw:
            raw.append(missing)
            given |= ASSUMED[missing]
            try:
                recording = whole_recording(path, replace(recipe, **given))
            except AllaniteError as error:  # the first error remains that of the job
                missing = error.choice
            else:
                self._traced(path, json.dumps(["raw", *raw]), recording, raw)
                return

    def _traced(self, path: str, key: str, recording: Recording, raw: Sequence[str] = ()) -> None:
        if path in self.files:
            file, folder, _ = self.files[path]
            full = None
            try:
                rest = trace.build(Path(folder), recording, key, raw, room=self.room)
                self.room = self.room if rest is None else rest
                full = problem_of(overfull(self.quota)) if rest is None else None
            except (OSError, UsageError) as error:  # the analysis goes on without it
                full = problem_of(FullError(f"the trace cannot be stored ({reason(error)}); make room on the disk"))
            self.send("trace", {"file": file, "problem": full})

    def send(self, kind: str, data: Answer) -> None:
        """Report to the server; without one there is nothing to go on for."""
        try:
            self.connection.send((kind, data))
        except OSError:
            os._exit(0)


def run(
    held: Held, job: str, *, verb: str, paths: list[str], choices: dict[str, Any], shown: str, lang: str,
    kept: tuple[dict[str, tuple[str, str, str]], float, int],  # id, folder and name of each path; bytes left; quota
) -> Answer:  # fmt: skip
    """Do a job; its result as JSON, and as it is shown."""
    (held.files, held.room, held.quota), held.lang = kept, lang
    request = Request.of(verb, choices)
    with processes(None), importing(IDENTIFICATION, kernels=True):
        value = request.task.run(paths, request.recipe, request.settings, Reports(held.tell, held.event, held.source))
    for old in list(held.values)[: 1 - MAX_RESULTS]:
        del held.values[old]
        held.drawn = {key: panel for key, panel in held.drawn.items() if key[0] != old}
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
        held.drawn[key] = panels_of(*faces.curve_of(value, channel, statistic))[0]
    return faces.drawn(held.drawn[key], value.recipe.level, lang)


def refit(held: Held, job: str, *, channel: str, choices: dict[str, Any], statistics: list[str], lang: str) -> Answer:
    """A channel with other terms or another band, and its curves."""
    value, _ = held.values[job]
    if not isinstance(value, Study):
        raise UsageError("only the result of analyze has a fit that can be changed: run analyze first")
    recipe = replace(value.recipe, **read_given(choices_of(Recipe), choices))
    fitted = refitted(value[channel], recipe)
    shown = replace(value, channels=(fitted,), recipe=recipe)
    names = list(dict.fromkeys(statistics or [recipe.statistic]))
    curves = [faces.curve_of(shown, channel, name) for name in names]
    assert fitted.fit is not None  # noqa: S101 - `refitted` raises else
    return {"fit": replace(fitted.fit, curve=None).to_dict(recipe.level),
            "curve": [faces.drawn(panels_of(curve, fit)[0], recipe.level, lang) for curve, fit in curves],
            **faces.described(shown, lang)["channels"][0]}  # fmt: skip


def export(held: Held, job: str, *, channels: list[str], target: str, choices: dict[str, Any], form: str,
           models: list[str], lang: str) -> Answer:  # fmt: skip
    """The file of a target, for the channels of a study and the noise of other sensors."""
    value, _ = held.values[job]
    how = How(**read_given(choices_of(How), choices))
    row, suffix = prepared(target, how, form)
    chosen = replace(value, channels=tuple(value[name] for name in channels)) if channels else value
    made = exported(row, [chosen, *models_of(models)], how, suffix)
    shown = faces.described(made, lang)
    return {
        "text": made.text, "binary": made.binary, "filename": f"{row.name}{made.suffix}",
        "html": "".join([shown["html"], *(sheet["html"] for sheet in shown["channels"])]) if made.entries else "",
    }  # fmt: skip


FORMS: dict[str, tuple[str, str, str]] = {
    "report": ("report", "report.html", "text/html; charset=utf-8"), "pdf": ("report", "report.pdf", "application/pdf"),
    "json": ("json", "results.json", "application/json"), "csv": ("csv", "curves.csv", "text/csv; charset=utf-8"),
    "coefficients": ("coefficients", "coefficients.csv", "text/csv; charset=utf-8"),
    "figure.svg": ("plot", "figure.svg", "image/svg+xml"), "figure.png": ("plot", "figure.png", "image/png"),
}  # fmt: skip
"""What can be saved: option of the command line, name of the file, media type."""


def save(held: Held, job: str, form: str, lang: str, dark: bool = False) -> Answer:
    """A file as the command line writes it; a `dark` figure is for a dark ground."""
    value, shown = held.values[job]
    name, path, _ = FORMS[form]
    data = rendered(value, name, path, lang, shown)
    if dark and isinstance(data, bytes):
        colors = {light.encode(): other.encode() for light, other in DARK.items()}
        data = _HEX.sub(lambda found: colors.get(found[0].lower(), found[0]), data)
    return {"data": data.encode("utf-8", "backslashreplace") if isinstance(data, str) else data}


_HEX = re.compile(b"#[0-9a-fA-F]{6}")


def has(held: Held, job: str) -> Answer:
    """Whether the result of a job is in memory."""
    return {"there": job in held.values}


TASKS: dict[str, Callable[..., Answer]] = {"run": run, "prepare": prepare, "example": example, "described": described,
                                           "deviation": deviation, "refit": refit, "export": export, "save": save,
                                           "has": has}  # fmt: skip
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
            with speaking(held.lang):
                held.send(PROBLEM, held.named(problem_of(error)))
