"""Work that goes on in a thread of its own while its results are used."""

import queue
import threading
from collections.abc import Callable, Iterator
from contextvars import copy_context
from typing import Any, Generic, TypeVar

T = TypeVar("T")

DEPTH = 2
"""Results that may wait."""


def ahead(source: Iterator[T]) -> Iterator[T]:
    """The items of an iterator, which is asked for the next ones while the last one is used.

    Examples
    --------
    >>> list(ahead(iter(range(5))))
    [0, 1, 2, 3, 4]
    """
    line = _Line(source)
    thread = threading.Thread(target=copy_context().run, args=(line.work,), daemon=True)
    thread.start()
    wait = True
    try:
        yield from line.items()
    except (KeyboardInterrupt, SystemExit):  # the program ends, and the thread with it
        wait = False
        raise
    finally:
        line.ended.set()
        if wait:
            thread.join()


class _Line(Generic[T]):
    """Items that wait to be used, and the error at their end, if there was one."""

    def __init__(self, source: Iterator[T]) -> None:
        self.source, self.ended = source, threading.Event()
        self.waiting: queue.Queue[tuple[bool, Any]] = queue.Queue(DEPTH)

    def work(self) -> None:
        """Put the items in line, until nobody waits."""
        end: BaseException | None = None
        try:
            for item in self.source:
                if not self._put(False, item):
                    break
        except BaseException as error:
            end = error
        finally:
            if hasattr(self.source, "close"):
                self.source.close()
        self._put(True, end)

    def items(self) -> Iterator[T]:
        """Take them out."""
        while True:
            last, item = self.waiting.get()
            if not last:
                yield item
            elif item is None:
                return
            else:
                raise item

    def _put(self, last: bool, item: Any) -> bool:
        """Whether there was somebody to use it."""
        while not self.ended.is_set():
            try:
                self.waiting.put((last, item), timeout=0.1)
            except queue.Full:
                continue
            return True
        return False


class Later(Generic[T]):
    """The result of a function that is called in another thread now.

    Examples
    --------
    >>> Later(lambda: 3)()
    3
    """

    def __init__(self, work: Callable[[], T]) -> None:
        self._found: list[tuple[T | None, BaseException | None]] = []

        def run() -> None:
            try:
                self._found.append((work(), None))
            except BaseException as error:
                self._found.append((None, error))

        self._thread = threading.Thread(target=copy_context().run, args=(run,), daemon=True)
        self._thread.start()

    def within(self, seconds: float) -> bool:
        """Whether it is there, after waiting so long for it."""
        self._thread.join(seconds)
        return not self._thread.is_alive()

    def __call__(self) -> T:
        """Wait for it."""
        self._thread.join()
        found, error = self._found[0]
        if error is not None:
            raise error
        return found  # type: ignore[return-value]
