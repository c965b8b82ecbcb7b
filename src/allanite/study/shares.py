"""One function for many items, shared between this process and forks of it: the same results in any number of them.

A fork begins with the memory of this process as it is: nothing is read, imported or sent to it, and samples exist once,
because nobody changes them. Only results come back, and of these not what was there before. That takes milliseconds, so
that it pays for items of a tenth of a second; for whole files, `allanite.batch` has processes that last.

A fork takes the next item from a pipe that all of them read. What it could not do, because of an error or because it
was killed, this process does itself, in the order of the items, so that an error is that of the first of them.
"""

import copyreg
import gc
import io
import multiprocessing
import os
import pickle
import signal
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import Any, Generic, TypeVar

from allanite.core.plain import Portable

Item = TypeVar("Item")
Result = TypeVar("Result")

_TOKEN = 4
"""Bytes of the number of an item in the pipe."""

_MOST = 8192
"""Items whose numbers a pipe holds; more of them are not shared."""

SAMPLES = 2**26
"""Samples on which processes work at once, unless their number is given: each needs several times their memory."""

_processes: ContextVar[int | None] = ContextVar("_processes", default=1)


@contextmanager
def processes(count: int | None) -> Iterator[None]:
    """Within this context work is shared between so many processes; None: as many as there are processors.

    Without it, and where processes cannot be forked safely (Windows, macOS), all is done in this process.
    """
    token = _processes.set(count)
    try:
        yield
    finally:
        _processes.reset(token)


def how_many(items: int = _MOST, samples: int = 0) -> int:
    """Processes for so many items, the largest of so many samples; within `shared`, one."""
    wanted = _processes.get()
    if wanted is None:
        wanted = min(_processors(), max(1, SAMPLES // max(samples, 1)))
    forks = sys.platform == "linux" and items <= _MOST
    return max(1, min(wanted, items)) if forks else 1


def _processors() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def shared(
    function: Callable[[Item], Result],
    items: Sequence[Item],
    *,
    count: int,
    known: Sequence[Any] = (),
    begun: Callable[[int], None] = lambda _: None,
) -> list[Result]:
    """``[function(item) for item in items]``, by `count` processes.

    Parameters
    ----------
    function : item -> result
        Changes nothing; its results can be pickled, or are computed in this process.
    items : sequence
    count : int
        Processes, this one included.
    known : sequence
        What results refer to and is not to be copied: records.
    begun : callable
        Called in this process with the number of an item that it begins.

    Examples
    --------
    >>> shared(abs, [-1, 2, -3], count=2)
    [1, 2, 3]
    """
    found: dict[int, Result] = {}
    if count > 1:
        reading, writing = os.pipe()
        os.write(writing, b"".join(i.to_bytes(_TOKEN, "little") for i in range(len(items))))
        os.close(writing)
        forks: list[_Fork] = []
        try:
            for _ in range(count - 1):
                forks.append(_Fork(_Work(function, items, reading, known), forks))
            with processes(1):
                _take(function, items, reading, found, begun=begun)
            for fork in forks:
                found |= fork.results(known)
        finally:
            os.close(reading)
            for fork in forks:
                fork.end()
    for i, item in enumerate(items):
        if i not in found:
            begun(i)
            found[i] = function(item)
    return [found[i] for i in range(len(items))]


def _take(
    function: Callable[[Item], Result],
    items: Sequence[Item],
    reading: int,
    found: dict[int, Result],
    *,
    begun: Callable[[int], None] = lambda _: None,
    going: Callable[[], bool] = lambda: True,
) -> None:
    """Process the items that are left, each by who takes it first, until one fails: `shared` does that once more."""
    with suppress(Exception):
        while going() and (token := os.read(reading, _TOKEN)):
            i = int.from_bytes(token, "little")
            begun(i)
            found[i] = function(items[i])


class _Fork:
    """Another process, from its start to its end."""

    def __init__(self, work: Callable[[Connection], None], others: Sequence["_Fork"]) -> None:
        context = multiprocessing.get_context("fork")
        self.connection, theirs = context.Pipe(duplex=False)
        ends = [self.connection, *(fork.connection for fork in others)]
        self.process: BaseProcess = context.Process(target=_begin, args=(work, theirs, ends), daemon=True)
        with warnings.catch_warnings():
            # that threads are not forked: those of Arrow and BLAS have nothing to do, and no fork asks that of a bar
            warnings.simplefilter("ignore", DeprecationWarning)
            self.process.start()
        theirs.close()  # so that its end is noticed

    def results(self, known: Sequence[Any]) -> dict[int, Any]:
        """What it found, by the number of the item; nothing if it was killed."""
        with suppress(EOFError):
            packed = pickle.loads(self.connection.recv_bytes())  # noqa: S301 - of our own process
            return {i: _Unpickler(io.BytesIO(data), known).load() for i, data in packed.items()}
        return {}

    def end(self) -> None:
        """Leave no process behind."""
        self.process.terminate()
        self.process.join()
        self.connection.close()


def _begin(work: Callable[[Connection], None], connection: Connection, ends: Sequence[Connection]) -> None:
    """What a fork does first."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent ends its forks when it is interrupted
    gc.disable()  # it writes to all objects, and what is written to is copied first
    for end in ends:
        end.close()
    with processes(1):
        work(connection)


class _Work(Generic[Item]):
    """What a fork does: items until none is left or the parent has ended, and then tells all results."""

    def __init__(
        self, function: Callable[[Item], Any], items: Sequence[Item], reading: int, known: Sequence[Any]
    ) -> None:
        self.function, self.items, self.reading, self.known = function, items, reading, known
        self.parent = os.getpid()

    def __call__(self, connection: Connection) -> None:
        """Work, and send what was found."""
        found: dict[int, bytes] = {}
        _take(self._packed, self.items, self.reading, found, going=lambda: os.getppid() == self.parent)
        with suppress(ConnectionError):
            connection.send_bytes(pickle.dumps(found))

    def _packed(self, item: Item) -> bytes:
        buffer = io.BytesIO()
        _Pickler(buffer, self.known).dump(self.function(item))
        return buffer.getvalue()


class _Pickler(pickle.Pickler):
    """Writes what both processes know as its number, and values with what was computed of them."""

    def __init__(self, file: io.BytesIO, known: Sequence[Any]) -> None:
        super().__init__(file, protocol=pickle.HIGHEST_PROTOCOL)
        self.known = {id(value): i for i, value in enumerate(known)}

    def persistent_id(self, value: Any) -> int | None:
        """The number of what is known."""
        return self.known.get(id(value))

    def reducer_override(self, value: Any) -> Any:
        """A value with its cached properties, which the other process would compute once more."""
        kind = type(value)
        if not isinstance(value, Portable) or any("__reduce__" in vars(base) for base in kind.__mro__[:-1]):
            return NotImplemented
        return copyreg.__newobj__, (kind,), dict(vars(value))  # type: ignore[attr-defined]


class _Unpickler(pickle.Unpickler):
    def __init__(self, file: io.BytesIO, known: Sequence[Any]) -> None:
        super().__init__(file)
        self.known = known

    def persistent_load(self, number: Any) -> Any:
        """What is known by its number."""
        return self.known[number]
