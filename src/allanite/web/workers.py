"""Processes that work for the server, started from one that is ready."""

import multiprocessing
import sys
import threading
import time
from typing import Any

from allanite.core.errors import DataError
from allanite.parallel.processes import EndedError, Process, Tell
from allanite.phrases.wording import spelled

MOST = 4
"""Processes at once."""

PROBLEM = "problem"
"""Kind of the message that a request was refused."""


class ProblemError(Exception):
    """A request was refused; `data` is what the page shows."""

    def __init__(self, data: dict[str, Any]) -> None:
        super().__init__(data["error"])
        self.data = data


class Worker(Process):
    """A process with what it has read; `ask` waits until it is free."""

    def __init__(self) -> None:
        from . import worker

        if sys.platform == "win32":
            context: Any = multiprocessing.get_context("spawn")
        else:  # started clean: the server has threads, which must not be forked
            context = multiprocessing.get_context("forkserver")
            context.set_forkserver_preload(["allanite.web.warm"])
        super().__init__(context, worker.main)
        self.lock = threading.Lock()
        self.used = time.monotonic()
        self.cancelled = False

    def ask(self, task: str, arguments: dict[str, Any], *, told: tuple[Any, ...] = (),
            tell: Tell = lambda kind, data: None) -> dict[str, Any]:  # fmt: skip
        """The answer to a request; `told` is what its errors are about, `tell` takes reports on the way.

        Raises
        ------
        ProblemError
            The request was refused.
        DataError
            The process has ended.
        """

        def report(kind: str, data: dict[str, Any]) -> None:
            if kind == PROBLEM:
                raise ProblemError(data)
            tell(kind, data)

        with self.lock:
            self.used = time.monotonic()
            try:
                return dict(self.request((task, arguments, told), report))
            except EndedError:
                if self.cancelled:
                    raise DataError("cancelled") from None
                how = f"by signal {-self.code}" if self.code < 0 else f"with code {self.code}"
                remedy = spelled("--channels, --from, --until, --memory", "channels, start, until, memory")
                raise DataError(
                    f"the process of this job was ended {how}, perhaps because memory was short: choose fewer channels "
                    f"or a part of the record ({remedy})"
                ) from None


class Workers:
    """The workers of all workspaces: the one of a lane keeps what its jobs have read."""

    def __init__(self) -> None:
        self.lanes: dict[str, Worker] = {}
        self.lock = threading.Lock()

    def of(self, lane: str) -> Worker:
        """The worker of a lane, started if there is none."""
        with self.lock:
            self.lanes = {name: worker for name, worker in self.lanes.items() if worker.alive}
            if lane not in self.lanes:
                idle = sorted((worker.used, name) for name, worker in self.lanes.items() if not worker.lock.locked())
                if len(self.lanes) >= MOST and idle:  # the one that was idle longest
                    self.lanes.pop(idle[0][1]).end()
                self.lanes[lane] = Worker()
            return self.lanes[lane]

    def end(self, lane: str) -> None:
        """End the worker of a lane, if there is one."""
        with self.lock:
            worker = self.lanes.pop(lane, None)
        if worker is not None:
            worker.cancelled = True
            worker.end()

    def end_all(self) -> None:
        """End all of them."""
        for lane in list(self.lanes):
            self.end(lane)
