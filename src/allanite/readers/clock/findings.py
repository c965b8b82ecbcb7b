"""What can be wrong with a clock: names, what each does to the numbers, what to do; and how each is put into words."""

from functools import cached_property
from typing import NamedTuple

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.finding import Finding
from allanite.core.wording import percent, plural

from .grid import Places, resolution

FAULTS: dict[str, tuple[str, str]] = {
    "lost samples": (
        "they are marked as gaps, nothing is put in their place",
        "choose a window without them (--from, --until), or close them up: time='none', rate=... (--time none --rate)",
    ),
    "jitter": (
        "if the sensor itself was sampled so unevenly, the shortest averaging times are not right; if only the stamps "
        "were late, nothing is wrong",
        "take the clock of the sensor (--time) if the file has it",
    ),
    "bursty stamps": (
        "they tell when readings arrived and not when they were taken: only their mean rate is used, and a lost sample "
        "does not show",
        "take the clock of the sensor (--time) if the file has it",
    ),
    "coarse stamps": (
        "the rate is counted from the first change of stamp to the last, and samples lost in ones and twos do not show",
        "log finer stamps, or the counter of the sensor",
    ),
    "duplicate stamps": (
        "the rows are taken one after the other, as they stand in the file",
        "check the logger: a reading that is written twice looks quieter than it is",
    ),
    "reversed stamps": (
        "the rows are taken in the order of the file",
        "check the logger; if the rows are out of order, sort the file by its stamps",
    ),
    "constant stamps": ("the clock says nothing, and lost samples do not show", "take another clock (--time)"),
    "clock drift": (
        "averaging times are right to that part only",
        "let the sensor and the logger warm up, or take another clock (--time)",
    ),
}
"""Name, consequence and remedy of each finding about stamps."""

UNSTEADY = 0.1
"""Rms departure of stamps, in intervals, that is called jitter."""

DRIFT = 1e-4
"""Relative change of rate within a record that is worth a word: no noise coefficient notices less."""

PARTS = 16
"""Parts of a record whose rates are compared."""


class Stamps:
    """Seconds since the first stamp, shape (n,), and what their column is called in messages."""

    def __init__(self, elapsed: FloatArray, label: str) -> None:
        self.elapsed, self.label = elapsed, label

    @cached_property
    def steps(self) -> FloatArray:
        """Differences of neighbours, shape (n - 1,)."""
        return np.diff(self.elapsed)

    @property
    def mean(self) -> float:
        """The mean step."""
        return float(self.elapsed[-1]) / self.steps.size

    @cached_property
    def departure(self) -> FloatArray:
        """From an even grid without losses, in intervals, shape (n,)."""
        return np.asarray(self.elapsed / self.mean - np.arange(self.elapsed.size))

    @cached_property
    def resolution(self) -> float:
        """The largest usual step of which all steps are multiples; 0 if there is none."""
        return resolution(self.steps)


class Hole(NamedTuple):
    """A loss: the number of samples, and the seconds after the first sample at which it begins."""

    size: int
    at: float


def finding(
    name: str, what: str, place: tuple[float, float] | None = None, *, consequence: str = "", remedy: str = ""
) -> Finding:
    """A finding of the table; words of its own case go over those of the table."""
    usual, advice = FAULTS[name]
    return Finding(name, what, consequence or usual, remedy or advice, place)


def lost_samples(places: Places, interval: float, source: str) -> Finding:
    """The finding about holes in a grid: how many, how much of the record, the first and the longest."""
    gaps = np.diff(places)
    holes = np.flatnonzero(gaps > 1)
    first, longest = (
        Hole(int(gaps[i]) - 1, (int(places[i]) + 1) * interval) for i in (holes[0], holes[gaps[holes].argmax()])
    )
    lost = int((gaps[holes] - 1).sum())
    count = f"{plural(lost, 'sample')} ({percent(lost / (places[-1] + 1))}) lost in {plural(holes.size, 'gap')}"
    size = f" of {first.size * interval:.4g} s" if first.size > 1 else ""
    where = f", {source}, the first{size} at {first.at:.6g} s"
    most = (
        f", the longest of {longest.size * interval:.4g} s at {longest.at:.6g} s" if longest.size > first.size else ""
    )
    return finding("lost samples", count + where + most, (first.at, float(places[holes[-1] + 1]) * interval))


