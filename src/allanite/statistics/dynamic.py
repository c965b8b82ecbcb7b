"""A statistic in windows that slide along a record: the dynamic Allan variance and its relatives."""

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from allanite.curve import Curve
from allanite.errors import DataError, UsageError
from allanite.model import Model
from allanite.record import KINDS, Record
from allanite.surface import Surface

from . import deviation, integrated, statistic_named
from .row import FloatArray, IntArray

FEWEST = 8
"""Samples below which a window is no window."""


SLIDING = ("oadev", "ohdev")
"""Overlapped differences, which neighbouring windows share: each is taken once, and windows are sums of blocks."""


def dynamic(
    record: Record,
    statistic: str = "oadev",
    *,
    window: float | None = None,
    step: float | None = None,
    taus: str | Sequence[float] = "octave",
    m: Sequence[int] | None = None,
    noise: Model | None = None,
) -> Surface:
    """A statistic in windows that slide along a record: what changes with time.

    Parameters
    ----------
    record : Record
        NaN marks lost samples.
    statistic : str
        A name in `STATISTICS`.
    window, step : float, optional
        Length of a window, a tenth of the record if left out, and distance of neighbours, an eighth of a window; s.
        Both are rounded to whole samples.
    taus, m, noise
        As of `deviation`, for a record of one window.

    Returns
    -------
    Surface
        Each row is what `deviation` gives for the samples of its window; NaN where these do not support it.

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
    samples, stride = _samples(record, window, step)
    first = _template(_part(record, 0, samples), partial(deviation, statistic=row.name, taus=taus, m=m, noise=noise))
    starts = np.arange(0, record.size - samples + 1, stride)
    if row.name in SLIDING and np.isfinite(record.values.sum(dtype=np.float64)):
        variance = _all_at_once(record, first, stride)
        count = np.broadcast_to(first.count, variance.shape)
    else:
        variance, count = _one_by_one(record, first, starts, samples)
    return Surface(
        statistic=row.name,
        time=np.asarray((starts + samples / 2) / record.rate),
        m=first.m,
        tau=first.tau,
        variance=variance,
        count=count,
        window=samples / record.rate,
        step=stride / record.rate,
        unit=record.signal.unit,
        rate=record.rate,
        name=record.name,
        history=record.history,
        noise=noise,
        law=first.law,
    )


def _samples(record: Record, window: float | None, step: float | None) -> tuple[int, int]:
    """Length of a window and of a step in samples."""
    for name, value in (("window", window), ("step", step)):
        if value is not None and not (np.isfinite(value) and value > 0):
            raise UsageError(f"the {name} is a positive number of seconds, not {value!r}")
    samples = record.size // 10 if window is None else round(window * record.rate)
    if not FEWEST <= samples <= record.size:
        raise UsageError(
            f"a window of {samples / record.rate:g} s does not do: {record.name!r} is {record.duration:g} s long, and "
            f"{FEWEST} samples take {FEWEST / record.rate:g} s"
        )
    return samples, max(1, samples // 8 if step is None else round(step * record.rate))


def _part(record: Record, start: int, samples: int) -> Record:
    stop = start + samples + KINDS[record.kind][1]
    return record.with_values(record.values[start:stop], f"window of {samples} samples at sample {start}")


def _template(part: Record, measure: Callable[[Record], Curve]) -> Curve:
    """The curve of a window without lost samples: the grid, the counts and the law of all windows."""
    return measure(part.with_values(np.arange(part.values.size) % 2, "no sample is lost"))


def _all_at_once(record: Record, first: Curve, stride: int) -> FloatArray:
    from allanite.kernels.dynamic import windowed

    row = statistic_named(first.statistic)
    x, scale = integrated(record)
    sums = windowed(x, first.m, first.count, row.order, stride)
    return np.asarray(sums * (scale**2 / row.norm) / (first.count * first.tau**2))


def _one_by_one(record: Record, first: Curve, starts: IntArray, samples: int) -> tuple[FloatArray, IntArray]:
    variance = np.full((starts.size, first.m.size), np.nan)
    count = np.zeros(variance.shape, dtype=np.int64)
    reason: DataError | None = None
    for i, start in enumerate(starts):
        try:
            curve = deviation(_part(record, int(start), samples), first.statistic, m=first.m.tolist())
        except DataError as error:  # this window has lost too much; the others have not
            reason = error
            continue
        variance[i], count[i] = curve.variance, curve.count
    if reason is not None and not np.isfinite(variance).any():
        raise DataError(f"no window of {record.name!r} supports {first.statistic}: {reason}") from None
    return variance, count
