"""One interval in detail: slopes of its regression lines, and the staircase that was recognized in its counts."""

import math
from dataclasses import dataclass

import numpy as np

from allanite.extending import BoolArray, FloatArray, Record, Signal, UsageError, Value, public

from .inputs import demand_whole, interval_of
from .linear import regression_lines
from .run import ExperimentSettings, piece, task_of
from .staircase import recognized


@dataclass(frozen=True, eq=False, repr=False)
class Closeup(Value):
    """What the estimators of lines and stairs see in one interval.

    Attributes
    ----------
    name : str
        Channel.
    signal : Signal
    start, duration, rate : float
        Of the interval, s after the record's first sample; sampling rate, Hz.
    slopes : array, shape (lines,)
        Slope of each regression line, SI; each begins one sample after the one before.
    kept : array, shape (lines,)
        Whether the conditional estimator keeps it.
    counts : array, shape (n + 1,)
        The angle in quanta at every sample, from 0; empty without a quantum.
    line : array, shape (n + 1,)
        The straight line whose floor is the staircase nearest to the counts; empty without a quantum.
    """

    name: str
    signal: Signal
    start: float
    duration: float
    rate: float
    slopes: FloatArray
    kept: BoolArray
    counts: FloatArray
    line: FloatArray

    @property
    def misfit(self) -> FloatArray:
        """Counts less the staircase, quanta."""
        return np.asarray(self.counts - np.floor(self.line))


@public
def closeup(record: Record, settings: ExperimentSettings | None = None, *, start: float = 0.0) -> Closeup:
    """Look at one interval of a record.

    Parameters
    ----------
    record : Record
    settings : ExperimentSettings, optional
        Its length, the dither to remove, the choices of the estimators.
    start : float
        Start of the interval, s after the record's first sample.

    Raises
    ------
    DataError
        A sample of the interval is not finite.
    UsageError
        The interval does not fit into the record.

    Examples
    --------
    >>> from allanite import GL1, simulate_ring_laser
    >>> record = simulate_ring_laser(GL1, 12.4392, 48_000, 400.0, rng=np.random.default_rng(1))
    >>> found = closeup(record)
    >>> found.slopes.size, bool(abs(found.misfit).mean() < 1)
    (300, True)
    """
    settings = settings or ExperimentSettings()
    size = min(max(3, round(settings.interval * record.rate)), record.size)
    first = round(start * record.rate) if np.isfinite(start) else -1
    if not 0 <= first <= record.size - size:
        raise UsageError(
            f"an interval of {size / record.rate:g} s from {start:g} s does not fit into {record.duration:g} s"
        )
    part = piece(record, first, size)
    demand_whole(part)
    task = task_of(part, None, settings.target, dither=settings.dither, options=settings.options)
    interval = interval_of(part, task)
    slopes, kept = regression_lines(interval, task)
    counts, line = np.empty(0), np.empty(0)
    if math.isfinite(interval.pulse):
        counts, line = recognized(interval, certified=settings.options.certified)
    rates = (slopes + interval.offset) * interval.size - settings.bias
    return Closeup(
        record.name, record.signal, first / record.rate, size / record.rate, record.rate, rates, kept,
        counts, line,
    )  # fmt: skip
