"""How much of a file has been read, for whoever waits for it."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

_told: ContextVar[Callable[[float], None] | None] = ContextVar("told", default=None)


@contextmanager
def told(tell: Callable[[float], None] | None) -> Iterator[None]:
    """While a file is read inside, `tell` is called with the share, 0 to 1, that has been read; None: nobody is."""
    token = _told.set(tell)
    try:
        yield
    finally:
        _told.reset(token)


def listener() -> Callable[[float], None] | None:
    """The function given to `told`: the `progress` of `Options` that have no other."""
    return _told.get()
