"""Numbers and names of choices in messages."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

WORTH = 0.25
"""Share of a recording that a part of it must have to be worth a proposal."""


def plural(count: int, noun: str, many: str = "") -> str:
    """A number and its noun, singular or plural.

    Examples
    --------
    >>> plural(1, "gap"), plural(7, "sample")
    ('1 gap', '7 samples')
    """
    return f"{count} {noun if count == 1 else many or noun + 's'}"


def percent(share: float) -> str:
    """A share with two significant digits, and all digits before the point.

    Examples
    --------
    >>> percent(0.00123), percent(0.345), percent(1.0), percent(12.3)
    ('0.12 %', '34 %', '100 %', '1230 %')
    """
    return f"{100 * share:.2g} %" if share < 0.995 else f"{100 * share:.0f} %"


def duration(seconds: float) -> str:
    """A duration with its unit.

    Examples
    --------
    >>> duration(42), duration(5400), duration(200_000)
    ('42 s', '1.5 h', '2.31 d')
    """
    for size, unit, least in ((86400.0, "d", 172800.0), (3600.0, "h", 3600.0), (60.0, "min", 120.0), (1.0, "s", 0.0)):
        if seconds >= least:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds:.3g} s"


def averaging(tau: float) -> str:
    """An averaging time: in seconds, as on the axis of a curve.

    Examples
    --------
    >>> averaging(5.119), averaging(927.4), averaging(16384.0)
    ('5.12 s', '927 s', '16400 s')
    """
    return f"{float(f'{tau:.3g}'):.15g} s"


_AT_COMMAND_LINE = ContextVar("_AT_COMMAND_LINE", default=False)


@contextmanager
def command_line() -> Iterator[None]:
    """Messages made within this context name options; elsewhere they name arguments."""
    token = _AT_COMMAND_LINE.set(True)
    try:
        yield
    finally:
        _AT_COMMAND_LINE.reset(token)


def spelled(option: str, argument: str) -> str:
    """The name of a choice in a message: an option at the command line, an argument in Python.

    Examples
    --------
    >>> spelled("--rate 100", "rate=100")
    'rate=100'
    """
    return option if _AT_COMMAND_LINE.get() else argument


def windowing() -> str:
    """The name of the choice of a part of the record."""
    return spelled("--from, --until", "prepare.trim")


def longest_without(bad: Iterable[tuple[float, float]], span: tuple[float, float]) -> str:
    """How to select the longest part of a recording, s, that holds none of these, s, ascending, unless it is short.

    Examples
    --------
    >>> longest_without([(10.0, 12.0), (90.0, 91.0)], (0.0, 100.0))
    'prepare.trim(recording, 12, 90)'
    """
    ends = [span[0], *(time for each in bad for time in each), span[1]]
    start, end = max(zip(ends[::2], ends[1::2], strict=True), key=lambda part: part[1] - part[0])
    return between(start, end) if end - start > WORTH * (span[1] - span[0]) else windowing()


def between(start: float, end: float) -> str:
    """How to select the part of a recording from `start` to `end`, s."""
    option = (f"--from {start:.6g} " if start > 0 else "") + f"--until {end:.6g}"
    return spelled(option, f"prepare.trim(recording, {start:.6g}, {end:.6g})")
