"""The standard streams, which may be closed or full, or have a reader that has left."""

import errno
import io
import os
import signal
import sys
from _thread import interrupt_main
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from threading import Lock, Timer, current_thread, main_thread
from types import FrameType

import click

ENDS = ("SIGINT", "SIGTERM", "SIGHUP")
"""Signals that end the program, where the system has them."""

SOON = 0.01
"""Seconds after which a signal that could not end the program is sent again."""

IMPORTER = "<frozen importlib"
"""Where Python's importer is: an exception within it keeps a lock for which other threads wait."""

WHOLE = ("tempfile", "llvmlite")
"""Packages within which an exception leaves a temporary file behind, or memory that is freed twice."""

_LOST: ContextVar[str] = ContextVar("_LOST", default="")
"""Why standard output took no more."""


class _Closed(io.TextIOBase):
    """Standard output that was closed before the program began."""

    encoding = "utf-8"

    def write(self, _: str) -> int:
        """Refuse."""
        raise OSError(errno.EBADF, "it is closed")


def begin() -> None:
    """Put something in the place of streams that are closed, lest the next file that is opened becomes one of them."""
    _LOST.set("")
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)
    if sys.stdout is None:
        sys.stdout = _Closed()
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115 - for as long as the program runs


@contextmanager
def ended() -> Iterator[None]:
    """Within this context a signal to end unwinds the program: no draft or copy is left.

    The exit code is that of a shell, 128 and the number of the signal. Where Python ignores the exception, in a
    callback of its own, it is raised once more.
    """

    waiting = Lock()

    def end(number: int, frame: FrameType | None) -> None:
        if waiting.locked() or _unbroken(frame):
            again(number)
        else:
            raise KeyboardInterrupt if number == signal.SIGINT else SystemExit(128 + number)

    def again(number: int) -> None:
        if waiting.acquire(blocking=False):
            timer = Timer(SOON, send, [number])
            timer.daemon = True
            timer.start()
            waiting.release()

    def send(number: int) -> None:
        with waiting:
            pass  # this timer has been started
        interrupt_main(number)

    def ignored(what: "sys.UnraisableHookArgs") -> None:
        value = what.exc_value
        if isinstance(value, KeyboardInterrupt):
            again(signal.SIGINT)
        elif isinstance(value, SystemExit) and isinstance(value.code, int) and value.code - 128 in taken:
            again(value.code - 128)
        else:
            before(what)

    numbers = [getattr(signal, name) for name in ENDS if hasattr(signal, name)]
    there = {number: signal.getsignal(number) for number in numbers if current_thread() is main_thread()}
    # what somebody else handles or ignores, as nohup does, stays so
    taken = {number: was for number, was in there.items() if was in (signal.SIG_DFL, signal.default_int_handler)}
    before, sys.unraisablehook = sys.unraisablehook, ignored
    for number in taken:
        signal.signal(number, end)
    try:
        yield
    finally:
        for number, was in taken.items():
            signal.signal(number, was)
        sys.unraisablehook = before


def _unbroken(frame: FrameType | None) -> bool:
    """Whether what runs now has to come to its end, which it soon does."""
    if frame is not None and frame.f_code.co_filename.startswith(IMPORTER):
        return True
    while frame is not None and str(frame.f_globals.get("__name__")).partition(".")[0] not in WHOLE:
        frame = frame.f_back
    return frame is not None


def ending(error: BaseException) -> BaseException | None:
    """The signal to end that lies behind an error, as an exception; None if there was none.

    A compiled loop that is interrupted, or a class that is being made, ends in an error of its own.
    """
    found: BaseException | None = error
    while found is not None and not isinstance(found, (KeyboardInterrupt, SystemExit)):
        found = found.__cause__ or found.__context__
    return found


@contextmanager
def while_read() -> Iterator[None]:
    """Write to standard output; if it takes no more, other outputs are written all the same.

    That its reader has left (``allanite ... | head``) is no failure; `lost` tells of any other reason.
    """
    try:
        yield
        sys.stdout.flush()
    except OSError as error:
        if error.errno not in (errno.EPIPE, errno.ENOSPC, errno.EBADF, errno.EIO, errno.EFBIG, errno.EDQUOT):
            raise
        if error.filename is not None:
            raise
        if error.errno != errno.EPIPE:
            _LOST.set(error.strerror or str(error))
        nowhere = os.open(os.devnull, os.O_WRONLY)
        if isinstance(sys.stdout, _Closed):
            sys.stdout = open(nowhere, "w", encoding="utf-8")  # noqa: SIM115 - for as long as the program runs
        else:
            os.dup2(nowhere, sys.stdout.fileno())


def lost() -> str:
    """Why standard output took no more; empty if it has taken all, or its reader has left."""
    return _LOST.get()


def complain(text: str, before: str = "") -> None:
    """Write to standard error, as far as it can be written to: the exit code says the rest.

    Names in the text must not drive the terminal; what stands `before` it may.
    """
    from allanite.reporting.sheet import printable

    try:
        click.echo(before + "\n".join(printable(line) for line in text.split("\n")), err=True)
    except OSError:
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115 - what is left in the old one is not flushed
