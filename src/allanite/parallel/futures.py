"""Results of other threads, as futures.

These threads end with the program, also while they compute. Those of `concurrent.futures.ThreadPoolExecutor` do not:
the program waits for them, so that a compiled loop could not be interrupted.
"""

from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import Future, wait
from contextvars import copy_context
from threading import Thread
from typing import Any, TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")

DEPTH = 2
"""Items that may wait."""

_END: Any = object()


def later(function: Callable[[], Result]) -> Future[Result]:
    """The result of a function that another thread calls now, in the context of this one.

    Examples
    --------
    >>> later(lambda: 3).result()
    3
    """
    future: Future[Result] = Future()
    context = copy_context()

    def call() -> None:
        try:
            future.set_result(context.run(function))
        except BaseException as error:  # which is raised by who asks for the result
            future.set_exception(error)

    Thread(target=call, daemon=True).start()
    return future


def ahead(source: Iterator[Item]) -> Iterator[Item]:
    """The items of an iterator, which is asked for the next ones while the last one is used.

    Examples
    --------
    >>> list(ahead(iter(range(5))))
    [0, 1, 2, 3, 4]
    """
    context = copy_context()
    waiting: deque[Future[Any]] = deque()

    def take_next() -> None:
        before = [*waiting][-1:]

        def take() -> Any:
            wait(before)
            return context.run(next, source, _END)

        waiting.append(later(take))

    try:
        for _ in range(DEPTH):
            take_next()
        while (item := waiting.popleft().result()) is not _END:
            take_next()
            yield item
    except GeneratorExit:  # nobody uses the others
        wait(waiting)
        if isinstance(source, Generator):
            source.close()
        raise


def spread(function: Callable[[Item], Result], items: Sequence[Item], threads: int) -> list[Result]:
    """``[function(item) for item in items]``, by so many threads, each item by who takes it first.

    Waiting for a thread is interrupted at once, a compiled loop is not: this thread only waits, also for a single
    other one. What others compute is left to end with the program, and none takes another item.

    Examples
    --------
    >>> spread(abs, [-1, 2, -3], 2)
    [1, 2, 3]
    """
    results: dict[int, Result] = {}
    left = iter(range(len(items)))  # of which each is given once: a step of it is not divided between threads

    def work() -> None:
        try:
            for i in left:
                results[i] = function(items[i])
        finally:
            deque(left, maxlen=0)  # nobody goes on after an error

    try:
        done, _ = wait([later(work) for _ in range(min(threads, len(items)))])
    finally:
        deque(left, maxlen=0)
    for future in done:
        future.result()
    return [results[i] for i in range(len(items))]
