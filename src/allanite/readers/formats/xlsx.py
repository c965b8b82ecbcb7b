"""Excel workbooks .xlsx: a sheet with one row per sample is read like a CSV file."""

from contextlib import suppress
from dataclasses import replace
from functools import partial

import numpy as np

from allanite.core.errors import DataError
from allanite.core.record import Recording
from allanite.phrases.phrase import say
from allanite.readers.columns import layout
from allanite.readers.columns.containers import Stream, any_inertial, stream_recording
from allanite.readers.columns.table import FileTable
from allanite.readers.options import Options
from allanite.readers.sandbox.process import Process, demand_members, demand_size, worded

from . import text

TITLE = "Excel workbook .xlsx (needs openpyxl)"

_ZIP, _PART = b"PK\x03\x04", b"xl/workbook.xml"


def sniff(head: bytes, suffix: str) -> bool:
    """Whether it is an archive with the suffix or the parts of a workbook."""
    return head.startswith(_ZIP) and (suffix in (".xlsx", ".xlsm") or _PART in head)


def read(path: str, options: Options) -> Recording:
    """The channels of a sheet, with the stored results of formulas; nothing in the workbook is executed."""
    with worded("the workbook"):
        demand_members(path, "the workbook")
    with Process("xlsx", path, options.progress) as process:

        def load(name: str, size: int) -> FileTable:
            demand_size(size, process.path, f"sheet {name!r}")
            return text.arranged(text.columns_of(process.load(name, (size,), np.dtype(np.uint8)).tobytes()), options)

        streams = list[Stream]()
        with worded("the workbook"):
            for item in process.contents["datasets"]:
                name, size, rows = str(item["path"]), int(item["size"]), int(item["rows"])
                with suppress(DataError):  # a sheet without rows of numbers
                    head = layout.find(str(item["head"]).encode())
                    fits = any_inertial(head.names, head.units)
                    count = rows - head.line + 1
                    streams.append(Stream(name, count, head.names, partial(load, name, size), likely=fits))
        if not streams:
            raise DataError(
                say("no sheet of the workbook has rows of numbers; formulas are read only if their results are stored")
            )
        likely = [stream for stream in streams if stream.likely]
        return stream_recording(streams if likely else [replace(stream, likely=True) for stream in streams], options)
