"""The sampling rate: given by the user, stated in the file, or from time stamps or a counter; never guessed."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.core.arrays import FloatArray
from allanite.core.errors import DataError
from allanite.core.language import join, say
from allanite.core.units import unit_of
from allanite.core.wording import spelled
from allanite.readers.columns.column import Column

from .clocks import Sources, counted_grid, places, unwrapped
from .grid import ONE_AFTER_THE_OTHER, Grid
from .stamps import fit, seconds_since

PLAUSIBLE = (0.5, 20e3)
"""Sampling rates, Hz, considered plausible when the unit of integer time stamps is determined."""


@dataclass(frozen=True, eq=False)
class Beat:
    """The sampling rate in Hz, the time of the first sample in s, the grid, the assumptions and the open questions."""

    rate: float = 0.0
    start: float | None = None
    notes: tuple[str, ...] = ()
    questions: tuple[str, ...] = ()
    grid: Grid = ONE_AFTER_THE_OTHER


def beat(sources: Sources, rate: float | None, repeated: Callable[[], NDArray[np.bool_]]) -> Beat:
    """The sampling rate, and the grid of the rows: from the user's `rate`, otherwise from `sources`.

    `repeated` marks rows with the same samples as the row before, shape (n - 1,).
    """
    given = rate if rate is not None else sources.rate
    first = sources.notes
    if rate is None and sources.rate is not None:
        first = (*first, say("rate {rate} Hz from {source}", rate=_shown(sources.rate), source=sources.source))
    column = sources.stamps
    if column is None or (given and column.text):
        unused = () if column is None else (say("{column} holds text and was not used", column=column.label),)
        return _unstamped(sources.counter, given, (*first, *unused))
    column.demand_numbers()
    stamps, wrapped = unwrapped(column.values)
    again = (
        (say("{column} wraps around at 2^{bits}: it was continued", column=column.label, bits=wrapped),)
        if wrapped
        else ()
    )
    unit, guessed = (sources.unit, "") if sources.unit else _guess(stamps, given)
    if not unit and not np.any(stamps != stamps[0]):
        unit = "s"  # time stamps that are all equal are so in any unit
    if not unit:
        return Beat(given, notes=first) if given else Beat(questions=(_ask_unit(column),))
    elapsed = seconds_since(stamps, unit)
    grid = _counted(sources.counter, elapsed) or fit(elapsed, column.label, repeated)
    if grid.trouble and not given:
        if not elapsed.any():
            return Beat(questions=(say("{trouble} and give no rate: {advice}", trouble=grid.trouble, advice=_ask()),))
        raise DataError(
            say(
                "{trouble}; {advice}, or {option} for another column",
                trouble=grid.trouble,
                advice=_rows(),
                option=spelled("--time", "time=..."),
            )
        )
    if grid.trouble:
        return Beat(
            float(given or 0),
            notes=(*first, say("{trouble}; the rows are assumed to be evenly spaced", trouble=grid.trouble)),
            grid=grid,
        )
    notes = _notes(column.label, (given, 1 / grid.interval), guessed, grid.lost)
    origin = stamps[0] if grid.rows is None else stamps[grid.rows[0]]
    return Beat(given or 1 / grid.interval, float(origin) * unit_of(unit).factor, (*first, *again, *notes), (), grid)


def _unstamped(column: Column | None, given: float | None, notes: tuple[str, ...]) -> Beat:
    """The beat without time stamps: missing samples from a counter, if the rate is given."""
    if given:
        return Beat(given, notes=notes, grid=counted_grid(column, 1 / given) or ONE_AFTER_THE_OTHER)
    if column is None:
        return Beat(questions=(say("the sampling rate is not in the file: {advice}", advice=_ask()),))
    asked = say(
        "the sampling rate is not in the file (the counter {column} shows which samples are missing, but not their "
        "rate): {advice}",
        column=column.label, advice=_ask(),
    )  # fmt: skip
    return Beat(questions=(asked,))


def _counted(column: Column | None, elapsed: FloatArray) -> Grid | None:
    """The grid according to a counter with gaps, if the time stamps increase at all."""
    where = None if column is None else places(column)
    if column is None or where is None or not elapsed[-1] > 0 or not np.isfinite(elapsed[-1]):
        return None
    return counted_grid(column, float(elapsed[-1]) / int(where[-1]))


def _notes(label: str, rates: tuple[float | None, float], guessed: str, lost: int) -> list[str]:
    given, measured = rates
    told: list[str] = [say("including {count} missing intervals", count=lost)] if lost else []
    told += [guessed] if guessed else []
    if given is None:
        return [join(", ", (say("rate {rate} Hz from {source}", rate=_shown(measured), source=label), *told))]
    if abs(given / measured - 1) <= 1e-3:
        return []
    used = say(
        "rate {rate} Hz is used, but the time stamps of {column} give {measured} Hz",
        rate=_shown(given), column=label, measured=_shown(measured),
    )  # fmt: skip
    return [join(", ", (used, *told))]


def _ask() -> str:
    return spelled(
        say("pass the sampling rate in Hz with --rate 100, or name the column of time stamps: --time 'stamp[us]'"),
        say("pass the sampling rate in Hz with rate=100, or name the column of time stamps: time='stamp[us]'"),
    )


def _rows() -> str:
    return spelled(
        say(
            "pass --rate to treat the rows as evenly spaced in the order of the file, with --from and --until to "
            "exclude the place"
        ),
        say(
            "pass rate=... to treat the rows as evenly spaced in the order of the file, and trim the recording to "
            "exclude the place"
        ),
    )


def _shown(rate: float) -> str:
    return repr(float(f"{rate:.7g}"))


def _guess(stamps: NDArray[Any], given: float | None) -> tuple[str, str]:
    """The unit of time stamps whose header has none, and the text for the note."""
    if not np.all(np.isfinite(stamps)) or np.any(stamps != np.floor(stamps)):
        return "s", say("time stamps assumed to be in seconds")
    low, high = (given / 3, 3 * given) if given else PLAUSIBLE
    fits = [unit for unit, rate in _readings(stamps) if low <= rate <= high]
    if len(fits) != 1:
        return "", ""
    if given:
        return fits[0], say("integer time stamps assumed to be in {unit}, consistent with the rate", unit=fits[0])
    return fits[0], say("integer time stamps assumed to be in {unit}, the only plausible unit", unit=fits[0])


def _readings(stamps: NDArray[Any]) -> list[tuple[str, float]]:
    span = float(stamps[-1]) - float(stamps[0])
    return [(unit, (len(stamps) - 1) / (span * unit_of(unit).factor)) for unit in ("s", "ms", "us", "ns") if span > 0]


def _ask_unit(column: Column) -> str:
    readings = [say("{rate:.6g} Hz as {unit}", rate=rate, unit=unit) for unit, rate in _readings(column.values)]
    how = spelled(f"--time '{column.name}[ms]', or --rate 100", f"time='{column.name}[ms]', or rate=100")
    if not readings:
        return say(
            "the last time stamp of {column} is not later than the first: {advice}", column=column.label, advice=_ask()
        )
    return say(
        "the unit of the integer time stamps of {column} is unknown ({readings}): pass {option}",
        column=column.label, readings=join(", ", readings), option=how,
    )  # fmt: skip
