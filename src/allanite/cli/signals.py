"""Signals that end the program: it unwinds, and leaves no draft, no copy and no hanging thread behind."""

import signal
import sys
from _thread import interrupt_main
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Lock, Timer, current_thread, main_thread
from types import FrameType

ENDS = ("SIGINT", "SIGTERM", "SIGHUP")  # signals that end the program, where the system has them

RESEND_PERIOD_S, END_PERIOD_S = 0.01, 0.25
"""Seconds after which a signal that had to wait is sent again, and one that should have ended the program."""

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
        numbers = [getattr(signal, name) for name in ENDS if hasattr(signal, name)]
        handlers = {number: signal.getsignal(number) for number in numbers if current_thread() is main_thread()}
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
    came = list[int]()
    numbers = (signal.SIGINT, signal.SIGTERM)
    before = {which: signal.signal(which, lambda number, _: came.append(number)) for which in numbers}
    try:
        yield lambda: bool(came)
    finally:
        for which, handler in before.items():
            signal.signal(which, handler)
