"""Routes of workspaces and their files."""

import os
import secrets
from importlib.resources import files
from typing import Any

from fastapi import Request
from starlette.concurrency import run_in_threadpool
from starlette.responses import Response

from allanite.core.errors import DataError
from allanite.core.names import demand_name

from .messages import body_of
from .store import CHOICES, MissingError, Store, shown


def menus(request: Request, lang: str = "") -> dict[str, Any]:
    """The menus, and what the page opens with."""
    from .tables import tables

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
    return {
        "id": state["id"],
        "files": list(map(_shown, state["files"].values())),
        "jobs": list(state["jobs"].values()),
        "choices": state["choices"],
    }


def drop_workspace(request: Request, name: str) -> dict[str, Any]:
    """Delete a workspace."""
    request.app.state.jobs.workers.end(f"{name} main")
    request.app.state.store.remove(name)
    return {}


async def choices(request: Request, name: str) -> dict[str, Any]:
    """Keep what the client wants to find again."""
    found = await body_of(request, CHOICES)
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
    path = str((await body_of(request)).get("path") or "")
    return _shown(open_file(request.app.state.store, name, path))


def open_file(store: Store, workspace: str, path: str) -> dict[str, Any]:
    """Enter a file of this machine by its path."""
    where = os.path.abspath(os.path.expanduser(path))
    if not path or not os.path.isfile(where):
        raise DataError(f"there is no file {path!r}; give its path on this machine")
    size = os.path.getsize(where)
    own = f"{workspace}-{secrets.token_hex(8)}"
    return store.add({"id": own, "name": shown(path), "bytes": size, "path": where, "own": False})


async def example(request: Request, name: str) -> dict[str, Any]:
    """Simulate a recording to play with."""
    from .tables import EXAMPLES, simulation

    which = str((await body_of(request)).get("name") or next(iter(EXAMPLES)))
    demand_name("example", which, EXAMPLES)
    store, jobs = request.app.state.store, request.app.state.jobs
    file, path = store.new_file(name, f"example-{which}.npz")
    line = simulation(which, str(path))
    await run_in_threadpool(jobs.work, name, "example", line=line)
    return _shown(store.add(file | {"bytes": path.stat().st_size}))


def _shown(file: dict[str, Any]) -> dict[str, Any]:
    """A file as the page shows it; where an upload is kept is not said."""
    return {key: file[key] for key in ("id", "name", "bytes", *(() if file["own"] else ("path",)))}


def drop_file(request: Request, name: str, file: str) -> dict[str, Any]:
    """Delete a file of a workspace."""
    if file.partition("-")[0] != name:
        raise MissingError(f"there is no file {file!r} in this workspace")
    request.app.state.store.drop(file)
    return {}
