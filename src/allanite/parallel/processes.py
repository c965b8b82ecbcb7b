"""A process that is started by this one and asked one thing at a time; results of threads, as futures.

These threads end with the program, also while they compute. Those of `concurrent.futures.ThreadPoolExecutor` do not:
the program waits for them, so that a compiled loop could not be interrupted.

Those of `concurrent.futures.ProcessPoolExecutor` are not: one that is killed ends all of them, none can be ended while
it works or say how it ended, and they go on when the program is killed.
"""

import multiprocessing
import os
import signal
import sys
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import Future, wait
from contextlib import suppress
from contextvars import copy_context
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from threading import Thread
from typing import Any, TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")

DEPTH = 2  # items that may wait

_END: Any = object()


def later(function: Callable[[], Result]) -> Future[Result]:
    """The result of a function that another thread calls now, in the context of this one."""
    future: Future[Result] = Future()
    context = copy_context()

    def call() -> None:
        try:
            future.set_result(context.run(function))
        except BaseException as error:  # which is raised by who asks for the result
            future.set_exception(error)

    Thread(target=call, daemon=True).start()
    return future


def ahead(source: Iterator[Item]) -> Iterator[Item]:
    """The items of an iterator, which is asked for the next ones while the last one is used."""
    context = copy_context()
    waiting: deque[Future[Any]] = deque()

    def take_next() -> None:
        before = [*waiting][-1:]

        def take() -> Any:
            wait(before)
            return context.run(next, source, _END)

        waiting.append(later(take))

    try:
        for _ in range(DEPTH):
            take_next()
        while (item := waiting.popleft().result()) is not _END:
            take_next()
            yield item
    except GeneratorExit:  # nobody uses the others
        wait(waiting)
        if isinstance(source, Generator):
            source.close()
        raise


def spread(function: Callable[[Item], Result], items: Sequence[Item], threads: int) -> list[Result]:
    """``[function(item) for item in items]``, by so many threads, each item by who takes it first."""
    # Waiting for a thread is interrupted at once, a compiled loop is not: this thread only waits, also for a single
    # other one. What others compute is left to end with the program, and none takes another item.
    results: dict[int, Result] = {}
    indices = iter(range(len(items)))  # of which each is given once: a step of it is not divided between threads

    def work() -> None:
        try:
            for i in indices:
                results[i] = function(items[i])
        finally:
            deque(indices, maxlen=0)  # nobody goes on after an error

    try:
        done, _ = wait([later(work) for _ in range(min(threads, len(items)))])
    finally:
        deque(indices, maxlen=0)
    for future in done:
        future.result()
    return [results[i] for i in range(len(items))]


ANSWER = "answer"  # kind of the message that a process sends last; those of other kinds are reports on the way

Tell = Callable[[str, Any], None]


def ready_context(warm: str) -> Any:
    """Starts processes as forks of one that has imported a module and has no threads; on Windows, each anew."""
    if sys.platform == "win32":
        return multiprocessing.get_context("spawn")
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload([warm])
    return context


class EndedError(Exception):
    """A process ended before it had answered."""


class Process:
    """Another process, and this end of its pipe: it ends when nobody holds that any more, however this one ended."""

    def __init__(
        self, context: Any, work: Callable[..., None], *arguments: Any, others: Sequence["Process"] = ()
    ) -> None:
        self.connection, theirs = context.Pipe()
        fork = context.get_start_method() == "fork"
        ends = [each.connection for each in (self, *others)] if fork else []
        self.process: BaseProcess = context.Process(target=_begin, args=(theirs, ends, work, arguments), daemon=fork)
        self.process.start()
        theirs.close()  # so that its end is noticed

    @property
    def alive(self) -> bool:
        """Whether it can be asked."""
        return bool(self.process.is_alive())

    @property
    def code(self) -> int:
        """How it has ended: its exit code, or less than zero the signal that ended it."""
        return self.process.exitcode or 0

    def request(self, message: Any, tell: Tell = lambda kind, data: None) -> Any:
        """The answer to a request; `tell` takes kind and data of the reports on the way."""
        try:
            self.connection.send(message)
            while True:
                kind, data = self.connection.recv()
                if kind == ANSWER:
                    return data
                tell(kind, data)
        except (EOFError, OSError):
            self.process.join(1.0)
            raise EndedError from None

    def interrupt(self) -> None:
        """Ask it to come to an end, by SIGTERM."""
        if self.process.pid is not None:
            with suppress(ProcessLookupError):
                os.kill(self.process.pid, signal.SIGTERM)

    def end(self) -> None:
        """End it at once, and the processes that it has started if it leads their group."""
        pid = self.process.pid
        if pid is not None and self.alive and hasattr(os, "killpg"):
            with suppress(ProcessLookupError, PermissionError):
                if os.getpgid(pid) == pid:
                    os.killpg(pid, signal.SIGKILL)
        self.process.kill()
        self.process.join(2.0)


def _begin(
    connection: Connection, ends: Sequence[Connection], work: Callable[..., None], arguments: Sequence[Any]
) -> None:
    """What a process does first."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent ends its processes when it is interrupted
    for end in ends:
        end.close()
    with suppress(EOFError, ConnectionError):  # nobody asks any more
        work(connection, *arguments)
