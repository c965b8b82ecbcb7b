"""Executors: one function applied to many items, in this process or in several, each result as soon as it is known."""

import multiprocessing
import signal
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Any, NamedTuple, Protocol

from allanite.core.errors import UsageError

Plain = dict[str, Any]
"""Plain data: what JSON can hold."""

Task = Callable[[Plain], Plain]
"""A function of a module, which another process can import; it raises only what is a defect."""


class Done(NamedTuple):
    """What became of an item: its result, or the reason why there is none."""

    item: Plain
    result: Plain | None = None
    error: str = ""


class Executor(Protocol):
    """Applies a task to items and yields what became of each, in the order in which they are finished."""

    def run(self, task: Task, items: Sequence[Plain]) -> Iterator[Done]:
        """Apply `task` to every item; an item that fails does not stop the others."""
        ...


@dataclass(frozen=True)
class Serial:
    """One item after the other, in this process."""

    def run(self, task: Task, items: Sequence[Plain]) -> Iterator[Done]:
        """Apply `task` to every item, in their order."""
        for item in items:
            yield Done(item, *attempt(task, item))


def attempt(task: Task, item: Plain) -> tuple[Plain | None, str]:
    """The result of a task, or the reason why there is none."""
    try:
        return task(item), ""
    except Exception as error:  # noqa: BLE001, RUF100 - becomes the error of this item, which is named
        return None, described(error)


def described(error: BaseException) -> str:
    """An unexpected exception as a sentence."""
    if isinstance(error, MemoryError):
        return "not enough memory; use fewer workers, or read fewer channels"
    return f"internal error ({type(error).__name__}: {error})"


class _Worker(NamedTuple):
    """A process with the item it was given, and whether this is its first attempt."""

    process: BaseProcess
    item: Plain
    first: bool


@dataclass(frozen=True)
class Processes:
    """Several processes of this machine, one item each at a time.

    A process that is killed is replaced. Its item is tried once more, and then reported as failed; other items are not
    affected. The processes import the main module anew: a script that uses them needs ``if __name__ == "__main__":``.

    Attributes
    ----------
    workers : int
        Number of processes, at least 1.
    """

    workers: int

    def __post_init__(self) -> None:
        if self.workers < 1:
            raise UsageError(f"the number of workers must be at least 1, not {self.workers}")

    def run(self, task: Task, items: Sequence[Plain]) -> Iterator[Done]:
        """Apply `task` to every item in the order in which they are finished; see `Executor`."""
        waiting = deque((item, True) for item in items)
        pool = _Pool(task)
        try:
            while waiting or pool.busy:
                while waiting and len(pool.busy) < self.workers:
                    pool.hand(*waiting.popleft())
                for worker, found in pool.finished():
                    if found is None and worker.first:
                        waiting.append((worker.item, False))
                    else:
                        yield Done(worker.item, *(found or (None, _end_of(worker.process))))
        finally:
            pool.end()


class _Pool:
    """Processes without an item, and those with one by their connection."""

    def __init__(self, task: Task) -> None:
        self.task = task
        self.idle: list[tuple[BaseProcess, Connection]] = []
        self.busy: dict[Connection, _Worker] = {}

    def hand(self, item: Plain, first: bool) -> None:
        """Give an item to a process that has none, or to a new one."""
        while True:
            process, connection = self.idle.pop() if self.idle else self._start()
            try:
                connection.send(item)
            except ConnectionError:  # it was killed while it had nothing to do
                process.join()
            else:
                self.busy[connection] = _Worker(process, item, first)
                return

    def finished(self) -> Iterator[tuple[_Worker, tuple[Plain | None, str] | None]]:
        """Wait for some processes; each with what it found, or None if it has ended."""
        for connection in [one for one in wait(list(self.busy)) if isinstance(one, Connection)]:
            worker = self.busy.pop(connection)
            try:
                found = connection.recv()
            except (EOFError, ConnectionError):
                worker.process.join()
                yield worker, None
            else:
                self.idle.append((worker.process, connection))
                yield worker, found

    def end(self) -> None:
        """Leave no process behind."""
        for connection, worker in self.busy.items():
            worker.process.terminate()
            self.idle.append((worker.process, connection))
        for process, connection in self.idle:
            connection.close()  # a process without an item ends by itself
            process.join()

    def _start(self) -> tuple[BaseProcess, Connection]:
        context = multiprocessing.get_context("spawn")  # a fork would inherit the locks of threads
        ours, theirs = context.Pipe()
        process = context.Process(target=_serve, args=(theirs, self.task))
        process.start()
        theirs.close()  # so that its end is noticed
        return process, ours


def _end_of(process: BaseProcess) -> str:
    """Why a process that was tried twice gave no result."""
    code = process.exitcode or 0
    how = f"was killed by signal {-code}" if code < 0 else f"ended with exit code {code}"
    return f"the process that analyzed it {how}, twice; is there enough memory for so many workers?"


def _serve(connection: Connection, task: Task) -> None:
    """The work of a process: items come and results go until the other end is closed, or its process has ended."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent ends its processes when it is interrupted
    with suppress(EOFError, ConnectionError):
        while True:
            connection.send(attempt(task, connection.recv()))
