"""Held samples: a logger faster than its sensor repeats each sample until the next one, and which are the sensor's own.

Successive samples that differ are a tick of the sensor. Where the samples are fine, none are equal by chance, and every
tick shows; where they are coarse, the ticks are those of a clock that runs through the instants of change.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from allanite.core.arrays import BoolArray, FloatArray, IntArray, complete
from allanite.core.plain import Header
from allanite.core.record import Record, Recording
from allanite.core.validity import Finding
from allanite.phrases.phrase import say

FEWEST, FEWEST_CHANGES = 400, 100  # samples, and changes among them, below which nothing is held
CHANGING = (0.02, 0.96)  # share of the samples that differ from the one before: held 50 times, and 1.04 times
FINE = 0.01  # probability that neighbours are equal by chance up to which every repeated sample is a held one

EVEN = 0.5
"""Variance of the distances between ticks over that of chance (a geometric law) below which the ticks are regular: 1
with a scatter of 0.1 for samples that a logger has filled in, 0.4 at most for clocks that jitter by a quarter."""

JUMPS = 0.05  # share of the changes by more than a step below which the signal creeps, and steps at even distances
CLEAR = 60.0  # power of the strongest line of the changes over their median below which no clock is looked for
APART = 0.25  # difference of the shares of equal neighbours between and at the ticks of a clock, 0 by chance
SURE = 0.9  # share of equal neighbours between the ticks of a clock nearly as fast as the logger: sinusoids show one
NEARLY = 1.5  # samples a tick up to which it is nearly as fast
SELDOM = 0.3  # share of the changes directly after another, over that of chance, below which all samples are repeated
SKIPPED = 1.75  # usual distances of two changes from which a sample between them equals the one before
HARMONICS = 40  # of the clock of a sensor, of which one is the strongest line of the changes
NEAR = 1.25  # factor within which the share of equal neighbours tells how many samples a tick has
LONGEST, TRIED = 1 << 18, 20_000  # samples of which the line is taken, and on which clocks are compared
TOGETHER = 50  # changes at one phase that tell the phase of a clock, which follows a drift of the clocks


@dataclass(frozen=True, eq=False)
class Hold:
    """The samples of a sensor: the index of each in the record, -1 where it is missing, and the intervals of each."""

    at: IntArray
    times: float


def held(columns: Sequence[NDArray[Any]]) -> Hold | None:
    """The samples of a sensor whose channels these are, if its logger repeats them."""
    whole = all(map(complete, columns))
    known = None if whole else np.logical_and.reduce([np.isfinite(column) for column in columns])
    y = columns if known is None else [column[known] for column in columns]
    if y[0].size < FEWEST:
        return None
    moved = np.zeros(y[0].size - 1, dtype=np.bool_)
    for column in y:
        moved |= column[1:] != column[:-1]
        if np.count_nonzero(moved) >= CHANGING[1] * moved.size:
            return None
    if moved.sum() < FEWEST_CHANGES or not CHANGING[0] < moved.mean():
        return None
    ticks = _ticks(moved, np.abs(np.diff(np.stack(y).astype(np.float64))))
    if ticks is None:
        return None
    at = np.flatnonzero(moved) + 1
    place = at if known is None else np.flatnonzero(known)[at]
    lost = place - at  # samples missing before
    times = (at[-1] - at[0]) / (ticks[-1] - ticks[0])
    ticks = ticks + np.rint((lost - lost[0]) / times).astype(np.int64)
    return Hold(_filled(place, ticks, np.diff(lost, prepend=lost[0]) > 0), float(times))


def _filled(at: IntArray, ticks: IntArray, gap: BoolArray) -> IntArray:
    """The sample of each tick: of one without a change that of the tick before, in a gap none."""
    source = np.zeros(ticks[-1] - ticks[0] + 1, np.int64)
    source[ticks - ticks[0]] = at
    source = np.maximum.accumulate(source)
    ends = ticks - ticks[0]
    for i in np.flatnonzero(gap):
        source[ends[i - 1] + 1 : ends[i]] = -1
    return source


def _ticks(moved: BoolArray, steps: FloatArray) -> IntArray | None:
    """The number of the tick at each change, ascending; None if there is no clock."""
    chance, creeping = _chance(steps)
    at = np.flatnonzero(moved) + 1
    if chance < FINE:
        runs = np.diff(at) / max(np.median(np.diff(at)), 2)
        return _counted(np.where(runs < SKIPPED, 1, np.rint(runs))) if _dispersion(moved) < EVEN else None
    if creeping:
        return None
    line, strength = _line(moved)
    ticks = _clocked(moved, line, chance) if strength > CLEAR else None
    return _spaced(moved) if ticks is None else ticks


def _chance(steps: FloatArray) -> tuple[float, bool]:
    """Probability that neighbours in all channels are equal by rounding, and whether changes are single steps."""
    chance, creeping = 1.0, True
    for row in steps:
        changes = row[row > 0]
        if not changes.size:
            continue
        step, high = float(changes.min()), float(np.quantile(changes, 0.99))
        spread, equal = math.sqrt(float(np.mean(np.minimum(changes, high) ** 2))), 0.0
        for _ in range(20):  # the density of a difference at zero times the step; equal ones are not in the spread
            equal = min(0.95, step / (math.sqrt(2 * math.pi * (1 - equal)) * spread))
        chance *= equal
        creeping &= float(np.mean(changes > 1.5 * step)) < JUMPS
    return chance, creeping


def _dispersion(moved: BoolArray) -> float:
    """Variance of the distances between changes, or between repeats if these are fewer, over that of chance."""
    apart = np.diff(np.flatnonzero(moved if moved.mean() <= 0.5 else ~moved))
    mean = float(apart.mean()) if apart.size > 1 else 1.0
    return float(apart.var()) / (mean * (mean - 1)) if mean > 1 else math.inf


def _line(moved: BoolArray) -> tuple[float, float]:
    """Frequency of the strongest line of the changes, in cycles a sample, and its power over the median."""
    x = moved[:LONGEST] - float(moved[:LONGEST].mean())
    power = np.abs(scipy.fft.rfft(x * np.hanning(x.size), 2 * x.size)) ** 2
    power[:64] = 0
    top = int(power.argmax())
    strength = float(power[top] / max(float(np.median(power[64:])), 1e-300))
    if top == power.size - 1:
        return 0.5, strength
    before, here, after = np.sqrt(power[top - 1 : top + 2])
    bend = before - 2 * here + after
    return (top + (0.5 * (before - after) / bend if bend else 0.0)) / (2 * x.size), strength


def _clocked(moved: BoolArray, line: float, chance: float) -> IntArray | None:
    """Ticks of a steady clock, of which a harmonic is the line, that explains which neighbours are equal."""
    expected = float(moved.mean()) / (1 - chance)
    clocks = {round((j + sign * line) / h, 9) for h in range(1, HARMONICS) for j in range(h + 1) for sign in (1, -1)}
    best, period = APART, 0.0
    for clock in sorted(c for c in clocks if expected / NEAR <= c <= min(CHANGING[1], expected * NEAR)):
        between, at = _equal(moved[:TRIED], 1 / clock)
        if between - at > best + 0.02 and between > (SURE if clock > 1 / NEARLY else 0.0):
            best, period = between - at, 1 / clock
    return np.maximum.accumulate(_tracked(np.flatnonzero(moved) + 1, period)[0]) if period else None


def _tracked(at: IntArray, period: float) -> tuple[IntArray, FloatArray, FloatArray]:
    """The nearest tick of each change, and the phase of the clock with the instants at which it is known."""
    # changes are spread over an interval of the logger, 1/period of a turn, whose mean direction has this length
    alike = float(np.sinc(1 / period)) ** 2
    count = max(1, int(at.size * alike / TOGETHER))
    starts = np.linspace(0, at.size, count + 1).astype(np.int64)
    turns = np.add.reduceat(np.exp(2j * math.pi * at / period), starts[:-1])
    phase = np.unwrap(np.angle(turns) / (2 * math.pi), period=1.0)
    middle = np.add.reduceat(at.astype(np.float64), starts[:-1]) / np.diff(starts)
    return np.rint(at / period - np.interp(at, middle, phase)).astype(np.int64), middle, phase


def _equal(moved: BoolArray, period: float) -> tuple[float, float]:
    """Shares of equal neighbours between the ticks of a clock and at them."""
    at = np.flatnonzero(moved) + 1
    ticks, middle, phase = _tracked(at, period)
    number = np.arange(ticks[0], ticks[-1] + 1)
    places = number * period
    for _ in range(3):  # the phase belongs to the place, which depends on it
        places = (number + np.interp(places, middle, phase)) * period
    ticking = np.zeros(moved.size + 1, dtype=np.bool_)
    ticking[np.clip(np.rint(places).astype(np.int64), 1, moved.size)] = True
    ticking = ticking[1:]
    if ticking.all():
        return 0.0, 0.0
    return 1 - float(moved[~ticking].mean()), 1 - float(moved[ticking].mean())


def _spaced(moved: BoolArray) -> IntArray | None:
    """Ticks of a clock without memory: hardly ever two changes one after the other, runs of so many intervals."""
    runs = np.diff(np.flatnonzero(moved)).astype(np.float64)
    if moved.mean() > 0.55 or float(np.mean(runs == 1)) > SELDOM * moved.mean():
        return None
    usual = max(int(np.convolve(np.bincount(runs.astype(np.int64)), np.ones(3), "same").argmax()), 2)
    period = float(runs[np.abs(runs - usual) <= max(0.4 * usual, 1)].mean())
    for _ in range(5):
        number = np.maximum(1.0, np.rint(runs / period))
        period = float(runs.sum() / number.sum())
    return _counted(number)


def _counted(number: FloatArray) -> IntArray:
    """Ticks of changes that are so many ticks apart."""
    return np.concatenate(([0], np.cumsum(number))).astype(np.int64)


def held_of(record: Record) -> Hold | None:
    """The samples of the sensor of one channel, if its logger repeats them."""
    return held([record.steps]) if _may_repeat(record) else None


def as_sensed(recording: Recording) -> Recording:
    """The recording with the samples of each sensor that its logger repeats taken once, at the sensor's own rate."""
    made, findings = dict[str, Record](), []
    alike = sorted(filter(_may_repeat, recording.records), key=_of_sensor)
    for _, group in groupby(alike, _of_sensor):
        members = list(group)
        hold = held([record.steps for record in members])
        if hold is not None:
            made |= {record.name: _own(record, hold) for record in members}
            findings.append(_told(members, hold, len(members) < len(recording.records)))
    if not made:
        return recording
    records = tuple(made.get(record.name, record) for record in recording.records)
    return replace(recording, records=records, findings=(*recording.findings, *findings))


