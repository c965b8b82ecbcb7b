"""Jobs of the workspaces: begun, reported, cancelled, kept on disk, and begun once more after a restart."""

import asyncio
import json
import secrets
import threading
from concurrent.futures import Future, wait
from contextlib import suppress
from pathlib import Path
from typing import Any

from allanite.cli.streams import complain
from allanite.core.errors import DataError, UsageError

from .requests import Request, problem_of
from .schema import JobBody
from .store import FullError, MissingError, State, Store, known, overfull, removed
from .workers import ProblemError, Worker, Workers

READY_PERIOD_S = 0.3  # seconds between looks whether what is compiled after an installation is ready
WARM = "warm"  # the lane of the worker that compiles what is not compiled yet

UNFINISHED = ("waiting", "running")

CANCELLED = {"error": "cancelled", "option": None, "exit": 130}

MAX_END_S = 60.0  # seconds in which a stream comes to its results when the server ends

LATEST = ("progress", "live")  # reports of which only the last one matters
MAX_EVENTS, MAX_LIVES = 200, 50  # reports of a job, and jobs that are over, that are remembered


class Live:
    """A job that is going on: what it has reported so far, each report with its number."""

    def __init__(self) -> None:
        self.events: list[tuple[int, str, dict[str, Any]]] = []
        self.count = 0
        self.over = self.stopping = False
        self.turn: Future[None] | None = None

    def tell(self, kind: str, data: dict[str, Any]) -> None:
        """Add a report."""
        kept = [event for event in self.events if kind not in LATEST or event[1] != kind]
        self.events = [*kept[1 - MAX_EVENTS :], (self.count, kind, data)]
        self.count += 1
        self.over = self.over or kind in ("done", "failed")


