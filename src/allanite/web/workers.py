"""Processes that work for the server: started from one that is ready, asked one thing at a time, ended at will."""

import multiprocessing
import os
import signal
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from allanite.core.errors import DataError
from allanite.phrases.wording import spelled

MOST = 4
"""Processes at once."""

Told = Callable[[str, dict[str, Any]], None]


class ProblemError(Exception):
    """A request was refused; `data` is what the page shows."""

    def __init__(self, data: dict[str, Any]) -> None:
        super().__init__(data["error"])
        self.data = data


class Worker:
    """A process with what it has read; `ask` waits until it is free."""

    def __init__(self) -> None:
        from . import worker

        context = _context()
        self.connection, theirs = context.Pipe()
        self.process = context.Process(target=worker.main, args=(theirs,))
        self.process.start()
        theirs.close()
        self.lock = threading.Lock()
        self.used = time.monotonic()
        self.jobs: set[str] = set()
        self.cancelled = False

    @property
    def alive(self) -> bool:
        """Whether it can be asked."""
        return bool(self.process.is_alive())

    def ask(self, task: str, arguments: dict[str, Any], *, told: tuple[Any, ...] = (),
            tell: Told = lambda kind, data: None) -> dict[str, Any]:  # fmt: skip
        """The answer to a request; `told` is what its errors are about, `tell` takes reports on the way.

        Raises
        ------
        ProblemError
            The request was refused.
        DataError
            The process has ended.
        """
        with self.lock:
            self.used = time.monotonic()
            try:
                self.connection.send((task, arguments, told))
                while True:
                    kind, data = self.connection.recv()
                    if kind == "answer":
                        return dict(data)
                    if kind == "problem":
                        raise ProblemError(data)
                    tell(kind, data)
            except (EOFError, OSError):
                self.process.join(1.0)
                raise DataError(self._end()) from None

    def _end(self) -> str:
        if self.cancelled:
            return "cancelled"
        code = self.process.exitcode
        how = f"by signal {-code}" if code is not None and code < 0 else f"with code {code}"
        remedy = spelled("--channels, --from, --until, --memory", "channels, start, until, memory")
        return (
            f"the process of this job was ended {how}, perhaps because memory was short: choose fewer channels or a "
            f"part of the record ({remedy})"
        )

    def interrupt(self) -> None:
        """End a stream, whose results are then computed."""
        if self.process.pid is not None:
            with suppress(ProcessLookupError):
                os.kill(self.process.pid, signal.SIGTERM)

    def end(self) -> None:
        """End the process and its forks."""
        pid = self.process.pid
        if pid is not None and self.alive and hasattr(os, "killpg"):
            with suppress(ProcessLookupError, PermissionError):
                if os.getpgid(pid) == pid:
                    os.killpg(pid, signal.SIGKILL)
        self.process.kill()
        self.process.join(2.0)


class Workers:
    """The workers of all workspaces: the one of a lane keeps what its jobs have read."""

    def __init__(self) -> None:
        self.lanes: dict[str, Worker] = {}
        self.lock = threading.Lock()

    def of(self, lane: str) -> Worker:
        """The worker of a lane, started if there is none."""
        with self.lock:
            found = self.lanes.get(lane)
            if found is not None and found.alive:
                return found
            self._retire()
            self.lanes[lane] = Worker()
            return self.lanes[lane]

    def _retire(self) -> None:
        """End the worker that was idle longest, if there are many."""
        self.lanes = {name: one for name, one in self.lanes.items() if one.alive}
        idle = sorted((one.used, name) for name, one in self.lanes.items() if not one.lock.locked())
        if len(self.lanes) >= MOST and idle:
            self.lanes.pop(idle[0][1]).end()

    def end(self, lane: str) -> None:
        """End the worker of a lane, if there is one."""
        with self.lock:
            found = self.lanes.pop(lane, None)
        if found is not None:
            found.cancelled = True
            found.end()

    def end_all(self) -> None:
        """End all of them."""
        for lane in list(self.lanes):
            self.end(lane)


def _context() -> Any:
    """Processes that are started clean: the server has threads, which must not be forked."""
    if sys.platform == "win32":
        return multiprocessing.get_context("spawn")
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["allanite.web.warm"])
    return context
