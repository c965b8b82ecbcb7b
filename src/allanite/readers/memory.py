"""How much memory a record needs, and how much of it may be used."""

import os
import re
from pathlib import Path

from allanite.core.errors import UsageError
from allanite.core.wording import spelled

NEED = 9
"""Memory that an analysis takes, over that of the samples as float64: measured with 3.2e7 samples of one channel."""

SHARE = 0.5
"""Share of the available memory that a record may take, unless it is given."""

_SIZE = re.compile(r"\s*(\d+(?:\.\d*)?)\s*([kMGT]?)i?B?\s*", re.IGNORECASE)
_UNITS = {"": 1, "k": 10**3, "m": 10**6, "g": 10**9, "t": 10**12}


def size_in_words(size: float) -> str:
    """A number of bytes with its unit, to three digits.

    Examples
    --------
    >>> size_in_words(72e9), size_in_words(1500)
    ('72 GB', '1.5 kB')
    """
    for unit, worth in (("TB", 1e12), ("GB", 1e9), ("MB", 1e6), ("kB", 1e3)):
        if size >= worth:
            return f"{size / worth:.3g} {unit}"
    return f"{size:.0f} B"


def bytes_of(text: str) -> int:
    """A size such as ``"1GB"`` or ``"500 MB"``.

    Examples
    --------
    >>> bytes_of("1GB"), bytes_of("1.5 MB")
    (1000000000, 1500000)
    """
    match = _SIZE.fullmatch(text)
    size = int(float(match[1]) * _UNITS[match[2].lower()]) if match else 0
    if not size:
        raise UsageError(f"{spelled('--memory', 'memory')} is a size such as 1GB or 500MB, not {text!r}")
    return size


def available() -> int:
    """Bytes of memory that are free, or could be."""
    try:
        lines = Path("/proc/meminfo").read_text().splitlines()
    except OSError:
        lines = []
    free = next((int(line.split()[1]) << 10 for line in lines if line.startswith("MemAvailable:")), 0)
    if not free and hasattr(os, "sysconf") and "SC_PHYS_PAGES" in os.sysconf_names:
        free = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    return free or 1 << 62  # a system that does not tell: reading may fail, as it did before


def allowed(memory: str | None, share: float = SHARE) -> int:
    """Bytes that a record may take: those given, or a share of those available."""
    return int(share * available()) if memory is None else bytes_of(memory)


def needed(numbers: int) -> int:
    """Bytes that the analysis of so many samples takes, all channels together."""
    return NEED * 8 * numbers
