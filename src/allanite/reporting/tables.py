"""Tables of plain text: numbers to the right, words to the left."""

import textwrap
from collections.abc import Iterator, Sequence

from .words import printable


def table_lines(head: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    r"""Headings and rows, two blanks between columns.

    Examples
    --------
    >>> print("\n".join(table_lines(["stage", "bits"], [["ADC", "12"], ["output", "8"]])))
      stage   bits
      ADC       12
      output     8
    """
    columns = list(zip(head, *rows, strict=True))
    widths = [max(map(len, column)) for column in columns]
    right = [all(cell[:1] in "+-.<0123456789" for cell in column[1:] if cell) for column in columns]
    for row in (head, *rows):
        cells = (
            printable(cell).rjust(w) if r else printable(cell).ljust(w)
            for cell, w, r in zip(row, widths, right, strict=True)
        )
        yield ("  " + "  ".join(cells)).rstrip()


def prose_lines(text: str, width: int, first: str = "  ") -> list[str]:
    """A sentence in lines of at most `width`."""
    return textwrap.wrap(
        printable(text), max(width, 40), initial_indent=first, subsequent_indent=" " * (len(first) + 2),
        break_long_words=False,
    )  # fmt: skip
