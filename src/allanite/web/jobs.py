"""Jobs of the workspaces: begun, reported, cancelled, kept on disk, and begun once more after a restart."""

import json
import secrets
import threading
from pathlib import Path
from typing import Any

from allanite.core.errors import DataError, UsageError
from allanite.core.files import write
from allanite.phrases.wording import command_line

from .requests import Request, problem_of
from .store import MissingError, State, Store, known
from .workers import ProblemError, Workers

WARM = "warm"
"""Lane of a worker that nobody uses: the first one that is started waits until everything is loaded."""

WAITING = 0.3
"""Seconds between looks whether what is compiled after an installation is ready."""

UNFINISHED = ("waiting", "running")


class Live:
    """A job that is going on: what it has reported so far."""

    def __init__(self) -> None:
        self.events: list[tuple[str, dict[str, Any]]] = []
        self.over = False

    def tell(self, kind: str, data: dict[str, Any]) -> None:
        """Add a report; of progress only the last one matters."""
        self.events.append((kind, data))
        self.over = self.over or kind in ("done", "failed")


class Jobs:
    """The jobs of a store, done by workers."""

    def __init__(self, store: Store) -> None:
        self.store, self.workers = store, Workers()
        self.live: dict[str, Live] = {}
        self.preparing: dict[str, Any] = {}
        self.ready = threading.Event()
        self.ready.set()

    def begin(self, workspace: str, asked: dict[str, Any]) -> State:
        """Enter a job and begin it.

        Raises
        ------
        UsageError
            There is no such verb, key or file.
        """
        state = self.store.state(workspace)
        wanted, choices = asked.get("files") or [], asked.get("recipe") or {}
        if not isinstance(wanted, list) or not isinstance(choices, dict):
            raise UsageError("a job has a list of files, and a recipe of keys and values")
        files = [self.store.file(str(name)) for name in wanted]
        if any(file["id"].partition("-")[0] != workspace for file in files):
            raise UsageError("the file belongs to another workspace")
        target = asked.get("target")
        names = [target] if isinstance(target, str) and target else [_called(file) for file in files]
        verb, recipe, lang = str(asked.get("verb")), dict(choices), str(asked.get("lang") or "en")
        with command_line():
            request = Request.of(verb, recipe)
        if verb == "watch" and not names:
            raise UsageError("a stream has an address: give a file, a port, or udp://127.0.0.1:9000 as target")
        request.demand_files(names)
        job = {
            "id": f"{state['id']}-{secrets.token_hex(8)}", "verb": verb, "files": [file["id"] for file in files],
            "target": target, "recipe": recipe, "lang": lang, "command": request.line(names, lang), "state": "waiting",
            "problem": None,
        }  # fmt: skip
        with self.store.changed(workspace) as state:
            state["jobs"][job["id"]] = job
        self._start(job)
        return job

    def resume(self, state: State) -> None:
        """Begin the jobs of a workspace that were not finished when the server ended."""
        for job in state["jobs"].values():
            if job["state"] in UNFINISHED and job["id"] not in self.live:
                self._start(job)

    def job(self, name: str) -> State:
        """A job by its id."""
        state = self.store.state(known(name.partition("-")[0]))
        found: State | None = state["jobs"].get(name)
        if found is None:
            raise MissingError(f"there is no job {name!r} in this workspace; run it again")
        return found

    def cancel(self, name: str) -> None:
        """End a job; of a stream that is watched, the results so far are computed first."""
        job = self.job(name)
        if job["state"] not in UNFINISHED:
            return
        lane = _lane(job)
        if job["verb"] == "watch" and job["state"] == "running" and not job.get("stopping"):
            job["stopping"] = True
            self.workers.of(lane).interrupt()
            return
        self._set(job, "cancelled")
        self.workers.end(lane)

    def result(self, name: str) -> tuple[bytes, bytes]:
        """The JSON of a result, and what is shown of it."""
        value, shown = self._paths(name)
        return value.read_bytes(), shown.read_bytes()

    def ask(self, name: str, task: str, **arguments: Any) -> dict[str, Any]:
        """Ask the worker that has the result of a job in memory; if none has, the job is done once more."""
        job = self.job(name)
        if job["state"] != "done":
            raise UsageError("the job has no result: run it again")
        worker = self.workers.of(_lane(job))
        if not worker.ask("has", {"job": name})["there"]:
            worker.ask("run", self._arguments(job))
        return worker.ask(task, {"job": name, **arguments})

    def warm(self) -> None:
        """Have the process ready from which workers are started."""

        def told(_: str, data: dict[str, Any]) -> None:
            self.preparing = data

        self.ready.clear()
        try:
            self.workers.of(WARM).ask("prepare", {}, tell=told)
        finally:
            self.ready.set()

    def work(self, workspace: str, task: str, **arguments: Any) -> dict[str, Any]:
        """Ask the worker of a workspace for something that is no job."""
        return self.workers.of(f"{workspace} main").ask(task, arguments)

    def _start(self, job: State) -> None:
        self.live[job["id"]] = Live()
        threading.Thread(target=self._run, args=(job,), daemon=True).start()

    def _run(self, job: State) -> None:
        live = self.live[job["id"]]

        def tell(kind: str, data: dict[str, Any]) -> None:
            if job["state"] == "waiting":
                self._set(job, "running")
            live.tell(kind, data)

        try:
            while not self.ready.wait(WAITING):  # two processes that compile the same take longer
                if self.preparing:
                    tell("progress", self.preparing)
                if job["state"] == "cancelled":
                    raise DataError("cancelled")
            with command_line():
                found = self.workers.of(_lane(job)).ask("run", self._arguments(job), tell=tell)
            value, shown = self._paths(job["id"])
            write(value, found["json"].encode(), force=True)
            write(shown, json.dumps(found["faces"] | {"exit": found["exit"]}).encode(), force=True)
        except ProblemError as problem:
            self._fail(job, live, problem.data)
        except Exception as error:
            self._fail(job, live, problem_of(error))
        else:
            self._set(job, "done")
            live.tell("done", {"exit": found["exit"]})

    def _fail(self, job: State, live: Live, problem: dict[str, Any]) -> None:
        if job["state"] == "cancelled":
            problem = {"error": "cancelled", "option": None, "exit": 130}
        else:
            job["problem"] = problem
            self._set(job, "failed")
        live.tell("failed", problem)

    def _set(self, job: State, state: str) -> None:
        try:
            with self.store.changed(job["id"].partition("-")[0]):
                job["state"] = state
        except MissingError:  # the workspace was deleted meanwhile
            job["state"] = state

    def _arguments(self, job: State) -> dict[str, Any]:
        files = [self.store.file(name) for name in job["files"]]
        return {
            "job": job["id"], "verb": job["verb"], "choices": job["recipe"], "shown": job["command"],
            "lang": job["lang"], "paths": [job["target"]] if job["target"] else [file["path"] for file in files],
            "files": {file["path"]: (file["id"], str(self.store.place(file["id"])), _called(file)) for file in files},
        }  # fmt: skip

    def _paths(self, name: str) -> tuple[Path, Path]:
        workspace, _, own = name.partition("-")
        folder = self.store.folder / known(workspace)
        return folder / f"{known(own)}.value.json", folder / f"{known(own)}.shown.json"


def _called(file: State) -> str:
    """What a file is called where the job is repeated: by its name if it was uploaded, else by its path."""
    return str(file["name"] if file["own"] else file["path"])


def _lane(job: State) -> str:
    """A stream has a worker of its own, since it does not end by itself."""
    return job["id"] if job["verb"] == "watch" else f"{job['id'].partition('-')[0]} main"
