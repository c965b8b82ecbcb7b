"""Outliers: samples that are inconsistent with the noise of the record."""

import math
from dataclasses import dataclass, replace
from weakref import WeakKeyDictionary

import numpy as np
import scipy

from allanite.core.arrays import FloatArray, IntArray
from allanite.core.errors import UsageError
from allanite.core.limits import quantile
from allanite.core.record import Record
from allanite.kernels import passing
from allanite.phrases.phrase import say, say_count

CHOICES = {"mark": "excluded, like missing samples", "keep": "kept"}  # what can be done with outliers
LOWEST_LIMIT = 5.0  # deviation from the running median, in standard deviations, below which no sample is an outlier
FALSE = 1e-3  # probability that a clean Gaussian record shows an outlier
SCALE_PARTS, SHORTEST_PART = 16, 4096  # number of parts of a record with separate scales, and their minimum length
SAMPLE = 1024  # number of samples of a part used for its scale
MOST = 0.02  # share of the samples above which they are not outliers but another noise

TAIL = 0.8
"""Share of the limit from which samples are counted to distinguish outliers from heavy tails: few spikes, but many
samples of a heavy-tailed noise, lie between this share and the limit.
"""


@dataclass(frozen=True, eq=False)
class Outliers:
    """The outliers `at` some of the intervals of a record, ascending: samples far from the running median."""

    at: IntArray
    limit: float  # of detection, and the largest deviation, in standard deviations
    largest: float = 0.0
    heavy: int = 0  # samples beyond the limit that are not outliers because the noise has heavy tails

    def words(self, record: Record) -> str:
        """``3 outliers beyond 5.6 standard deviations, the first at 12.34 s, the largest 31``."""
        return say_count(self.at.size,
                         "{count} outlier beyond {limit:.2g} standard deviations, at {first:.6g} s, of {largest:.3g}",
                         "{count} outliers beyond {limit:.2g} standard deviations, the first at {first:.6g} s, the "
                         "largest {largest:.3g}", limit=self.limit, first=record.cut + self.at[0] / record.rate,
                         largest=self.largest)  # fmt: skip


_known: WeakKeyDictionary[Record, Outliers] = WeakKeyDictionary()
"""What was found in records that are still there: checks, fit and residuals ask for it one after another."""


def outliers(record: Record, among: int | None = None) -> Outliers:
    """Samples (for an angle: steps) far from the median of the 31 around them."""
    # The limit is 5 standard deviations, or in a long record the value that one clean record in a thousand exceeds. The
    # standard deviation is 1.4826 times the median absolute residual, and at least the typical step between neighbours
    # that differ, so that coarse samples are not outliers. The search is repeated without the outliers found, because
    # dense spikes widen the scale. If too many samples lie just below the limit, the noise has heavy tails, and none
    # of them is an outlier. Of a record that is only a part of another one, `among` is the number of samples of that.
    if among is not None:
        return _found(record, among)
    if record not in _known:
        _known[record] = _found(record, None)
    return _known[record]