def _may_repeat(record: Record) -> bool:
    """Whether a sample is a state of the sensor, not a sum or a point of an angle."""
    return record.kind in ("rate", "value") and not record.out_of_range


def _of_sensor(record: Record) -> tuple[str, float, int, str]:
    """Channels for which this is equal change at once; columns that are no inertial sensor stand alone."""
    return record.signal.name, record.rate, record.size, "" if record.signal.inertial else record.name


def _own(record: Record, hold: Hold) -> Record:
    values = np.array(record.values[hold.at], dtype=np.float64)
    values[hold.at < 0] = np.nan
    start = (record.start or 0.0) + int(hold.at[0]) / record.rate
    what = say("held {times:.4g} times: each sample of the sensor is used once", times=hold.times)
    return replace(record.with_values(values, what, start=start), rate=record.rate / hold.times)


def was_held(record: Record | Header) -> bool:
    """Whether the samples of this channel were repeated, and are used once."""
    return any(entry.startswith("held ") for entry in record.history)


def _told(members: Sequence[Record], hold: Hold, some: bool) -> Finding:
    """The finding that samples are held, of some channels of a recording or of all."""
    what = held_words(members[0].rate, hold)
    if some:
        what = say("{channels}: {what}", channels=", ".join(record.name for record in members), what=what)
    return Finding(
        "held", what, say("each sample of the sensor is used once, at its own rate"),
        say("log at the rate of the sensor"),
    )  # fmt: skip


def held_words(rate: float, hold: Hold) -> str:
    """How often samples are held, and the rate of the sensor."""
    return say("held from {own:.5g} Hz: the logger repeats each sample {times:.4g} times on average, at {rate:.6g} Hz",
               own=rate / hold.times, times=hold.times, rate=rate)  # fmt: skip
