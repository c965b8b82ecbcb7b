"""Outliers: readings that no noise of this record makes."""

import math
from dataclasses import dataclass, replace

import numpy as np

from allanite.core.arrays import FloatArray, IntArray
from allanite.core.errors import UsageError
from allanite.core.limits import quantile
from allanite.core.record import Record

CHOICES = {"mark": "left out, as lost readings", "keep": "kept"}
"""What may become of outliers."""

FEWEST = 5.0
"""Standard deviations off the running median below which nothing is an outlier."""

FALSE = 1e-3
"""Probability that a clean Gaussian record shows one."""

PARTS, SHORTEST_PART = 16, 4096
"""Parts of a record that have each its own scale, and the length that they have at least."""

SAMPLE = 1024
"""Readings of a part from which its scale is taken."""

MOST = 0.02
"""Share of the readings above which they are no outliers but another noise."""

TAIL = 0.8
"""Share of the limit from which readings are counted that are no outliers: of spikes few are there, of heavy tails
more than beyond the limit."""


@dataclass(frozen=True, eq=False)
class Outliers:
    """The outliers `at` some of the intervals of a record, ascending: readings far off the running median.

    `limit` is from how many standard deviations on, `largest` the most of them; `heavy` counts the readings beyond the
    limit that are none, because the noise itself has heavy tails.
    """

    at: IntArray
    limit: float
    largest: float = 0.0
    heavy: int = 0

    def words(self, record: Record) -> str:
        """``3 outliers beyond 5.6 standard deviations, the first at 12.34 s, the largest 31``."""
        count = f"{self.at.size} outlier" + ("s" if self.at.size > 1 else "")
        first = f"the first at {record.cut + self.at[0] / record.rate:.6g} s"
        return f"{count} beyond {self.limit:.2g} standard deviations, {first}, the largest {self.largest:.3g}"


def outliers(record: Record) -> Outliers:
    """Readings (of an angle: steps) far off the median of the 31 around them.

    The limit is 5 standard deviations, or in a long record what one clean record in a thousand reaches; the standard
    deviation is 1.4826 times the median absolute residual, and never less than the usual step between neighbours that
    differ: a coarse reading is no outlier. What was found is left out and the rest looked at once more, because dense
    spikes widen the scale. Where the readings just below the limit are too many for spikes, the noise has heavy tails:
    they belong to it, and there are no outliers.

    Examples
    --------
    >>> y = np.random.default_rng(1).standard_normal(1000)
    >>> y[[300, 500]] += 50.0
    >>> outliers(Record(y, rate=10.0, unit="deg/s")).at.tolist()
    [300, 500]
    """
    steps = record.steps
    whole = steps.dtype.kind != "f" or bool(np.isfinite(steps.sum()))
    there = None if whole else np.flatnonzero(np.isfinite(steps))
    y = np.ascontiguousarray(steps if there is None else steps[there], dtype=np.float64)
    nothing = np.empty(0, np.int64)
    if y.size < 64:
        return Outliers(nothing, FEWEST)
    limit = max(FEWEST, -quantile(FALSE / 2 / y.size))
    at, size, heavy = _off(y, limit)
    if at.size and not heavy:
        rest = np.delete(np.arange(y.size), at)
        more, others, heavy = _off(y[rest], limit)
        at, size = np.concatenate((at, rest[more])), np.concatenate((size, others))
    if heavy or at.size > MOST * y.size:
        return Outliers(nothing, limit, heavy=int(at.size))
    at.sort()
    return Outliers(at if there is None else there[at], limit, float(size.max(initial=0.0)))


def marked(record: Record, found: Outliers) -> Record:
    """The record with the outliers lost (NaN); counts become increments.

    An angle that is wrong at single points, up and down again, loses these points; one that jumps becomes its steps.
    """
    if not found.at.size:
        return record
    what = f"{found.words(record)}: marked as lost"
    points = _wrong_points(record, found.at)
    if points.size:
        values = record.values.copy()
        values[points] = np.nan
        return record.with_values(values, what, start=record.start)
    values = np.array(record.steps, dtype=np.float64)
    values[found.at] = np.nan
    kind = "rate" if record.kind == "rate" else "increment"
    return replace(record, values=values, kind=kind, history=(*record.history, what))


