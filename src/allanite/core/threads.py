"""Threads: one for products of matrices, whose digits depend on it; several that leave when they are interrupted."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import copy_context
from functools import cache
from threading import Thread
from typing import Any, TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")


@contextmanager
def one_thread() -> Iterator[None]:
    """Let the libraries for linear algebra, those of numpy and scipy, use one thread.

    Their threads divide a product by their number, and its sums are rounded accordingly. Products are short here, and
    threads that wait for each other while other processes have the cores take several times as long.

    Examples
    --------
    >>> from threadpoolctl import threadpool_info
    >>> with one_thread():
    ...     {each["num_threads"] for each in threadpool_info() if each["user_api"] == "blas"}
    {1}
    """
    with _libraries().limit(limits=1, user_api="blas"):
        yield


@cache
def _libraries() -> Any:
    """The libraries that are loaded, which are looked for once."""
    import scipy.linalg  # noqa: F401 - a library is limited from when it is loaded
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


def spread(function: Callable[[Item], Result], items: Sequence[Item], threads: int) -> list[Result]:
    """``[function(item) for item in items]``, by so many threads, each item by who takes it first.

    Waiting for a thread is interrupted at once, a compiled loop is not: this thread only waits, also for a single
    other one. What others compute is left to end with the program, and none takes another item.

    Examples
    --------
    >>> spread(abs, [-1, 2, -3], 2)
    [1, 2, 3]
    """
    found: dict[int, Result] = {}
    errors: list[BaseException] = []
    left = iter(range(len(items)))  # of which each is given once: a step of it is not divided between threads

    def work() -> None:
        try:
            for i in left:
                if errors:
                    return
                found[i] = function(items[i])
        except BaseException as error:  # which the waiting thread raises
            errors.append(error)

    every = [Thread(target=copy_context().run, args=(work,), daemon=True) for _ in range(min(threads, len(items)))]
    try:
        for one in every:
            one.start()
        for one in every:
            one.join()
    except BaseException as error:
        errors.append(error)
        raise
    if errors:
        raise errors[0]
    return [found[i] for i in range(len(items))]
