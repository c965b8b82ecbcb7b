"""Parts: a file whose rows are read a part at a time; their meaning is that of the first rows."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from allanite.readers.options import Options

from .table import FileTable

HEAD = 1 << 18
"""Rows by which columns, units and the clock are recognized."""

Blocks = Callable[[Sequence[int], int], Iterator[list[NDArray[Any]]]]
"""Indices of columns, and rows at a time -> arrays of these columns, of at most about that many rows."""


@dataclass(frozen=True, eq=False)
class Parts:
    """A file that can be read in parts.

    `head` is the table of its first rows, `rows` their number in the whole file, `blocks` reads columns of `head` from
    the beginning, and `options` are those of the head, which a container may have narrowed.
    """

    head: FileTable
    rows: int
    blocks: Blocks
    options: Options
