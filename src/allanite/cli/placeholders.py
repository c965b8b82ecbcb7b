"""Placeholders of a proposed command that were typed as they stand."""

import re
from collections.abc import Sequence
from itertools import pairwise

from allanite.core.errors import UsageError
from allanite.core.placeholders import COLUMN, MEANINGS, RATE, SCALE, UNIT

PLACES = {
    "--unit": rf"\b({COLUMN}|{UNIT})\b", "--rate": rf"\b({RATE})\b", "--scale": rf"\b({SCALE})\b",
    "--time": rf".*\[({UNIT})\]",
}  # fmt: skip
"""The options that have them, and where."""


def demand_filled(words: Sequence[str]) -> None:
    """Refuse a command in which a placeholder was left.

    Examples
    --------
    >>> demand_filled(["info", "a.csv", "--rate", "HZ"])
    Traceback (most recent call last):
        ...
    allanite.core.errors.UsageError: --rate HZ: put the sampling rate in Hz in the place of HZ
    """
    joined = (word.split("=", 1) for word in words if word.startswith("--") and "=" in word)
    for option, value in (*pairwise(words), *joined):
        match = re.search(PLACES[option], value) if option in PLACES else None
        if match:
            raise UsageError(f"{option} {value}: put {MEANINGS[match[1]]} in the place of {match[1]}")
