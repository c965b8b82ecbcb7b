"""Functions from a record to a record, each with an entry in the history."""

from dataclasses import replace

import numpy as np

from allanite.core.errors import UsageError, given
from allanite.core.kinds import KINDS
from allanite.core.record import Record, Recording
from allanite.phrases.phrase import say
from allanite.statistics.table import statistic_named

from .outliers import marked, outliers


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


def detrend(record: Record, statistic: str) -> Record:
    """The record minus its least-squares ramp, for a statistic that is insensitive to a ramp.

    Raises
    ------
    UsageError
        The statistic is sensitive to a ramp, as the whole Allan family: R^2 tau^2 / 2 is part of its value.
    """
    if statistic_named(statistic).order < 3:
        raise UsageError(
            f"{statistic} is sensitive to a ramp, R^2 tau^2 / 2 is part of its value; a ramp may be removed only "
            "for statistics of third differences"
        )
    y = np.asarray(record.values, dtype=np.float64)
    t = np.arange(y.size) - (y.size - 1) / 2
    slope = float(t @ y / (t @ t))
    what = say("ramp of {slope:.6g} {unit} per second removed", slope=slope * record.rate, unit=record.unit)
    return record.with_values(y - slope * t, what, start=record.start)


def block_means(record: Record, m: int) -> Record:
    """Means (for increments and counts: sums) of `m` successive samples, at the rate divided by `m`.

    Exact for the Allan family: the curve at averaging factors k m is
    unchanged. Samples beyond the last whole block are omitted, which the history states.
    """
    if not isinstance(m, (int, np.integer)) or not 1 <= m <= record.size // 2:
        raise UsageError(f"blocks must have between 1 and {record.size // 2} samples, not {given(m)}")
    if record.kind == "angle":
        kept = record.values[:: int(m)]
    else:
        count = record.size // m
        blocks = record.values[: count * m].reshape(count, m)
        kept = blocks.sum(axis=1) if record.integrated else blocks.mean(axis=1)
    left = record.size - (len(kept) - KINDS[record.kind][1]) * m
    what = say("blocks of {size} samples", size=m)
    if left:
        what = say("blocks of {size} samples, the last {left} samples omitted", size=m, left=left)
    return replace(record, values=kept, rate=record.rate / m, history=(*record.history, what))


NEAR = 0.01
"""Relative difference of a sampling interval from a nominal one: a clock that is that wrong is still meant."""


def averaged(recording: Recording, time: float) -> Recording:
    """The recording with means over `time` seconds for samples (of increments and counts: sums).

    Raises
    ------
    UsageError
        The time is not a multiple of the sampling interval within 1 %, or the record is shorter than two blocks.

    Examples
    --------
    >>> recording = Recording((Record([1.0, 3.0, 2.0, 6.0], rate=2.0, unit="deg/h"),))
    >>> averaged(recording, 1.0)[0].values.tolist()
    [2.0, 4.0]
    """
    first = recording.records[0]
    m = round(time * first.rate) if np.isfinite(time) else 0
    if m < 1 or abs(m / first.rate - time) > NEAR * time:
        raise UsageError(
            f"means over {time:g} s are no whole number of samples at {first.rate:g} Hz; the nearest time is "
            f"{max(m, 1) / first.rate:g} s"
        )
    records, others = ([block_means(r, m) for r in part] for part in (recording.records, recording.others))
    return replace(recording, records=tuple(records), others=tuple(others))


def decimate(record: Record, factor: int) -> Record:
    """Every `factor`-th sample of a rate after a linear-phase low-pass filter at 0.4 of the new rate.

    Unlike block means, it prevents aliasing of vibration into the band; the transients of the filter
    are cut off. The shortest averaging times of the result show the filter, not the sensor.
    """
    if record.integrated:
        raise UsageError(f"decimation needs a rate; for {record.kind}s use block_means, which preserves the angle")
    if not isinstance(factor, (int, np.integer)) or factor < 2 or record.size < 64 * factor:
        raise UsageError(f"the factor must be between 2 and {record.size // 64}, not {given(factor)}")
    from scipy.signal import firwin, oaconvolve

    taps = firwin(30 * int(factor) + 1, 0.8 / factor, window=("kaiser", 8.0))
    offset = record.constant
    filtered = oaconvolve(np.asarray(record.values, dtype=np.float64) - offset, taps, mode="valid") + offset
    start = (record.start or 0.0) + (taps.size // 2) / record.rate
    what = say(
        "low-pass filtered at {frequency:.6g} Hz and every {factor}th sample kept",
        frequency=0.4 * record.rate / factor,
        factor=factor,
    )
    return replace(
        record,
        values=np.ascontiguousarray(filtered[:: int(factor)]),
        rate=record.rate / factor,
        start=start,
        history=(*record.history, what),
    )
