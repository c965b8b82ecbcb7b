"""From bytes to rows of numbers: lines of numbers with commas, semicolons, tabs or blanks between them."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from allanite.core.errors import UsageError
from allanite.readers.columns.column import headed, lookup, unique

UNIT = re.compile(r"[\[(].*$")
"""What follows a name in a heading."""

LONGEST = 1 << 16
"""Bytes of a line, beyond which it is not one of text."""


@dataclass
class Lines:
    """Collects bytes and gives rows; what is no row of numbers is a row of NaN.

    The first line may hold names. A line that is not complete waits for the rest of it.
    """

    names: tuple[str, ...] = ()
    width: int = 0
    bad: int = 0
    between: bytes | None = None
    rest: bytes = field(default=b"", repr=False)
    head: bytes = field(default=b"", repr=False)

    def rows(self, data: bytes) -> list[list[float]]:
        """The rows that are complete now."""
        *whole, self.rest = (self.rest + data).split(b"\n")
        if len(self.rest) > LONGEST:
            raise UsageError("what comes has no lines; send lines of numbers, with commas or blanks between them")
        found = (self._row(line) for line in whole)
        return [row for row in found if row is not None]

    def torn(self) -> None:
        """Forget the line that will not be completed."""
        self.rest = b""

    def _row(self, line: bytes) -> list[float] | None:
        line = line.strip()
        if not line or line.startswith(b"#"):
            return None
        if not self.width:
            self.between = next((mark for mark in (b",", b";", b"\t") if mark in line), None)
        parts = line.split(self.between)
        try:
            row = [float(part) for part in parts]
        except ValueError:
            row = []
        if not self.width:
            if not row:
                self.head = line
                return None
            self.width = len(row)
            self.names = self._named()
        if len(row) != self.width:
            self.bad += 1
            return [math.nan] * self.width
        return row

    def _named(self) -> tuple[str, ...]:
        """The names above the first row of numbers, if there are as many; a single one may contain blanks."""
        if not self.head:
            return ()
        parts = [self.head] if self.width == 1 else self.head.split(self.between)
        if len(parts) != self.width:
            return ()
        return tuple(UNIT.sub("", part.decode("utf-8", "replace")).strip() for part in parts)


def places(lines: Lines, wanted: Sequence[str] | None, time: str | None) -> tuple[dict[str, int], int | None]:
    """Columns of the channels, by name, and that of the time, as indices; columns are called as those of a file.

    Raises
    ------
    UsageError
        There is no such column.
    """
    headers = lines.names or ("",) * lines.width
    every = unique(tuple(headed(np.empty(0), place, header) for place, header in enumerate(headers, 1)))
    clock = None if time is None else lookup(every, time)
    chosen = (
        [column for column in every if column is not clock] if wanted is None else [lookup(every, w) for w in wanted]
    )
    return {column.name: column.position - 1 for column in chosen}, None if clock is None else clock.position - 1
