"""Routes of workspaces and their files."""

import os
import secrets
from importlib.resources import files
from typing import Any

from fastapi import Request
from starlette.concurrency import run_in_threadpool
from starlette.responses import Response

from allanite.core.errors import DataError
from allanite.core.files import encoded
from allanite.core.names import demand_name

from .messages import body_of
from .schema import ExampleBody, Lang, PathBody
from .store import MissingError, Store, shown


def menus(request: Request, lang: Lang = "") -> dict[str, Any]:
    """The menus, and what the page opens with."""
    from .tables import tables

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
    request.app.state.jobs.forget(name)
    request.app.state.store.remove(name)
    return {}


async def choices(request: Request, name: str) -> dict[str, Any]:
    """Keep what the client wants to find again."""
    found = await body_of(request, dict[str, Any])
    with request.app.state.store.changed(name) as state:
        state["choices"] = found
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


def open_file(store: Store, workspace: str, path: str) -> dict[str, Any]:
    """Enter a file of this machine by its path."""
    where = os.path.abspath(os.path.expanduser(path))
    if not path or not os.path.isfile(where):
        raise DataError(f"there is no file {path!r}; give its path on this machine")
    if encoded(where) != os.fsencode(where):
        raise DataError(f"the path {where!r} is not UTF-8, which the page needs: rename the file or its folder")
    size = os.path.getsize(where)
    own = f"{workspace}-{secrets.token_hex(8)}"
    return store.add({"id": own, "name": shown(path), "bytes": size, "path": where, "own": False})


async def example(request: Request, name: str) -> dict[str, Any]:
    """Simulate a recording to play with."""
    from .tables import EXAMPLES, simulation

    which = (await body_of(request, ExampleBody)).name or next(iter(EXAMPLES))
    demand_name("example", which, EXAMPLES)
    store, jobs = request.app.state.store, request.app.state.jobs
    await run_in_threadpool(store.measure)
    with store.arriving(name, f"example-{which}.npz") as (file, path):
        await jobs.work(name, "example", line=simulation(which, str(path)))
        file["bytes"] = path.stat().st_size
        store.reserve(file, file["bytes"])
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
