"""Column: one column of a file, and how a user refers to it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from numpy.typing import NDArray

from allanite.core.errors import DataError, UsageError
from allanite.core.names import nearest
from allanite.phrases.phrase import Phrase, join, say

from . import headers


@dataclass(frozen=True, eq=False)
class FileColumn:
    """One column of a file."""

    values: NDArray[Any]  # float64 or int64 of shape (n,), empty for text
    position: int  # in the file, counted from 1
    # what the file states, empty or None if it does not
    name: str = ""
    unit: str = ""
    kind: str = ""
    scale: float | None = None
    header: str = ""  # unchanged
    text: str = ""  # the first entry of a column of text, empty for numbers
    history: tuple[str, ...] = ()  # processing of the samples before they were written

    @property
    def label(self) -> str:
        """The name of the column in messages, as in its file."""
        return say("column {header!r}", header=self.header) if self.header else self.name

    def demand_numbers(self) -> None:
        """Refuse a column of text."""
        if self.text:
            raise DataError(say(
                "{column} holds text ({text!r}) instead of numbers; select another column",
                column=self.label, text=self.text,
            ))  # fmt: skip


def headed(values: NDArray[Any], position: int, header: str, *, unit: str = "", text: str = "") -> FileColumn:
    """A column with the name, and unless given the unit, from its header."""
    name, stated = headers.split(header)
    if unit:
        unit = unit.strip("[](){} ")
        name, stated, header = header.strip(), unit.strip(), f"{header.strip()} [{unit}]".strip()
    return FileColumn(values, position, name or f"column {position}", stated, header=header.strip(), text=text)


def unique(columns: tuple[FileColumn, ...]) -> tuple[FileColumn, ...]:
    """The columns with unique names: the second ``gx`` becomes ``gx 2``."""
    taken: set[str] = set()
    result = []
    for column in columns:
        name, again = column.name, 2
        while name in taken:
            name, again = f"{column.name} {again}", again + 1
        taken.add(name)
        result.append(replace(column, name=name))
    return tuple(result)


def lookup(columns: tuple[FileColumn, ...], key: str, choice: str = "channels") -> FileColumn:
    """The column called `key` by a choice: by name or header, ignoring case, or by its position counted from 1."""
    wanted = key.strip()
    exact = [column for column in columns if wanted in (column.name, column.header)]
    alike = [column for column in columns if wanted.lower() in (column.name.lower(), column.header.lower())]
    placed = [column for column in columns if wanted == str(column.position)]
    for column in (*exact, *alike, *placed):
        return column
    names = [f"{column.position}: {column.header or column.name}" for column in columns]
    meant = nearest(wanted, [column.name for column in columns])
    known = f"did you mean {meant}? Columns" if meant else "columns"
    cure = (wanted, meant) if meant else ("", "")
    raise UsageError(f"no column {key!r}; {known}: {some(names, 30)}", choice=choice, cure=cure)


def some(names: Sequence[str], most: int = 20) -> Phrase:
    """The names as text, at most `most` of them."""
    shown = join(", ", names[:most])
    if len(names) <= most:
        return shown
    return say("{names} and {count} more", names=shown, count=len(names) - most)
