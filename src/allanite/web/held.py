"""What the process that works has in memory, and where it reports to."""

import json
import os
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from multiprocessing.connection import Connection
from pathlib import Path, PurePath
from typing import Any

from allanite.core.errors import AllaniteError, DataError
from allanite.core.record import Recording
from allanite.parallel.processors import PREPARING, imported
from allanite.statistics import deviation as deviation_of
from allanite.study.channels import whole_recording
from allanite.study.parts import in_parts
from allanite.study.recipe import READING, Recipe

from . import faces, trace
from .requests import problem_of
from .store import overfull

KEPT = 2
"""Recordings that stay in memory."""

SAID = 0.05
"""Seconds between reports of progress."""

ASSUMED: dict[str, dict[str, Any]] = {
    "unit": {"unit": "deg/s", "kind": None}, "kind": {"unit": "deg/s", "kind": None}, "rate": {"rate": 1.0},
}  # fmt: skip
"""With what a file is read, to draw its numbers, whose unit, kind or rate is not known."""

SEEN = 1.0
"""Seconds between the curves of a stream."""

Answer = dict[str, Any]


class Held:
    """What the process has in memory, and where it reports to.

    `values` are results by job, `recordings` what was read, by path and choices; `room` is left of the `quota`, bytes.
    """

    def __init__(self, connection: Connection) -> None:
        self.connection = connection
        self.values: dict[str, Any] = {}
        self.recordings: dict[tuple[str, str], Recording] = {}
        self.files: Mapping[str, tuple[str, str, str]] = {}
        self.room, self.quota = 0.0, 0
        self.drawn: dict[tuple[Any, ...], Any] = {}
        self.said = self.seen = 0.0
        self.lang = "en"

    def tell(self, what: str, fraction: float) -> None:
        """Report progress, not too often."""
        now = time.monotonic()
        if now - self.said >= SAID or fraction >= 1.0:
            self.said = now
            word = "preparing" if what == PREPARING else None
            self.send("progress", {"what": what, "word": word, "fraction": fraction})

    def event(self, words: str, watch: Any) -> None:
        """Report what happens in a stream, and its curves so far."""
        self.send("words", {"text": words})
        now = time.monotonic()
        if now - self.seen >= SEEN:
            self.seen = now
            curves = [channel.curve for channel in watch.latest or () if channel.curve is not None]
            self.send("live", {"channels": [faces.drawn(faces.panel_of(curve), 0.95, self.lang) for curve in curves]})

    def named(self, problem: Answer) -> Answer:
        """A problem with the names of files instead of where they are kept."""
        words = problem["error"]
        for path, (_, _, name) in self.files.items():
            words = words.replace(path, PurePath(name).name)
        return problem | {"error": words}

    def source(self, path: str, recipe: Recipe) -> Recording | str:
        """The recording of a file, read unless it is in memory; its path, if it does not fit into memory.

        Its trace is written beside the upload.
        """
        with in_parts(path, recipe) as reader:
            if reader is not None:
                return path
        key = json.dumps(recipe.to_dict(READING), sort_keys=True, default=str)
        if (path, key) not in self.recordings:
            while len(self.recordings) >= KEPT:
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
                    drawn.append(faces.drawn(faces.panel_of(curve), 0.95, self.lang))
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
            rest = trace.build(Path(folder), recording, key, raw, room=self.room)
            self.room = self.room if rest is None else rest
            full = problem_of(overfull(self.quota)) if rest is None else None
            self.send("trace", {"file": file, "problem": full})

    def send(self, kind: str, data: Answer) -> None:
        """Report to the server; without one there is nothing to go on for."""
        try:
            self.connection.send((kind, data))
        except OSError:
            os._exit(0)
