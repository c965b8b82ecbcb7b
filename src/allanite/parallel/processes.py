"""A process that is started by this one, asked one thing at a time, and ended at will.

Those of `concurrent.futures.ProcessPoolExecutor` are not: one that is killed ends all of them, none can be ended while
it works or say how it ended, and they go on when the program is killed.
"""

import multiprocessing
import os
import signal
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import Any

ANSWER = "answer"
"""Kind of the message that a process sends last; those of other kinds are reports on the way."""

Tell = Callable[[str, Any], None]


def ready_context(warm: str) -> Any:
    """Starts processes as forks of one that has imported a module and has no threads; on Windows, each anew."""
    if sys.platform == "win32":
        return multiprocessing.get_context("spawn")
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload([warm])
    return context


class EndedError(Exception):
    """A process ended before it had answered."""


class Process:
    """Another process and this end of its pipe.

    It ends when nobody holds this end any more, however this process ended.
    """

    def __init__(
        self, context: Any, work: Callable[..., None], *arguments: Any, others: Sequence["Process"] = ()
    ) -> None:
        self.connection, theirs = context.Pipe()
        fork = context.get_start_method() == "fork"
        ends = [each.connection for each in (self, *others)] if fork else []
        self.process: BaseProcess = context.Process(target=_begin, args=(theirs, ends, work, arguments), daemon=fork)
        self.process.start()
        theirs.close()  # so that its end is noticed

    @property
    def alive(self) -> bool:
        """Whether it can be asked."""
        return bool(self.process.is_alive())

    @property
    def code(self) -> int:
        """How it has ended: its exit code, or less than zero the signal that ended it."""
        return self.process.exitcode or 0

    def request(self, message: Any, tell: Tell = lambda kind, data: None) -> Any:
        """The answer to a request; `tell` takes kind and data of the reports on the way."""
        try:
            self.connection.send(message)
            while True:
                kind, data = self.connection.recv()
                if kind == ANSWER:
                    return data
                tell(kind, data)
        except (EOFError, OSError):
            self.process.join(1.0)
            raise EndedError from None

    def interrupt(self) -> None:
        """Ask it to come to an end, by SIGTERM."""
        if self.process.pid is not None:
            with suppress(ProcessLookupError):
                os.kill(self.process.pid, signal.SIGTERM)

    def end(self) -> None:
        """End it at once, and the processes that it has started if it leads their group."""
        pid = self.process.pid
        if pid is not None and self.alive and hasattr(os, "killpg"):
            with suppress(ProcessLookupError, PermissionError):
                if os.getpgid(pid) == pid:
                    os.killpg(pid, signal.SIGKILL)
        self.process.kill()
        self.process.join(2.0)


def _begin(
    connection: Connection, ends: Sequence[Connection], work: Callable[..., None], arguments: Sequence[Any]
) -> None:
    """What a process does first."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent ends its processes when it is interrupted
    for end in ends:
        end.close()
    with suppress(EOFError, ConnectionError):  # nobody asks any more
        work(connection, *arguments)
