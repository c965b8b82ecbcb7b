"""The server: on this machine alone, until Ctrl-C."""

import secrets
import socket
import sys
import threading
import webbrowser
from collections.abc import Sequence
from typing import Any

import uvicorn

from allanite.core.errors import UsageError
from allanite.phrases.wording import spelled
from allanite.reporting.language import catalogue

from .access import Door
from .api import application
from .filing import open_file
from .jobs import Jobs
from .store import Store, private_folder

HOST = "127.0.0.1"
"""The address: nobody on another machine can reach it."""


def serve(paths: Sequence[str], *, port: int, browser: bool, lang: str, limit: int, quota: int) -> None:
    """Serve the page until it is interrupted.

    Parameters
    ----------
    paths : sequence of path
        Files to open.
    port : int
        0 for any that is free.
    browser : bool
        Whether to open the page in the browser.
    lang : str
        Language that the page begins with.
    limit, quota : int
        Bytes of an upload, and of all files that the page keeps.

    Raises
    ------
    UsageError
        The port is taken; the language is unknown.
    DataError
        A file does not exist.
    """
    catalogue(lang)
    listener = listen(port)
    port = listener.getsockname()[1]
    store = Store(private_folder(), limit=limit, quota=quota)
    jobs = Jobs(store)
    first: dict[str, Any] = {"lang": lang, "workspace": None}
    if paths:
        first["workspace"] = store.new()["id"]
        for path in paths:
            open_file(store, first["workspace"], path)
    token = secrets.token_urlsafe(24)
    door = Door(application(store, jobs, first), port=port, token=token, session=store.session())
    server = uvicorn.Server(
        uvicorn.Config(door, log_level="error", access_log=False, timeout_graceful_shutdown=1, lifespan="off",
                       server_header=False)
    )  # fmt: skip
    url = f"http://{HOST}:{port}/?token={token}"
    sys.stdout.write(f"{url}\nopen this link, once; Ctrl-C ends the server\n")
    sys.stdout.flush()
    if browser:
        threading.Thread(target=webbrowser.open, args=(url,), daemon=True).start()
    threading.Thread(target=jobs.warm, daemon=True).start()
    try:
        server.run(sockets=[listener])
    finally:
        jobs.workers.end_all()
        listener.close()


def listen(port: int) -> socket.socket:
    """A socket at a port of this machine."""
    found = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    if sys.platform != "win32":
        found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        found.bind((HOST, port))
        found.listen(128)
    except OSError as error:
        found.close()
        words = f"{port} cannot be used ({error.strerror}); give another, or 0 for any that is free"
        raise UsageError(f"{spelled('--port', 'port')} {words}") from None
    return found
