"""The even grid of the rows, whose intervals are counted, never guessed; findings about the clock and their texts."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from allanite.core.arrays import FloatArray
from allanite.core.validity import Finding
from allanite.kernels import passing
from allanite.phrases.phrase import join, percent, say, say_count, spelled

Places = NDArray[np.int64]

RESOLUTIONS = (60.0, 10.0, 1.0, 0.1, 0.01, 1e-3, 1e-4, 1e-5, 1e-6)  # time steps, s, in which clocks are read or printed
PART = 10_000  # number of time stamps around the middle of the record that decide between estimates of the interval

STAMPS_AHEAD = (16, 1024, 1024, 1024)
"""Number of time stamps that must stay close to the grid: a wrong interval drifts away within a few."""


@dataclass(frozen=True, eq=False)
class SampleGrid:
    """An even grid of sampling times."""

    interval: float = 0.0  # s, between the first and the last time stamp over the intervals, missing ones included
    rows: Places | None = None  # those kept, in order of time; None: all, in the order of the file
    places: Places | None = None  # of the rows on the grid; None: consecutive
    findings: tuple[Finding, ...] = ()  # defects of the time stamps
    trouble: str = ""  # why they give no rate; empty if they do

    @property
    def lost(self) -> int:
        """Number of grid points without a row."""
        return 0 if self.places is None else int(self.places[-1]) + 1 - self.places.size

    @property
    def history(self) -> tuple[str, ...]:
        """History entries of placing the rows on the grid."""
        lost = (say("{lost} missing samples marked as gaps", lost=self.lost),) if self.lost else ()
        if self.rows is None:
            return lost
        done = say("repeated rows removed") if np.all(np.diff(self.rows) > 0) else say("rows sorted by time stamp")
        return (done, *lost)

    def put(self, values: NDArray[Any]) -> NDArray[Any]:
        """The samples on the grid, NaN where one is missing."""
        kept = values if self.rows is None else values[self.rows]
        if self.places is None or not self.lost:
            return kept
        whole = np.full(kept.size + self.lost, np.nan)
        whole[self.places] = kept
        return whole


ONE_AFTER_THE_OTHER = SampleGrid()  # the default grid, if nothing else is known


def resolution(steps: FloatArray) -> float:
    """The largest typical step of which all steps are multiples; 0 if there is none."""
    ends = steps[steps > 0][:10_000]
    for step in RESOLUTIONS if ends.size else ():
        multiples = ends / step
        if multiples.min() > 0.5 and np.abs(multiples - np.rint(multiples)).max() < 1e-3:
            return step
    return 0.0


class Pace(NamedTuple):
    """An interval in s, the grid position of each row relative to its number, and the remaining deviation."""

    interval: float
    shift: Places
    residual: FloatArray

    @property
    def bursts(self) -> bool:
        """Whether bursts at a steady pace were mistaken for a finer grid, most of which would be missing."""
        size = self.shift.size + int(self.shift[-1])
        return bool(self.shift[-1] > 0.6 * size and (np.diff(self.shift) > 0).mean() > 0.02)


def pace(elapsed: FloatArray, rows: Places, slack: float) -> Pace:
    """The grid of increasing time stamps in s, shape (n,), of rows with these numbers."""
    # Deviations of up to `slack` intervals are not gaps.
    middle = slice(max(0, rows.size // 2 - PART), rows.size // 2 + PART)
    near, where = elapsed[middle], rows[middle]
    steps = np.diff(near) / np.diff(where)
    # the mean of all steps is right if little is missing, that of typical steps if much is, of short ones if most is
    guesses = [float(near[-1] - near[0]) / int(where[-1] - where[0])]
    for usual in (float(np.quantile(steps, share)) for share in (0.5, 0.1)):
        typical = steps[(steps > 0.4 * usual) & (steps < 1.6 * usual)]
        guesses.append(float(typical.mean()) if typical.size else usual)
    paces = [_refined(near, where, guess, slack) for guess in guesses if guess > 0]
    floor = resolution(steps) / math.sqrt(12)
    shortest = min(paces, key=lambda one: _length(one, where, floor))
    return _refined(elapsed, rows, shortest.interval, slack)


def _length(found: Pace, rows: Places, floor: float) -> float:
    """For a description of the time stamps: the deviation beyond their rounding, and the occupied grid points."""
    interval, shift, residual = found
    lost, count = int(shift[-1]), int(rows[-1] - rows[0])
    # any time stamps fit a grid of their own last digit; one step is then no more frequent than two
    if lost > 0.4 * (count + lost) and np.bincount(np.clip(np.diff(rows + shift), 0, 9)).argmax() != 1:
        return math.inf
    off = np.where(np.diff(shift, prepend=0) < 0, 1.0, np.clip(residual, -1, 1))
    scatter = max(interval * float(np.sqrt(np.square(off).mean())), floor, 1e-9 * interval)
    return math.log(scatter) + math.log(max(count + lost, 1))


def _refined(elapsed: FloatArray, rows: Places, interval: float, slack: float) -> Pace:
    """Refine an estimate of the interval with the number of intervals."""
    span, count = float(elapsed[-1] - elapsed[0]), int(rows[-1] - rows[0])
    for ahead in STAMPS_AHEAD:
        shift, _ = passing.followed(elapsed / interval, rows, ahead, slack)
        counted = count + int(shift[-1])
        if counted < 1 or interval == span / counted:
            break
        interval = span / counted
    return Pace(interval, *passing.followed(elapsed / interval, rows, STAMPS_AHEAD[-1], slack))


def _without_stamps(_: str) -> str:
    option = spelled(say("--time none --rate HZ"), say("time='none', rate=..."))
    return say("choose a window without them, or ignore the time stamps: {option}", option=option)


def _use_sensor(option: str) -> str:
    return say("use the clock of the sensor ({option}) if the file has it", option=option)


FAULTS: dict[str, tuple[str, Callable[[str], str]]] = {
    say("missing samples"): (say("they are marked as gaps, nothing is put in their place"), _without_stamps),
    "jitter": (
        say("if the sensor itself was sampled so unevenly, the deviations at the shortest averaging times are "
            "wrong; if only the time stamps were late, the results are right"), _use_sensor),
    say("bursty time stamps"): (
        say("they tell when samples arrived, not when they were taken: only their mean rate is used, and "
            "missing samples remain undetected"), _use_sensor),
    say("coarse time stamps"): (
        say("the rate is counted from the first change of the time stamp to the last, and single missing "
            "samples remain undetected"), lambda _: say("log finer time stamps, or the counter of the sensor")),
    say("duplicate time stamps"): (
        say("the rows are used one after the other, in the order of the file"),
        lambda _: say("check the logger: samples that are written twice make the noise look smaller")),
    say("reversed time stamps"): (
        say("the rows are used in the order of the file"),
        lambda _: say("check the logger; if the rows are out of order, sort the file by time stamp")),
    say("damaged time stamps"): (
        say("each is set by its neighbours"),
        lambda _: say("check the logger, and the cable or card that it writes to")),
    say("constant time stamps"): (
        say("the clock gives no information, and missing samples remain undetected"),
        lambda option: say("use another clock ({option})", option=option)),
    say("clock drift"): (
        say("averaging times are accurate only to that part"),
        lambda option: say("let the sensor and the logger warm up, or use another clock ({option})", option=option)),
}  # fmt: skip
"""Name, consequence and remedy of each finding about time stamps; a remedy may name the option of another clock."""

UNSTEADY = 0.1  # RMS deviation of time stamps from an even grid, in intervals, above which they are called jittered
DRIFT = 1e-4  # relative change of rate within a record that is reported; noise coefficients are less sensitive
PARTS = 16  # number of parts of a record whose rates are compared


class Stamps:
    """Seconds since the first time stamp, shape (n,), and the name of their column in messages."""

    def __init__(self, elapsed: FloatArray, label: str) -> None:
        self.elapsed, self.label = elapsed, label

    @cached_property
    def steps(self) -> FloatArray:
        """Differences of successive time stamps, shape (n - 1,)."""
        return np.diff(self.elapsed)

    @cached_property
    def equal(self) -> NDArray[np.bool_]:
        """Which time stamps are equal to the previous one, shape (n - 1,)."""
        return np.asarray(self.steps == 0)

    @property
    def mean(self) -> float:
        """The mean step."""
        return float(self.elapsed[-1]) / self.steps.size

    @cached_property
    def departure(self) -> FloatArray:
        """Deviation from an even grid without gaps, in intervals, shape (n,)."""
        even = self.elapsed / self.mean
        even -= np.arange(even.size)
        return even

    @cached_property
    def resolution(self) -> float:
        """The largest typical step of which all steps are multiples; 0 if there is none."""
        return resolution(self.steps)


class Hole(NamedTuple):
    """A gap: the number of missing samples, and its start in seconds after the first sample."""

    size: int
    at: float


def finding(
    name: str, what: str, place: tuple[float, float] | None = None, *, consequence: str = "", remedy: str = ""
) -> Finding:
    """A finding of the table; texts given here replace those of the table."""
    usual, advice = FAULTS[name]
    return Finding(name, what, consequence or usual, remedy or advice(spelled("--time COLUMN", "time=...")), place)


def lost_samples(places: Places, interval: float, source: str) -> Finding:
    """The finding about missing samples: how many, which share of the record, the first and the longest gap."""
    return Holes().seen(places).finding(interval, source)


class Holes:
    """The gaps of a grid that is seen in parts: how many, how many samples are missing, the first and the longest."""

    def __init__(self) -> None:
        self.count = self.lost = self.size = self.end = 0
        self.first: tuple[int, int] = (0, 0)
        self.longest: tuple[int, int] = (0, 0)

    def seen(self, places: Places, begin: int = 0) -> "Holes":
        """Add the gaps between places on the grid, counted from `begin`; a part begins with the last place before."""
        gaps = np.diff(places)
        holes = np.flatnonzero(gaps > 1)
        self.size = begin + int(places[-1]) + 1
        if holes.size:
            each = [(int(gaps[i]) - 1, begin + int(places[i]) + 1) for i in (holes[0], holes[gaps[holes].argmax()])]
            self.first = self.first if self.count else each[0]
            self.longest = each[1] if each[1][0] > self.longest[0] else self.longest
            self.count, self.lost = self.count + holes.size, self.lost + int((gaps[holes] - 1).sum())
            self.end = begin + int(places[holes[-1] + 1])
        return self

    def finding(self, interval: float, source: str) -> Finding:
        """The finding about them."""
        first, longest = (Hole(size, at * interval) for size, at in (self.first, self.longest))
        samples = say_count(self.lost, "{count} sample", "{count} samples")
        missing = say("{samples} ({share}) missing in {gaps}, {source}",
                      samples=samples, share=percent(self.lost / self.size), source=source,
                      gaps=say_count(self.count, "{count} gap", "{count} gaps"))  # fmt: skip
        what = [missing, say("the first at {time:.6g} s", time=first.at)]
        if first.size > 1:
            what[1] = say("the first of {length:.4g} s at {time:.6g} s", length=first.size * interval, time=first.at)
        if longest.size > first.size:
            length = longest.size * interval
            what.append(say("the longest of {length:.4g} s at {time:.6g} s", length=length, time=longest.at))
        return finding("missing samples", join(", ", what), (first.at, self.end * interval))


def duplicates(stamps: Stamps) -> tuple[Finding, ...]:
    """Time stamps that repeat while the samples do not."""
    if not stamps.equal.any():
        return ()
    what = say_count(int(stamps.equal.sum()),
                     "{count} stamp of {column} is equal to the previous one, although the samples differ; the first "
                     "is in row {row} of the data",
                     "{count} stamps of {column} are equal to the previous one, although the samples differ; the "
                     "first is in row {row} of the data",
                     column=stamps.label, row=int(np.argmax(stamps.equal)) + 2)  # fmt: skip
    return (finding("duplicate time stamps", what),)


def bursty(stamps: Stamps, mean: float) -> Finding:
    """Steps whose median gives another rate than their mean."""
    steps = stamps.steps
    what = say("bursty time stamps in {column}: {median:.4g} Hz from the median step, {mean:.6g} Hz from the mean; "
               "steps from {shortest} to {longest}", column=stamps.label, median=1 / float(np.median(steps)),
               mean=1 / mean, shortest=duration(float(steps.min())), longest=duration(float(steps.max())))  # fmt: skip
    return finding("bursty time stamps", what)


def unsteady(stamps: Stamps, departure: FloatArray, interval: float) -> tuple[Finding, ...]:
    """Jitter and drift, from the deviation of time stamps in intervals."""
    if largest(departure) < UNSTEADY / 2:  # of which neither second differences nor means are so large
        return ()
    return (*jitter(stamps, departure, interval), *drift(stamps, departure))


def largest(values: FloatArray) -> float:
    """The largest absolute value."""
    return float(max(values.max(), -values.min()))


def jitter(stamps: Stamps, departure: FloatArray, interval: float) -> tuple[Finding, ...]:
    """Scatter of successive time stamps beyond the rounding of their last digit."""
    if departure.size < 10:
        return ()
    # rounding has variance 1/12; if its errors alternate, second differences show three times as much
    rounding = (stamps.resolution / interval) ** 2 / 4
    rms = max(float(np.diff(departure, 2).var()) / 6 - rounding, 0.0) ** 0.5
    if rms < UNSTEADY:
        return ()
    low, high = (duration(float(step)) for step in (stamps.steps.min(), stamps.steps.max()))
    what = say("the time stamps of {column} scatter by {scatter:.2g} intervals RMS; steps from {low} to {high} "
               "instead of {interval}",
               column=stamps.label, scatter=rms, low=low, high=high, interval=duration(interval))  # fmt: skip
    return (finding("jitter", what),)


def drift(stamps: Stamps, departure: FloatArray) -> tuple[Finding, ...]:
    """A rate that differs between sixteenths of the record."""
    size = departure.size // PARTS
    if size < 64:
        return ()
    means = departure[: PARTS * size].reshape(PARTS, size).mean(axis=1)
    rates = np.diff(means) / size
    change = float(np.ptp(rates))
    bend = float(np.ptp(means - np.linspace(means[0], means[-1], PARTS)))
    if change < DRIFT or bend < 0.75 or change < DRIFT + 10 * float(np.diff(departure).std()) / size**1.5:
        return ()
    return (drifting(stamps.label, change),)


def drifting(label: str, change: float) -> Finding:
    """A rate that changes by this part of itself."""
    return finding("clock drift", say("the clock of {column} changes its rate by {change:.2g} ppm within the record",
                                      column=label, change=change * 1e6))  # fmt: skip


def duration(seconds: float) -> str:
    """A short time with its unit."""
    for size, unit in ((1.0, "s"), (1e-3, "ms"), (1e-6, "us")):
        if abs(seconds) >= 0.9995 * size:
            return f"{seconds / size:.4g} {unit}"
    return f"{seconds * 1e9:.3g} ns" if seconds else "0 s"
