"""PSINS text: the increments of a strapdown unit, as the toolbox of Yan Gongmin (NWPU Xi'an) logs them."""

from itertools import islice
from pathlib import Path

import numpy as np

from allanite.core.errors import DataError
from allanite.core.record import Recording
from allanite.phrases.phrase import say
from allanite.readers.columns import parse
from allanite.readers.columns.column import FileColumn
from allanite.readers.columns.layout import Layout, decoded, is_number, numbered_lines
from allanite.readers.columns.table import FileTable
from allanite.readers.options import Options

TITLE = "PSINS text: three header rows, then integer increments of three gyros and three accelerometers"

_CHANNELS = (("gx", "arcsec"), ("gy", "arcsec"), ("gz", "arcsec"), ("ax", "ug*s"), ("ay", "ug*s"), ("az", "ug*s"))
_GRAVITY = (9.7, 9.9)  # m/s^2, anywhere on the Earth


def sniff(head: bytes, suffix: str) -> bool:
    """Whether the first line names PSINS, or the first three rows have the shape of its header."""
    lines = head.splitlines()
    if lines and lines[0].lstrip().startswith(b"%") and b"PSINS" in lines[0]:
        return True
    texts = (decoded(line).strip() for line in lines)
    rows = list(islice((text.split() for text in texts if text and not text.startswith("%")), 3))
    if len(rows) < 3 or not all(len(row) == 6 and all(map(is_number, row)) for row in rows):
        return False
    place, scales = ([float(cell) for cell in row] for row in rows[1:])
    return _GRAVITY[0] < place[5] < _GRAVITY[1] and place[4] > 0 and abs(place[0]) <= 90 and min(scales) > 0


def read(path: str, options: Options) -> Recording:
    """The six channels ``gx gy gz ax ay az`` as counts; interval and scale factors are in the file."""
    data = Path(path).read_bytes()
    rows = [(n, at, text.split()) for n, at, text in numbered_lines(data) if text and not text.lstrip().startswith("%")]
    if len(rows) < 4:
        raise DataError(
            f"a PSINS file has three header rows and then the increments, but {len(rows)} rows of numbers were found"
        )
    for line, _, row in rows[:3]:
        if len(row) != 6 or not all(map(is_number, row)):
            raise DataError(
                f"line {line} is a header row of a PSINS file and must hold six numbers, not {' '.join(row)[:60]!r}"
            )
    place, scales = ([float(cell) for cell in row] for _, _, row in rows[1:3])
    interval, gravity = place[4], place[5]
    if not interval > 0 or not all(scale > 0 for scale in scales):
        raise DataError(
            f"the sampling interval ({interval} ms) and the scale factors {scales} of a PSINS header must be positive"
        )
    names = tuple(name for name, _ in _CHANNELS)
    values, notes = parse.columns(data, Layout(" ", ".", names, ("",) * 6, frozenset(), rows[3][1], rows[3][0]))
    columns = [
        FileColumn(numbers, i, name, unit, "count", scale, header=name)
        for i, ((name, unit), numbers, scale) in enumerate(zip(_CHANNELS, values, scales, strict=True), 1)
        if isinstance(numbers, np.ndarray)
    ]
    where = say("the interval of {interval:g} ms in the second header row", interval=interval)
    return FileTable(
        tuple(columns), 1000 / interval, where,
        (say("local gravity in the header: {gravity:g} m/s^2", gravity=gravity), *notes),
    ).recording(options)  # fmt: skip
