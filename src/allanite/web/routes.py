"""HTTP as the page speaks it: what a request says, answers to errors, routes of workspaces, files, jobs and results."""

import asyncio
import json
import os
import secrets
from collections.abc import AsyncIterator
from importlib.resources import files
from typing import Annotated, Any

from fastapi import Query, Request
from fastapi.exceptions import RequestValidationError
from starlette.concurrency import run_in_threadpool
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect
from starlette.responses import JSONResponse, Response, StreamingResponse
from uvicorn.protocols.http.h11_impl import H11Protocol

from allanite.core.errors import AllaniteError, DataError, UsageError
from allanite.core.files import encoded, reason
from allanite.core.names import demand_name
from allanite.core.syntax import toml

from . import trace
from .faces import EXAMPLES, simulation, tables
from .jobs import Jobs
from .requests import problem_of
from .schema import ExampleBody, ExportBody, JobBody, Lang, PathBody, RefitBody, faults, fitting
from .store import FullError, MissingError, Store, shown
from .worker import FORMS
from .workers import ProblemError

TURN_TIMEOUT_S = 10.0
"""Seconds in which a client sends the head of a request, or takes what is sent; a browser here takes milliseconds."""

MAX_CONNECTIONS = 200
"""Connections beyond which the oldest that waits for its client is closed; Linux gives a process 1024 files."""

MAX_ACCEPTED = 64  # connections that are taken at once, before those that are too many are closed


class PromptProtocol(H11Protocol):
    """Closes a connection whose client does not send a request or take the answer in time, or is in the way."""

    late: asyncio.TimerHandle | None = None
    begun = 0.0

    @property
    def idle(self) -> bool:
        """Whether it is the turn of the client: to ask for something, or to take what is sent."""
        return self.cycle is None or self.cycle.response_complete or self.flow.write_paused

    def connection_made(self, transport: Any) -> None:
        """Begin to wait for the first request."""
        super().connection_made(transport)
        self.begun = self.loop.time()
        if len(self.connections) > MAX_CONNECTIONS:
            every = [other for other in self.connections if isinstance(other, PromptProtocol)]
            min((other for other in every if other.idle), key=lambda other: other.begun).end()
        self._wait()

    def data_received(self, data: bytes) -> None:
        """Take a part of a request, and wait for the rest of its head."""
        super().data_received(data)
        self._wait()

    def pause_writing(self) -> None:
        """Wait until the client takes what was sent."""
        super().pause_writing()
        self._wait()

    def resume_writing(self) -> None:
        """Send the rest."""
        super().resume_writing()
        self._wait()

    def connection_lost(self, exc: Exception | None) -> None:
        """Wait no more."""
        super().connection_lost(exc)
        self._stop()

    def end(self) -> None:
        """Close it now, whatever was not sent yet."""
        self.connections.discard(self)
        self.transport.abort()

    def _wait(self) -> None:
        if not self.idle:
            self._stop()
        elif self.late is None:
            self.late = self.loop.call_later(TURN_TIMEOUT_S, self.end)

    def _stop(self) -> None:
        if self.late is not None:
            self.late.cancel()
            self.late = None


MAX_BODY_BYTES = 1_000_000  # bytes of a request that is no upload


async def body_of(request: Request, schema: Any) -> Any:
    """The body of a request, as its schema says."""
    body = b""
    async for chunk in request.stream():
        body += chunk
        if len(body) > MAX_BODY_BYTES:
            raise UsageError(f"a request has at most {MAX_BODY_BYTES} bytes")
    return fitting(schema, body or b"{}")


class Answer(JSONResponse):
    """JSON in ASCII: whatever a text is made of, it can be sent."""

    def render(self, content: Any) -> bytes:
        """The body."""
        return json.dumps(content, allow_nan=False).encode("ascii")


ANSWERED: tuple[Any, ...] = (AllaniteError, ProblemError, RequestValidationError, HTTPException, OSError,
                             ClientDisconnect, Exception)  # fmt: skip
"""Kinds of errors that are answered."""


def answered(request: Request, error: Exception) -> JSONResponse:
    """What is answered to an error."""
    if isinstance(error, ProblemError):
        return Answer(error.data, 500 if error.data["exit"] == 1 else 400)
    if isinstance(error, HTTPException):
        return Answer(problem_of(UsageError(str(error.detail))), error.status_code)
    if isinstance(error, RequestValidationError):
        error = UsageError(faults(error))
    if isinstance(error, ClientDisconnect):  # which nobody hears of
        error = UsageError("the request broke off")
    if isinstance(error, OSError):
        place = repr(str(error.filename or request.app.state.store.folder))
        error = DataError(f"{place} cannot be used ({reason(error)}); see that it is there and can be written")
    statuses = ((MissingError, 404), (FullError, 413), (AllaniteError, 400), (Exception, 500))
    return Answer(problem_of(error), next(status for kind, status in statuses if isinstance(error, kind)))


