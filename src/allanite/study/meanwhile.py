"""Modules imported while a file is read: most of a job's start, on a processor that has nothing else to do.

One thread imports at a time. What it imports does not import what the reading thread does, so that neither waits for
the other. It has ended when a process is forked.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from importlib import import_module
from threading import Event

from allanite.readers.ahead import Later

IDENTIFICATION = ("scipy.special", "scipy.fft", "allanite.kernels.robust", "scipy.optimize", "scipy.interpolate")
"""Modules that the identification of noise needs."""

FIGURES = ("matplotlib.figure", "matplotlib.backends.backend_agg", "matplotlib.backends.backend_svg")
"""Modules that figures need."""

_begun: ContextVar[Later[None] | None] = ContextVar("_begun", default=None)


@contextmanager
def importing(names: Sequence[str]) -> Iterator[None]:
    """Within this context modules are imported by another thread, after those of the contexts around it.

    Examples
    --------
    >>> with importing(["string"]):
    ...     imported()
    """
    before = _begun.get()
    given_up = Event()

    def work() -> None:
        if before is not None:
            before()
        for name in names:
            if not given_up.is_set():
                import_module(name)

    token = _begun.set(Later(work) if names else before)
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


def imported() -> None:
    """Wait for what is being imported."""
    begun = _begun.get()
    if begun is not None:
        begun()
