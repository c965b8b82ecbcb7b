"""Executors: one function applied to many items, in this process or in several, each result as soon as it is known."""

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass
from functools import partial
from multiprocessing.connection import Connection
from typing import Any, NamedTuple, Protocol

from allanite.core.errors import UsageError
from allanite.parallel.futures import later
from allanite.parallel.processes import ANSWER, EndedError, Process, ready_context

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
        return (attempt(task, item) for item in items)


def attempt(task: Task, item: Plain) -> Done:
    """What becomes of an item."""
    try:
        return Done(item, task(item))
    except Exception as error:  # noqa: BLE001, RUF100 - becomes the error of this item, which is named
        return Done(item, error=described(error))


def described(error: BaseException) -> str:
    """An unexpected exception as a sentence."""
    if isinstance(error, MemoryError):
        return "not enough memory; use fewer workers, or read fewer channels"
    return f"internal error ({type(error).__name__}: {error})"


@dataclass(frozen=True)
class Processes:
    """Several processes of this machine, one item each at a time.

    A process that is killed is replaced. Its item is tried once more, and then reported as failed; other items are not
    affected. The processes import the main module anew: a script that uses them needs ``if __name__ == "__main__":``.
    """

    workers: int  # number of processes, at least 1

    def __post_init__(self) -> None:
        if self.workers < 1:
            raise UsageError(f"the number of workers must be at least 1, not {self.workers}")

    def run(self, task: Task, items: Sequence[Plain]) -> Iterator[Done]:
        """Apply `task` to every item in the order in which they are finished; see `Executor`."""
        context = ready_context("allanite.batch.warm")
        waiting = deque((item, True) for item in items)
        idle: list[Process] = []
        busy: dict[Future[Done], tuple[Process, Plain, bool]] = {}
        try:
            while waiting or busy:
                while waiting and len(busy) < self.workers:
                    item, first = waiting.popleft()
                    idle = [process for process in idle if process.alive]
                    process = idle.pop() if idle else Process(context, _serve, task)
                    busy[later(partial(process.request, item))] = process, item, first
                for future in wait(busy, return_when=FIRST_COMPLETED).done:
                    process, item, first = busy.pop(future)
                    try:
                        done = future.result()
                    except EndedError:
                        if first:
                            waiting.append((item, False))
                        else:
                            code = process.code
                            how = f"was killed by signal {-code}" if code < 0 else f"ended with exit code {code}"
                            yield Done(item, error=f"the process that analyzed it {how}, twice; is there enough memory "
                                       "for so many workers?")  # fmt: skip
                    else:
                        idle.append(process)
                        yield done
        finally:
            for process in (*idle, *(process for process, _, _ in busy.values())):
                process.end()


def _serve(connection: Connection, task: Task) -> None:
    """The work of a process: items come and results go."""
    while True:
        connection.send((ANSWER, attempt(task, connection.recv())))
