"""Functions from a record to a record, each with an entry in the history."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import scipy

from allanite.core.aliases import public
from allanite.core.arrays import BoolArray, stretches
from allanite.core.errors import DataError, UsageError, given
from allanite.core.kinds import KINDS
from allanite.core.record import SHORTEST, Record, Recording
from allanite.core.validity import Finding
from allanite.phrases.phrase import say, say_count
from allanite.statistics.table import statistic_named

from .inspector import means
from .outliers import MOST, marked, outliers
from .stillness import AT_REST, busy
from .view import View
from .window import of_each


@public
def mark_outliers(record: Record) -> Record:
    """Replace outliers by NaN: missing samples.

    They are not interpolated: the record then has gaps, and its history states how many and where the first is.
    Outliers are defined in `allanite.prepare.outliers.outliers`. Counts become increments, and so does an angle that
    jumps; an angle that is wrong at single points loses these.

    Examples
    --------
    >>> y = np.random.default_rng(1).standard_normal(1000)
    >>> y[500] = 50.0
    >>> marked = mark_outliers(Record(y, rate=1.0, unit="deg/s"))
    >>> np.flatnonzero(np.isnan(marked.values)).tolist(), marked.history
    ([500], ('1 outlier beyond 5 standard deviations, at 500 s, of 51.5: marked as missing',))
    """
    return marked(record, outliers(record))


MOTION = ("mark", "refuse")  # what can be done where the sensor moves
PASSES = 4  # how often motion is looked for, each time without what was found before


def demand_motion(word: str) -> str:
    """Refuse an unknown choice for motion."""
    if word not in MOTION:
        raise UsageError(f"motion must be {' or '.join(map(repr, MOTION))}, not {word!r}")
    return word


def mark_motion(records: Sequence[Record]) -> tuple[Record, ...]:
    """Replace by NaN, in all channels of a body, the blocks of a second in which one of them moves."""
    # The blocks are those of the finding "moving"; the search is repeated without them, since motion widens the scale.
    moved = motion(records)
    if not moved.any():
        return tuple(records)
    return tuple(_still(record, moved) if record.signal.inertial else record for record in records)


def motion(records: Sequence[Record]) -> BoolArray:
    """The intervals that `mark_motion` leaves out, shape (size,)."""
    carried = [record for record in records if record.signal.inertial]
    moved = np.zeros(max((record.size for record in carried), default=0), dtype=np.bool_)
    for _ in range(PASSES):
        before = int(moved.sum())
        for record in carried:
            moved[: record.size] |= _moving(_still(record, moved) if before else record)
        if int(moved.sum()) == before:
            break
    return moved


def _moving(record: Record) -> BoolArray:
    """Intervals of a record that lie in moving blocks, shape (size,); of a single one, too."""
    # A block is no moving one where only few of its samples, at most 2 % or one, are outliers.
    moved = np.zeros(record.size, dtype=np.bool_)
    view = View(record)
    if record.out_of_range or view.steps.size < SHORTEST:
        return moved
    loud = busy(view)
    if loud.any():
        count = np.bincount(view.outlying // view.span, minlength=loud.size)[: loud.size]
        loud &= (count == 0) | (count > max(1, MOST * view.span))
        inside = np.flatnonzero(np.repeat(loud, view.span))
        moved[inside if view.left is None else view.left[inside]] = True
    return moved


def _still(record: Record, moved: BoolArray) -> Record:
    """The record without the intervals in which it moved."""
    values = np.array(record.values, dtype=np.float64)
    at = moved[: record.size]
    for first in range(KINDS[record.kind][1] + 1):  # an interval of an angle has two ends
        values[first : first + at.size][at] = np.nan
    return record.with_values(values, motion_found(record, at).what, start=record.start)


def motion_found(record: Record, moved: BoolArray) -> Finding:
    """The finding about intervals that are left out because the sensor moved."""
    runs = stretches(moved)
    first, last = (record.cut + place / record.rate for place in (runs[0, 0], runs[-1, 1]))
    what = say("moved in {places}, from {first:.4g} s to {last:.4g} s: left out",
               places=say_count(len(runs), "{count} place", "{count} places"), first=first, last=last)  # fmt: skip
    return Finding("moving", what, AT_REST, place=(first, last))


@public
def detrend(record: Record, statistic: str) -> Record:
    """The record minus the least-squares ramp of its rates, for a statistic that is insensitive to a ramp.

    Missing samples (NaN) stay missing. Of an angle the parabola is subtracted that the ramp adds up to.

    Raises
    ------
    UsageError
        The statistic is sensitive to a ramp, as the whole Allan family: R^2 tau^2 / 2 is part of its value.
    DataError
        Fewer than two rates are known.
    """
    if statistic_named(statistic).order < 3:
        raise UsageError(f"{statistic} is sensitive to a ramp, R^2 tau^2 / 2 is part of its value; a ramp may be "
                         "removed only for statistics of third differences")  # fmt: skip
    values = np.asarray(record.values, dtype=np.float64)
    y = np.diff(values) if (angle := KINDS[record.kind][1] == 1) else values
    at = np.flatnonzero(np.isfinite(y))
    if at.size < 2:
        raise DataError(f"a ramp cannot be fitted: {at.size} of {y.size} rates are known, at least 2 are needed")
    t = np.arange(y.size) - at.mean()
    slope = float(t[at] @ y[at] / (t[at] @ t[at]))
    ramp = np.concatenate(([0.0], np.cumsum(slope * t))) if angle else slope * t
    size = slope * record.rate * (record.scale or 1.0)
    what = say("ramp of {slope:.6g} {unit} per second removed", slope=size, unit=record.unit)
    return record.with_values(values - ramp, what, start=record.start)


@public
def block_means(record: Record, m: int) -> Record:
    """Means (for increments and counts: sums) of `m` successive samples, at the rate divided by `m`.

    Exact for the Allan family: the curve at averaging factors k m is
    unchanged. Samples beyond the last whole block are omitted, which the history states.
    """
    if not isinstance(m, (int, np.integer)) or not 1 <= m <= record.size // 2:
        raise UsageError(f"means of {given(m)} samples are not possible: the record has {record.size}, so that a mean "
                         f"takes a whole number from 1 to {record.size // 2}")  # fmt: skip
    kept = means(record.values, record.kind, int(m))
    rest = record.size - (len(kept) - KINDS[record.kind][1]) * m
    return replace(record, values=kept, rate=record.rate / m, history=(*record.history, blocks_words(int(m), rest)))


def blocks_words(m: int, left: int) -> str:
    """History entry of means over `m` samples, of which so many are `left` at the end."""
    if left:
        return say("blocks of {size} samples, the last {left} samples omitted", size=m, left=left)
    return say("blocks of {size} samples", size=m)


NEAR = 0.01  # relative difference of a sampling interval from a nominal one: a clock that is that wrong is still meant


def averaged(recording: Recording, time: float) -> Recording:
    """The recording with means over `time` seconds for samples (of increments and counts: sums)."""
    m = samples_in(time, recording.records[0].rate)
    return of_each(recording, lambda record: block_means(record, m))


def samples_in(time: float, rate: float) -> int:
    """How many samples a mean over `time` seconds is of; refused where it is no whole number, within 1 %."""
    m = round(time * rate) if np.isfinite(time) else 0
    if m < 1 or abs(m / rate - time) > NEAR * time:
        raise UsageError(f"means over {time:g} s are no whole number of samples at {rate:g} Hz; the nearest time is "
                         f"{max(m, 1) / rate:g} s")  # fmt: skip
    return m


@public
def decimate(record: Record, factor: int) -> Record:
    """Every `factor`-th sample of a rate after a linear-phase low-pass filter at 0.4 of the new rate.

    Unlike block means, it prevents aliasing of vibration into the band; the transients of the filter
    are cut off. The shortest averaging times of the result show the filter, not the sensor.
    """
    if record.integrated:
        raise UsageError(f"decimation needs a rate; for {record.kind}s use block_means, which preserves the angle")
    if not isinstance(factor, (int, np.integer)) or factor < 2 or record.size < 64 * factor:
        raise UsageError(f"the factor must be between 2 and {record.size // 64}, not {given(factor)}")
    taps = scipy.signal.firwin(30 * int(factor) + 1, 0.8 / factor, window=("kaiser", 8.0))
    offset = record.constant
    less = np.asarray(record.values, dtype=np.float64) - offset
    filtered = scipy.signal.oaconvolve(less, taps, mode="valid") + offset
    start = (record.start or 0.0) + (taps.size // 2) / record.rate
    what = say("low-pass filtered at {frequency:.6g} Hz and every {factor}th sample kept",
               frequency=0.4 * record.rate / factor, factor=factor)  # fmt: skip
    return replace(
        record, values=np.ascontiguousarray(filtered[:: int(factor)]), rate=record.rate / factor, start=start,
        history=(*record.history, what),
    )  # fmt: skip
