"""The standard streams, the only door to the terminal, and signals that end the program and leave nothing behind."""

import errno
import io
import os
import re
import signal
import sys
import time
import warnings
from _thread import interrupt_main
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from threading import Lock, Timer, current_thread, main_thread
from types import FrameType

import click

from allanite.phrases.phrase import visible


class _Closed(io.TextIOBase):
    """Standard output that was closed before the program began."""

    encoding = "utf-8"

    def write(self, _: str) -> int:
        """Refuse."""
        raise OSError(errno.EBADF, "it is closed")


class _Nowhere(io.TextIOWrapper):
    """In the place of standard output that takes no more, and `why`."""

    def __init__(self, why: str) -> None:
        super().__init__(open(os.devnull, "wb"), encoding="utf-8")  # noqa: SIM115 - for as long as the program runs
        self.why = why


def begin() -> None:
    """Put something in the place of streams that are closed, lest the next file that is opened becomes one of them."""
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
def while_read() -> Iterator[None]:
    """Write to standard output; if it takes no more, other outputs are written all the same, and `lost` says why."""
    try:
        yield
        sys.stdout.flush()
    except OSError as error:
        if error.errno not in (errno.EPIPE, errno.ENOSPC, errno.EBADF, errno.EIO, errno.EFBIG, errno.EDQUOT):
            raise
        if error.filename is not None:
            raise
        if not isinstance(sys.stdout, _Closed):  # what is left in it goes nowhere, too
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.stdout = _Nowhere("" if error.errno == errno.EPIPE else error.strerror or str(error))


def lost() -> str:
    """Why standard output took no more; empty if it has taken all, or its reader has left."""
    return str(getattr(sys.stdout, "why", ""))


def show(*lines: str) -> None:
    """Write lines to standard output; names in them must not drive the terminal, nor begin lines of their own."""
    click.echo(_harmless(lines))


def hand_over(data: str | bytes, *, styled: bool = False) -> None:
    """Write a result to standard output as it is for a program; on a terminal nothing drives it but the styles."""
    if sys.stdout.isatty():
        text = data if isinstance(data, str) else data.decode("utf-8", "replace")
        parts = re.split(r"(\x1b\[[\d;]*m)", text) if styled else [text]
        data = "".join(part if i % 2 else "\n".join(map(visible, part.split("\n"))) for i, part in enumerate(parts))
    click.echo(data, nl=False)


def complain(*lines: str, before: str = "") -> None:
    """Write lines to standard error, as far as it takes them; what stands `before` them may drive the terminal."""
    try:
        click.echo(before + _harmless(lines), err=True)
    except OSError:
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115 - what is left in the old one is not flushed


@contextmanager
def as_sentences(kind: type[Warning]) -> Iterator[None]:
    """Warnings of this kind are printed as sentences on stderr."""
    with warnings.catch_warnings():
        warnings.simplefilter("always", kind)
        warnings.showwarning = lambda message, *_, **__: complain(f"allanite: {message}")
        yield


def _harmless(lines: Iterable[str]) -> str:
    from allanite.reporting.digits import printable

    return "\n".join(map(printable, lines))


ENDS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
"""Signals that end the program."""

RESEND_PERIOD_S, END_PERIOD_S = 0.01, 0.25
"""Seconds after which a signal that had to wait is sent again, and one that should have ended the program."""

AGAIN_S = 0.5
"""Seconds after which Ctrl-C comes once more; whoever ends a group of processes may send its signal twice."""

IMPORTER = "<frozen importlib"
"""Where Python's importer is: an exception within it keeps a lock for which other threads wait."""

WHOLE = ("tempfile", "llvmlite")
"""Packages within which an exception leaves a temporary file behind, or memory that is freed twice."""


@contextmanager
def ended() -> Iterator[None]:
    """Within this context a signal to end unwinds the program, again and again if a library ignores the exception."""
    ending = _Ending()
    before, sys.unraisablehook = sys.unraisablehook, ending.ignored
    try:
        yield
    finally:
        ending.over()
        sys.unraisablehook = before


class _Ending:
    """What the signals do that are neither handled nor ignored already, as nohup does, from now on."""

    def __init__(self) -> None:
        self.starting, self.before = Lock(), sys.unraisablehook
        handlers = {number: signal.getsignal(number) for number in ENDS if current_thread() is main_thread()}
        usual = (signal.SIG_DFL, signal.default_int_handler)
        self.taken = {number: was for number, was in handlers.items() if was in usual}
        for number in self.taken:
            signal.signal(number, self.end)

    def over(self) -> None:
        """Let them do what they did before."""
        taken, self.taken = self.taken, {}
        for number, was in taken.items():
            signal.signal(number, was)

    def end(self, number: int, frame: FrameType | None) -> None:
        """Raise what ends the program, unless it is being prepared, must wait or does its work already."""
        if self.starting.locked():
            return
        # an import, and what some packages do, has to come to its end, which it soon does
        whole, at = frame is not None and frame.f_code.co_filename.startswith(IMPORTER), frame
        while at is not None and not whole:
            whole = str(at.f_globals.get("__name__")).partition(".")[0] in WHOLE
            at = at.f_back
        now = not whole and ended_by(sys.exc_info()[1]) is None
        self.send(number, END_PERIOD_S if now else RESEND_PERIOD_S)
        if now:
            raise KeyboardInterrupt if number == signal.SIGINT else SystemExit(128 + number)  # as of a shell

    def send(self, number: int, wait: float) -> None:
        """Send a signal after so many seconds, if the program has not ended."""

        def sent() -> None:
            with self.starting:
                pass  # the thread that starts this timer has gone on
            if number in self.taken:
                interrupt_main(signal.Signals(number))

        if self.starting.acquire(blocking=False):
            timer = Timer(wait, sent)
            timer.daemon = True
            timer.start()
            self.starting.release()

    def ignored(self, what: "sys.UnraisableHookArgs") -> None:
        """An exception that Python ignores: if it is to end the program, it will be raised again."""
        if ended_by(what.exc_value) is None:
            self.before(what)


def ended_by(error: BaseException | None) -> BaseException | None:
    """The exception of a signal to end that lies behind an error; None if there is none."""
    while error is not None and not isinstance(error, (KeyboardInterrupt, SystemExit)):
        error = error.__cause__ or error.__context__
    return error


@contextmanager
def stopping() -> Iterator[Callable[[], bool]]:
    """Within this context signals that end the program are noted: whether one came is the answer of the value."""
    came = list[float]()

    def note(number: int, frame: FrameType | None) -> None:
        """Note it; Ctrl-C once more does what it did before."""
        came.append(time.monotonic())
        if came[-1] - came[0] > AGAIN_S and number == signal.SIGINT and callable(was := before[signal.SIGINT]):
            was(number, frame)

    heard = [which for which in ENDS if signal.getsignal(which) != signal.SIG_IGN]  # nohup ignores hangups
    before = {which: signal.signal(which, note) for which in heard}
    try:
        yield lambda: bool(came)
    finally:
        for which, handler in before.items():
            signal.signal(which, handler)
