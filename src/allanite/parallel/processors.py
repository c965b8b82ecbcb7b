"""What the processors are used for: one function for many items, shared by forks, and imports while a file is read.

One thread imports at a time. What it imports does not import what the reading thread does, so that neither waits for
the other. It has ended when a process is forked.

A fork begins with the memory of this process as it is: nothing is read, imported or sent to it, and samples exist once,
because nobody changes them. Only results come back, and of these not what was there before. That takes milliseconds, so
that it pays for items of a tenth of a second; for whole files, `allanite.batch` has processes that last.

Each takes the next item from a pipe that all of them read. What a fork could not do, because of an error or because it
was killed, this process does itself, in the order of the items, so that an error is that of the first.
"""

import gc
import io
import multiprocessing
import os
import pickle
import signal
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, wait
from contextlib import AbstractContextManager, contextmanager, suppress
from contextvars import ContextVar
from importlib import import_module
from multiprocessing.connection import Connection
from threading import Event
from typing import Any, NamedTuple, TypeVar

from .processes import ANSWER, EndedError, Process, later

MOST = 8192  # items whose numbers a pipe holds; more of them are not shared

SAMPLES = 2**26
"""Samples on which processes work at once, unless their number is given: each needs several times their memory."""

IDENTIFICATION = ("scipy.special", "scipy.fft")
"""Modules that the identification of noise needs."""

FIGURES = ("matplotlib.figure", "matplotlib.backends.backend_agg", "matplotlib.backends.backend_svg")
"""Modules that figures for print need."""

PAGE = ("matplotlib.ticker", "jinja2")
"""Modules that a page needs, whose figures are sketches."""

PREPARING = "preparing, once after an installation: about 6 s"  # what a bar says while kernels are compiled

UNKEPT = "compiling (it is kept if NUMBA_CACHE_DIR names a folder that can be written)"
"""What it says where no folder for compiled code can be written."""


class _Use(NamedTuple):
    """The number of processes, None for that of the processors; what another thread does, and whether it compiles."""

    processes: int | None = 1
    importing: Future[None] | None = None
    compiles: Event | None = None


_use: ContextVar[_Use] = ContextVar("_use", default=_Use())  # noqa: B039 - a tuple


@contextmanager
def _using(**changes: Any) -> Iterator[None]:
    token = _use.set(_use.get()._replace(**changes))
    try:
        yield
    finally:
        _use.reset(token)


def processes(count: int | None) -> AbstractContextManager[None]:
    """Within this context work is shared between so many processes; None: as many as there are processors."""
    # Without it, and where processes cannot be forked safely (Windows, macOS), all is done in this process.
    return _using(processes=count)


def processors() -> int:
    """The number of processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def how_many(items: int = MOST, samples: int = 0) -> int:
    """Processes for so many items, the largest of so many samples; within `shared`, one."""
    wanted = _use.get().processes
    if wanted is None:
        wanted = min(processors(), max(1, SAMPLES // max(samples, 1)))
    forks = sys.platform == "linux" and items <= MOST
    return max(1, min(wanted, items)) if forks else 1


class _GivenUpError(Exception):
    """Nobody needs what is compiled."""


@contextmanager
def importing(names: Sequence[str], *, kernels: bool = False) -> Iterator[None]:
    """Within this context modules are imported by another thread, after those of the contexts around it."""
    # With `kernels` those of the usual analysis are loaded before, or compiled if they are not in the cache.
    given_up, compiles = Event(), Event()

    def compiling() -> None:
        if given_up.is_set():
            raise _GivenUpError
        compiles.set()

    def work() -> None:
        imported()  # what the contexts around this one want
        if kernels:
            from allanite.kernels.ahead import ready

            with suppress(_GivenUpError):
                ready(compiling, alone=(_use.get().processes or processors()) == 1)
        for name in names:
            if not given_up.is_set():
                import_module(name)

    with _using(importing=later(work), compiles=compiles) if names else _using():
        try:
            yield
        except BaseException:
            given_up.set()
            raise
        finally:
            imported()


def imported(tell: Callable[[str, float], None] | None = None) -> None:
    """Wait for what is being imported or compiled, and tell if it is compiled."""
    _, future, compiles = _use.get()
    if future is None:
        return
    while tell is not None and not wait([future], 0.1).done:
        if compiles and compiles.is_set():
            from allanite.kernels.compiling import KEPT

            tell(PREPARING if KEPT else UNKEPT, 0.04)
    future.result()


def spare() -> bool:
    """Whether threads that compute have more than one processor: of two, one is taken while modules are imported."""
    future = _use.get().importing
    return processors() > 2 or future is None or future.done()


Item = TypeVar("Item")
Result = TypeVar("Result")

_TOKEN = 4  # bytes of the number of an item in the pipe


def shared(
    function: Callable[[Item], Result],
    items: Sequence[Item],
    *,
    count: int,
    known: Sequence[Any] = (),
    begun: Callable[[int], None] | None = None,
) -> list[Result]:
    """``[function(item) for item in items]``, by `count` processes."""

    def process(i: int) -> Result:
        if begun:
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
    numbers = {id(value): i for i, value in enumerate(known)}

    def packed(i: int) -> bytes:
        buffer = io.BytesIO()
        pickler = pickle.Pickler(buffer, pickle.HIGHEST_PROTOCOL)
        pickler.persistent_id = lambda value: numbers.get(id(value))  # type: ignore[method-assign]
        pickler.dump(process(i))
        return buffer.getvalue()

    results = _take(packed, reading, lambda: os.getppid() == parent)
    connection.recv()
    connection.send((ANSWER, results))
