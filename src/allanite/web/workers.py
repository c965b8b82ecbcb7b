"""Processes that work for the server, started from one that is ready; who asks one waits for a future, not a thread."""

import threading
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from contextvars import copy_context
from typing import Any, TypeVar

from allanite.core.errors import DataError
from allanite.parallel.processes import EndedError, Process, Tell, ready_context
from allanite.phrases.phrase import spelled

from .requests import PROBLEM
from .worker import main

MAX_PROCESSES = 4  # processes at once, unless more are busy

Result = TypeVar("Result")


class ProblemError(Exception):
    """A request was refused; `data` is what the page shows."""

    def __init__(self, data: dict[str, Any]) -> None:
        super().__init__(data["error"])
        self.data = data


class Worker:
    """A process with what it has read, started when it is first asked, and the thread in which it is asked in turn."""

    def __init__(self) -> None:
        self.turns = ThreadPoolExecutor(1)
        self.lock = threading.Lock()
        self.process: Process | None = None
        self.used, self.waiting, self.closed = time.monotonic(), 0, False

    def ask(self, task: str, arguments: dict[str, Any], tell: Tell = lambda kind, data: None,
            ended: Callable[[], bool] = lambda: False) -> dict[str, Any]:  # fmt: skip
        """The answer to a request; `tell` takes reports on the way, `ended` says whether it was cancelled meanwhile."""

        def report(kind: str, data: dict[str, Any]) -> None:
            if kind == PROBLEM:
                raise ProblemError(data)
            tell(kind, data)

        with self.lock:
            if self.closed or ended():
                raise DataError("cancelled")
            if self.process is None or not self.process.alive:
                self.process = Process(ready_context("allanite.web.warm"), main)
            process = self.process
        try:
            return dict(process.request((task, arguments), report))
        except EndedError:
            if self.closed or ended():
                raise DataError("cancelled") from None
            how = f"by signal {-process.code}" if process.code < 0 else f"with code {process.code}"
            remedy = spelled("--channels, --from, --until, --memory", "channels, start, until, memory")
            raise DataError(f"the process of this job was ended {how}, perhaps because memory was short: choose fewer "
                            f"channels or a part of the record ({remedy})", choice="channels") from None  # fmt: skip

    def end(self) -> None:
        """End the process; the next one that asks has a new one."""
        with self.lock:
            if self.process is not None:
                self.process.end()

    def close(self) -> None:
        """End the process for good; who waits for it is refused."""
        self.closed = True
        self.turns.shutdown(wait=False, cancel_futures=True)
        self.end()


class Workers:
    """The workers of all workspaces: the one of a lane keeps what its jobs have read."""

    def __init__(self) -> None:
        self.lanes: dict[str, Worker] = {}
        self.lock = threading.Lock()

    def submit(self, lane: str, work: Callable[[Worker], Result]) -> Future[Result]:
        """What is done with the worker of a lane, when it is its turn."""
        with self.lock:
            if lane not in self.lanes:
                idle = [(worker.used, name) for name, worker in self.lanes.items() if not worker.waiting]
                if len(self.lanes) >= MAX_PROCESSES and idle:  # the one that was idle longest
                    threading.Thread(target=self.lanes.pop(min(idle)[1]).close).start()
                self.lanes[lane] = Worker()
            worker = self.lanes[lane]
            worker.waiting += 1
            future = worker.turns.submit(copy_context().run, work, worker)
        future.add_done_callback(lambda _: self._done(worker))
        return future

    def _done(self, worker: Worker) -> None:
        with self.lock:
            worker.waiting -= 1
            worker.used = time.monotonic()

    def end(self, lane: str) -> None:
        """End what the worker of a lane does, if there is one."""
        with self.lock:
            worker = self.lanes.get(lane)
        if worker is not None:
            worker.end()

    def interrupt(self, lane: str) -> None:
        """Ask the worker of a lane to come to an end, if it works."""
        with self.lock:
            worker = self.lanes.get(lane)
        if worker is not None and worker.process is not None:
            worker.process.interrupt()

    def close(self, *lanes: str) -> None:
        """End workers for good, by default all."""
        with self.lock:
            closed = [self.lanes.pop(lane) for lane in lanes or list(self.lanes) if lane in self.lanes]
        for worker in closed:
            worker.close()
