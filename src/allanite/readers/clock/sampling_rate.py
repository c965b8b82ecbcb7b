"""The sampling rate: given by the user, stated in the file, or from time stamps or a counter; never guessed."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from allanite.core.errors import RATE, DataError, UsageError
from allanite.core.units import unit_of
from allanite.core.validity import Finding
from allanite.phrases.phrase import join, percent, say, spelled
from allanite.readers.columns.column import FileColumn

from .clocks import ClockSources, addressed, counted_grid, places, readings, unit_by_rate, unwrapped
from .findings import ONE_AFTER_THE_OTHER, SampleGrid
from .stamps import Damage, fit, mended, seconds_since

SAME = 1e-3  # relative difference up to which a given rate and that of time stamps are the same
REFUSED = 0.01  # the same beyond which a rate that the user gives is refused: one of the two is wrong
NOMINAL = 0.05  # the same for the rate that a file states: sensors are seldom as fast as their data sheet


@dataclass(frozen=True, eq=False)
class Beat:
    """The sampling rate in Hz, the time of the first sample in s, assumptions, open questions, grid, and warnings."""

    rate: float = 0.0
    start: float | None = None
    notes: tuple[str, ...] = ()
    questions: tuple[str, ...] = ()
    grid: SampleGrid = ONE_AFTER_THE_OTHER
    contradictions: tuple[Finding, ...] = ()

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Defects of the time stamps, and rates that contradict each other."""
        return (*self.grid.findings, *self.contradictions)


class Stamped(NamedTuple):
    """Time stamps before their grid is known: their unit, the given rate, and the notes about them so far."""

    column: FileColumn
    stamps: NDArray[Any]
    unit: str
    sources: ClockSources
    rate: float | None
    given: float | None
    first: tuple[str, ...]
    again: tuple[str, ...]
    guessed: str
    against: tuple[Finding, ...]
    damage: Damage


def beat(sources: ClockSources, rate: float | None, repeated: Callable[[], NDArray[np.bool_]]) -> Beat:
    """The sampling rate, and the grid of the rows: from the user's `rate`, otherwise from `sources`."""
    # `repeated` marks rows with the same samples as the row before, shape (n - 1,).
    clock = stamped(sources, rate)
    if isinstance(clock, Beat):
        return clock
    elapsed = seconds_since(clock.stamps, clock.unit)
    where = None if sources.counter is None else places(sources.counter)
    grid = None
    if where is not None and elapsed[-1] > 0 and np.isfinite(elapsed[-1]):
        grid = counted_grid(sources.counter, float(elapsed[-1]) / int(where[-1]))
    grid = grid or fit(elapsed, clock.column.label, repeated)
    if grid.trouble and not clock.given and not elapsed.any():
        return Beat(questions=(say("{trouble} and give no rate: {advice}", trouble=grid.trouble, advice=_ask()),))
    findings = (*clock.damage.findings(clock.column.label), *grid.findings)
    return settled(clock, replace(grid, findings=findings), grid.lost)


def stamped(sources: ClockSources, rate: float | None) -> Stamped | Beat:
    """The time stamps, or the beat where there are none, or their unit is unknown."""
    given, column = rate if rate is not None else sources.rate, sources.stamps
    if column is None and given is None:
        given = sources.stated
    first = sources.notes
    if rate is None and given is not None:
        source = sources.source if sources.rate else sources.stated_source
        first = (*first, say("rate {rate} Hz from {source}", rate=_shown(given), source=source))
    against = _against(sources, rate)
    if column is None or (given and column.text):
        return replace(_unstamped(sources, given, first), contradictions=against)
    column.demand_numbers()
    whole, damaged = mended(column.values)
    stamps, wrapped = unwrapped(whole)
    continued = say("{column} wraps around at 2^{bits}: it was continued", column=column.label, bits=wrapped)
    unit, guessed = _unit(sources, stamps, given or sources.stated)
    if not unit:
        _demand_counter(column, rate)
        known = Beat(given or 0.0, notes=first, contradictions=against)
        return known if given else Beat(questions=(_ask_unit(column),))
    again = (continued,) if wrapped else ()
    damage = Damage().add(damaged, column.values)
    return Stamped(column, stamps, unit, sources, rate, given, first, again, guessed, against, damage)


