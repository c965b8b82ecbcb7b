"""A format: a line with the sampling rate, then a sample of a gyroscope in deg/s on each line."""

import numpy as np

from allanite.core.errors import DataError
from allanite.core.record import Recording
from allanite.readers.columns.column import column
from allanite.readers.columns.table import FileTable
from allanite.readers.options import Options

TITLE = "tones of a recorder"


def sniff(head: bytes, suffix: str) -> bool:
    """Whether a file begins as such files do."""
    return head.startswith(b"TONES ")


def read(path: str, options: Options) -> Recording:
    """The channels of a file; what it lacks is in `options`."""
    try:
        with open(path, encoding="ascii") as file:
            rate, values = float(file.readline().split()[1]), np.array([float(line) for line in file])
    except (ValueError, IndexError) as error:
        raise DataError(f"no file of tones: {error}") from None
    table = FileTable((column("gz [deg/s]", values, 1),), rate=rate, rate_source="its first line")
    return table.recording(options)
