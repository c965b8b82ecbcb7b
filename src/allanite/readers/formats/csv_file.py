"""CSV as this package writes it: the description in a comment, a header with units, a row for each sample."""

import re
from pathlib import Path

from allanite.core.record import Recording
from allanite.readers.columns.description import KEY, described, restored
from allanite.readers.columns.table import Table

_COMMENT = re.compile(rb'# (\{"%s": .*\})\r?\n' % KEY.encode())


def write(recording: Recording, path: str) -> None:
    """A column for each channel; other programs pass over the first line as a comment."""
    import pyarrow as pa
    from pyarrow import csv

    table = pa.table([pa.array(r.values) for r in recording], names=[str(i) for i in range(len(recording))])
    header = ",".join(f"{_plain(r.name)} [{r.unit}]" for r in recording)
    with Path(path).open("wb") as file:
        file.write(f"# {described(recording)}\n{header}\n".encode())
        csv.write_csv(table, file, csv.WriteOptions(include_header=False, quoting_style="none"))


def with_description(table: Table, data: bytes) -> Table:
    """The table of a text with what the description in its first line says, if there is one."""
    match = _COMMENT.match(data)
    return restored(table, match[1]) if match else table


def _plain(name: str) -> str:
    """A name that no reader of CSV takes for several."""
    return re.sub(r"[^\w.+-]+", "_", name) or "column"
