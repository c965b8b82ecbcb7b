"""A text file as columns of any kind requested by name: angles, cosines, times."""

from dataclasses import dataclass

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.errors import DataError, UnitError, UsageError
from allanite.core.units import unit_of
from allanite.phrases.phrase import spelled
from allanite.readers.formats.text import sheet_of
from allanite.readers.sandbox.source import checked, digest_of

from .column import FileColumn, lookup, unique


@dataclass(frozen=True, eq=False)
class FileSheet:
    """The columns of a file, its path, its sha256, and the assumptions."""

    columns: tuple[FileColumn, ...]
    source: str = ""
    digest: str = ""
    notes: tuple[str, ...] = ()

    def values(self, key: str, unit: str, *, given: str | None = None) -> FloatArray:
        """The column `key` (name, header, or position from 1) in `unit`, float64 of shape (n,); empty cells are NaN."""
        # `given` is the unit of the column and overrides its header. A missing column or unknown unit raises
        # `UsageError`, another quantity `UnitError`, text `DataError`.
        column = lookup(self.columns, key)
        column.demand_numbers()
        stated = given or column.unit
        if not stated and unit != "1":
            raise UsageError(f"the unit of {column.label} is unknown: write it in the header as in '{column.name} "
                             f"[deg]', or pass {spelled('--unit deg', 'given=deg')}")  # fmt: skip
        size, wanted = unit_of(stated or "1"), unit_of(unit)
        # the difference of a cosine is a number, but may also be written as a small angle
        if size.dimension != wanted.dimension and not (unit == "1" and size.dimension == unit_of("rad").dimension):
            raise UnitError(f"{column.label} is in {stated!r}, which cannot be converted to {unit!r}")
        return np.asarray(column.values, dtype=np.float64) * (size.factor / wanted.factor)


def sheet(path: str) -> FileSheet:
    """Read the columns of a text or CSV file; `DataError` if it does not exist or contains no rows of numbers."""
    name, _ = checked(path)
    try:
        columns, notes = sheet_of(name)
    except DataError:
        raise DataError(f"{name}: no rows of numbers are found; a text or CSV file is expected, with the names of its "
                        "columns above rows of numbers") from None  # fmt: skip
    except OSError as error:
        raise DataError(f"{name}: the file cannot be read ({error.strerror or error})") from None
    return FileSheet(unique(tuple(columns)), name, digest_of(name), notes)
