"""A format whose files name a pipe, and are read once that is closed: a job that takes as long as a test wants."""

import numpy as np

from allanite.core.record import Recording
from allanite.readers.columns.column import column
from allanite.readers.columns.table import FileTable
from allanite.readers.options import Options

TITLE = "a file that waits"


def sniff(head: bytes, suffix: str) -> bool:
    """Whether a file begins as such files do."""
    return head.startswith(b"WAIT ")


def read(path: str, options: Options) -> Recording:
    """Zeros, after the pipe is closed."""
    with open(path, encoding="utf-8") as file:
        pipe = file.readline().split(maxsplit=1)[1].strip()
    with open(pipe, "rb") as end:
        end.read()
    table = FileTable((column("gz [deg/s]", np.zeros(1000), 1),), rate=100.0, rate_source="this format")
    return table.recording(options)
