"""A statistic in sliding windows of a record: the dynamic Allan variance and related statistics."""

from collections.abc import Sequence
from typing import Unpack

import numpy as np

from allanite.core.aliases import public
from allanite.core.arrays import complete
from allanite.core.curve import Curve, Surface
from allanite.core.errors import DataError, UsageError
from allanite.core.kinds import KINDS
from allanite.core.model import ModelLike
from allanite.core.ranges import TIME
from allanite.core.record import Record, Samples, Sampling, as_record
from allanite.kernels import allan
from allanite.parallel.processes import spread
from allanite.phrases.phrase import say
from allanite.statistics import deviation

from .estimator import WindowMeans, estimate, integrated
from .row import Statistic
from .table import statistic_named

MIN_SAMPLES = 8  # minimum number of samples in a window


@public
def dynamic(
    record: Samples,
    statistic: str = "oadev",
    *,
    window: float | None = None,
    step: float | None = None,
    taus: str | Sequence[float] = "octave",
    m: Sequence[int] | None = None,
    noise: ModelLike | None = None,
    threads: int = 1,
    **sampling: Unpack[Sampling],
) -> Surface:
    """Compute a statistic in sliding windows of a record, which shows changes with time.

    Parameters
    ----------
    record : Record or array, shape (n,)
        NaN marks missing samples.
    statistic : str
        A name in `STATISTICS`.
    window, step : float, optional
        Length of a window, by default a tenth of the record, and distance between windows, by default an eighth of a
        window; s. Both are rounded to whole samples.
    taus, m, noise
        As for `deviation`, for a record of one window.
    threads : int
        Maximum number of threads, used where windows are processed one by one; the results are the same.
    **sampling
        As for `deviation`.

    Returns
    -------
    Surface
        Each row is the result of `deviation` for the samples of its window; NaN if these are not sufficient.

    Raises
    ------
    DataError
        No window supports the statistic.
    UsageError
        A name is unknown; the window is too short, or longer than the record; see also `deviation`.

    References
    ----------
    L. Galleani, P. Tavella, The dynamic Allan variance, IEEE Trans. UFFC 56 (2009) 450; M. van Herk, Pattern
    Recognition Letters 13 (1992) 517 (sums of blocks).

    Examples
    --------
    >>> y = np.random.default_rng(1).standard_normal(10_000)
    >>> y[5000:] *= 3
    >>> surface = dynamic(Record(y, rate=10.0, unit="deg/h", name="z"), window=100.0, step=50.0).to("deg/h")
    >>> surface.deviation.shape, float((surface.deviation[-1, 0] / surface.deviation[0, 0]).round(1))
    ((19, 9), 3.0)
    """
    row = statistic_named(statistic)
    if threads < 1:
        raise UsageError(f"the number of threads must be at least 1, not {threads!r}")
    record = as_record(record, "dynamic", sampling, unit="1")
    record.demand_range()
    samples, stride = _samples(record, window, step)
    # any window without missing samples: its curve has the grid, the counts and the law of all windows
    flawless = np.sin(np.arange(samples) ** 2.0)
    unit, kind = record.signal.unit, record.signal.kind
    window_of_all = Record(flawless, record.rate, unit, kind, name=record.name)
    first = deviation(window_of_all, row.name, taus=taus, m=m, noise=noise)
    starts = np.arange(0, record.size - samples + 1, stride)
    if row.sliding and complete(record.values):
        angle = integrated(record, row.order)
        sums = allan.windowed(angle.pieces[0].x, first.m, first.count, row.order, stride)
        variance = sums * (angle.scale**2 / (row.norm(first.m) * first.count * first.tau**2))
        shape = variance.shape
        means = WindowMeans(variance, np.broadcast_to(first.count, shape), np.broadcast_to(first.factor, shape))
    else:
        points = samples + KINDS[record.kind][1]
        parts = [
            record.with_values(
                record.values[start : start + points],
                say("window of {count} samples at sample {start}", count=samples, start=start),
            )
            for start in starts.tolist()
        ]
        shape = (len(parts), first.m.size)
        means = WindowMeans(np.full(shape, np.nan), np.zeros(shape, dtype=np.int64), np.full(shape, np.nan))
        reason: DataError | None = None
        for i, result in enumerate(spread(lambda part: _one(part, row, first), parts, threads)):
            if isinstance(result, DataError):
                reason = result
                continue
            means.variance[i], means.number[i], means.factor[i] = result
        if reason is not None and not means.number.any():
            raise DataError(say("no window of {channel!r} supports {statistic}: {reason}", channel=parts[0].name,
                                statistic=row.name, reason=reason)) from None  # fmt: skip
    return Surface(statistic=row.name, time=np.asarray((starts + samples / 2) / record.rate), m=first.m, tau=first.tau,
                   variance=means.variance, count=means.number, factor=means.factor, window=samples / record.rate,
                   step=stride / record.rate, unit=first.unit, rate=record.rate, name=record.name,
                   history=record.history, noise=first.noise, law=first.law, supposes=first.supposes)  # fmt: skip


def _samples(record: Record, window: float | None, step: float | None) -> tuple[int, int]:
    """Length of a window and of a step in samples."""
    for name, value in (("window", window), ("step", step)):
        TIME.demand(value, f"the {name}")
    samples = record.size // 10 if window is None else round(window * record.rate)
    if not MIN_SAMPLES <= samples <= record.size:
        raise UsageError(
            f"a window of {samples / record.rate:g} s is not possible: {record.name!r} is {record.duration:g} s "
            f"long, and the minimum of {MIN_SAMPLES} samples is {MIN_SAMPLES / record.rate:g} s"
        )
    return samples, max(1, samples // 8 if step is None else round(step * record.rate))


def _one(part: Record, row: Statistic, first: Curve) -> WindowMeans | DataError:
    """A window by itself, or the reason if too many samples are missing."""
    try:
        angle = integrated(part, row.order)
        variance, number, factor = estimate(row, angle, first.m)
    except DataError as error:
        return error
    return WindowMeans(variance * (angle.scale / part.interval ** (1 - row.power)) ** 2, number, factor)