def menus(request: Request, lang: Lang = "") -> dict[str, Any]:
    """The menus, and what the page opens with."""
    first, store = request.app.state.first, request.app.state.store
    return tables(lang or first["lang"]) | {"first": first | {"notes": store.notes, "aside": store.aside()}}


def style() -> Response:
    """The style sheet of reports."""
    return Response((files("allanite.reporting") / "style.css").read_text("utf-8"), media_type="text/css")


def link(request: Request) -> dict[str, Any]:
    """A link that opens the page once, for a second start of the command."""
    return {"link": request.app.state.door.link()}


def workspaces(request: Request) -> list[dict[str, Any]]:
    """All workspaces, the last one first."""
    states = request.app.state.store.all()
    return [{"id": state["id"], "files": [file["name"] for file in state["files"].values()]} for state in states]


def new_workspace(request: Request) -> dict[str, Any]:
    """A new workspace."""
    return {"id": request.app.state.store.new()["id"]}


def workspace(request: Request, name: str) -> dict[str, Any]:
    """A workspace as it is; jobs that a server left unfinished are begun once more."""
    state = request.app.state.store.state(name)
    request.app.state.jobs.resume(state)
    return {"id": state["id"], "files": list(map(_shown, state["files"].values())),
            "jobs": list(state["jobs"].values()), "choices": state["choices"]}  # fmt: skip


def drop_workspace(request: Request, name: str) -> dict[str, Any]:
    """Delete a workspace."""
    request.app.state.jobs.forget(name)
    request.app.state.store.remove(name)
    return {}


async def choices(request: Request, name: str) -> dict[str, Any]:
    """Keep what the client wants to find again."""
    kept = await body_of(request, dict[str, Any])
    with request.app.state.store.changed(name) as state:
        state["choices"] = kept
    return {}


async def upload(request: Request, name: str) -> dict[str, Any]:
    """Write an upload to disk while it comes."""
    store = request.app.state.store
    await run_in_threadpool(store.measure)
    with store.arriving(name, request.query_params.get("name", "")) as (file, path), open(path, "xb") as out:
        store.reserve(file, int(request.headers.get("content-length") or 0))
        async for chunk in request.stream():
            file["bytes"] += len(chunk)
            store.reserve(file, file["bytes"])
            await run_in_threadpool(out.write, chunk)
    return _shown(file)


async def opened(request: Request, name: str) -> dict[str, Any]:
    """Open a file where it is."""
    asked = await body_of(request, PathBody)
    return _shown(open_file(request.app.state.store, name, asked.path))


def sought(path: str) -> str:
    """Where a file of this machine is, by its path."""
    where = os.path.abspath(os.path.expanduser(path))
    if path and os.path.isdir(where):
        raise DataError(f"{path!r} is a folder: give a file of it")
    if not path or not os.path.isfile(where):
        raise DataError(f"there is no file {path!r}; give its path on this machine")
    if encoded(where) != os.fsencode(where):
        raise DataError(f"the path {where!r} is not UTF-8, which the page needs: rename the file or its folder")
    return where


def open_file(store: Store, workspace: str, path: str) -> dict[str, Any]:
    """Enter a file of this machine by its path."""
    where, own = sought(path), f"{workspace}-{secrets.token_hex(8)}"
    return store.add({"id": own, "name": shown(path), "bytes": os.path.getsize(where), "path": where, "own": False})


async def example(request: Request, name: str) -> dict[str, Any]:
    """Simulate a recording to play with."""
    which = (await body_of(request, ExampleBody)).name or next(iter(EXAMPLES))
    demand_name("example", which, EXAMPLES)
    store, jobs = request.app.state.store, request.app.state.jobs
    await run_in_threadpool(store.measure)
    with store.arriving(name, f"example-{which}.npz") as (file, path):
        await jobs.work(name, "example", line=simulation(which, str(path)))
        file["bytes"] = path.stat().st_size
        store.reserve(file, file["bytes"], upload=False)
    return _shown(file)


def _shown(file: dict[str, Any]) -> dict[str, Any]:
    """A file as the page shows it; where an upload is kept is not said."""
    return {key: file[key] for key in ("id", "name", "bytes", *(() if file["own"] else ("path",)))}


def drop_file(request: Request, name: str, file: str) -> dict[str, Any]:
    """Delete a file of a workspace."""
    if file.partition("-")[0] != name:
        raise MissingError(f"there is no file {file!r} in this workspace")
    request.app.state.store.drop(file)
    return {}


EVENTS_PERIOD_S = 0.05  # seconds between looks for new events
HEARTBEAT_PERIOD_S = 10.0  # seconds after which a stream of events without any says that it is there


async def begin(request: Request, name: str) -> dict[str, Any]:
    """Begin a job."""
    asked = await body_of(request, JobBody)
    job = await run_in_threadpool(request.app.state.jobs.begin, name, asked)
    return {"job": job["id"], "command": job["command"]}


