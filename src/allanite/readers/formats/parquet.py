"""Parquet tables: columns read one by one, units from their metadata or names."""

import json
from typing import Any

import numpy as np

from allanite.core.errors import DataError
from allanite.core.language import say
from allanite.core.record import Recording
from allanite.readers.columns.arrays import RATE_NAMES, column, is_number, of_arrow
from allanite.readers.columns.column import Column, headed
from allanite.readers.columns.datasets import WIDEST
from allanite.readers.columns.table import KEY, Table, described, restored
from allanite.readers.options import Options
from allanite.readers.sandbox.guard import demand_size, worded

TITLE = "Apache Parquet .parquet"

_MAGIC = b"PAR1"
_UNIT_NAMES = (b"unit", b"units", b"Unit", b"Units")


def sniff(head: bytes, suffix: str) -> bool:
    """Whether the first bytes, or else the name, are those of a Parquet file."""
    return head.startswith(_MAGIC) or suffix in (".parquet", ".pq")


def read(path: str, options: Options) -> Recording:
    """The channels of a Parquet table; a missing value is NaN."""
    import pyarrow as pa
    from pyarrow import parquet

    with worded(), parquet.ParquetFile(path, memory_map=True) as file:
        schema, rows = file.schema_arrow, file.metadata.num_rows
        if len(schema) > WIDEST:
            raise DataError(f"the table has {len(schema)} columns; expected one per channel")
        demand_size(rows * 8 * len(schema), path, "the table")
        demand_size(_unpacked(file.metadata), path, "the table")
        names = schema.names
        rate, text, index = _metadata(schema.metadata or {})
        columns, left = list[Column](), list[str]()
        for place, field in enumerate(schema, 1):
            if pa.types.is_nested(field.type):
                left.append(field.name)
            else:
                columns.append(_column(file, field, place, names[: place - 1].count(field.name)))
    notes = (say("left out, lists or structures: {names}", names=", ".join(left)),) if left else ()
    table = Table(tuple(c for c in columns if c.name not in index), rate, say("the metadata of the file"), notes)
    return restored(table, text).recording(options)


def write(recording: Recording, path: str) -> None:
    """A column for each channel, with its unit in the metadata of the column and the rate in that of the file."""
    import pyarrow as pa
    from pyarrow import parquet

    fields = [
        pa.field(r.name, pa.int64() if r.values.dtype.kind == "i" else pa.float64(), metadata={"unit": r.unit})
        for r in recording
    ]
    metadata = {KEY: described(recording), "rate": repr(recording[0].rate)}
    table = pa.table([pa.array(r.values) for r in recording], schema=pa.schema(fields, metadata))
    parquet.write_table(table, path, compression="zstd", use_dictionary=False)


def _unpacked(metadata: Any) -> int:
    """Size in bytes that the row groups claim to unpack to.

    The claims of single columns are not read: damaged statistics make pyarrow abort the interpreter
    ("Repetition level histogram size mismatch", pyarrow 26).
    """
    return sum(max(0, metadata.row_group(i).total_byte_size) for i in range(metadata.num_row_groups))


def _metadata(said: dict[bytes, bytes]) -> tuple[float | None, bytes, set[str]]:
    """Sampling rate, stored description and the columns that are only an index, if the file has them."""
    rates = [said[name.encode()] for name in RATE_NAMES if name.encode() in said]
    try:
        rate = float(rates[0]) if rates else None
    except ValueError:
        rate = None
    return rate if rate and 0 < rate < float("inf") else None, said.get(KEY.encode(), b""), _index(said)


def _index(said: dict[bytes, bytes]) -> set[str]:
    """The unnamed index that pandas writes as a column."""
    try:
        names = json.loads(said.get(b"pandas", b"{}")).get("index_columns", [])
    except (ValueError, AttributeError, RecursionError):
        return set()
    return {name for name in names if isinstance(name, str) and name.startswith("__index_level_")}


def _column(file: Any, field: Any, place: int, before: int) -> Column:
    """A column; `before` columns of the same name precede it."""
    said = field.metadata or {}
    unit = next((said[name].decode() for name in _UNIT_NAMES if name in said), "")
    if not is_number(field.type):
        # not all of it: a dictionary of long words may represent any length
        first = next(file.iter_batches(1, columns=[field.name], use_threads=False), None)
        word = None if first is None or not first.num_rows else first.column(before)[0].as_py()
        return headed(np.empty(0), place, field.name, text=str(word or "text")[:100])
    chunks = file.read([field.name], use_threads=False).column(before)
    return column(field.name, of_arrow(chunks), place, unit=unit)
