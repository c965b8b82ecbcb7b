"""The standard streams, which may be closed or full, or have a reader that has left: the only door to the terminal."""

import errno
import io
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import click


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


def show(text: str) -> None:
    """Write lines to standard output; names in them must not drive the terminal."""
    click.echo(_harmless(text))


def hand_over(data: str | bytes) -> None:
    """Write a result to standard output as it is: its renderer made the names harmless, or it is for a program."""
    click.echo(data, nl=False)


def complain(text: str, before: str = "") -> None:
    """Write to standard error, as far as it can be written to; what stands `before` the text may drive the terminal."""
    try:
        click.echo(before + _harmless(text), err=True)
    except OSError:
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115 - what is left in the old one is not flushed


def _harmless(text: str) -> str:
    from allanite.reporting.digits import printable

    return "\n".join(map(printable, text.split("\n")))
