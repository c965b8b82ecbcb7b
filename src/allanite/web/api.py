"""The routes of the page."""

import asyncio
import json
import os
import secrets
from collections.abc import AsyncIterator
from importlib.resources import files
from typing import Any

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from starlette.concurrency import run_in_threadpool
from starlette.exceptions import HTTPException
from starlette.responses import JSONResponse, Response, StreamingResponse
from starlette.staticfiles import StaticFiles

from allanite.core.errors import AllaniteError, DataError, UsageError

from . import trace
from .jobs import Jobs
from .line import problem_of
from .store import CHOICES, FullError, MissingError, Store
from .tables import EXAMPLES, simulation, tables
from .worker import FORMS
from .workers import ProblemError

QUIET = 0.05
"""Seconds between looks for new events."""

ALIVE = 10.0
"""Seconds after which a stream of events without any says that it is there."""

LONGEST = 1_000_000
"""Bytes of a request that is no upload."""


def application(store: Store, jobs: Jobs, first: dict[str, Any]) -> FastAPI:
    """The application behind the door; `first` is what the page opens with: workspace and language."""
    # nothing is reported anywhere, whatever the environment asks for
    app = FastAPI(
        docs_url=None, redoc_url=None, openapi_url=None, redirect_slashes=False, telemetry={"auto_configure": False}
    )
    app.state.store, app.state.jobs, app.state.first = store, jobs, first
    for kind, answer in ANSWERS.items():
        app.add_exception_handler(kind, answer)
    for path, (method, endpoint) in ROUTES.items():
        app.add_api_route(path.partition(" ")[2], endpoint, methods=[method], response_model=None)
    app.mount("/", StaticFiles(directory=str(files("allanite.web") / "static"), html=True))
    return app


def menus(request: Request, lang: str = "") -> dict[str, Any]:
    """The menus, and what the page opens with."""
    first = request.app.state.first
    return tables(lang or first["lang"]) | {"first": first}


def style() -> Response:
    """The style sheet of reports."""
    return Response((files("allanite.reporting") / "style.css").read_text("utf-8"), media_type="text/css")


def workspaces(request: Request) -> list[dict[str, Any]]:
    """All workspaces, the last one first."""
    return [
        {"id": state["id"], "files": [file["name"] for file in state["files"].values()]}
        for state in request.app.state.store.all()
    ]


def new_workspace(request: Request) -> dict[str, Any]:
    """A new workspace."""
    return {"id": request.app.state.store.new()["id"]}


def workspace(request: Request, name: str) -> dict[str, Any]:
    """A workspace as it is; jobs that a server left unfinished are begun once more."""
    state = request.app.state.store.state(name)
    request.app.state.jobs.resume(state)
    return _public(state)


def _public(state: dict[str, Any]) -> dict[str, Any]:
    found = [{k: v for k, v in file.items() if k != "path" or not file["own"]} for file in state["files"].values()]
    return {"id": state["id"], "files": found, "jobs": list(state["jobs"].values()), "choices": state["choices"]}


def drop_workspace(request: Request, name: str) -> dict[str, Any]:
    """Delete a workspace."""
    request.app.state.jobs.workers.end(f"{name} main")
    request.app.state.store.remove(name)
    return {}


async def choices(request: Request, name: str) -> dict[str, Any]:
    """Keep what the client wants to find again."""
    found = await _json(request, CHOICES)
    with request.app.state.store.changed(name) as state:
        state["choices"] = found
    return {}


async def upload(request: Request, name: str) -> dict[str, Any]:
    """Write an upload to disk while it comes."""
    store = request.app.state.store
    used = await run_in_threadpool(store.used)
    store.demand_room(int(request.headers.get("content-length") or 0), used)
    file, path = store.new_file(name, request.query_params.get("name", ""))
    try:
        with open(path, "xb") as out:
            async for chunk in request.stream():
                file["bytes"] += len(chunk)
                store.demand_room(file["bytes"], used)
                await run_in_threadpool(out.write, chunk)
    except BaseException:
        path.unlink(missing_ok=True)
        store.place(file["id"]).rmdir()
        raise
    return _shown(store.add(file))


async def opened(request: Request, name: str) -> dict[str, Any]:
    """Open a file where it is."""
    path = str((await _json(request)).get("path") or "")
    return _shown(open_file(request.app.state.store, name, path))


def open_file(store: Store, workspace: str, path: str) -> dict[str, Any]:
    """Enter a file of this machine by its path."""
    where = os.path.abspath(os.path.expanduser(path))
    if not path or not os.path.isfile(where):
        raise DataError(f"there is no file {path!r}; give its path on this machine")
    size = os.path.getsize(where)
    own = f"{workspace}-{secrets.token_hex(8)}"
    return store.add({"id": own, "name": path, "bytes": size, "path": where, "own": False})