def _demand_counter(column: FileColumn, rate: float | None) -> None:
    """Refuse a rate that integer time stamps contradict in any unit; those that count rows contradict none."""
    rates = readings(column.values)
    if rate and rates and abs(rates[0][1] - 1) > SAME:
        raise UsageError(
            say("the rate given, {rate} Hz, contradicts the time stamps of {column} ({readings}): omit it, or ignore "
                "the time stamps with {option}", rate=_shown(rate), column=column.label, readings=_listed(rates),
                option=spelled("--time none", "time='none'")), choice="time", cure=("", "--time none"),
        )  # fmt: skip


def settled(seen: Stamped, grid: SampleGrid, lost: int) -> Beat:
    """The beat of time stamps by their grid, on which so many samples are missing."""
    given, label = seen.given, seen.column.label
    if grid.trouble and not given:
        raise DataError(say("{trouble}; {advice}, or {option} for another column", trouble=grid.trouble, advice=_rows(),
                            option=spelled("--time COLUMN", "time=...")))  # fmt: skip
    if grid.trouble:
        return Beat(
            float(given or 0),
            notes=(*seen.first, say("{trouble}; the rows are assumed to be evenly spaced", trouble=grid.trouble)),
            grid=grid, contradictions=seen.against,
        )  # fmt: skip
    measured = 1 / grid.interval
    if seen.rate and _apart(seen.rate, measured, REFUSED):
        raise UsageError(
            say("the rate given, {rate} Hz, contradicts the time stamps of {column}, {measured} Hz{guessed}: omit it, "
                "or ignore the time stamps with {option}", rate=_shown(seen.rate), column=label,
                measured=_shown(measured), guessed=f" ({seen.guessed})" if seen.guessed else "",
                option=spelled("--time none", "time='none'")), choice="time", cure=("", "--time none"),
        )  # fmt: skip
    notes, differing = _notes(label, (given, measured), seen.guessed, lost)
    stated = seen.sources.stated
    if given is None and _apart(measured, stated, NOMINAL):
        differing = (_contradiction(measured, stated or 0.0, seen.sources.stated_source),)
    origin = seen.stamps[0] if grid.rows is None else seen.stamps[grid.rows[0]]
    assumed = (*seen.first, *seen.again, *notes)
    return Beat(given or measured, float(origin) * unit_of(seen.unit).factor, assumed, (), grid,
                (*seen.against, *differing))  # fmt: skip


def _against(sources: ClockSources, rate: float | None) -> tuple[Finding, ...]:
    """Warnings that the given rate contradicts those that the file states."""
    stated = ((sources.rate, sources.source), (sources.stated, sources.stated_source))
    return tuple(
        _contradiction(rate, other, source) for other, source in stated if rate and other and _apart(rate, other)
    )


def _apart(rate: float, other: float | None, limit: float = SAME) -> bool:
    """Whether two rates differ by more than a relative `limit`; not if the other is unknown."""
    return other is not None and abs(rate / other - 1) > limit


def _contradiction(rate: float, other: float, source: str, told: Sequence[str] = ()) -> Finding:
    """The warning that one rate is used although something else gives another."""
    high, low = max(rate, other), min(rate, other)
    apart = say("{share} apart", share=percent(high / low - 1))
    if high >= 2 * low:
        apart = say("a factor of {factor:.4g} apart", factor=high / low)
    used = say("rate {rate} Hz is used, but {source} gives {other} Hz, {apart}",
               rate=_shown(rate), source=source, other=_shown(other), apart=apart)  # fmt: skip
    return Finding(
        say("given rate"), join(", ", (used, *told)),
        say("if the other is right, averaging times are wrong by that ratio, and coefficients by a power of it"),
        say("find out which is right, and give it with {option}", option=spelled("--rate HZ", "rate=...")),
    )  # fmt: skip