def _found(record: Record, among: int | None) -> Outliers:
    steps = record.steps
    known = None if record.complete else np.flatnonzero(np.isfinite(steps))
    y = np.ascontiguousarray(steps if known is None else steps[known], dtype=np.float64)
    nothing = np.empty(0, np.int64)
    if y.size < 64:
        return Outliers(nothing, LOWEST_LIMIT)
    limit = max(LOWEST_LIMIT, -quantile(FALSE / 2 / (among or y.size)))
    part = max(-(-(among or y.size) // SCALE_PARTS), SHORTEST_PART)
    at, size, heavy = _off(y, limit, part)
    if at.size and not heavy:
        rest = np.delete(np.arange(y.size), at)
        more, others, heavy = _off(y[rest], limit, part)
        at, size = np.concatenate((at, rest[more])), np.concatenate((size, others))
    if heavy or at.size > MOST * y.size:
        return Outliers(nothing, limit, heavy=int(at.size))
    at.sort()
    return Outliers(at if known is None else known[at], limit, float(size.max(initial=0.0)))


def marked(record: Record, found: Outliers) -> Record:
    """The record with outliers replaced by NaN; counts become increments."""
    # An angle that is wrong at single points (up and down again) loses these points; one that jumps is converted to its
    # steps.
    if not found.at.size:
        return record
    what = say("{outliers}: marked as missing", outliers=found.words(record))
    if record.kind == "angle" and not found.at.size % 2 and record.values.dtype.kind == "f":
        # if all outliers are pairs of steps that cancel, the points between them are wrong
        up, back = found.at[::2], found.at[1::2]
        steps = np.diff(record.values)
        size = np.maximum(np.abs(steps[up]), np.abs(steps[back]))
        if ((back == up + 1) & (np.abs(steps[up] + steps[back]) < 0.5 * size)).all():
            values = record.values.copy()
            values[back] = np.nan
            return record.with_values(values, what, start=record.start)
    values = np.array(record.steps, dtype=np.float64)
    values[found.at] = np.nan
    kind = "increment" if record.integrated else record.kind
    return replace(record, values=values, kind=kind, history=(*record.history, what))


def treated(record: Record, choice: str) -> Record:
    """The record with its outliers marked as missing, or unchanged if the choice is to keep them."""
    demand_choice(choice)
    return marked(record, outliers(record)) if choice == "mark" else record


def demand_choice(choice: str) -> str:
    """Refuse an unknown choice for outliers."""
    if choice not in CHOICES:
        known = "; ".join(f"{name!r}: {meaning}" for name, meaning in CHOICES.items())
        raise UsageError(f"unknown choice for outliers {choice!r}; known choices: {known}")
    return choice


def _off(y: FloatArray, limit: float, part: int) -> tuple[IntArray, FloatArray, bool]:
    """Indices beyond the limit, their deviations in standard deviations, and whether the noise has heavy tails."""
    # standard deviation of the residuals in each part, from some of them
    scales = []
    for start in range(0, y.size, part):
        # the last part may have only a few samples: it is extended into the one before
        first = max(0, min(start, y.size - SHORTEST_PART))
        length = min(part, y.size - first)
        at = first + np.linspace(0, length - 1, min(length, SAMPLE)).astype(np.int64)
        steps = np.abs(y[at[1:]] - y[at[1:] - 1])
        steps = steps[steps > 0]
        spread = 1.4826 * float(np.median(np.abs(_residuals(y, at))))
        scales.append(max(spread, float(np.median(steps)) if steps.size else math.inf))
    scale = np.array(scales)
    near = passing.off(y, TAIL * limit * scale, part)
    size = np.abs(_residuals(y, near)) / scale[near // part]
    at = near[size > limit]
    expected = 2 * y.size * float(scipy.special.ndtr(-TAIL * limit))
    below = near.size - at.size - expected - 3 * math.sqrt(expected)
    # only the ends of a run of outliers stand out: those between are found from there
    run = at
    while run.size:
        beside = np.unique(np.clip(np.concatenate((run - 1, run + 1)), 0, y.size - 1))
        beside = beside[~np.isin(beside, at)]
        run = beside[np.abs(_residuals(y, beside)) > limit * scale[beside // part]]
        at = np.concatenate((at, run))
    return at, np.abs(_residuals(y, at)) / scale[at // part], below > max(3.0, 0.3 * at.size)


def _residuals(y: FloatArray, at: IntArray) -> FloatArray:
    """Deviation of y from the median of the 31 samples around each index, or of the first or last 31 near an end."""
    width = min(2 * passing.HALF + 1, y.size)
    windows = np.lib.stride_tricks.sliding_window_view(y, width)
    start, middle = np.clip(at - passing.HALF, 0, y.size - width), ((width - 1) // 2, width // 2)
    off = np.empty(at.size)
    for i in range(0, at.size, SAMPLE):
        some = slice(i, i + SAMPLE)
        off[some] = y[at[some]] - np.sort(windows[start[some]], axis=1)[:, middle].mean(axis=1)
    return off
