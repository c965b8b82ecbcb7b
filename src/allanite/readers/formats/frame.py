"""Tables in memory, of pandas, polars or pyarrow: any object with ``columns`` whose entries have ``to_numpy()``."""

from typing import Any

import numpy as np

from allanite.core.errors import DataError, UsageError
from allanite.core.record import Recording
from allanite.readers.arrow import pa
from allanite.readers.columns import parse
from allanite.readers.columns.column import is_number, numbers, of_arrow
from allanite.readers.options import FrameLike, Options

from . import text


def read(frame: FrameLike, options: Options) -> Recording:
    """The channels of a table; the names of its columns are read like the headers of a CSV file."""
    # The index of a pandas table is a column too if it has a name or holds times. A missing value is NaN.
    if options.dtype is not None:
        raise UsageError("dtype, columns and offset describe raw binary files; omit them for a table in memory")
    named = list[tuple[str, Any]]()
    index: Any = getattr(frame, "index", None)
    if hasattr(index, "to_numpy"):
        values = index.to_numpy()
        if index.name is not None or values.dtype.kind in "Mm":
            named.append((str("time" if index.name is None else index.name), values))
    for name in getattr(frame, "column_names", frame.columns):  # pyarrow calls its arrays columns
        values = frame[name].to_numpy()
        if values.ndim != 1:
            raise DataError(f"several columns of the table, or one with several dimensions, are called {str(name)!r}")
        named.append((str(name), values))
    headers = tuple(name for name, _ in named)
    parsed = [_parsed(name, values) for name, values in named]
    columns, tags, notes = text.of_parsed(parsed, headers, ("",) * len(headers))
    return text.arranged(text.Parsed(columns, tags, notes), options).recording(options)


def _parsed(name: str, values: Any) -> parse.Parsed:
    """A column, parsed like that of a text file."""
    if values.dtype.kind in "Mm":
        return np.asarray(values.astype(f"{values.dtype.kind}8[ns]"))
    if values.dtype.kind in "iuf":
        return numbers(values, name)
    try:
        column = pa.chunked_array([pa.array(values, from_pandas=True)])
        if is_number(column.type):
            return of_arrow(column)
        words = column.cast(pa.string())
    except pa.ArrowException:
        return "objects"
    if column.null_count == len(values):
        return np.full(len(values), np.nan)
    return parse.words_of(words, f"column {name!r}")
