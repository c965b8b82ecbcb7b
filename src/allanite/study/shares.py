"""One function for many items, shared between this process and forks of it: the same results in any number of them.

What a fork could not do this process does itself, in the order of the items, so that an error is that of the first.
"""

import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any, Generic, NamedTuple, TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")
Made_co = TypeVar("Made_co", covariant=True)

_MOST = 8192
"""Items whose numbers a pipe holds; more of them are not shared."""

SAMPLES = 2**26
"""Samples on which processes work at once, unless their number is given: each needs several times their memory."""

_processes: ContextVar[int | None] = ContextVar("_processes", default=1)


@contextmanager
def processes(count: int | None) -> Iterator[None]:
    """Within this context work is shared between so many processes; None: as many as there are processors.

    Without it, and where processes cannot be forked safely (Windows, macOS), all is done in this process.
    """
    token = _processes.set(count)
    try:
        yield
    finally:
        _processes.reset(token)


def how_many(items: int = _MOST, samples: int = 0) -> int:
    """Processes for so many items, the largest of so many samples; within `shared`, one."""
    wanted = _processes.get()
    if wanted is None:
        wanted = min(_processors(), max(1, SAMPLES // max(samples, 1)))
    forks = sys.platform == "linux" and items <= _MOST
    return max(1, min(wanted, items)) if forks else 1


def alone() -> bool:
    """Whether all is to be done in this process."""
    return (_processes.get() or _processors()) == 1


def _processors() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def shared(
    function: Callable[[Item], Result],
    items: Sequence[Item],
    *,
    count: int,
    known: Sequence[Any] = (),
    begun: Callable[[int], None] = lambda _: None,
) -> list[Result]:
    """``[function(item) for item in items]``, by `count` processes.

    Parameters
    ----------
    function : item -> result
        Changes nothing; its results can be pickled, or are computed in this process.
    items : sequence
    count : int
        Processes, this one included.
    known : sequence
        What results refer to and is not to be copied: records.
    begun : callable
        Called in this process with the number of an item that it begins.

    Examples
    --------
    >>> shared(abs, [-1, 2, -3], count=2)
    [1, 2, 3]
    """
    found: dict[int, Result] = {}
    if count > 1:
        from .forks import among
        from .meanwhile import imported

        imported()
        with processes(1):
            among(count, function, items, found, known=known, begun=begun)
    for i, item in enumerate(items):
        if i not in found:
            begun(i)
            found[i] = function(item)
    return [found[i] for i in range(len(items))]


class Work(NamedTuple, Generic[Made_co]):
    """What processes can share: tasks, and how one thing is made of their results, in this process."""

    tasks: Sequence[Callable[[], Any]]
    whole: Callable[[list[Any]], Made_co]

    @staticmethod
    def one(task: Callable[[], Result]) -> "Work[Result]":
        """A single task, which makes all of it."""
        return Work((task,), lambda found: found[0])

    def then(self, function: Callable[[Made_co], Item]) -> "Work[Item]":
        """The same, with a function of what it makes, in this process."""
        return Work(self.tasks, lambda found: function(self.whole(found)))

    def beside(self, other: "Work[Item]") -> "Work[tuple[Made_co, Item]]":
        """Both at once."""
        own = len(self.tasks)
        return Work((*self.tasks, *other.tasks), lambda found: (self.whole(found[:own]), other.whole(found[own:])))


def made(work: Work[Result]) -> Result:
    """What one work makes, after its tasks were shared."""
    found: Result = next(done(work))
    return found


def done(*works: Work[Any]) -> Iterator[Any]:
    """What each work makes, after the tasks of all of them were shared.

    Examples
    --------
    >>> list(done(Work.one(list), Work([int, float], sum).then(str)))
    [[], '0.0']
    """
    tasks = [task for work in works for task in work.tasks]
    found = iter(shared(lambda task: task(), tasks, count=how_many(len(tasks))))
    for work in works:
        yield work.whole([next(found) for _ in work.tasks])
