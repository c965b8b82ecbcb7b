"""The angle of a record, split at its gaps, and estimates from it: windows with missing samples are omitted."""

from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from allanite.core.aliases import public
from allanite.core.arrays import FloatArray, IntArray, stretches
from allanite.core.errors import DataError, UsageError
from allanite.core.kinds import KINDS
from allanite.core.record import Record
from allanite.kernels import allan
from allanite.parallel.processes import spread
from allanite.phrases.phrase import say, windowing

from .differences import OADEV
from .moments.means import Places, There, takes_means, variance_of
from .row import Statistic, seconds

MAX_SWEPT = 1000  # averaging factors of a request whose variances are kept for the next one

MAX_DIRECT_SECONDS = 0.2
"""Seconds of a compiled loop from which on it runs in a thread of its own, so that it can be interrupted."""


class Piece(NamedTuple):
    """The angle over a stretch without gaps: the sample at which it starts, and its points (one more than samples)."""

    start: int
    x: FloatArray


class AngleRecord(NamedTuple):
    """The angle of a record in units of its steps: its pieces and its length in sample intervals, gaps included."""

    # `scale` is what x must be multiplied with to be SI.
    pieces: tuple[Piece, ...]
    size: int
    scale: float

    @property
    def places(self) -> list[tuple[int, int]]:
        """(first sample, samples) of every piece."""
        return [(piece.start, piece.x.size - 1) for piece in self.pieces]


@public
def integrated(record: Record, order: int) -> AngleRecord:
    """The angle of a record, for statistics that take differences of `order`.

    A constant rate is removed first where `order` lets it: a bias then costs no digits. No sum runs across a gap; a
    record without two neighbouring samples that are finite is a DataError.
    """
    values, places = record.values, places_of(record)
    if record.kind == "angle":
        pieces = [Piece(a, (values[a : a + n + 1] - values[a]).astype(np.float64)) for a, n in places]
    else:
        constant = record.constant if order > 1 else 0
        pieces = [Piece(a, allan.integrate(values[a : a + n], constant)) for a, n in places]
    return AngleRecord(tuple(pieces), record.size, angle_scale(record))


def places_of(record: Record) -> Places:
    """(first sample, samples) of every stretch without gaps, of two samples or more."""
    record.demand_range()
    values = record.values
    runs = [[0, len(values)]] if record.complete else stretches(np.isfinite(values)).tolist()
    each = [(a, b - a - KINDS[record.kind][1]) for a, b in runs]
    long = tuple((a, n) for a, n in each if n > 1)
    if not long:
        raise DataError(say("{channel!r} has no two successive samples that are finite; no differences can be computed",
                            channel=record.name))  # fmt: skip
    return long


def angle_scale(record: Record) -> float:
    """What the steps of the angle of a record are multiplied with to be SI."""
    return record.factor * (1.0 if record.integrated else record.interval)


class WindowMeans(NamedTuple):
    """Variances in squared steps of the angle over the sample interval, number of windows, factor that is in them."""

    variance: FloatArray
    number: IntArray
    factor: FloatArray


def estimate(row: Statistic, angle: AngleRecord, m: IntArray, *, divisor: int = 30, threads: int = 1) -> WindowMeans:
    """A statistic of a record at averaging factors `m`, for a unit sample interval."""
    # DataError where the record has gaps and the statistic no meaning there, or is too short for the ratio of a hybrid.
    if not row.parts:
        return windows(row, angle, m, threads)
    which = row.part_of(m, angle.size)
    variance, count, factor = np.empty(m.size), np.zeros(m.size, np.int64), np.ones(m.size)
    for i, part in enumerate(row.parts):
        here = which == i
        if here.any():
            variance[here], count[here], _ = windows(part, angle, m[here], threads)
            if i == len(row.parts) - 1:
                factor[here] = bias_ratio(row.parts[-1], angle, divisor, threads)
    return WindowMeans(variance * factor, count, factor)


def windows(row: Statistic, angle: AngleRecord, m: IntArray, threads: int = 1) -> WindowMeans:
    """The mean over all windows that are complete; NaN where there is none."""
    if len(angle.pieces) > 1 and not row.gaps:
        raise DataError(say("{statistic} folds the record back at its ends and is not defined for a record with gaps; "
                            "use another statistic (oadev, theo1, mtotdev), or select a window without gaps ({choice})",
                            statistic=row.name, choice=windowing()))  # fmt: skip
    if m.size > 1 and not np.all(m[1:] >= m[:-1]):
        order = np.argsort(m, kind="stable")
        variance, number, factor = windows(row, angle, m[order], threads)
        back = np.argsort(order)
        return WindowMeans(variance[back], number[back], factor[back])
    sums, count = np.zeros(m.size), np.zeros(m.size, np.int64)
    for start, x in angle.pieces:
        if row.overlapped or start == 0:
            total, number = _sums(row, x, m, threads), row.count(x.size - 1, m)
        else:  # windows that do not overlap start at multiples of m of the record
            skip = -start % m
            each = [row.sums(x[s:], m[i : i + 1])[0] if s < x.size - 1 else 0.0 for i, s in enumerate(skip)]
            total = np.array(each)
            number = np.array([row.count(x.size - 1 - int(s), k) for s, k in zip(skip, m, strict=True)])
        sums = np.maximum(sums, total) if row.extreme else sums + total
        count += number
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.where(count > 0, sums / (1 if row.extreme else count), np.nan)
    variance = mean / (row.norm(m) * np.asarray(m, dtype=np.float64) ** 2)
    return WindowMeans(variance * (m * row.tau_factor) ** (2.0 * row.power), count, np.ones(m.size))


