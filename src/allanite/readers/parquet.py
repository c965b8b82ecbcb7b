"""Parquet tables: columns read one by one, units from their metadata or their names."""

import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.record import Recording

from .arrays import RATE_NAMES, column
from .column import Column, headed
from .description import KEY, described, restored
from .guard import demand_size, worded
from .options import Options
from .table import Table

TITLE = "Apache Parquet .parquet"

_MAGIC = b"PAR1"
_UNIT_NAMES = (b"unit", b"units", b"Unit", b"Units")


def sniff(head: bytes, suffix: str) -> bool:
    """Whether the first bytes, or else the name, are those of a Parquet file."""
    return head.startswith(_MAGIC) or suffix in (".parquet", ".pq")


def read(path: str, options: Options) -> Recording:
    """The channels of a Parquet table; a missing value is NaN.

    Raises
    ------
    DataError
        The file is damaged, or claims more readings than it can hold.
    UsageError
        What the file does not say is not given either.
    """
    import pyarrow as pa
    from pyarrow import parquet

    with worded(), parquet.ParquetFile(path, memory_map=True) as file:
        schema, rows = file.schema_arrow, file.metadata.num_rows
        demand_size(rows * 8 * len(schema), path, "the table")
        demand_size(_unpacked(file.metadata), path, "the table")
        rate, text, index = _metadata(schema.metadata or {})
        columns, left = list[Column](), list[str]()
        for place, field in enumerate(schema, 1):
            if pa.types.is_nested(field.type):
                left.append(field.name)
            else:
                columns.append(_column(file, field, place))
    notes = (f"left out, lists or structures: {', '.join(left)}",) if left else ()
    table = Table(tuple(c for c in columns if c.name not in index), rate, "the metadata of the file", notes)
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
    """Bytes that the pages of a file claim to unpack to."""
    groups = (metadata.row_group(i) for i in range(metadata.num_row_groups))
    return sum(group.column(j).total_uncompressed_size for group in groups for j in range(group.num_columns))


def _metadata(said: dict[bytes, bytes]) -> tuple[float | None, bytes, set[str]]:
    """Sampling rate, our own description and the columns that are only an index, as far as the file has them."""
    rates = [said[name.encode()] for name in RATE_NAMES if name.encode() in said]
    try:
        rate = float(rates[0]) if rates else None
    except ValueError:
        rate = None
    return rate if rate and 0 < rate < float("inf") else None, said.get(KEY.encode(), b""), _index(said)


def _index(said: dict[bytes, bytes]) -> set[str]:
    """The nameless index that pandas writes as a column of its own."""
    try:
        names = json.loads(said.get(b"pandas", b"{}")).get("index_columns", [])
    except (ValueError, AttributeError, RecursionError):
        return set()
    return {name for name in names if isinstance(name, str) and name.startswith("__index_level_")}


def _column(file: Any, field: Any, place: int) -> Column:
    said = field.metadata or {}
    unit = next((said[name].decode() for name in _UNIT_NAMES if name in said), "")
    values = _values(file.read([field.name], use_threads=False).column(0))
    if isinstance(values, str):
        return headed(np.empty(0), place, field.name, text=values)
    return column(field.name, values, place, unit=unit)


def _values(chunks: Any) -> NDArray[Any] | str:
    """Numbers or stamps, NaN or NaT where one is missing; of anything else the first entry as text."""
    import pyarrow as pa

    kind = chunks.type
    if pa.types.is_decimal(kind) or pa.types.is_null(kind):
        chunks = chunks.cast(pa.float64())
    elif pa.types.is_date(kind):
        chunks = chunks.cast(pa.timestamp("ns"))
    elif pa.types.is_time(kind):  # of day
        chunks = chunks.cast(pa.time64("ns")).cast(pa.int64()).cast(pa.duration("ns"))
    kind = chunks.type
    if pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_timestamp(kind):
        return np.asarray(chunks.to_numpy())
    if pa.types.is_duration(kind):
        return np.asarray(chunks.to_numpy())
    first = next((entry for chunk in chunks.chunks for entry in chunk[:100].to_pylist() if entry is not None), "text")
    return str(first) or "text"