async def example(request: Request, name: str) -> dict[str, Any]:
    """Simulate a recording to play with."""
    which = str((await _json(request)).get("name") or next(iter(EXAMPLES)))
    if which not in EXAMPLES:
        raise UsageError(f"unknown example {which!r}; examples: {', '.join(EXAMPLES)}")
    store, jobs = request.app.state.store, request.app.state.jobs
    file, path = store.new_file(name, f"example-{which}.npz")
    line = simulation(which, str(path))
    await run_in_threadpool(jobs.work, name, "example", line=line)
    return _shown(store.add(file | {"bytes": path.stat().st_size}))


def _shown(file: dict[str, Any]) -> dict[str, Any]:
    return {key: file[key] for key in ("id", "name", "bytes")}


def drop_file(request: Request, name: str, file: str) -> dict[str, Any]:
    """Delete a file of a workspace."""
    if file.partition("-")[0] != name:
        raise MissingError(f"there is no file {file!r} in this workspace")
    request.app.state.store.drop(file)
    return {}


async def begin(request: Request, name: str) -> dict[str, Any]:
    """Begin a job."""
    asked = await _json(request)
    job = await run_in_threadpool(request.app.state.jobs.begin, name, asked)
    return {"job": job["id"], "command": job["command"]}


def job(request: Request, name: str, lang: str = "") -> Response:
    """A job with its result."""
    jobs = request.app.state.jobs
    found = jobs.job(name)
    parts = {key: found[key] for key in ("id", "state", "verb", "recipe", "lang", "files", "target", "command")}
    text = json.dumps(parts | {"problem": found["problem"], "toml": _toml(found["recipe"])})
    if found["state"] != "done":
        return Response(text, media_type="application/json")
    value, shown = jobs.result(name)
    if lang and lang != found["lang"]:
        shown = json.dumps(jobs.ask(name, "described", lang=lang)).encode()
    body = text[:-1].encode() + b', "value": ' + value.strip() + b", " + shown.strip()[1:]
    return Response(body, media_type="application/json")


def _toml(recipe: dict[str, Any]) -> str:
    from allanite.reporting.sheet import toml

    return toml(recipe)


async def events(request: Request, name: str) -> StreamingResponse:
    """What a job reports, as it comes."""
    jobs = request.app.state.jobs
    found = jobs.job(name)
    jobs.resume(jobs.store.state(name.partition("-")[0]))
    return StreamingResponse(_stream(jobs, found), media_type="text/event-stream")


async def _stream(jobs: Jobs, job: dict[str, Any]) -> AsyncIterator[str]:
    live = jobs.live.get(job["id"])
    if live is None:
        kind = "done" if job["state"] == "done" else "failed"
        yield _event(kind, {} if kind == "done" else _ended(job))
        return
    sent, quiet = 0, 0.0
    while True:
        events = live.events
        while sent < len(events):
            kind, data = events[sent]
            sent += 1
            # of progress only the last report matters
            if kind not in ("progress", "live") or sent == len(events) or events[sent][0] != kind:
                quiet = 0.0
                yield _event(kind, data)
        if live.over and sent == len(live.events):
            return
        quiet += QUIET
        if quiet >= ALIVE:
            quiet = 0.0
            yield ": still there\n\n"
        await asyncio.sleep(QUIET)


def _ended(job: dict[str, Any]) -> dict[str, Any]:
    return job["problem"] or {"error": job["state"], "option": None, "exit": 130}


def _event(kind: str, data: dict[str, Any]) -> str:
    return f"event: {kind}\ndata: {json.dumps(data)}\n\n"


def cancel(request: Request, name: str) -> dict[str, Any]:
    """Cancel a job."""
    request.app.state.jobs.cancel(name)
    return {}


def traced(request: Request, file: str, channel: str = "", points: int = 2000) -> dict[str, Any]:
    """A part of the trace of a channel."""
    store = request.app.state.store
    store.file(file)
    given = [request.query_params.get(key) for key in ("from", "to")]
    try:
        start, end = (float(text) if text else None for text in given)
    except ValueError:
        raise UsageError(f"the window of a trace is in seconds, not {given!r}") from None
    return trace.window(store.place(file), channel, start, end, points)


def deviation(request: Request, name: str, channel: str, statistic: str = "oadev", lang: str = "") -> dict[str, Any]:
    """A curve with its band, its model, and each term."""
    lang = lang or request.app.state.jobs.job(name)["lang"]
    found: dict[str, Any] = request.app.state.jobs.ask(
        name, "deviation", channel=channel, statistic=statistic, lang=lang
    )
    return found


async def refit(request: Request, name: str) -> dict[str, Any]:
    """A channel with other terms or another band."""
    asked, jobs = await _json(request), request.app.state.jobs
    arguments = {
        "channel": str(asked.get("channel")),
        "choices": {key: asked[key] for key in REFITTED if asked.get(key)},
        "statistics": list(asked.get("statistics") or []),
        "lang": asked.get("lang") or jobs.job(name)["lang"],
    }
    found: dict[str, Any] = await run_in_threadpool(lambda: jobs.ask(name, "refit", **arguments))
    return found