def _wrong_points(record: Record, at: IntArray) -> IntArray:
    """Points of an angle between two outlying steps that cancel; none unless all outliers are such pairs."""
    none = np.empty(0, np.int64)
    if record.kind != "angle" or at.size % 2 or record.values.dtype.kind != "f":
        return none
    there, back = at[::2], at[1::2]
    steps = np.diff(record.values)
    size = np.maximum(np.abs(steps[there]), np.abs(steps[back]))
    paired = (back == there + 1) & (np.abs(steps[there] + steps[back]) < 0.5 * size)
    return back if bool(paired.all()) else none


def treated(record: Record, choice: str) -> Record:
    """The record with its outliers lost, or as it is where the choice is to keep them.

    Raises
    ------
    UsageError
        See `demand_choice`.
    """
    demand_choice(choice)
    return marked(record, outliers(record)) if choice == "mark" else record


def demand_choice(choice: str) -> None:
    """Refuse an unknown word for what becomes of outliers.

    Raises
    ------
    UsageError
        It is not in `CHOICES`.
    """
    if choice not in CHOICES:
        known = "; ".join(f"{name!r}: {meaning}" for name, meaning in CHOICES.items())
        raise UsageError(f"what becomes of outliers is one of {known}; not {choice!r}")


def _off(y: FloatArray, limit: float) -> tuple[IntArray, FloatArray, bool]:
    """Indices beyond the limit, by how many standard deviations, and whether as many lie just below it."""
    from scipy.special import ndtr

    from allanite.kernels.robust import off

    part = max(-(-y.size // PARTS), SHORTEST_PART)
    scale = _scales(y, part)
    near = off(y, TAIL * limit * scale, part)
    size = np.abs(_residuals(y, near)) / scale[near // part]
    at = near[size > limit]
    expected = 2 * y.size * float(ndtr(-TAIL * limit))
    below = near.size - at.size - expected - 3 * math.sqrt(expected)
    # of a run of outliers only the ends bend: those between are found from there
    run = at
    while run.size:
        beside = np.unique(np.clip(np.concatenate((run - 1, run + 1)), 0, y.size - 1))
        beside = beside[~np.isin(beside, at)]
        run = beside[np.abs(_residuals(y, beside)) > limit * scale[beside // part]]
        at = np.concatenate((at, run))
    return at, np.abs(_residuals(y, at)) / scale[at // part], below > max(3.0, 0.3 * at.size)


def _scales(y: FloatArray, part: int) -> FloatArray:
    """Standard deviation of the residuals in each part, from some of them."""
    scales = []
    for start in range(0, y.size, part):
        # the last part may be a few readings long: it is filled up from the one before
        first = max(0, min(start, y.size - SHORTEST_PART))
        length = min(part, y.size - first)
        at = first + np.linspace(0, length - 1, min(length, SAMPLE)).astype(np.int64)
        steps = np.abs(y[at[1:]] - y[at[1:] - 1])
        steps = steps[steps > 0]
        spread = 1.4826 * float(np.median(np.abs(_residuals(y, at))))
        scales.append(max(spread, float(np.median(steps)) if steps.size else math.inf))
    return np.array(scales)


def _residuals(y: FloatArray, at: IntArray) -> FloatArray:
    """How far y is off the median of the 31 readings around the indices `at`; near an end, of the first or last 31."""
    from allanite.kernels.robust import HALF

    width = min(2 * HALF + 1, y.size)
    windows = np.lib.stride_tricks.sliding_window_view(y, width)
    start, middle = np.clip(at - HALF, 0, y.size - width), ((width - 1) // 2, width // 2)
    off = np.empty(at.size)
    for i in range(0, at.size, SAMPLE):
        some = slice(i, i + SAMPLE)
        off[some] = y[at[some]] - np.sort(windows[start[some]], axis=1)[:, middle].mean(axis=1)
    return off