async def job(request: Request, name: str, lang: Lang = "") -> Response:
    """A job with its result."""
    jobs = request.app.state.jobs
    state = jobs.job(name)
    parts = {key: state[key] for key in ("id", "state", "verb", "recipe", "lang", "files", "target", "command")}
    text = json.dumps(parts | {"problem": state["problem"], "toml": toml(state["recipe"])})
    if state["state"] != "done":
        return Response(text, media_type="application/json")
    value, shown = await run_in_threadpool(jobs.result, name)
    if lang and lang != state["lang"]:
        shown = json.dumps(await jobs.ask(name, "described", lang=lang)).encode()
    body = text[:-1].encode() + b', "value": ' + value.strip() + b", " + shown.strip()[1:]
    return Response(body, media_type="application/json")


async def events(request: Request, name: str) -> StreamingResponse:
    """What a job reports, as it comes."""
    jobs = request.app.state.jobs
    state = jobs.job(name)
    jobs.resume(jobs.store.state(name.partition("-")[0]))
    return StreamingResponse(_stream(jobs, state), media_type="text/event-stream")


async def _stream(jobs: Jobs, job: dict[str, Any]) -> AsyncIterator[str]:
    live = jobs.live.get(job["id"])
    if live is None:
        kind = "done" if job["state"] == "done" else "failed"
        problem = job["problem"] or {"error": job["state"], "option": None, "exit": 130}
        yield _event(kind, {} if kind == "done" else problem)
        return
    sent, quiet = 0, 0.0
    while True:
        over = live.over  # before the events are looked at: the last one is among them then
        for number, kind, data in live.events:
            if number >= sent:
                sent, quiet = number + 1, 0.0
                yield _event(kind, data)
        if over:
            return
        quiet += EVENTS_PERIOD_S
        if quiet >= HEARTBEAT_PERIOD_S:
            quiet = 0.0
            yield ": still there\n\n"
        await asyncio.sleep(EVENTS_PERIOD_S)


def _event(kind: str, data: dict[str, Any]) -> str:
    return f"event: {kind}\ndata: {json.dumps(data)}\n\n"


def cancel(request: Request, name: str) -> dict[str, Any]:
    """Cancel a job."""
    request.app.state.jobs.cancel(name)
    return {}


def traced(  # noqa: PLR0917 - parameters of the query
    request: Request, file: str, channel: str = "", points: int = 2000,
    start: Annotated[float | None, Query(alias="from", allow_inf_nan=False)] = None,
    end: Annotated[float | None, Query(alias="to", allow_inf_nan=False)] = None,
) -> dict[str, Any]:  # fmt: skip
    """A part of the trace of a channel."""
    store = request.app.state.store
    store.file(file)
    return trace.window(store.place(file), channel, start, end, points)


async def deviation(
    request: Request, name: str, channel: str = "", statistic: str = "oadev", lang: Lang = ""
) -> dict[str, Any]:
    """A curve with its band, its model, and each term."""
    jobs: Jobs = request.app.state.jobs
    lang = lang or jobs.job(name)["lang"]
    return await jobs.ask(name, "deviation", channel=channel, statistic=statistic, lang=lang)


async def refit(request: Request, name: str) -> dict[str, Any]:
    """A channel with other terms or another band."""
    asked: RefitBody = await body_of(request, RefitBody)
    jobs: Jobs = request.app.state.jobs
    choices = asked.model_dump(exclude={"channel", "statistics", "lang"})
    lang = asked.lang or jobs.job(name)["lang"]
    return await jobs.ask(name, "refit", channel=asked.channel, choices=choices, statistics=asked.statistics, lang=lang)


async def export(request: Request, name: str) -> dict[str, Any]:
    """The file of a target."""
    asked: ExportBody = await body_of(request, ExportBody)
    jobs: Jobs = request.app.state.jobs
    own = asked.model_dump(include={"channels", "target", "form", "models"})
    return await jobs.ask(name, "export", choices=asked.model_extra, lang=asked.lang or jobs.job(name)["lang"], **own)


async def save(request: Request, name: str, form: str, lang: Lang = "", dark: bool = False) -> Response:
    """A file as the command line writes it; a figure may be for a `dark` ground."""
    jobs: Jobs = request.app.state.jobs
    state = jobs.job(name)
    if form == "recipe":
        return _download(toml(state["recipe"]).encode(), "recipe.toml", "application/toml; charset=utf-8")
    demand_name("form", form, (*FORMS, "recipe"))
    _, path, kind = FORMS[form]
    if form == "json":
        return _download((await run_in_threadpool(jobs.result, name))[0], f"allanite-{path}", kind)
    made = await jobs.ask(name, "save", form=form, lang=lang or state["lang"], dark=dark and form == "figure.svg")
    return _download(made["data"], f"allanite-{path}", kind)


def _download(data: bytes, name: str, kind: str) -> Response:
    return Response(data, media_type=kind, headers={"Content-Disposition": f'attachment; filename="{name}"'})
