"""The cells of a line of text, and whether they are numbers."""

import csv
import re
from typing import NamedTuple

MISSING = frozenset(("", "nan", "null", "na", "n/a", "#n/a", "-nan", "none", "1.#qnan", "-1.#ind", "1.#ind"))

_NUMBER = re.compile(r"[-+]?(?:(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?|nan|inf|infinity)", re.IGNORECASE)


class Row(NamedTuple):
    """A line of the file: its number from 1, where it begins, its cells."""

    line: int
    offset: int
    cells: list[str]


def is_number(cell: str, decimal: str = ".") -> bool:
    """Whether a cell is a number.

    Examples
    --------
    >>> is_number("-1.5e-3"), is_number("1,5", ","), is_number("1_000"), is_number("0x10")
    (True, True, False, False)
    """
    return bool(_NUMBER.fullmatch(cell if decimal == "." else cell.replace(decimal, ".", 1)))


def cells(line: str, delimiter: str) -> list[str]:
    """The cells of a line, without quotes and outer blanks."""
    if delimiter == " ":
        return line.split()
    if '"' in line:
        try:
            return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])]
        except csv.Error:
            pass  # a stray quotation mark: cut at the delimiters
    return [cell.strip() for cell in line.split(delimiter)]


def decoded(raw: bytes) -> str:
    """Text of a header: UTF-8, or else Latin-1, in which the degree sign of older loggers is written."""
    try:
        return raw.decode("utf-8")
    except UnicodeDecodeError:
        return raw.decode("latin-1")


def has_number(row: Row, decimal: str) -> bool:
    """Whether a row has a number in it."""
    return any(is_number(cell, decimal) for cell in row.cells)
