"""The server: on this machine alone, until Ctrl-C; who may come in, its routes, and what is answered to errors."""

import asyncio
import hmac
import http.client
import json
import logging
import secrets
import socket
import sys
import threading
import time
import webbrowser
from collections.abc import Awaitable, Callable, MutableMapping, Sequence
from contextlib import closing
from importlib.resources import files
from pathlib import Path
from typing import IO, Any

import uvicorn
from fastapi import FastAPI
from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import JSONResponse, PlainTextResponse
from starlette.staticfiles import StaticFiles

from allanite.cli.streams import show
from allanite.core.errors import UsageError
from allanite.core.files import draft, locked, reason
from allanite.phrases.phrase import command_line, spelled
from allanite.reporting.language import catalogue

from . import routes
from .jobs import Jobs
from .routes import ANSWERED, MAX_ACCEPTED, Answer, PromptProtocol, answered, open_file, sought
from .store import MissingError, Store, private_folder

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
Application = Callable[[Scope, Receive, Send], Awaitable[None]]

SAFE = ("GET", "HEAD")  # methods that change nothing; every other request must say that it comes from this page

EMPTY_STYLE = "'sha256-47DEQpj8HBSa+/TImW+5JCeuQeRkm5NMpJWZG3hSuFU='"
"""Hash of the empty style sheet that the charts make and then fill by rules."""