async def export(request: Request, name: str) -> dict[str, Any]:
    """The file of a target."""
    asked, jobs = await _json(request), request.app.state.jobs
    arguments = {"channels": list(asked.get("channels") or []), "target": str(asked.get("target")),
                 "choices": asked, "form": str(asked.get("form") or "")}  # fmt: skip
    found: dict[str, Any] = await run_in_threadpool(lambda: jobs.ask(name, "export", **arguments))
    return found


def nowhere(rest: str) -> None:
    """Whatever else begins like a route is none: it never names a file."""
    raise MissingError(f"there is no route {rest!r}")


REFITTED = ("terms", "band", "method", "level", "outliers")
"""Choices of a refit."""


def save(request: Request, name: str, form: str, lang: str = "", inline: bool = False) -> Response:
    """A file to download, as the command line writes it."""
    jobs = request.app.state.jobs
    found = jobs.job(name)
    how = "inline" if inline and form.startswith("figure") else "attachment"
    if form == "recipe":
        return _download(_toml(found["recipe"]).encode(), "recipe.toml", "application/toml; charset=utf-8")
    if form not in FORMS:
        raise UsageError(f"unknown form {form!r}; forms: {', '.join((*FORMS, 'recipe'))}")
    _, path, kind = FORMS[form]
    data = jobs.result(name)[0] if form == "json" else jobs.ask(
        name, "save", form=form, lang=lang or found["lang"])["data"]  # fmt: skip
    return _download(data, f"allanite-{path}", kind, how)


def _download(data: bytes, name: str, kind: str, how: str = "attachment") -> Response:
    return Response(data, media_type=kind, headers={"Content-Disposition": f'{how}; filename="{name}"'})


ROUTES: dict[str, tuple[str, Any]] = {
    "get /api/tables": ("GET", menus),
    "get /report.css": ("GET", style),
    "get /api/workspaces": ("GET", workspaces),
    "post /api/workspaces": ("POST", new_workspace),
    "get /api/workspaces/{name}": ("GET", workspace),
    "delete /api/workspaces/{name}": ("DELETE", drop_workspace),
    "put /api/workspaces/{name}/choices": ("PUT", choices),
    "post /api/workspaces/{name}/files": ("POST", upload),
    "delete /api/workspaces/{name}/files/{file}": ("DELETE", drop_file),
    "post /api/workspaces/{name}/open": ("POST", opened),
    "post /api/workspaces/{name}/example": ("POST", example),
    "post /api/workspaces/{name}/jobs": ("POST", begin),
    "get /api/jobs/{name}": ("GET", job),
    "get /api/jobs/{name}/events": ("GET", events),
    "post /api/jobs/{name}/cancel": ("POST", cancel),
    "get /api/files/{file}/trace": ("GET", traced),
    "get /api/jobs/{name}/deviation": ("GET", deviation),
    "post /api/jobs/{name}/refit": ("POST", refit),
    "post /api/jobs/{name}/export": ("POST", export),
    "get /api/jobs/{name}/save": ("GET", save),
    "get /api/{rest:path}": ("GET", nowhere),
}
"""Method and path of each route: its function."""


async def _json(request: Request, most: int = LONGEST) -> dict[str, Any]:
    """The object in the body of a request."""
    body = b""
    async for chunk in request.stream():
        body += chunk
        if len(body) > most:
            raise UsageError(f"a request has at most {most} bytes")
    try:
        found = json.loads(body or b"{}")
    except ValueError as error:
        raise UsageError(f"the request is not JSON: {error}") from None
    if not isinstance(found, dict):
        raise UsageError("the request is not an object of JSON")
    return found


def _refused(request: Request, error: Exception) -> JSONResponse:
    status = 404 if isinstance(error, MissingError) else 413 if isinstance(error, FullError) else 400
    return JSONResponse(problem_of(error), status)


def _problem(request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, ProblemError)  # noqa: S101 - the table says so
    return JSONResponse(error.data, 500 if error.data["exit"] == 1 else 400)


def _invalid(request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, RequestValidationError)  # noqa: S101 - the table says so
    words = "; ".join(f"{'.'.join(map(str, one['loc']))}: {one['msg']}" for one in error.errors())
    return JSONResponse({"error": words, "option": None, "exit": 2}, 400)


def _http(request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, HTTPException)  # noqa: S101 - the table says so
    return JSONResponse({"error": str(error.detail), "option": None, "exit": 2}, error.status_code)


def _defect(request: Request, error: Exception) -> JSONResponse:
    return JSONResponse(problem_of(error), 500)


ANSWERS: dict[Any, Any] = {
    AllaniteError: _refused, ProblemError: _problem, RequestValidationError: _invalid, HTTPException: _http,
    Exception: _defect,
}  # fmt: skip
"""Kind of an error: what is answered."""
