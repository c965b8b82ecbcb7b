"""Binary files of KF-GINS: rows of seven doubles, time and increments of three gyroscopes and three accelerometers.

Raw binary is never guessed: nothing in these files says what they are. They are read if the user says so with the type
``kfgins``; otherwise, rows that look like it are refused with that advice.

Source of the format: KF-GINS (i2Nav Group, Wuhan University), README.
"""

import os

import numpy as np

from allanite.core.errors import UsageError
from allanite.core.record import Recording
from allanite.phrases.phrase import say, spelled
from allanite.readers.columns.column import FileColumn
from allanite.readers.columns.table import FileTable
from allanite.readers.options import Options

TITLE = "KF-GINS binary (give the dtype kfgins)"

_CHANNELS = (("gx", "rad"), ("gy", "rad"), ("gz", "rad"), ("ax", "m/s"), ("ay", "m/s"), ("az", "m/s"))
_WIDTH = 8 * (1 + len(_CHANNELS))
_FEWEST = 20
_STEPS, _RATE, _GRAVITY = (1e-4, 0.5), 20.0, (8.0, 12.0)  # s, rad/s, m/s^2


def sniff(head: bytes, suffix: str) -> bool:
    """Whether the first rows have even times, and increments of a unit on the Earth that hardly moves."""
    count = len(head) // _WIDTH
    if count < _FEWEST:
        return False
    rows = np.frombuffer(head, "<f8", 7 * count).reshape(count, 7)
    # most doubles of other files are far too large or too small
    if not np.all(np.isfinite(rows)) or np.abs(rows).max() > 1e12:
        return False
    steps = np.diff(rows[:, 0])
    step = float(np.median(steps))
    if not _STEPS[0] <= step <= _STEPS[1] or np.mean(np.abs(steps / step - 1) < 0.2) < 0.9:
        return False
    rates = np.abs(rows[:, 1:4]).max() / step
    gravity = float(np.median(np.sqrt(np.square(rows[:, 4:]).sum(axis=1)))) / step
    return bool(rates < _RATE and _GRAVITY[0] < gravity < _GRAVITY[1])


def read(path: str, options: Options) -> Recording:
    """The six channels ``gx gy gz ax ay az`` as increments, and their clock."""
    # refuse to read what was not asked for: rows in degrees, or of rates and g at 10 Hz, look the same
    if options.dtype is None:
        raise UsageError(say(
            "rows of seven doubles, which may be KF-GINS binary: time in s, increments in rad and m/s; if they "
            "are, use {option}; if not, {other} reads them as plain numbers",
            option=spelled("--dtype kfgins", "dtype='kfgins'"), other=spelled("--dtype 7f8", "dtype='7f8'"),
        ))  # fmt: skip
    if (options.columns, options.offset) != (None, None):
        raise UsageError(say("KF-GINS binary has rows of seven doubles and no header; omit {option}",
                             option=spelled("--columns and --offset", "columns and offset")))  # fmt: skip
    count, rest = divmod(os.path.getsize(path), _WIDTH)
    rows = np.fromfile(path, "<f8", 7 * count).reshape(count, 7)
    columns = [FileColumn(np.ascontiguousarray(rows[:, 0]), 1, "time", "s", header="time")]
    for i, (name, unit) in enumerate(_CHANNELS, 1):
        columns.append(FileColumn(np.ascontiguousarray(rows[:, i]), i + 1, name, unit, "increment", header=name))
    notes = [say("rows of seven doubles are read as KF-GINS binary: time in s, increments in rad and m/s")]
    if rest:
        notes.append(say("the last {bytes} bytes are no whole row and are left out", bytes=rest))
    return FileTable(tuple(columns), notes=tuple(notes)).recording(options)
