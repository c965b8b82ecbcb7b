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
    waiting: queue.Queue[tuple[str, Any]] = queue.Queue(DEPTH)
    ended = threading.Event()

    def put(what: str, item: Any) -> None:
        while not ended.is_set():
            try:
                waiting.put((what, item), timeout=0.1)
            except queue.Full:
                continue
            return

    def work() -> None:
        try:
            for item in source:
                put("item", item)
                if ended.is_set():
                    break
            put("end", None)
        except BaseException as error:  # noqa: BLE001 - whatever it is, it is raised where the items are used
            put("error", error)
        finally:
            if hasattr(source, "close"):
                source.close()

    thread = threading.Thread(target=copy_context().run, args=(work,), daemon=True)
    thread.start()
    try:
        while True:
            what, item = waiting.get()
            if what == "end":
                return
            if what == "error":
                raise item
            yield item
    finally:
        ended.set()
        thread.join()


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
            except BaseException as error:  # noqa: BLE001 - raised where the result is used
                self._found.append((None, error))

        self._thread = threading.Thread(target=copy_context().run, args=(run,), daemon=True)
        self._thread.start()

    def __call__(self) -> T:
        self._thread.join()
        found, error = self._found[0]
        if error is not None:
            raise error
        return found  # type: ignore[return-value]
