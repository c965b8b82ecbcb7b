"""The kernels of the usual analysis, made ready before they are needed: once after an installation they are compiled.

Two processes do that. The other one begins with what has the most parts of its own; what either has compiled, the other
loads from the cache. If it cannot be started or fails, or if there is no cache, all is compiled here.
"""

import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from importlib import import_module
from subprocess import DEVNULL

from numba.core import event
from numba.core.sigutils import normalize_signature

from allanite.kernels.compiling import KEPT

_X, _M, _FREE, _COLUMNS = "float64[::1]", "int64[::1]", "boolean[::1]", "float64[:, ::1]"
_DATA = f"Tuple(({_X}, {_X}, float64[:, :, ::1], {_COLUMNS}))"

THERE = {"whittle.minimise": f"({_X}, {_FREE}, {_X}, {_COLUMNS}, {_DATA}, int64, {_X}, int64)"}
"""What the other process compiles: kernel and types of its arguments."""

HERE = {
    "leastsquares.weighted_nnls": f"({_COLUMNS}, {_X}, {_X}, {_X})",
    "whittle.resonance": f"({_COLUMNS}, {_COLUMNS}, float64, float64, boolean)",
    "squared.add_overlapped": f"({_X}, {_X}, {_M}, int64, int64)",
    "passing.off": f"({_X}, {_X}, int64)",
    "cosine._binned": f"({_X}, {_M}, {_M})",
    "cosine.less_constant": f"({_X}, float64)",
    "cosine.less_ramp": f"({_X}, float64)",
    "theo.parabola_sums": f"({_X}, float64, float64)",
    "allan.integrate": f"({_X}, float64)",
}


def ready(compiling: Callable[[], None], *, alone: bool) -> None:
    """Load the kernels of the usual analysis, or compile those that are not in the cache."""
    begun = _Begun(compiling, alone or not KEPT)
    try:
        with event.install_listener("numba:compile", begun):
            load(HERE)
            begun.wait()
            load(THERE)
    finally:
        begun.end()


class _Begun(event.Listener):
    """Starts the other process when something has to be compiled."""

    def __init__(self, compiling: Callable[[], None], alone: bool) -> None:
        self.compiling, self.alone = compiling, alone
        self.other: subprocess.Popen[bytes] | None = None

    def on_start(self, _: event.Event) -> None:
        """Called when the compiling of a kernel or part begins."""
        self.compiling()
        if not self.alone:
            self.alone = True
            with suppress(OSError):
                # -P: a module in the current folder may have the name of one of ours
                self.other = subprocess.Popen(  # noqa: S603  our own program, and no shell
                    [sys.executable, "-P", "-m", __name__], stdin=DEVNULL, stdout=DEVNULL, stderr=DEVNULL
                )

    def on_end(self, _: event.Event) -> None:
        """Nothing is to be done."""

    def wait(self) -> None:
        """Wait for the other process, which is not started any more."""
        self.alone = True
        while self.other is not None and self.other.poll() is None:
            self.compiling()
            time.sleep(0.02)

    def end(self) -> None:
        """Leave no process behind; what is compiled is written in one step, or not at all."""
        if self.other is not None:
            self.other.kill()
            self.other.wait()


def load(kernels: dict[str, str]) -> None:
    """Load or compile kernels, in this order."""
    for name, types in kernels.items():
        module, _, kernel = name.partition(".")
        arguments, _ = normalize_signature(types)  # type: ignore[no-untyped-call]
        # by these, and not by their text, a call finds the code in the cache
        getattr(import_module(f"allanite.kernels.{module}"), kernel).compile(arguments)


if __name__ == "__main__":
    load(THERE)
