"""One thread for products of matrices, whose digits depend on it."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any


@contextmanager
def one_thread() -> Iterator[None]:
    """Let the libraries for linear algebra, those of numpy and scipy, use one thread.

    Their threads divide a product by their number, and its sums are rounded accordingly. Products are short here, and
    threads that wait for each other while other processes have the cores take several times as long.

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
