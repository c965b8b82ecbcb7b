"""Items processed by this process and forks of it, each by who takes it first.

A fork begins with the memory of this process as it is: nothing is read, imported or sent to it, and samples exist once,
because nobody changes them. Only results come back, and of these not what was there before. That takes milliseconds, so
that it pays for items of a tenth of a second; for whole files, `allanite.batch` has processes that last.

A fork takes the next item from a pipe that all of them read. What it could not do, because of an error or because it
was killed, is left out: this process does it itself.
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
from multiprocessing.process import BaseProcess
from typing import Any, Generic, TypeVar

from allanite.core.plain import Portable

Item = TypeVar("Item")
Result = TypeVar("Result")

_TOKEN = 4
"""Bytes of the number of an item in the pipe."""


def among(
    count: int,
    function: Callable[[Item], Result],
    items: Sequence[Item],
    found: dict[int, Result],
    *,
    known: Sequence[Any],
    begun: Callable[[int], None],
) -> None:
    """Put into `found` what `count` processes make of the items; see `shares.shared`."""
    reading, writing = os.pipe()
    os.write(writing, b"".join(i.to_bytes(_TOKEN, "little") for i in range(len(items))))
    os.close(writing)
    forks: list[_Fork] = []
    try:
        for _ in range(count - 1):
            forks.append(_Fork(_Work(function, items, reading, known), forks))
        _take(function, items, reading, found, begun=begun)
        for fork in forks:
            found |= fork.results(known)
    finally:
        os.close(reading)
        for fork in forks:
            fork.end()


def _take(
    function: Callable[[Item], Result],
    items: Sequence[Item],
    reading: int,
    found: dict[int, Result],
    *,
    begun: Callable[[int], None] = lambda _: None,
    going: Callable[[], bool] = lambda: True,
) -> None:
    """Process the items that are left, each by who takes it first, until one fails."""
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
    signal.signal(signal.SIGTERM, signal.SIG_DFL)  # at once, whatever the parent does at its own
    gc.disable()  # it writes to all objects, and what is written to is copied first
    for end in ends:
        end.close()
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
