"""From stamps to an even grid: the interval, the places of the rows on it, and what is wrong with the stamps."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from allanite.finding import Finding
from allanite.record import FloatArray
from allanite.units import unit_of

from .faults import finding

Places = NDArray[np.int64]

EVEN = 0.5
"""Intervals by which every stamp may depart from the even grid before losses are looked for."""

UNSTEADY = 0.1
"""Rms departure of stamps, in intervals, that is called jitter."""

BURSTY = 1.5
"""Ratio of the mean and the median interval, either way, from which stamps are called bursty."""

DRIFT = 1e-4
"""Relative change of rate within a record that is worth a word."""

MOST_LOST = 0.9
"""Share of lost samples above which stamps are not believed: a clock that was set leaves such holes."""

PART = 10_000
"""Stamps, either way from the middle, that decide between guesses of the interval."""

PAUSE = 20.0
"""Steps of a bursty clock, over its long ones (one in a hundred), that are losses and no bursts."""

RESOLUTIONS = (60.0, 10.0, 1.0, 0.1, 0.01, 1e-3, 1e-4, 1e-5, 1e-6)
"""Steps, s, in which clocks are read or printed."""


@dataclass(frozen=True, eq=False)
class Grid:
    """An even grid under the stamps.

    Attributes
    ----------
    interval : float
        Of the grid, s; the time between the first stamp and the last over the intervals between them, lost ones
        counted.
    rows : array of int, optional
        The rows that are kept, in the order of time; None for all in the order of the file.
    places : array of int, optional
        Where they stand on the grid; None for one after the other.
    findings : tuple of Finding
        What is wrong with the stamps.
    trouble : str
        Why the stamps give no rate; empty if they do.
    """

    interval: float = 0.0
    rows: Places | None = None
    places: Places | None = None
    findings: tuple[Finding, ...] = ()
    trouble: str = ""

    @property
    def lost(self) -> int:
        """Number of places without a row."""
        return 0 if self.places is None else int(self.places[-1]) + 1 - self.places.size

    @property
    def history(self) -> tuple[str, ...]:
        """What putting rows on the grid does to a record."""
        lost = (f"{self.lost} lost readings marked as gaps, by the stamps",) if self.lost else ()
        return (*(() if self.rows is None else ("rows put in the order of their stamps, each once",)), *lost)

    def put(self, values: NDArray[Any]) -> NDArray[Any]:
        """The readings on the grid, NaN where one is lost."""
        kept = values if self.rows is None else values[self.rows]
        if not self.lost:
            return kept
        whole = np.full(kept.size + self.lost, np.nan)
        whole[self.places] = kept
        return whole


def seconds_since(stamps: NDArray[Any], unit: str) -> FloatArray:
    """Seconds since the first stamp; integers are subtracted as such, since nanoseconds of an epoch exceed float64."""
    with np.errstate(all="ignore"):  # what is not finite is refused by `fit`
        return np.asarray((stamps - stamps[0]) * unit_of(unit).factor, dtype=np.float64)


def fit(elapsed: FloatArray, label: str, repeated: Callable[[], NDArray[np.bool_]]) -> Grid:
    """The grid under stamps.

    Parameters
    ----------
    elapsed : array, shape (n,)
        Seconds since the first stamp.
    label : str
        The column in messages.
    repeated : callable
        Says which rows have the readings of the row before, shape (n - 1,) or (1,); asked if stamps repeat.
    """
    bad = ~np.isfinite(elapsed)
    if bad.any():
        where = f"the first at row {int(np.argmax(bad)) + 1} of the data"
        return Grid(trouble=f"{label} has no stamp in {int(bad.sum())} of {bad.size} rows, {where}")
    steps = np.diff(elapsed)
    if not steps.any():
        what = f"all stamps of {label} are equal"
        return Grid(findings=(finding("constant stamps", what),), trouble=what)
    equal = steps == 0
    if equal.any() and bool(np.broadcast_to(repeated(), equal.shape)[equal].all()):
        return _without(np.flatnonzero(np.concatenate(([True], ~equal))), elapsed, label)
    if steps.min() < 0:
        return _reversed(elapsed, steps, label)
    return _forward(elapsed, steps, label)


def _without(rows: Places, elapsed: FloatArray, label: str) -> Grid:
    """The grid of stamps of which some rows, written twice, are left out."""
    grid = fit(elapsed[rows], label, lambda: np.zeros(rows.size - 1, dtype=bool))
    count = elapsed.size - rows.size
    first = int(np.flatnonzero(np.diff(rows, prepend=-1) > 1)[0]) if rows[-1] + 1 > rows.size else rows.size
    what = f"{count} rows repeat the row before, stamp and readings, the first at row {first + 1} of the data"
    found = finding("duplicate stamps", what, consequence="each is taken once")
    kept = rows if grid.rows is None else rows[grid.rows]
    return replace(grid, rows=kept, findings=(found, *grid.findings))


def _reversed(elapsed: FloatArray, steps: FloatArray, label: str) -> Grid:
    """Rows out of order, a jitter beyond the interval, or a clock that was set."""
    back = steps < 0
    first = int(np.argmax(back)) + 1
    what = (
        f"{int(back.sum())} stamps of {label} go back in time, the first at row {first + 1} of the data by "
        f"{-steps[first - 1]:.4g} s"
    )
    order = np.argsort(elapsed, kind="stable")
    sorted_steps = np.diff(elapsed[order])
    usual = float(np.median(sorted_steps))
    if order[0] == 0 and sorted_steps.min() > 0.3 * usual:
        grid = _forward(elapsed[order] - elapsed[order[0]], sorted_steps, label)
        if not grid.trouble and not {"jitter", "bursty stamps"} & {f.name for f in grid.findings}:
            said = "in order they follow an even grid: the rows stand out of order, and were put in the order of time"
            found = finding("reversed stamps", what, consequence=said)
            return replace(grid, rows=order, findings=(found, *grid.findings))
    mean = float(elapsed[-1]) / steps.size
    if mean > 0 and -steps.min() < 10 * mean and np.abs(elapsed / mean - np.arange(elapsed.size)).max() < 20:
        found = finding(
            "reversed stamps", what, consequence="no step is large: the rows are taken in the order of the file"
        )
        return Grid(mean, findings=(found,))
    cause = "a clock that was set, two recordings in one file, or rows out of order"
    found = finding("reversed stamps", what, consequence=f"{cause}: the rows are taken in the order of the file")
    return Grid(findings=(found,), trouble=f"{what} ({cause})")


def _forward(elapsed: FloatArray, steps: FloatArray, label: str) -> Grid:
    """The grid of stamps that never go back."""
    mean = float(elapsed[-1]) / steps.size
    if float((steps == 0).mean()) >= 0.2:
        return _in_ticks(elapsed, steps, label)
    again = _duplicates(steps, label, mean)
    departure = np.abs(elapsed / mean - np.arange(elapsed.size)).max()
    if departure <= EVEN and steps.max() < (1 + EVEN) * mean:
        unsteady = _unsteady(elapsed / mean - np.arange(elapsed.size), elapsed, mean, label)
        return Grid(mean, findings=(*again, *unsteady))
    interval, shift, left = _follow(elapsed, np.arange(elapsed.size), EVEN)
    off = float((np.abs(left) > EVEN).mean())
    ratio = mean / float(np.median(steps))
    mostly = _mostly_missing(shift, elapsed.size)
    if (off > 0.05 or mostly) and not 1 / BURSTY < ratio < BURSTY:
        return _in_bursts(elapsed, steps, label, again)
    if off > 0.05 or mostly:
        unsteady = _unsteady(elapsed / mean - np.arange(elapsed.size), elapsed, mean, label)
        return Grid(mean, findings=(*again, *unsteady))
    return _on_grid(elapsed, interval, np.arange(elapsed.size) + shift, label, again, left)


def _in_bursts(elapsed: FloatArray, steps: FloatArray, label: str, found: tuple[Finding, ...]) -> Grid:
    """The mean rate of stamps that come in bursts, and what was lost in pauses that no burst explains."""
    mean, long = float(elapsed[-1]) / steps.size, PAUSE * float(np.quantile(steps, 0.99))
    rows = np.arange(elapsed.size)
    if steps.max() > long:
        interval, shift, _ = _follow(elapsed, rows, long / mean)
        found = (*found, _bursty(steps, interval, label))
        return _on_grid(elapsed, interval, rows + shift, label, found, np.zeros(1), rows[:0])
    return Grid(mean, findings=(*found, _bursty(steps, mean, label)))


def _mostly_missing(shift: Places, size: int) -> bool:
    """Whether bursts at a steady pace were taken for a finer grid, of which most is missing time and again."""
    return bool(shift[-1] > 0.6 * (size + shift[-1]) and (np.diff(shift) > 0).mean() > 0.02)


def _on_grid(
    elapsed: FloatArray,
    interval: float,
    places: Places,
    label: str,
    found: tuple[Finding, ...],
    left: FloatArray,
    told: Places | None = None,
) -> Grid:
    """The grid with its losses, unless they are not to be believed."""
    gaps = np.diff(places)
    if gaps.min() < 1:
        row = int(np.argmin(gaps)) + 2
        more = int(1 - gaps.min())
        what = f"row {row} of the data is more than the clock of {label} has intervals for ({more} too many)"
        again = found or (finding("duplicate stamps", what, consequence="the rows are taken as evenly spaced"),)
        return Grid(findings=again, trouble=what)
    lost = int(places[-1]) + 1 - places.size
    if lost > MOST_LOST * places[-1]:
        row = int(np.argmax(gaps))
        what = (
            f"the stamps of {label} jump by {np.diff(elapsed)[row]:.6g} s before row {row + 2} of the data, and "
            f"{lost} of {places[-1] + 1} samples would be missing: a clock that was set, or a logger that was stopped"
        )
        return Grid(trouble=what)
    drift = (elapsed / interval - places)[slice(None) if told is None else told]
    lost_found = (lost_samples(places, interval, f"by the stamps of {label}"),) if lost else ()
    unsteady = (*_jitter(left, elapsed, interval, label), *_drift(drift, elapsed, interval, label))
    return Grid(interval, None, places if lost else None, (*lost_found, *found, *unsteady))


def lost_samples(places: Places, interval: float, source: str) -> Finding:
    """The finding about holes in a grid."""
    gaps = np.diff(places)
    holes = np.flatnonzero(gaps > 1)
    lost, longest = int((gaps[holes] - 1).sum()), int(holes[gaps[holes].argmax()])
    share = 100 * lost / (places[-1] + 1)
    where = (int(places[holes[0]]) + 1) * interval
    count = f"{lost} sample{'s' * (lost > 1)} ({share:.2g} %) lost in {holes.size} gap{'s' * (holes.size > 1)}"
    most = f", the longest of {(gaps[longest] - 1) * interval:.4g} s at {places[longest] * interval:.6g} s"
    end = float(places[holes[-1] + 1]) * interval
    return finding("lost samples", f"{count}, {source}, the first at {where:.6g} s{most * (lost > 1)}", (where, end))


def _follow(elapsed: FloatArray, rows: Places, slack: float) -> tuple[float, Places, FloatArray]:
    """Interval, shift of each row and what is left: of several first guesses the best on a part, refined on all."""
    middle = slice(max(0, rows.size // 2 - PART), rows.size // 2 + PART)
    return _refined(elapsed, rows, _interval(elapsed[middle], rows[middle], slack), slack)


def _interval(elapsed: FloatArray, rows: Places, slack: float) -> float:
    """The interval that describes stamps in the shortest way."""
    steps = np.diff(elapsed) / np.diff(rows)
    span, count = float(elapsed[-1] - elapsed[0]), int(rows[-1] - rows[0])
    # the mean of all is right where little is lost, that of the usual steps where much is, of the short where most is
    guesses = [span / count, *(_mean_near(steps, float(np.quantile(steps, q))) for q in (0.5, 0.1))]
    found = [_refined(elapsed, rows, guess, slack) for guess in guesses if guess > 0]
    floor = _resolution(elapsed, steps) / 3.5

    def length(fit: tuple[float, Places, FloatArray]) -> float:
        """What is left beyond the rounding of the stamps, and which places of the grid are taken."""
        interval, shift, left = fit
        off = np.where(np.diff(shift, prepend=0) < 0, 1.0, np.clip(left, -1, 1))
        residual = interval * float(np.sqrt(np.square(off).mean()))
        if shift[-1] > 0.4 * (count + shift[-1]) and np.bincount(np.clip(np.diff(rows + shift), 0, 9)).argmax() != 1:
            return math.inf  # any stamps fit a grid of their own last digit: one step is then no more usual than two
        return math.log(max(residual, floor, 1e-9 * interval)) + math.log(max(count + int(shift[-1]), 1))

    return min(found, key=length)[0]


def _mean_near(steps: FloatArray, usual: float) -> float:
    near = steps[(steps > 0.4 * usual) & (steps < 1.6 * usual)]
    return float(near.mean()) if near.size else usual


def _refined(elapsed: FloatArray, rows: Places, interval: float, slack: float) -> tuple[float, Places, FloatArray]:
    """From a guess of the interval to the one that the count of intervals gives."""
    from allanite.kernels.clock import followed

    span, count = float(elapsed[-1] - elapsed[0]), int(rows[-1] - rows[0])
    for ahead in (16, 1024, 1024, 1024):  # a guess that is off drifts away within few stamps, a refined one does not
        shift, left = followed(elapsed / interval, rows, ahead, slack)
        counted = count + int(shift[-1])
        if counted < 1:
            break
        interval, before = span / counted, interval
        if interval == before:
            break
    shift, left = followed(elapsed / interval, rows, 1024, slack)
    return interval, shift, left


def _in_ticks(elapsed: FloatArray, steps: FloatArray, label: str) -> Grid:
    """The grid of stamps of which many are equal: the rows at which they change are counted."""
    changes = np.flatnonzero(steps > 0) + 1
    tick = _resolution(elapsed, steps)
    rows = elapsed.size / (changes.size + 1)
    if changes.size < 3:
        return Grid(
            findings=(finding("coarse stamps", f"the stamps of {label} change {changes.size} times in all"),),
            trouble=f"the stamps of {label} change {changes.size} times in {elapsed.size} rows: too coarse for a rate",
        )
    interval, shift, left = _follow(elapsed[changes], changes, 1.5)
    whole = np.zeros(elapsed.size, dtype=np.int64)
    whole[changes] = np.diff(shift, prepend=0)
    places = np.arange(elapsed.size) + np.cumsum(whole)
    mostly = _mostly_missing(shift, elapsed.size)
    if tick > 0.5 * interval and not mostly:
        coarse = finding("coarse stamps", f"stamps of {_time(tick)} in {label}, {rows:.3g} rows with the same one")
    else:
        coarse = finding("bursty stamps", f"the stamps of {label} come in groups of {rows:.3g} equal ones")
    if float((np.abs(left) > 1.5).mean()) > 0.05 or mostly or np.diff(places).min() < 1:
        span = float(elapsed[changes[-1]] - elapsed[changes[0]])
        return Grid(span / (changes[-1] - changes[0]), findings=(coarse,))
    return _on_grid(elapsed, interval, places, label, (coarse,), np.zeros(1), changes)


def _resolution(elapsed: FloatArray, steps: FloatArray) -> float:
    """The step in which a clock is read: the largest usual one of which all steps are multiples; 0 if there is none."""
    ends = steps[steps > 0][:10_000]
    for step in RESOLUTIONS:
        multiples = ends / step
        if multiples.min() > 0.5 and np.abs(multiples - np.rint(multiples)).max() < 1e-3:
            return step
    return 0.0


def _duplicates(steps: FloatArray, label: str, mean: float) -> tuple[Finding, ...]:
    equal = steps == 0
    count = int(equal.sum())
    if not count:
        return ()
    first = int(np.argmax(equal)) + 1
    what = f"{count} stamps of {label} repeat the one before with other readings, the first at row {first + 1} of the data"
    said = "the rows are taken one after the other, as they stand in the file"
    return (finding("duplicate stamps", what, (first * mean, first * mean), consequence=said),)


def _bursty(steps: FloatArray, mean: float, label: str) -> Finding:
    median = float(np.median(steps))
    what = (
        f"bursty stamps in {label}: {1 / median:.4g} Hz by the median step, {1 / mean:.6g} Hz by the mean; steps from "
        f"{_time(float(steps.min()))} to {_time(float(steps.max()))}"
    )
    return finding("bursty stamps", what)


def _unsteady(departure: FloatArray, elapsed: FloatArray, interval: float, label: str) -> tuple[Finding, ...]:
    return (*_jitter(departure, elapsed, interval, label), *_drift(departure, elapsed, interval, label))


def _jitter(departure: FloatArray, elapsed: FloatArray, interval: float, label: str) -> tuple[Finding, ...]:
    """Scatter of neighbouring stamps beyond the rounding of their last digit."""
    if departure.size < 10:
        return ()
    scatter = float(np.diff(departure, 2).var()) / 6
    steps = np.diff(elapsed)
    rounding = _resolution(elapsed, steps) / interval
    rms = max(scatter - rounding**2 / 4, 0.0) ** 0.5
    if rms < UNSTEADY:
        return ()
    what = (
        f"the stamps of {label} scatter by {rms:.2g} intervals rms; steps from {_time(float(steps.min()))} to "
        f"{_time(float(steps.max()))} where {_time(interval)} is usual"
    )
    return (finding("jitter", what),)


def _drift(departure: FloatArray, elapsed: FloatArray, interval: float, label: str) -> tuple[Finding, ...]:
    """A rate that is not the same in all sixteenths of the record."""
    size = departure.size // 16
    if size < 64:
        return ()
    means = departure[: 16 * size].reshape(16, size).mean(axis=1)
    rates = np.diff(means) / size
    change = float(rates.max() - rates.min())
    noise = float(np.diff(departure).std()) / size**1.5
    if change < DRIFT + 10 * noise or float(np.ptp(means - np.linspace(means[0], means[-1], 16))) < 0.75:
        return ()
    what = f"the clock of {label} changes its rate by {change * 1e6:.2g} ppm within the record"
    return (finding("clock drift", what),)


def _time(seconds: float) -> str:
    """A short time with its unit."""
    for size, unit in ((1.0, "s"), (1e-3, "ms"), (1e-6, "us")):
        if abs(seconds) >= 0.9995 * size:
            return f"{seconds / size:.4g} {unit}"
    return f"{seconds * 1e9:.3g} ns" if seconds else "0 s"


class Steadiness(NamedTuple):
    """How well stamps keep time, without their unit."""

    trouble: int
    scatter: float
    words: str

    def __str__(self) -> str:
        return self.words


def steadiness(stamps: NDArray[Any]) -> Steadiness:
    """How well stamps keep time: those that rise at every row before those that repeat, and these before the rest."""
    steps = np.diff(stamps.astype(np.float64) if stamps.dtype.kind == "f" else stamps - stamps[0]).astype(np.float64)
    if not np.all(np.isfinite(steps)) or not steps.any() or steps.min() < 0:
        words = "goes back" if np.all(np.isfinite(steps)) and steps.any() else "is constant or has holes"
        return Steadiness(3, 0.0, words)
    usual = float(np.median(steps))
    share = float((steps == 0).mean())
    if share >= 0.2 or not usual:
        return Steadiness(2, share, f"repeats {100 * share:.2g} % of its stamps")
    scatter = float(np.quantile(np.abs(steps / usual - 1), 0.9))
    return Steadiness(int(scatter > EVEN), scatter, f"scatters by {100 * scatter:.2g} % of a step")