def duplicates(stamps: Stamps) -> tuple[Finding, ...]:
    """Stamps that repeat while the readings do not."""
    equal = stamps.steps == 0
    if not equal.any():
        return ()
    count = counted(int(equal.sum()), "stamp", f" of {stamps.label}")
    which = f"{count} equal to the one before, but the readings are not"
    return (finding("duplicate stamps", f"{which}; the first is in row {int(np.argmax(equal)) + 2} of the data"),)


def bursty(stamps: Stamps, mean: float) -> Finding:
    """Steps of which the usual one says another rate than all of them together."""
    steps = stamps.steps
    spread = f"steps from {duration(float(steps.min()))} to {duration(float(steps.max()))}"
    rates = f"{1 / float(np.median(steps)):.4g} Hz by the median step, {1 / mean:.6g} Hz by the mean"
    return finding("bursty stamps", f"bursty stamps in {stamps.label}: {rates}; {spread}")


def unsteady(stamps: Stamps, departure: FloatArray, interval: float) -> tuple[Finding, ...]:
    """Jitter and drift, from the departure of stamps in intervals."""
    return (*jitter(stamps, departure, interval), *drift(stamps, departure))


def jitter(stamps: Stamps, departure: FloatArray, interval: float) -> tuple[Finding, ...]:
    """Scatter of neighbouring stamps beyond the rounding of their last digit."""
    if departure.size < 10:
        return ()
    # rounding makes 1/12; its errors may alternate, and second differences then show them three times as large
    rounding = (stamps.resolution / interval) ** 2 / 4
    rms = max(float(np.diff(departure, 2).var()) / 6 - rounding, 0.0) ** 0.5
    if rms < UNSTEADY:
        return ()
    low, high = (duration(float(step)) for step in (stamps.steps.min(), stamps.steps.max()))
    spread = f"steps from {low} to {high} where {duration(interval)} is right"
    return (finding("jitter", f"the stamps of {stamps.label} scatter by {rms:.2g} intervals rms; {spread}"),)


def drift(stamps: Stamps, departure: FloatArray) -> tuple[Finding, ...]:
    """A rate that is not the same in all sixteenths of the record."""
    size = departure.size // PARTS
    if size < 64:
        return ()
    means = departure[: PARTS * size].reshape(PARTS, size).mean(axis=1)
    rates = np.diff(means) / size
    change = float(np.ptp(rates))
    noise = float(np.diff(departure).std()) / size**1.5
    bend = float(np.ptp(means - np.linspace(means[0], means[-1], PARTS)))
    if change < DRIFT + 10 * noise or bend < 0.75:
        return ()
    what = f"the clock of {stamps.label} changes its rate by {change * 1e6:.2g} ppm within the record"
    return (finding("clock drift", what),)


def counted(count: int, noun: str, whose: str = "") -> str:
    """A number and its noun with its verb.

    Examples
    --------
    >>> counted(1, "row"), counted(7, "stamp", " of column 't'")
    ('1 row is', "7 stamps of column 't' are")
    """
    return f"{count} {noun}{'s' * (count > 1)}{whose} {'are' if count > 1 else 'is'}"


def duration(seconds: float) -> str:
    """A short time with its unit.

    Examples
    --------
    >>> duration(1.0), duration(0.0025), duration(2e-6), duration(0.0)
    ('1 s', '2.5 ms', '2 us', '0 s')
    """
    for size, unit in ((1.0, "s"), (1e-3, "ms"), (1e-6, "us")):
        if abs(seconds) >= 0.9995 * size:
            return f"{seconds / size:.4g} {unit}"
    return f"{seconds * 1e9:.3g} ns" if seconds else "0 s"