def with_means(row: Statistic, angle: AngleRecord, m: IntArray, plain: WindowMeans) -> WindowMeans:
    """The estimate with means of what is there, where few windows are complete; see `moments.means`."""
    places = angle.places
    taken = np.flatnonzero(takes_means(row, m, places, angle.size)).tolist()
    if not taken:
        return plain
    x, variance, number = np.empty(angle.size + 1), plain.variance.copy(), plain.number.copy()
    end, total = 0, 0.0
    for start, points in (*angle.pieces, Piece(angle.size, np.zeros(1))):
        x[end:start], end = total, start + points.size
        total = np.add(points, total, out=x[start:end])[-1]
    where = There(places, angle.size)
    for i in taken:
        variance[i], number[i] = variance_of(row, int(m[i]), where, x)
    return WindowMeans(variance, number, plain.factor)


_Known = tuple[Places, IntArray, FloatArray, IntArray]
_none = np.empty(0, np.int64)
_allan: WeakKeyDictionary[Record, _Known] = WeakKeyDictionary()
"""Places, factors, overlapping Allan variances and numbers of windows of records that are still there: checks,
contradictions, readings and the curve ask for them one after another."""


def estimated(
    record: Record, row: Statistic, m: IntArray, *, angle: AngleRecord | None = None, divisor: int = 30,
    means: bool = True, threads: int = 1,
) -> tuple[WindowMeans, Places]:  # fmt: skip
    """A statistic of a record at averaging factors, gaps by `means`, and its places; oadev once for each factor."""
    if row is not OADEV or not means or m.size > MAX_SWEPT:
        return _estimated(angle or integrated(record, row.order), row, m, divisor=divisor, means=means, threads=threads)
    places, known, variance, number = _allan.get(record, ((), _none, np.empty(0), _none))
    more = np.setdiff1d(m, known)
    if not places or more.size:
        angle = angle or integrated(record, row.order)
        (own, count, _), places = _estimated(angle, row, more, divisor=divisor, means=means, threads=threads)
        known, at = np.unique(np.concatenate((known, more)), return_index=True)
        variance, number = np.concatenate((variance, own))[at], np.concatenate((number, count))[at]
        _allan[record] = places, known, variance, number
    at = np.searchsorted(known, m)
    return WindowMeans(variance[at], number[at], np.ones(m.size)), places


def _estimated(
    angle: AngleRecord, row: Statistic, m: IntArray, *, divisor: int, means: bool, threads: int
) -> tuple[WindowMeans, Places]:
    plain = estimate(row, angle, m, divisor=divisor, threads=threads)
    return with_means(row, angle, m, plain) if means else plain, angle.places


def _sums(row: Statistic, x: FloatArray, m: IntArray, threads: int) -> FloatArray:
    if threads == 1 and seconds(row, x.size, m) < MAX_DIRECT_SECONDS:
        return row.sums(x, m)
    shares = row.split(x.size, m, min(threads, m.size)) if threads > 1 else [np.arange(m.size)]
    sums = np.empty(m.size)
    for share, total in zip(shares, spread(lambda share: row.sums(x, m[share]), shares, threads), strict=True):
        sums[share] = total
    return sums


def bias_ratio(theo1: Statistic, angle: AngleRecord, divisor: int, threads: int = 1) -> float:
    """kf: mean of OAVAR(m = 9 + 3i) / Theo1(m = 12 + 4i), both at one tau, for i = 0 .. points / divisor - 3."""
    if divisor not in (6, 30):
        raise UsageError(
            f"the divisor of TheoBR's ratio must be 30 (as published) or 6 (as in Stable32), not {divisor!r}"
        )
    last = (angle.size + 1) // divisor - 3
    if last < 0:
        raise DataError(
            say("TheoBR needs at least {least} samples for its bias ratio, but there are {size}; use theo1, or oadev",
                least=3 * divisor - 1, size=angle.size)
        )  # fmt: skip
    i = np.arange(last + 1)
    known, wanted = (windows(row, angle, m, threads) for row, m in ((OADEV, 9 + 3 * i), (theo1, 12 + 4 * i)))
    both = (known.number > 0) & (wanted.number > 0)
    if not both.any():
        raise DataError(say("the gaps leave no window of 12 samples for the bias ratio of TheoBR; use oadev"))
    both &= wanted.variance > 0
    return float(np.mean(known.variance[both] / wanted.variance[both])) if both.any() else 1.0