def _unstamped(sources: ClockSources, given: float | None, notes: tuple[str, ...]) -> Beat:
    """The beat without time stamps: missing samples from a counter, if the rate is given."""
    column = sources.counter
    if sources.stamps is not None:
        notes = (*notes, say("{column} holds text and was not used", column=sources.stamps.label))
    if given:
        return Beat(given, notes=notes, grid=counted_grid(column, 1 / given) or ONE_AFTER_THE_OTHER)
    if sources.stated_source:
        several = say("the file states rates that contradict each other, {places}", places=sources.stated_source)
        return Beat(questions=(join(": ", (several, _ask())),))
    if column is None:
        return Beat(questions=(say("the sampling rate is not in the file: {advice}", advice=_ask()),))
    asked = say("the sampling rate is not in the file (the counter {column} shows which samples are missing, but not "
                "their rate): {advice}", column=column.label, advice=_ask())  # fmt: skip
    return Beat(questions=(asked,))


def _notes(
    label: str, rates: tuple[float | None, float], guessed: str, lost: int
) -> tuple[list[str], tuple[Finding, ...]]:
    """The note on the rate of time stamps, or the warning that it is not the given one."""
    given, measured = rates
    told: list[str] = [say("including {count} missing intervals", count=lost)] if lost else []
    told += [guessed] if guessed else []
    if given is None:
        return [join(", ", (say("rate {rate} Hz from {source}", rate=_shown(measured), source=label), *told))], ()
    return [], (_contradiction(given, measured, label, told),) if _apart(given, measured) else ()


def _ask() -> str:
    return spelled(say("pass --rate HZ, or --time COLUMN"), say("pass rate=100 (in Hz), or time='stamp[us]'"))


def _rows() -> str:
    return spelled(
        say("pass --rate HZ if the rows are evenly spaced, exclude the place with --from and --until"),
        say("pass rate=... if the rows are evenly spaced, exclude the place with start and end"),
    )


def _shown(rate: float) -> str:
    return repr(float(f"{rate:.7g}"))


def _unit(sources: ClockSources, stamps: NDArray[Any], given: float | None) -> tuple[str, str]:
    """The unit of time stamps, and the text for the note if it was guessed; empty if it is unknown."""
    if sources.unit:
        return sources.unit, ""
    if not np.any(stamps != stamps[:1]):  # time stamps that are all equal are so in any unit
        return "s", ""
    whole = bool(np.all(stamps == np.floor(stamps)))
    unit, why = unit_by_rate(stamps) if not given and np.all(np.isfinite(stamps)) else ("", "")
    if unit or not whole:
        return unit or "s", why or say("time stamps assumed to be in seconds")
    fits = [unit for unit, rate in readings(stamps) if given and given / 3 <= rate <= 3 * given]
    if len(fits) != 1:
        return "", ""
    return fits[0], say("integer time stamps assumed to be in {unit}, consistent with the rate", unit=fits[0])


def _listed(readings: list[tuple[str, float]]) -> str:
    return join(", ", (say("{rate:.6g} Hz as {unit}", rate=rate, unit=unit) for unit, rate in readings))


def _ask_unit(column: FileColumn) -> str:
    rates = readings(column.values)
    if not rates:
        return say("the last time stamp of {column} is not later than the first: {advice}",
                   column=column.label, advice=_ask())  # fmt: skip
    address = addressed(column)
    return say("the unit of the integer time stamps of {column} is unknown ({readings}): pass {option}",
               column=column.label, readings=_listed(rates),
               option=spelled(f"--time '{address}', or --rate {RATE}", f"time='{address}', or rate=100"))  # fmt: skip
