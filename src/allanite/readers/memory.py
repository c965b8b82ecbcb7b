"""How much memory a record needs, and how much of it may be used."""

import os
import re
from pathlib import Path

from allanite.core.errors import UsageError
from allanite.phrases.wording import spelled

NEED = 9
"""Memory that an analysis takes, over that of the samples as float64: measured with 3.2e7 samples of one channel."""

SHARE = 0.5
"""Share of the available memory that a record may take, unless it is given."""

UNKNOWN = 1 << 60
"""Bytes that are free on a system that does not tell: reading may fail, as it would without the question."""

MACHINE, OWN = Path("/proc/meminfo"), Path("/proc/self/statm")

GROUPS = (
    (Path("/sys/fs/cgroup/memory.max"), Path("/sys/fs/cgroup/memory.current"), "inactive_file "),
    (
        Path("/sys/fs/cgroup/memory/memory.limit_in_bytes"),
        Path("/sys/fs/cgroup/memory/memory.usage_in_bytes"),
        "total_inactive_file ",
    ),
)
"""Limit and use of a container, as its own control group is mounted in it, and the line of what can be given back."""

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
    """Bytes of memory that this process may still take: of the machine, its control group and its address space."""
    return max(0, min(_of_machine(), _of_group(), _of_addresses()))


def _of_machine() -> int:
    free = next((int(line.split()[1]) << 10 for line in _lines(MACHINE) if line.startswith("MemAvailable:")), 0)
    if not free and hasattr(os, "sysconf") and "SC_PHYS_PAGES" in os.sysconf_names:
        free = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    return free or UNKNOWN


def _of_group() -> int:
    """What the control group of a container leaves; what the system caches of files is given back."""
    left = UNKNOWN
    for limit, used, cached in GROUPS:
        most = next((int(line) for line in _lines(limit) if line.isdigit()), UNKNOWN)
        if most < UNKNOWN:
            lines = _lines(limit.parent / "memory.stat")
            kept = next((int(line.split()[1]) for line in lines if line.startswith(cached)), 0)
            left = min(left, most - int(_lines(used)[0]) + kept)
    return left


def _of_addresses() -> int:
    """What ``ulimit -v`` leaves."""
    try:
        import resource
    except ImportError:  # not of this system
        return UNKNOWN
    most, _ = resource.getrlimit(resource.RLIMIT_AS)
    if most == resource.RLIM_INFINITY:
        return UNKNOWN
    pages = next((int(line.split()[0]) for line in _lines(OWN)), 0)
    return most - pages * resource.getpagesize()


def _lines(path: Path) -> list[str]:
    try:
        return path.read_text().splitlines()
    except OSError:
        return []


def allowed(memory: str | None, share: float = SHARE) -> int:
    """Bytes that a record may take: those given, or a share of those available."""
    return int(share * available()) if memory is None else bytes_of(memory)


def needed(numbers: int) -> int:
    """Bytes that the analysis of so many samples takes, all channels together."""
    return NEED * 8 * numbers
