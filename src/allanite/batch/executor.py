"""Executors: one function applied to many items, in this process, in several, or by the workers of a scheduler."""

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from multiprocessing.connection import Connection
from queue import Empty, SimpleQueue
from typing import Any, NamedTuple, Protocol

from allanite.core.errors import UsageError, demand_extra
from allanite.parallel.processes import ANSWER, EndedError, Process, later, ready_context

Plain = dict[str, Any]  # plain data: what JSON can hold

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
    """Several processes of this machine, one item each at a time."""

    # A process that is killed is replaced. Its item is tried once more, and then reported as failed; other items are
    # not affected. The processes import the main module anew: a script that uses them needs if __name__ == "__main__":
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


PATIENCE = 10  # seconds in which a scheduler must answer, and in which it must have a worker

SAME = ("python", "allanite", "numpy", "scipy", "numba")
"""What the numbers depend on: its version must be the same on all workers."""


@dataclass(frozen=True)
class Dask:
    """The workers of a Dask scheduler, which see the files by the same paths and have the same version of allanite."""

    # another worker takes over from one that is lost; a file that has cost several workers is reported as failed
    address: str  # of the scheduler: ``tcp://10.0.0.5:8786``

    def run(self, task: Task, items: Sequence[Plain]) -> Iterator[Done]:
        """Apply `task` to every item in the order in which they are finished; see `Executor`."""
        demand_extra("dask", "distributed", what="a scheduler")
        distributed = import_module("distributed")
        try:
            client = distributed.Client(self.address, timeout=PATIENCE)
        except (OSError, ValueError) as error:
            raise UsageError(f"the Dask scheduler {self.address!r} does not answer ({error}); start "
                             f"one with 'dask scheduler' and workers with 'dask worker {self.address}', or check the "
                             "address") from None  # fmt: skip
        with client:
            self._demand_workers(client)
            given, ended = {client.submit(task, item, pure=False): item for item in items}, SimpleQueue[Any]()
            for future in given:
                future.add_done_callback(ended.put)
            while given:
                try:
                    future = ended.get(timeout=PATIENCE)
                except Empty:  # a long record, or nobody works on it
                    self._demand_workers(client)
                else:  # a result that nobody holds is forgotten by the workers, too
                    yield self._done(future, given.pop(future))

    def _done(self, future: Any, item: Plain) -> Done:
        """What became of an item whose future has ended."""
        if future.cancelled():
            raise UsageError(f"the Dask scheduler {self.address!r} ended before the work was done; start it again and "
                             "repeat the command: what is stored is not done again")  # fmt: skip
        problem = future.exception()
        if problem is None:
            return Done(item, future.result())
        if type(problem).__name__ == "KilledWorker":
            return Done(item, error="every worker that analyzed it was lost; is there memory for so many workers?")
        return Done(item, error=described(problem))

    def _demand_workers(self, client: Any) -> None:
        """Refuse a scheduler without workers, and workers of other versions than those of this process."""
        try:
            client.wait_for_workers(1, timeout=PATIENCE)
        except TimeoutError:
            raise UsageError(f"the Dask scheduler {self.address!r} has no worker; start some "
                             f"with 'dask worker {self.address}' and repeat the command: what is stored is not done "
                             "again") from None  # fmt: skip
        versions = client.get_versions(packages=SAME[1:])
        here, wrong = _versions(versions["client"]), []
        for worker, each in sorted(versions["workers"].items()):
            other = [f"{name} {has} instead of {here[name]}"
                     for name, has in _versions(each).items() if has != here[name]]  # fmt: skip
            wrong += [f"{worker} has {', '.join(other)}"] if other else []
        if wrong:
            more = f" (and {len(wrong) - 3} more)" if len(wrong) > 3 else ""
            raise UsageError(f"the Dask workers have other versions than this computer: {'; '.join(wrong[:3])}{more}; "
                             "install the same versions everywhere and start the workers again")  # fmt: skip


def _versions(seen: Any) -> dict[str, str]:
    """Versions of what must be the same; of Python the first two numbers."""
    packages = seen["packages"] | {"python": ".".join(seen["packages"]["python"].split(".")[:2])}
    return {name: packages[name] or "(missing)" for name in SAME}
