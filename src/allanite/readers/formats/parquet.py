"""Parquet tables: columns read one by one, units from their metadata or names."""

import json
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.core.errors import DataError
from allanite.core.files import in_utf8
from allanite.core.record import Recording
from allanite.phrases.phrase import say
from allanite.readers.arrow import pa, parquet
from allanite.readers.columns.column import RATE_NAMES, FileColumn, column, headed, is_number, of_arrow
from allanite.readers.columns.containers import WIDEST
from allanite.readers.columns.lines import HEAD_ROWS, Parts
from allanite.readers.columns.table import KEY, FileTable, described, restored, with_units
from allanite.readers.options import Options
from allanite.readers.sandbox.process import demand_size, worded

TITLE = "Apache Parquet .parquet"

BUFFERED: dict[str, Any] = {"pre_buffer": False, "buffer_size": 1 << 20}  # bytes ahead, instead of a whole row group

_UNIT_NAMES = (b"unit", b"units", b"Unit", b"Units")


def read(path: str, options: Options) -> Recording:
    """The channels of a Parquet table; a missing value is NaN."""
    with worded(), in_utf8(path) as source, parquet.ParquetFile(source, memory_map=True) as file:
        table = _table(file, path, lambda field, before: file.read([field.name], use_threads=False).column(before))
    return table.recording(options)


def parts(path: str, options: Options) -> Parts:
    """The rows of a Parquet table, which are decoded one batch after the other."""
    with worded(), in_utf8(path) as source, parquet.ParquetFile(source, **BUFFERED) as file:

        def first_rows(field: Any, before: int) -> Any:
            first = next(file.iter_batches(HEAD_ROWS, columns=[field.name], use_threads=False), None)
            batches, schema = ([], None) if first is None else ([first], first.schema)
            return pa.Table.from_batches(batches, schema).column(before)

        table = _table(file, path, first_rows)
        rows, names = file.metadata.num_rows, file.schema_arrow.names

    def blocks(wanted: Sequence[int], at_once: int) -> Iterator[list[NDArray[Any]]]:
        fields = [table.columns[i].position - 1 for i in wanted]
        keys = list(dict.fromkeys(names[i] for i in fields))
        with worded(), in_utf8(path) as source, parquet.ParquetFile(source, **BUFFERED) as file:
            for batch in file.iter_batches(at_once, columns=keys, use_threads=len(keys) > 1):
                # columns come in the order of the file, and all that have a name
                held = [i for i, name in enumerate(names) if name in keys]
                yield [of_arrow(pa.chunked_array([batch.column(held.index(i))])) for i in fields]

    return Parts(table, rows, blocks, options)


def _table(file: Any, path: str, load: Callable[[Any, int], Any]) -> FileTable:
    """The columns of a file; `load` reads that of a field which so many of the same name precede."""
    schema, rows = file.schema_arrow, file.metadata.num_rows
    if len(schema) > WIDEST:
        raise DataError(f"the table has {len(schema)} columns; expected one per channel")
    demand_size(rows * 8 * len(schema), path, "the table")
    # what row groups claim to unpack to; damaged statistics of single columns make pyarrow abort the interpreter
    groups = map(file.metadata.row_group, range(file.metadata.num_row_groups))
    demand_size(sum(max(0, group.total_byte_size) for group in groups), path, "the table")
    rate, text, index = _metadata(schema.metadata or {})
    columns, nested = list[FileColumn](), list[str]()
    for place, field in enumerate(schema, 1):
        if pa.types.is_nested(field.type):
            nested.append(field.name)
            continue
        before, about = schema.names[: place - 1].count(field.name), field.metadata or {}
        unit = next((about[name].decode() for name in _UNIT_NAMES if name in about), "")
        if is_number(field.type):
            columns.append(column(field.name, of_arrow(load(field, before)), place, unit=unit))
        else:
            # not all of it: a dictionary of long words may represent any length
            first = next(file.iter_batches(1, columns=[field.name], use_threads=False), None)
            word = None if first is None or not first.num_rows else first.column(before)[0].as_py()
            columns.append(headed(np.empty(0), place, field.name, text=str(word or "text")[:100]))
    notes = (say("left out, lists or structures: {names}", names=", ".join(nested)),) if nested else ()
    table = FileTable(tuple(c for c in columns if c.name not in index), rate, say("the metadata of the file"), notes)
    return restored(table, text)


def write(recording: Recording, path: str) -> None:
    """A column for each channel, with its unit in the metadata of the column and the rate in that of the file."""
    fields = [
        pa.field(r.name, pa.int64() if r.values.dtype.kind == "i" else pa.float64(), metadata={"unit": r.unit})
        for r in recording
    ]
    headers = with_units([r.name for r in recording], recording)
    metadata = {KEY: described(recording, headers), "rate": repr(recording[0].rate)}
    table = pa.table([pa.array(r.values) for r in recording], schema=pa.schema(fields, metadata))
    with in_utf8(path, "wb") as target:
        parquet.write_table(table, target, compression="zstd", use_dictionary=False)


def _metadata(metadata: dict[bytes, bytes]) -> tuple[float | None, bytes, set[str]]:
    """Sampling rate, stored description and the columns that are only an index, as pandas writes it without a name."""
    rates = [metadata[name.encode()] for name in RATE_NAMES if name.encode() in metadata]
    try:
        rate = float(rates[0]) if rates else None
    except ValueError:
        rate = None
    try:
        names = json.loads(metadata.get(b"pandas", b"{}")).get("index_columns", [])
    except (ValueError, AttributeError, RecursionError):
        names = []
    index = {name for name in names if isinstance(name, str) and name.startswith("__index_level_")}
    return rate if rate and 0 < rate < float("inf") else None, metadata.get(KEY.encode(), b""), index
