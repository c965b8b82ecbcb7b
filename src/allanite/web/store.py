"""What is kept on this disk: workspaces with their files, jobs and choices, in a folder of this user alone."""

import json
import os
import re
import secrets
import shutil
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from allanite.cli.streams import complain
from allanite.core.errors import DataError, UsageError
from allanite.core.files import DRAFTS, reason, write
from allanite.phrases.phrase import spelled, visible
from allanite.readers.parts import size_in_words

from . import schema

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
    """Workspaces below a folder."""

    def __init__(self, folder: Path, *, limit: int, quota: int) -> None:
        self.folder, self.limit, self.quota = folder, limit, quota
        self.lock = threading.RLock()
        self.states: dict[str, State] = {}
        self.notes: list[str] = []  # what was found damaged
        self.stored, self.coming = 0, dict[str, int]()  # bytes, and those reserved for files that are being written
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        folder.chmod(0o700)

    def all(self) -> list[State]:
        """Every workspace, the last one first; a damaged one is left out, and noted."""
        paths = [path for path in self._places() if (path / "state.json").is_file()]
        paths.sort(key=lambda path: (path / "state.json").stat().st_mtime, reverse=True)
        return [state for path in paths if (state := self.find(path.name)) is not None]

    def aside(self) -> list[State]:
        """Workspaces that cannot be read, and the bytes that they take: their uploads are still on the disk."""
        with self.lock:
            lost = [path for path in self._places() if not self.find(path.name)]
            return [{"id": path.name, "bytes": self._taken(path)} for path in lost]

    def _places(self) -> list[Path]:
        return [path for path in self.folder.iterdir() if _ID.fullmatch(path.name) and path.is_dir()]

    def clear(self) -> None:
        """Remove what interrupted uploads and jobs have left; for the only server of this folder."""
        for place in self._places():
            aside, own = place / f"state.json{schema.ASIDE}", place / "state.json"
            if aside.exists() and not own.exists():  # this version may read it, or it was mended
                aside.rename(own)
        for state in self.all():
            for path in (self.folder / state["id"]).iterdir():
                name = f"{state['id']}-{path.name.partition('.')[0]}"
                if _ID.match(path.name) and name not in state["files"] and name not in state["jobs"]:
                    removed(path)
        for path in (*self.folder.rglob(DRAFTS), *self.folder.glob("*/*/trace.part")):
            removed(path)

    def new(self) -> State:
        """A workspace."""
        name = secrets.token_hex(8)
        state: State = {"id": name, "files": {}, "jobs": {}, "choices": {}}
        with self.lock:
            (self.folder / name).mkdir(mode=0o700)
            self.states[name] = state
            try:
                self.save(state)
            except FullError:
                self.remove(name)
                raise
        return state

    def state(self, name: str) -> State:
        """The state of a workspace."""
        state = self.find(known(name))
        if state is None:
            raise MissingError(f"there is no workspace {name!r}; reload the page to begin a new one")
        return state

    def find(self, name: str) -> State | None:
        """The state of a workspace; None if there is none that can be read."""
        with self.lock:
            if name not in self.states:
                state = self.kept(self.folder / name / "state.json", schema.workspace(name))
                if state is None:
                    return None
                self.states[name] = state
            return self.states[name]

    def kept(self, path: Path, form: Any) -> Any:
        """What a file holds, by its schema; None if there is none, or if it was damaged, which is noted."""
        return schema.kept(path, form, self._note)

    def _note(self, words: str) -> None:
        if words not in self.notes:
            self.notes.append(words)
            complain(words)

    @contextmanager
    def changed(self, name: str) -> Iterator[State]:
        """The state of a workspace, saved afterwards; what cannot be saved is not entered."""
        with self.lock:
            state = self.state(name)
            before = {key: dict(state[key]) for key in ("files", "jobs", "choices")}
            try:
                yield state
                self.save(state)
            except BaseException:
                state.update(before)
                raise

    def save(self, state: State) -> None:
        """Write a state."""
        self.put(self.folder / state["id"] / "state.json", json.dumps(state).encode())

    @staticmethod
    def put(path: Path, data: bytes) -> None:
        """Write a file of the page, atomically."""
        try:
            write(path, data, force=True)
        except UsageError as error:  # which names another path as the remedy
            raise FullError(f"{str(error).partition(';')[0]}; make room on the disk, and see that the folder of the "
                            "page can be written") from None  # fmt: skip

    def remove(self, name: str) -> None:
        """Delete a workspace, also one that cannot be read."""
        with self.lock:
            if not (place := self.folder / known(name)).is_dir():
                self.state(name)
            self.states.pop(name, None)
            removed(place)

    def file(self, name: str) -> State:
        """A file by its id."""
        workspace = name.partition("-")[0]
        file: State | None = self.state(known(workspace))["files"].get(name)
        if file is None:
            raise MissingError(f"there is no file {name!r} in this workspace; upload it again")
        return file

    def place(self, name: str) -> Path:
        """The folder of a file, made if it is missing."""
        workspace, _, own = name.partition("-")
        path = self.folder / known(workspace) / known(own)
        path.mkdir(mode=0o700, exist_ok=True)
        return path

    @contextmanager
    def arriving(self, workspace: str, name: str) -> Iterator[tuple[State, Path]]:
        """A file that is being written, and where; it is entered afterwards, or nothing of it stays."""
        self.state(workspace)
        own = f"{workspace}-{secrets.token_hex(8)}"
        suffix = _SUFFIX.search(name)
        path = self.place(own) / f"data{suffix[0].lower() if suffix else ''}"
        file: State = {"id": own, "name": shown(name), "bytes": 0, "path": str(path), "own": True}
        self.coming[own] = 0
        try:
            yield file, path
            with self.lock:
                self.add(file)
                self.stored += file["bytes"]
        except BaseException as error:
            shutil.rmtree(path.parent, ignore_errors=True)
            if isinstance(error, OSError):
                raise FullError(f"the file cannot be stored ({reason(error)}); make room on the disk") from None
            raise
        finally:
            del self.coming[own]

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
            removed(self.place(name))

    def measure(self) -> None:
        """Look how many bytes all workspaces take, without what is being written."""
        with self.lock:
            self.stored = self._taken(self.folder)

    def _taken(self, place: Path) -> int:
        """Bytes of the files below a folder, without what is being written."""
        taken = 0
        for folder, _, names in os.walk(place):
            for name in names if "-".join(Path(folder).parts[-2:]) not in self.coming else ():
                with suppress(FileNotFoundError):  # drafts come and go
                    taken += os.lstat(os.path.join(folder, name)).st_size
        return taken

    def room(self) -> int:
        """Bytes that the quota has room for."""
        with self.lock:
            self.measure()
            return self.quota - self.stored - sum(self.coming.values())

    def reserve(self, file: State, size: int, *, upload: bool = True) -> None:
        """Reserve bytes for a file that is being written, or refuse it: it is too large, or there is no room."""
        if upload and size > self.limit:
            raise FullError(f"the file is larger than {size_in_words(self.limit)}, the limit of an upload: open it by "
                            f"its path, or raise the limit with {spelled('--limit', 'limit')}",
                            choice="limit")  # fmt: skip
        with self.lock:
            if self.stored + sum(self.coming.values()) + max(0, size - self.coming[file["id"]]) > self.quota:
                raise overfull(self.quota, "open the file by its path, " if upload else "")
            self.coming[file["id"]] = max(size, self.coming[file["id"]])


def overfull(quota: int, remedy: str = "") -> FullError:
    """The error where the files of the page would take more than these bytes."""
    return FullError(f"the files of the page would take more than {size_in_words(quota)}: delete some of them, "
                     f"{remedy}or allow more with {spelled('--quota', 'quota')}", choice="quota")  # fmt: skip


class MissingError(UsageError):
    """There is no such workspace, file or job."""


def removed(path: Path) -> None:
    """Delete a file, a folder with what it holds, or a link."""
    shutil.rmtree(path) if path.is_dir() and not path.is_symlink() else path.unlink(missing_ok=True)


def known(name: str) -> str:
    """An id, as they are made here: never a path."""
    if not _ID.fullmatch(name):
        raise MissingError(f"{name!r} is not an id")
    return name


def shown(name: str) -> str:
    """The name of a file as it is shown: without folders and control characters."""
    return visible(name.replace("\\", "/").rpartition("/")[2])[:200] or "recording"
