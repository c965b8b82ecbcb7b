"""Text by the cells of a terminal: a Chinese character takes two of them, and a line may end behind any one."""

import re
import textwrap
from collections.abc import Iterator

from rich.cells import cell_len

_WIDE = "\u2e80-\u9fff\uf900-\ufaff\uff00-\uff60"
_CHUNK = re.compile(rf"\s+|[（「《【“]*[{_WIDE}][，。；：、！？）」》】”]*|[^\s{_WIDE}]+")


def pad(text: str, width: int) -> str:
    """The text, filled with blanks to so many cells."""
    return text + " " * (width - cell_len(text))


def wrapped(text: str, width: int, first: str, rest: str) -> list[str]:
    """Lines of at most `width` cells, which begin with `first` and `rest`; words longer than that are not torn.

    Examples
    --------
    >>> wrapped("零偏不稳定性 0.3 deg/h", 12, "", "  ")
    ['零偏不稳定性', '  0.3 deg/h']
    """
    if len(text) == cell_len(text):
        return textwrap.wrap(
            text, width, initial_indent=first, subsequent_indent=rest, break_on_hyphens=False, break_long_words=False
        )
    return list(_lines(_CHUNK.findall(text), width, first, rest))


def _lines(chunks: list[str], width: int, line: str, rest: str) -> Iterator[str]:
    empty = True
    for chunk in chunks:
        if not empty and cell_len(line + chunk.rstrip()) > width:
            yield line.rstrip()
            line, empty = rest, True
        if not (empty and chunk.isspace()):
            line, empty = line + (" " if chunk.isspace() else chunk), False
    if not empty:
        yield line.rstrip()