class Jobs:
    """The jobs of a store, done by workers."""

    def __init__(self, store: Store) -> None:
        self.store, self.workers = store, Workers()
        self.live: dict[str, Live] = {}
        self.preparing: dict[str, Any] = {}
        self.ready = threading.Event()
        self.ready.set()

    def begin(self, workspace: str, asked: JobBody) -> State:
        """Enter a job and begin it."""
        state = self.store.state(workspace)
        files = [self.store.file(name) for name in asked.files]
        if any(file["id"].partition("-")[0] != workspace for file in files):
            raise UsageError("the file belongs to another workspace")
        names = [asked.target] if asked.target else [_called(file) for file in files]
        verb, recipe, lang = asked.verb, asked.recipe, asked.lang or "en"
        request = Request.of(verb, recipe)
        if verb == "watch" and not names:
            raise UsageError("a stream has an address: give a file, a port, or udp://127.0.0.1:9000 as target")
        request.demand_files(names)
        job = {"id": f"{state['id']}-{secrets.token_hex(8)}", "verb": verb, "files": [file["id"] for file in files],
               "target": asked.target or None, "recipe": recipe, "lang": lang, "command": request.line(names, lang),
               "state": "waiting", "problem": None}  # fmt: skip
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
        job: State | None = state["jobs"].get(name)
        if job is None:
            raise MissingError(f"there is no job {name!r} in this workspace; run it again")
        return job

    def cancel(self, name: str) -> None:
        """End a job; of a stream that is watched, the results so far are computed first."""
        job = self.job(name)
        if job["state"] not in UNFINISHED:
            return
        live = self.live.get(name)
        if live and job["verb"] == "watch" and job["state"] == "running" and not live.stopping:
            live.stopping = True
            self.workers.interrupt(_lane(job))
            return
        self._set(job, "cancelled")
        if live and live.turn and live.turn.cancel():  # it had not begun
            live.tell("failed", CANCELLED)
        else:
            self.workers.end(_lane(job))

    def forget(self, workspace: str) -> None:
        """End what is done for a workspace."""
        jobs = (self.store.find(known(workspace)) or {"jobs": {}})["jobs"].values()
        for job in jobs:
            self._set(job, "cancelled")
        self.workers.close(f"{workspace} main", *map(_lane, jobs))

    def close(self) -> None:
        """End everything; streams that are watched come to their results before."""
        jobs = [job for state in [*self.store.states.values()] for job in state["jobs"].values()]
        watched = [job["id"] for job in jobs if job["verb"] == "watch" and job["state"] == "running"]
        streams = {name: self.live[name] for name in watched if name in self.live}
        try:
            for name, live in streams.items():
                self.cancel(name) if not live.stopping else None
            if streams:
                complain("the results of what is watched are computed; Ctrl-C once more ends without them")
            wait([live.turn for live in streams.values() if live.turn], MAX_END_S)
        finally:
            self.workers.close()

    def result(self, name: str) -> tuple[bytes, bytes]:
        """The JSON of a result, and what is shown of it."""
        value, shown = self._paths(name)
        if any(self.store.kept(path, dict[str, Any]) is None for path in (value, shown)):
            raise MissingError("the result of this job is not there any more: run it again")
        return value.read_bytes(), shown.read_bytes()

    async def ask(self, name: str, task: str, **arguments: Any) -> dict[str, Any]:
        """Ask the worker that has the result of a job in memory; if none has, the job is done once more."""
        job = self.job(name)
        if job["state"] != "done":
            raise UsageError("the job has no result: run it again")

        def answer(worker: Worker) -> dict[str, Any]:
            if not worker.ask("has", {"job": name})["there"]:
                if job["verb"] == "watch":
                    raise DataError("the samples of a stream are not kept: watch it again")
                worker.ask("run", self._arguments(job))
            return worker.ask(task, {"job": name, **arguments})

        return await asyncio.wrap_future(self.workers.submit(_lane(job), answer))

    def warm(self) -> None:
        """Begin to have the process ready from which workers are started; if that fails, the first job says why."""

        def told(_: str, data: dict[str, Any]) -> None:
            self.preparing = data

        def warmed(_: Future[Any]) -> None:
            self.workers.close(WARM)
            self.ready.set()

        self.ready.clear()
        self.workers.submit(WARM, lambda worker: worker.ask("prepare", {}, told)).add_done_callback(warmed)

    async def work(self, workspace: str, task: str, **arguments: Any) -> dict[str, Any]:
        """Ask the worker of a workspace for something that is no job."""
        turn = self.workers.submit(f"{workspace} main", lambda worker: worker.ask(task, arguments))
        return await asyncio.wrap_future(turn)

    def _start(self, job: State) -> None:
        for name in [name for name, live in list(self.live.items()) if live.over][:-MAX_LIVES]:
            self.live.pop(name, None)
        live = self.live[job["id"]] = Live()
        live.turn = self.workers.submit(_lane(job), lambda worker: self._run(job, live, worker))

    def _run(self, job: State, live: Live, worker: Worker) -> None:
        def tell(kind: str, data: dict[str, Any]) -> None:
            if job["state"] == "waiting":
                self._set(job, "running")
            if kind == "trace" and not data["problem"] and self.store.room() < 0:  # others came at the same time
                removed(self.store.place(data["file"]) / "trace")
                data |= {"problem": problem_of(overfull(self.store.quota))}
            live.tell(kind, data)

        def ended() -> bool:
            return bool(job["state"] == "cancelled")

        try:
            # two processes that compile the same take longer
            while not self.ready.wait(READY_PERIOD_S) and not ended():
                if self.preparing:
                    tell("progress", self.preparing)
            answer = worker.ask("run", self._arguments(job), tell, ended)
            value, shown = self._paths(job["id"])
            self.store.put(value, answer["json"].encode("utf-8", "replace"))
            self.store.put(shown, json.dumps(answer["faces"] | {"exit": answer["exit"]}).encode())
        except ProblemError as problem:
            self._fail(job, live, problem.data)
        except Exception as error:
            self._fail(job, live, problem_of(error))
        else:
            self._set(job, "done")
            live.tell("done", {"exit": answer["exit"]})

    def _fail(self, job: State, live: Live, problem: dict[str, Any]) -> None:
        if problem["error"] != "cancelled":  # what the end of the server has cancelled begins once more
            job["problem"] = problem
            self._set(job, "failed")
        live.tell("failed", problem if job["state"] == "failed" else CANCELLED)

    def _set(self, job: State, state: str) -> None:
        """Go on to another state, unless the job is over or its workspace deleted; on a full disk, in memory."""
        with suppress(MissingError, FullError), self.store.changed(job["id"].partition("-")[0]):
            if job["state"] in UNFINISHED:
                job["state"] = state

    def _arguments(self, job: State) -> dict[str, Any]:
        files = [self.store.file(name) for name in job["files"]]
        places = {file["path"]: (file["id"], str(self.store.place(file["id"])), _called(file)) for file in files}
        return {"job": job["id"], "verb": job["verb"], "choices": job["recipe"], "shown": job["command"],
                "lang": job["lang"], "paths": [job["target"]] if job["target"] else [file["path"] for file in files],
                "kept": (places, self.store.room(), self.store.quota)}  # fmt: skip

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
