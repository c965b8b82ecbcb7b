"""Statistics of a record over averaging time: the table, the estimates, their expectation and confidence."""

from collections.abc import Callable, Sequence

import numpy as np

from allanite.curve import Curve
from allanite.errors import DataError, UsageError
from allanite.model import Model, Term
from allanite.record import Record

from .allan import ADEV, OADEV
from .moments import covariance as covariance
from .moments import edf as edf
from .moments import expectation, law
from .row import FloatArray, IntArray, Statistic

STATISTICS: dict[str, Statistic] = {
    "adev": ADEV,
    "oadev": OADEV,
}


MOST = 300_000
"""Averaging times that are computed one by one; their cost is the square of the record's length."""


def statistic_named(name: str) -> Statistic:
    """The row of `STATISTICS`; an unknown name is an error that lists the known ones."""
    if name not in STATISTICS:
        raise UsageError(f"unknown statistic {name!r}; known are {', '.join(STATISTICS)}")
    return STATISTICS[name]


def deviation(
    record: Record,
    statistic: str = "oadev",
    *,
    taus: str | Sequence[float] = "octave",
    m: Sequence[int] | None = None,
    noise: Model | None = None,
) -> Curve:
    """A statistic of a record, for many averaging times at once.

    Parameters
    ----------
    record : Record
        All its samples finite.
    statistic : str
        A name in `STATISTICS`.
    taus : {"octave", "decade", "log", "all"} or sequence of float
        Averaging times: 1, 2, 4, 8 ... samples; 1, 2, 4, 10, 20, 40 ...; about 100, spaced evenly in the logarithm;
        every one; or seconds. The named grids reach to the statistic's largest averaging factor.
    m : sequence of int, optional
        Averaging factors instead of times.
    noise : Model, optional
        The noise supposed for the confidence limits, ``identify(record).model``.

    Returns
    -------
    Curve
        SI. A constant is removed before integrating, so that a bias costs no digits.

    Raises
    ------
    DataError
        A sample is not finite.
    UsageError
        An unknown statistic or grid; a time that is not a multiple of the sample interval, or too long.

    Examples
    --------
    >>> record = Record([892.0, 809, 823, 798, 671, 644, 883, 903, 677], rate=1.0, unit="1", kind="rate")
    >>> deviation(record, "oadev", m=[1, 2]).deviation.round(5).tolist()
    [91.22945, 85.95287]
    """
    row = statistic_named(statistic)
    factors = _factors(m, record, row) if m is not None else _grid(taus, record, row)
    x, scale = integrated(record)
    count = np.asarray(row.count(record.size, factors), dtype=np.int64)
    tau = factors / record.rate
    variance = row.sums(x, factors) * (scale**2 / row.norm) / (count * tau**2)
    return Curve(
        statistic=row.name,
        m=factors,
        tau=tau,
        variance=variance,
        count=count,
        unit=record.signal.unit,
        rate=record.rate,
        name=record.name,
        history=record.history,
        noise=noise,
        law=None if noise is None else law(row, noise, record, factors),
    )


def expected(model: Model | Term, statistic: str, tau: float | Sequence[float] | FloatArray) -> FloatArray:
    """The exact expectation of a statistic's variance under a model.

    Parameters
    ----------
    model : Model or Term
    statistic : str
        A name in `STATISTICS`.
    tau : array_like, shape (k,)
        Averaging times, s.

    Returns
    -------
    array, shape (k,)
        Variance, SI.

    Examples
    --------
    >>> from allanite.model import N
    >>> expected(N(1.0, "rad/sqrt(s)"), "oadev", [1.0, 4.0]).tolist()
    [1.0, 0.25]
    """
    model = model if isinstance(model, Model) else Model((model,))
    return expectation(statistic_named(statistic), model.structure, np.atleast_1d(np.asarray(tau, dtype=np.float64)))


def integrated(record: Record) -> tuple[FloatArray, float]:
    """The angle with a constant rate removed, shape (n + 1,), and what it must be multiplied with to be SI."""
    if not np.isfinite(record.values.sum(dtype=np.float64)):
        bad = ~np.isfinite(record.values)
        raise DataError(
            f"{bad.sum()} of {bad.size} readings of {record.name!r} are not finite, the first at sample "
            f"{int(bad.argmax())}; cut a window without them (prepare.trim, --from, --until)"
        )
    if record.kind == "angle":
        return np.asarray(record.values - record.values[0], dtype=np.float64), record.factor
    from allanite.kernels.allan import integrate

    step = record.interval if record.kind == "rate" else 1.0
    return integrate(record.values, record.constant), record.factor * step


def _factors(m: Sequence[int], record: Record, row: Statistic) -> IntArray:
    factors = np.atleast_1d(np.asarray(m))
    if factors.size and factors.dtype.kind not in "iu":
        raise UsageError(f"averaging factors are integers, not {factors.dtype}; give times in seconds as taus")
    largest = row.largest(record.size)
    if factors.size == 0 or factors.min() < 1 or factors.max() > largest:
        raise UsageError(f"averaging factors of {row.name} lie between 1 and {largest} for {record.size} samples")
    return factors.astype(np.int64)


def _grid(taus: str | Sequence[float], record: Record, row: Statistic) -> IntArray:
    largest = row.largest(record.size)
    if isinstance(taus, str):
        if taus not in GRIDS:
            raise UsageError(f"unknown grid of averaging times {taus!r}; known are {', '.join(GRIDS)}, or give seconds")
        if taus == "all" and largest > MOST:
            raise UsageError(f"all {largest} averaging times of {row.name} would take hours; choose 'log', or give m")
        return GRIDS[taus](largest)
    wanted = np.atleast_1d(np.asarray(taus, dtype=np.float64)) * record.rate
    factors = np.rint(wanted)
    off = np.abs(factors - wanted) > 1e-6 * np.maximum(wanted, 1)
    if off.any():
        tau = wanted[off][0] / record.rate
        raise UsageError(f"tau = {tau:g} s is no multiple of the sample interval {record.interval:g} s")
    return _factors(factors.astype(np.int64).tolist(), record, row)


def _octaves(largest: int) -> IntArray:
    return 2 ** np.arange(largest.bit_length(), dtype=np.int64)


def _decades(largest: int) -> IntArray:
    steps = np.outer(10 ** np.arange(len(str(largest)), dtype=np.int64), [1, 2, 4]).ravel()
    return steps[steps <= largest]


def _logarithmic(largest: int, points: int = 100) -> IntArray:
    """`points` distinct integers, spread as evenly in the logarithm as integers can be."""
    if largest <= points:
        return np.arange(1, largest + 1, dtype=np.int64)
    total = points
    while True:
        factors = np.unique(np.rint(np.geomspace(1, largest, total)).astype(np.int64))
        if factors.size >= points:
            return factors
        total += points - factors.size


GRIDS: dict[str, Callable[[int], IntArray]] = {
    "octave": _octaves,
    "decade": _decades,
    "log": _logarithmic,
    "all": lambda largest: np.arange(1, largest + 1, dtype=np.int64),
}
