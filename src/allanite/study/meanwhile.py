"""Modules imported and kernels made ready while a file is read, on a processor that has nothing else to do.

One thread imports at a time. What it imports does not import what the reading thread does, so that neither waits for
the other. It has ended when a process is forked.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from importlib import import_module
from threading import Event
from typing import NamedTuple

from allanite.readers.ahead import Later

from .shares import alone

IDENTIFICATION = ("scipy.special", "scipy.fft", "scipy.optimize", "scipy.interpolate")
"""Modules that the identification of noise needs."""

FIGURES = ("matplotlib.figure", "matplotlib.backends.backend_agg", "matplotlib.backends.backend_svg")
"""Modules that figures need."""

PREPARING = "preparing, once after an installation: about 6 s"
"""What a bar says while kernels are compiled."""


class _Work(NamedTuple):
    """What another thread does, and whether it has to compile."""

    done: Later[None]
    compiles: Event


class _GivenUpError(Exception):
    """Nobody needs what is compiled."""


_begun: ContextVar[_Work | None] = ContextVar("_begun", default=None)


@contextmanager
def importing(names: Sequence[str], *, kernels: bool = False) -> Iterator[None]:
    """Within this context modules are imported by another thread, after those of the contexts around it.

    With `kernels` those of the usual analysis are loaded before, or compiled if they are not in the cache.

    Examples
    --------
    >>> with importing(["string"]):
    ...     imported()
    """
    before = _begun.get()
    given_up, compiles = Event(), Event()

    def compiling() -> None:
        if given_up.is_set():
            raise _GivenUpError
        compiles.set()

    def work() -> None:
        if before is not None:
            before.done()
        if kernels:
            from allanite.kernels.ahead import ready

            with suppress(_GivenUpError):
                ready(compiling, alone=alone())
        for name in names:
            if not given_up.is_set():
                import_module(name)

    token = _begun.set(_Work(Later(work), compiles) if names else before)
    try:
        yield
    except BaseException:
        given_up.set()
        raise
    finally:
        try:
            imported()
        finally:
            _begun.reset(token)


def imported(tell: Callable[[str, float], None] | None = None) -> None:
    """Wait for what is being imported or compiled, and tell if it is compiled."""
    begun = _begun.get()
    if begun is None:
        return
    while tell is not None and not begun.done.within(0.1):
        if begun.compiles.is_set():
            tell(PREPARING, 0.04)
    begun.done()
