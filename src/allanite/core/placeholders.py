"""Words in a proposed command in whose place the user puts what no file says."""

import re
from collections.abc import Sequence
from itertools import pairwise

from .errors import UsageError

UNIT, RATE, SCALE, COLUMN = "UNIT", "HZ", "SCALE", "COLUMN"

MEANINGS = {
    UNIT: "the unit, such as deg/s, rad/s, m/s^2 or g, of time s, ms, us or ns",
    RATE: "the sampling rate, a number of Hz",
    SCALE: "the size of one count with its unit, such as 0.01deg/s",
    COLUMN: "the name or number of a column",
}

_PLACES = {"--unit": rf"\b({COLUMN}|{UNIT})\b", "--rate": rf"({RATE})", "--scale": rf"({SCALE})",
           "--time": rf".*\[({UNIT})\]"}  # fmt: skip
"""The option of each, and what its value is then."""


def demand_filled(words: Sequence[str]) -> None:
    """Refuse a command in which a placeholder was left.

    Raises
    ------
    UsageError
        The message says what belongs in its place.

    Examples
    --------
    >>> demand_filled(["info", "a.csv", "--rate", "HZ"])
    Traceback (most recent call last):
        ...
    allanite.core.errors.UsageError: --rate HZ: HZ stands for the sampling rate, a number of Hz; put it in its place
    """
    joined = (word.split("=", 1) for word in words if word.startswith("--") and "=" in word)
    for option, value in (*pairwise(words), *joined):
        match = re.search(_PLACES[option], value) if option in _PLACES else None
        if match:
            what = f"{match[1]} stands for {MEANINGS[match[1]]}"
            raise UsageError(f"{option} {value}: {what}; put it in its place")