HEADERS = {
    "Content-Security-Policy": f"default-src 'self'; style-src 'self' {EMPTY_STYLE}; img-src 'self' data: blob:; "
    "object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff", "X-Frame-Options": "DENY", "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin", "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}  # fmt: skip
"""Headers of every answer."""

ENTRY = "/api/enter"  # where the token of a link is exchanged for the secret

MAX_LINKS, MAX_LINK_AGE_S = 16, 3600.0
"""Links that can be open at once, the newest ones, and seconds until one is too old."""


class Door:
    """Refuses requests of other hosts, of other pages, and to the API without the secret of this start."""

    def __init__(self, inside: Application, *, port: int, clock: Callable[[], float] = time.monotonic) -> None:
        self.inside, self.port, self.clock = inside, port, clock
        # it comes in a header, which no browser adds by itself: a cookie would be sent to every port of this machine
        self.secret = secrets.token_urlsafe(32)
        self.tokens = dict[str, float]()
        self.hosts = {f"{name}:{port}" for name in ("127.0.0.1", "localhost")}

    def link(self) -> str:
        """A link that opens the page once; its token is in the fragment, which is in no request and no referrer."""
        token = secrets.token_urlsafe(24)
        newest = list(self._valid().items())[1 - MAX_LINKS :]
        self.tokens = {**dict(newest), token: self.clock() + MAX_LINK_AGE_S}
        return f"http://127.0.0.1:{self.port}/#token={token}"

    def _valid(self) -> dict[str, float]:
        return {token: end for token, end in self.tokens.items() if end > self.clock()}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let a request in, or answer it here."""
        if scope["type"] != "http":
            if scope["type"] == "lifespan":
                await self.inside(scope, receive, send)
            return

        begun = False

        async def closed(message: MutableMapping[str, Any]) -> None:
            nonlocal begun
            if message["type"] == "http.response.start":
                begun = True
                headers = MutableHeaders(scope=message)
                for name, value in HEADERS.items():
                    headers[name] = value
            await send(message)

        answer = self._answer(scope)
        try:
            with command_line():  # messages name options, as controls are called by them
                await (answer or self.inside)(scope, receive, closed)
        except asyncio.CancelledError:
            if begun:
                raise
            await _refusal("the server was ended: run allanite serve again", 503)(scope, receive, closed)

    def _answer(self, scope: Scope) -> Application | None:
        """The answer to a request that does not come in."""
        headers = Headers(scope=scope)
        if headers.get("host", "") not in self.hosts:
            return PlainTextResponse("this server answers at 127.0.0.1 only", 421)
        if scope["method"] not in SAFE and headers.get("origin", "") not in {f"http://{host}" for host in self.hosts}:
            return _refusal("the request comes from another page", 403)
        if not scope["path"].startswith("/api/"):
            return None
        given = headers.get("authorization", "").removeprefix("Bearer ").encode()
        if scope["path"] == ENTRY and scope["method"] == "POST":
            return self._entered(given)
        if not hmac.compare_digest(given, self.secret.encode()):
            return _refusal("open the link that allanite serve prints; run it once more for a new one", 401)
        return None

    def _entered(self, given: bytes) -> Application:
        self.tokens = self._valid()
        token = next((token for token in self.tokens if hmac.compare_digest(given, token.encode())), None)
        if token is None:
            return _refusal("this link was used already, or is too old: run allanite serve once more for another", 403)
        del self.tokens[token]
        return JSONResponse({"secret": self.secret})


def _refusal(words: str, status: int) -> JSONResponse:
    return JSONResponse({"error": words, "option": None, "exit": 2}, status)


def application(store: Store, jobs: Jobs, first: dict[str, Any]) -> FastAPI:
    """The application behind the door; `first` is what the page opens with: workspace and language."""
    # nothing is reported anywhere, whatever the environment asks for
    app = FastAPI(docs_url=None, redoc_url=None, openapi_url=None, redirect_slashes=False,
                  telemetry={"auto_configure": False}, default_response_class=Answer)  # fmt: skip
    app.state.store, app.state.jobs, app.state.first = store, jobs, first
    for kind in ANSWERED:
        app.add_exception_handler(kind, answered)
    for path, (method, endpoint) in ROUTES.items():
        app.add_api_route(path.partition(" ")[2], endpoint, methods=[method], response_model=None)
    app.mount("/", StaticFiles(directory=str(files("allanite.web") / "static"), html=True))
    return app


def nowhere(rest: str) -> None:
    """Whatever else begins like a route is none: it never names a file."""
    raise MissingError(f"there is no route {rest!r}")


ROUTES: dict[str, tuple[str, Any]] = {
    "get /api/tables": ("GET", routes.menus), "get /report.css": ("GET", routes.style),
    "post /api/link": ("POST", routes.link), "get /api/workspaces": ("GET", routes.workspaces),
    "post /api/workspaces": ("POST", routes.new_workspace), "get /api/workspaces/{name}": ("GET", routes.workspace),
    "delete /api/workspaces/{name}": ("DELETE", routes.drop_workspace),
    "put /api/workspaces/{name}/choices": ("PUT", routes.choices),
    "post /api/workspaces/{name}/files": ("POST", routes.upload),
    "delete /api/workspaces/{name}/files/{file}": ("DELETE", routes.drop_file),
    "post /api/workspaces/{name}/open": ("POST", routes.opened),
    "post /api/workspaces/{name}/example": ("POST", routes.example),
    "post /api/workspaces/{name}/jobs": ("POST", routes.begin), "get /api/jobs/{name}": ("GET", routes.job),
    "get /api/jobs/{name}/events": ("GET", routes.events), "post /api/jobs/{name}/cancel": ("POST", routes.cancel),
    "get /api/files/{file}/trace": ("GET", routes.traced), "get /api/jobs/{name}/deviation": ("GET", routes.deviation),
    "post /api/jobs/{name}/refit": ("POST", routes.refit), "post /api/jobs/{name}/export": ("POST", routes.export),
    "get /api/jobs/{name}/save": ("GET", routes.save), "get /api/{rest:path}": ("GET", nowhere),
}  # fmt: skip
"""Method and path of each route: its function."""

HOST = "127.0.0.1"  # the address: nobody on another machine can reach it

LOCK, ADDRESS = ".lock", "address"
"""Files of the folder: one that the only server of it has locked, and port and secret of that, for its user alone."""

ANSWER_TIMEOUT_S = 5.0  # seconds in which the server that runs already answers


def serve(paths: Sequence[str], *, port: int, browser: bool, lang: str, limit: int, quota: int) -> None:
    """Serve the page until it is interrupted."""
    catalogue(lang)
    paths = [sought(path) for path in paths]
    try:
        folder = private_folder()
    except RuntimeError as error:
        raise UsageError(f"the folder for the files of the page is unknown ({error}); set HOME") from None
    try:
        store = Store(folder, limit=limit, quota=quota)
        held = _lock(folder)
        if held is not None:
            store.clear()
    except OSError as error:
        raise UsageError(f"{str(error.filename or folder)!r} cannot be used ({reason(error)}); remove it, or make it "
                         f"writable: the page keeps its files in {str(folder)!r}") from None  # fmt: skip
    if held is None:
        link = joined(store, paths)
        _announce(link, "a server of yours runs already, with options of its own")
        if browser:
            webbrowser.open(link)
        return
    with held:
        _serve(store, paths, port, browser, lang)


def _lock(folder: Path) -> IO[bytes] | None:
    """The lock of the only server of a folder, without the address of the one before it; None if another has it."""
    path = folder / LOCK
    held = locked(path)
    if held is not None:
        try:
            (folder / ADDRESS).unlink(missing_ok=True)
        except OSError:
            held.close()
            raise
    return held


def _serve(store: Store, paths: Sequence[str], port: int, browser: bool, lang: str) -> None:
    listener = listen(port)
    port = listener.getsockname()[1]
    jobs = Jobs(store)
    first: dict[str, Any] = {"lang": lang, "workspace": None}
    if paths:
        first["workspace"] = store.new()["id"]
        for path in paths:
            open_file(store, first["workspace"], path)
    app = application(store, jobs, first)
    door = app.state.door = Door(app, port=port)
    server = uvicorn.Server(
        uvicorn.Config(door, http=PromptProtocol, ws="none", log_level="error", access_log=False, lifespan="off",
                       backlog=MAX_ACCEPTED, timeout_graceful_shutdown=1, server_header=False)
    )  # fmt: skip
    # what is broken off by the end is no error
    logging.getLogger("uvicorn.error").addFilter(lambda record: not server.should_exit)
    with draft(store.folder / ADDRESS, force=True) as part:
        part.chmod(0o600)
        part.write_text(json.dumps({"port": port, "secret": door.secret}), "ascii")
    link = door.link()
    _announce(link, "Ctrl-C ends the server")
    if browser:
        threading.Thread(target=webbrowser.open, args=(link,), daemon=True).start()
    try:
        jobs.warm()
        server.run(sockets=[listener])
    finally:
        listener.close()
        (store.folder / ADDRESS).unlink(missing_ok=True)
        jobs.close()


def _announce(link: str, words: str) -> None:
    show(link, f"open this link, once; {words}")


def joined(store: Store, paths: Sequence[str]) -> str:
    """A link to the server that has locked the folder, where these files are opened."""
    until = time.monotonic() + ANSWER_TIMEOUT_S
    while time.monotonic() < until:
        try:
            address = json.loads((store.folder / ADDRESS).read_text("ascii"))
            place = _asked(address, "workspaces", {})["id"] if paths else ""
            for path in paths:
                _asked(address, f"workspaces/{place}/open", {"path": path})
            link: str = _asked(address, "link", {})["link"]
            return f"{link}&workspace={place}" if place else link
        except UsageError:
            raise
        except (OSError, ValueError, http.client.HTTPException):  # it is just starting
            time.sleep(0.1)
    words = "does not answer; end it first"
    raise UsageError(f"another server of yours keeps its files in {str(store.folder)!r} and {words}")


def _asked(address: dict[str, Any], path: str, body: dict[str, str]) -> Any:
    host = f"{HOST}:{address['port']}"
    headers = {"Origin": f"http://{host}", "Authorization": f"Bearer {address['secret']}"}
    with closing(http.client.HTTPConnection(host, timeout=ANSWER_TIMEOUT_S)) as connection:
        connection.request("POST", f"/api/{path}", json.dumps(body), headers)
        answer = connection.getresponse()
        data = json.loads(answer.read())
    if answer.status >= 400:
        raise UsageError(data["error"])
    return data


def listen(port: int) -> socket.socket:
    """A socket at a port of this machine."""
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    if sys.platform != "win32":
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind((HOST, port))
        listener.listen(MAX_ACCEPTED)
    except OSError as error:
        listener.close()
        words = f"{port} cannot be used ({error.strerror}); give another, or 0 for any that is free"
        raise UsageError(f"{spelled('--port', 'port')} {words}") from None
    return listener
