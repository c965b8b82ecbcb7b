"""Column: one column of a file, and how a user points at it."""

from dataclasses import dataclass, replace
from typing import Any

from numpy.typing import NDArray

from allanite.core.errors import DataError, UsageError

from . import headers


@dataclass(frozen=True, eq=False)
class Column:
    """One column of a file.

    Parameters
    ----------
    values : array, shape (n,)
        float64 or int64; empty if the column holds text.
    position : int
        Its place in the file, counted from 1.
    name, unit, kind, scale
        What the file says about it; empty or None where it says nothing.
    header : str
        The header as it stands in the file; empty if there is none.
    text : str
        The first entry of a column of text; empty for numbers.
    history : tuple of str
        What was done to the readings before they were written.
    """

    values: NDArray[Any]
    position: int
    name: str = ""
    unit: str = ""
    kind: str = ""
    scale: float | None = None
    header: str = ""
    text: str = ""
    history: tuple[str, ...] = ()

    @property
    def label(self) -> str:
        """The column in a message, as its file names it."""
        return f"column {self.header!r}" if self.header else self.name

    def demand_numbers(self) -> None:
        """Refuse a column of text.

        Raises
        ------
        DataError
            The column holds text.
        """
        if self.text:
            raise DataError(f"{self.label} holds text ({self.text!r}), numbers are expected; choose another column")


def headed(values: NDArray[Any], position: int, header: str, *, unit: str = "", text: str = "") -> Column:
    """A column whose name, and unit unless it is given, are read off its header.

    Examples
    --------
    >>> import numpy as np
    >>> column = headed(np.array([1.0, 2.0]), 1, "gx [deg/s]")
    >>> column.name, column.unit, column.label
    ('gx', 'deg/s', "column 'gx [deg/s]'")
    """
    name, said = headers.split(header)
    if unit:
        unit = unit.strip("[](){} ")
        name, said, header = header.strip(), unit.strip(), f"{header.strip()} [{unit}]".strip()
    return Column(values, position, name or f"column {position}", said, header=header.strip(), text=text)


def unique(columns: tuple[Column, ...]) -> tuple[Column, ...]:
    """The columns with no name twice: the second ``gx`` becomes ``gx 2``."""
    taken: set[str] = set()
    result = []
    for column in columns:
        name, again = column.name, 2
        while name in taken:
            name, again = f"{column.name} {again}", again + 1
        taken.add(name)
        result.append(replace(column, name=name))
    return tuple(result)


def lookup(columns: tuple[Column, ...], key: str) -> Column:
    """The column called `key`: by name, by header, regardless of case, or by its place counted from 1.

    Raises
    ------
    UsageError
        There is none; the message lists the columns.
    """
    wanted = key.strip()
    exact = [column for column in columns if wanted in (column.name, column.header)]
    alike = [column for column in columns if wanted.lower() in (column.name.lower(), column.header.lower())]
    placed = [column for column in columns if wanted == str(column.position)]
    for column in (*exact, *alike, *placed):
        return column
    raise UsageError(f"no column {key!r}; there are {listed(columns)}")


def listed(columns: tuple[Column, ...]) -> str:
    """The columns in words, not more than 30 of them."""
    names = [f"{column.position}: {column.header or column.name!s}" for column in columns[:30]]
    return ", ".join(names) + (f" and {len(columns) - 30} more" if len(columns) > 30 else "")
