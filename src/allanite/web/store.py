"""What is kept on this disk: workspaces with their files, jobs and choices, in a folder of this user alone."""

import json
import os
import re
import secrets
import shutil
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from allanite.core.errors import DataError, UsageError
from allanite.core.files import write
from allanite.phrases.wording import spelled
from allanite.readers.memory import size_in_words

DAYS = 30.0
"""Days after which a cookie is no longer valid."""

CHOICES = 1_000_000
"""Bytes of a client's own state at most."""

_SECRET = re.compile(rb"[A-Za-z0-9_-]{43}")
"""32 random bytes; what is left of an interrupted start is shorter."""

_ID = re.compile(r"[0-9a-f]{16}")
_SUFFIX = re.compile(r"(\.[A-Za-z0-9]{1,8}){1,2}$")

State = dict[str, Any]


def private_folder() -> Path:
    """The folder of this user's workspaces: within the cache folder of the system."""
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local"
    elif sys.platform == "darwin":
        base = Path.home() / "Library" / "Caches"
    else:
        base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "allanite" / "serve"


class FullError(DataError):
    """An upload is too large, or the disk quota is used up."""

    exit_code = 4


class Store:
    """Workspaces below a folder.

    Parameters
    ----------
    folder : path
        Made if it is missing, for this user only.
    limit, quota : int
        Bytes of an upload, and of all workspaces.
    """

    def __init__(self, folder: Path, *, limit: int, quota: int) -> None:
        self.folder, self.limit, self.quota = folder, limit, quota
        self.lock = threading.RLock()
        self.states: dict[str, State] = {}
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        folder.chmod(0o700)

    def session(self) -> str:
        """The value of the cookie: the same after a restart, for some weeks."""
        path = self.folder / "session"
        if path.is_file() and time.time() - path.stat().st_mtime < DAYS * 86400:
            kept = path.read_bytes()
            if _SECRET.fullmatch(kept):
                return kept.decode("ascii")
        made = secrets.token_urlsafe(32)
        write(path, made.encode("ascii"), force=True)  # whole or not at all
        path.chmod(0o600)  # before, the mode of the folder alone keeps others out
        return made

    def all(self) -> list[State]:
        """Every workspace, the last one first."""
        found = sorted(self.folder.glob("*/state.json"), key=lambda path: path.stat().st_mtime, reverse=True)
        return [self.state(path.parent.name) for path in found]

    def new(self) -> State:
        """A workspace."""
        name = secrets.token_hex(8)
        (self.folder / name).mkdir(mode=0o700)
        state: State = {"id": name, "files": {}, "jobs": {}, "choices": {}}
        with self.lock:
            self.states[name] = state
            self.save(state)
        return state

    def state(self, name: str) -> State:
        """The state of a workspace.

        Raises
        ------
        UsageError
            There is none.
        """
        with self.lock:
            if name not in self.states:
                path = self.folder / known(name) / "state.json"
                if not path.is_file():
                    raise MissingError(f"there is no workspace {name!r}; reload the page to begin a new one")
                self.states[name] = json.loads(path.read_text("utf-8"))
            return self.states[name]

    @contextmanager
    def changed(self, name: str) -> Iterator[State]:
        """The state of a workspace, saved afterwards."""
        with self.lock:
            state = self.state(name)
            yield state
            self.save(state)

    def save(self, state: State) -> None:
        """Write a state, atomically."""
        write(self.folder / state["id"] / "state.json", json.dumps(state).encode(), force=True)

    def remove(self, name: str) -> None:
        """Delete a workspace."""
        with self.lock:
            self.state(name)
            del self.states[name]
            shutil.rmtree(self.folder / known(name))

    def file(self, name: str) -> State:
        """A file by its id.

        Raises
        ------
        UsageError
            There is none.
        """
        workspace = name.partition("-")[0]
        found: State | None = self.state(known(workspace))["files"].get(name)
        if found is None:
            raise MissingError(f"there is no file {name!r} in this workspace; upload it again")
        return found

    def place(self, name: str) -> Path:
        """The folder of a file, made if it is missing."""
        workspace, _, own = name.partition("-")
        path = self.folder / known(workspace) / known(own)
        path.mkdir(mode=0o700, exist_ok=True)
        return path

    def new_file(self, workspace: str, name: str) -> tuple[State, Path]:
        """A file that is going to be written, and where; its suffix alone is that of its name."""
        self.state(workspace)
        own = f"{workspace}-{secrets.token_hex(8)}"
        suffix = _SUFFIX.search(name)
        path = self.place(own) / f"data{suffix[0].lower() if suffix else ''}"
        return {"id": own, "name": shown(name), "bytes": 0, "path": str(path), "own": True}, path

    def add(self, file: State) -> State:
        """Enter a file that was written."""
        with self.changed(file["id"].partition("-")[0]) as state:
            state["files"][file["id"]] = file
        return file

    def drop(self, name: str) -> None:
        """Delete a file of a workspace; a file that was opened where it is stays there."""
        self.file(name)
        with self.changed(name.partition("-")[0]) as state:
            del state["files"][name]
            shutil.rmtree(self.place(name))

    def used(self) -> int:
        """Bytes of all workspaces."""
        return sum(path.lstat().st_size for path in self.folder.rglob("*") if path.is_file())

    def demand_room(self, size: int, used: int) -> None:
        """Refuse an upload that is too large, or for which there is no room."""
        if size > self.limit:
            raise FullError(
                f"the file is larger than {size_in_words(self.limit)}, the limit of an upload: open it by its path, or "
                f"raise the limit with {spelled('--limit', 'limit')}",
                choice="limit",
            )
        if used + size > self.quota:
            raise FullError(
                f"the files of the page would take more than {size_in_words(self.quota)}: delete some of them, open "
                f"the file by its path, or allow more with {spelled('--quota', 'quota')}",
                choice="quota",
            )


class MissingError(UsageError):
    """There is no such workspace, file or job."""


def known(name: str) -> str:
    """An id, as they are made here: never a path."""
    if not _ID.fullmatch(name):
        raise MissingError(f"{name!r} is not an id")
    return name


def shown(name: str) -> str:
    """The name of a file as it is shown: without folders and control characters."""
    last = name.replace("\\", "/").rpartition("/")[2]
    clean = "".join(letter if letter.isprintable() else "\N{REPLACEMENT CHARACTER}" for letter in last)
    return clean[:200] or "recording"
