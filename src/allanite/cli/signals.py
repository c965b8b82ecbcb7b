"""Signals that end the program: it unwinds, and leaves no draft, no copy and no hanging thread behind."""

import signal
import sys
from _thread import interrupt_main
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock, Timer, current_thread, main_thread
from types import FrameType

ENDS = ("SIGINT", "SIGTERM", "SIGHUP")
"""Signals that end the program, where the system has them."""

SOON = 0.01
"""Seconds after which a signal that could not end the program is sent again."""

IMPORTER = "<frozen importlib"
"""Where Python's importer is: an exception within it keeps a lock for which other threads wait."""

WHOLE = ("tempfile", "llvmlite")
"""Packages within which an exception leaves a temporary file behind, or memory that is freed twice."""

_again = Lock()
"""Held while a timer is started that sends a signal again."""


@contextmanager
def ended() -> Iterator[None]:
    """Within this context a signal to end unwinds the program: no draft or copy is left.

    The exit code is that of a shell, 128 and the number of the signal. Where Python ignores the exception, in a
    callback of its own, it is raised once more.
    """

    def ignored(what: "sys.UnraisableHookArgs") -> None:
        number = _number(what.exc_value)
        if number in taken:
            _send_again(number)
        else:
            before(what)

    numbers = [getattr(signal, name) for name in ENDS if hasattr(signal, name)]
    there = {number: signal.getsignal(number) for number in numbers if current_thread() is main_thread()}
    # what somebody else handles or ignores, as nohup does, stays so
    taken = {number: was for number, was in there.items() if was in (signal.SIG_DFL, signal.default_int_handler)}
    before, sys.unraisablehook = sys.unraisablehook, ignored
    for number in taken:
        signal.signal(number, _end)
    try:
        yield
    finally:
        for number, was in taken.items():
            signal.signal(number, was)
        sys.unraisablehook = before


def _end(number: int, frame: FrameType | None) -> None:
    """Raise what ends the program, now or soon."""
    if _again.locked() or _unbroken(frame):
        _send_again(number)
    else:
        raise KeyboardInterrupt if number == signal.SIGINT else SystemExit(128 + number)


def _number(error: BaseException | None) -> int:
    """The signal that an exception stands for; 0 if none."""
    if isinstance(error, SystemExit) and isinstance(error.code, int):
        return error.code - 128
    return signal.SIGINT if isinstance(error, KeyboardInterrupt) else 0


def _send_again(number: int) -> None:
    """Send a signal after a moment; one that comes while this is prepared is the same one."""

    def send() -> None:
        with _again:
            pass  # the thread that started this timer has gone on
        interrupt_main(signal.Signals(number))

    if _again.acquire(blocking=False):
        timer = Timer(SOON, send)
        timer.daemon = True
        timer.start()
        _again.release()


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
