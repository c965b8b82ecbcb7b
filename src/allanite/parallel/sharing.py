"""One function for many items, shared between this process and forks of it: the same results in any number of them.

A fork begins with the memory of this process as it is: nothing is read, imported or sent to it, and samples exist once,
because nobody changes them. Only results come back, and of these not what was there before. That takes milliseconds, so
that it pays for items of a tenth of a second; for whole files, `allanite.batch` has processes that last.

Each takes the next item from a pipe that all of them read. What a fork could not do, because of an error or because it
was killed, this process does itself, in the order of the items, so that an error is that of the first.
"""

import copyreg
import gc
import io
import multiprocessing
import os
import pickle
import signal
import warnings
from collections.abc import Callable, Sequence
from contextlib import suppress
from multiprocessing.connection import Connection
from typing import Any, TypeVar

from allanite.core.plain import Portable

from .processes import ANSWER, EndedError, Process
from .processors import imported, processes

Item = TypeVar("Item")
Result = TypeVar("Result")

_TOKEN = 4  # bytes of the number of an item in the pipe


def shared(
    function: Callable[[Item], Result],
    items: Sequence[Item],
    *,
    count: int,
    known: Sequence[Any] = (),
    begun: Callable[[int], None] = lambda _: None,
) -> list[Result]:
    """``[function(item) for item in items]``, by `count` processes."""

    def process(i: int) -> Result:
        begun(i)
        return function(items[i])

    results: dict[int, Result] = {}
    if count > 1:
        imported()
        with processes(1):
            results = _with_forks(count - 1, process, lambda i: function(items[i]), len(items), known)
    for i in range(len(items)):
        if i not in results:
            results[i] = process(i)
    return [results[i] for i in range(len(items))]


def _with_forks(
    count: int, here: Callable[[int], Result], there: Callable[[int], Result], items: int, known: Sequence[Any]
) -> dict[int, Result]:
    """What this process and so many forks of it make of the items, by their numbers."""
    reading, writing = os.pipe()
    os.write(writing, b"".join(i.to_bytes(_TOKEN, "little") for i in range(items)))
    os.close(writing)
    context, forks = multiprocessing.get_context("fork"), list[Process]()
    try:
        with warnings.catch_warnings():
            # that threads are not forked: those of Arrow and BLAS have nothing to do, and no fork asks that of a bar
            warnings.simplefilter("ignore", DeprecationWarning)
            for _ in range(count):
                forks.append(Process(context, _work, there, reading, known, os.getpid(), others=forks))
        results = _take(here, reading)
        for fork in forks:
            with suppress(EndedError):
                for i, data in fork.request(None).items():
                    unpickler = pickle.Unpickler(io.BytesIO(data))  # noqa: S301 - of our own process
                    unpickler.persistent_load = known.__getitem__  # type: ignore[method-assign]
                    results[i] = unpickler.load()
        return results
    finally:
        os.close(reading)
        for fork in forks:
            fork.end()


def _take(
    process: Callable[[int], Result], reading: int, going: Callable[[], bool] = lambda: True
) -> dict[int, Result]:
    """Process the items that are left, each by who takes it first, until one fails."""
    results: dict[int, Result] = {}
    with suppress(Exception):
        while going() and (token := os.read(reading, _TOKEN)):
            i = int.from_bytes(token, "little")
            results[i] = process(i)
    return results


def _work(
    connection: Connection, process: Callable[[int], Any], reading: int, known: Sequence[Any], parent: int
) -> None:
    """What a fork does: items until none is left or the parent has ended, and then it tells all results."""
    signal.signal(signal.SIGTERM, signal.SIG_DFL)  # at once, whatever the parent does at its own
    gc.disable()  # it writes to all objects, and what is written to is copied first

    def packed(i: int) -> bytes:
        buffer = io.BytesIO()
        _Pickler(buffer, known).dump(process(i))
        return buffer.getvalue()

    results = _take(packed, reading, lambda: os.getppid() == parent)
    connection.recv()
    connection.send((ANSWER, results))


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
