"""What the processors are used for: how many processes share work, and what is imported while a file is read.

One thread imports at a time. What it imports does not import what the reading thread does, so that neither waits for
the other. It has ended when a process is forked.
"""

import os
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, wait
from contextlib import AbstractContextManager, contextmanager, suppress
from contextvars import ContextVar
from importlib import import_module
from threading import Event
from typing import Any, NamedTuple

from .processes import later

MOST = 8192  # items whose numbers a pipe holds; more of them are not shared

SAMPLES = 2**26
"""Samples on which processes work at once, unless their number is given: each needs several times their memory."""

IDENTIFICATION = ("scipy.special", "scipy.fft", "scipy.optimize", "scipy.interpolate")
"""Modules that the identification of noise needs."""

FIGURES = ("matplotlib.figure", "matplotlib.backends.backend_agg", "matplotlib.backends.backend_svg")
"""Modules that figures need."""

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
