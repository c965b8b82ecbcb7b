"""Averaging factors: named grids, times in seconds, and what a statistic allows."""

from collections.abc import Callable, Sequence

import numpy as np

from allanite.core.arrays import FloatArray, IntArray
from allanite.core.errors import UsageError
from allanite.core.names import unknown
from allanite.core.ranges import TIME
from allanite.phrases.phrase import spelled

from .row import Statistic


def times(row: Statistic, m: IntArray, size: int) -> FloatArray:
    """Tau over the sample interval, shape of m."""
    parts = row.parts or (row,)
    return np.asarray(m * np.array([part.tau_factor for part in parts])[row.part_of(m, size)])


def agree(asked: Sequence[float], taus: FloatArray) -> bool:
    """Whether averaging times are those that were asked for."""
    return len(taus) == np.size(asked) and np.allclose(taus, np.ravel(asked), rtol=1e-6, atol=0)


def factors_of(
    taus: str | Sequence[float], row: Statistic, size: int, rate: float, *, nearest: bool = False
) -> IntArray:
    """Averaging factors of a named grid, or of times in seconds; those that are no multiples become the `nearest`."""
    parts = row.parts or (row,)
    if not isinstance(taus, str):
        asked = TIME.demand(np.atleast_1d(np.asarray(taus, dtype=np.float64)), "averaging times")
        part = [parts[-1] if len(parts) > 1 and tau * rate > row.join * size else parts[0] for tau in asked]
        factor, step = np.array([p.tau_factor for p in part]), np.array([p.step for p in part])
        wanted = asked * rate / factor
        m = np.rint(wanted / step) * step
        off = ~(np.abs(m - wanted) <= 1e-6 * np.maximum(np.abs(wanted), 1))
        if nearest and off.any() and (m >= step).all():
            _demand_times(asked, row, size, rate)
            return np.unique(m).astype(np.int64)
        if off.any():
            i = int(off.argmax())
            unit, near = step[i] * factor[i] / rate, m[i] * factor[i] / rate
            raise UsageError(
                f"tau = {asked[i]:g} s is not a multiple of {unit:g} s, which {row.name} needs at {rate:g} Hz; the "
                f"nearest is {max(near, unit):g} s"
            )
        _demand_times(asked, row, size, rate)
        return np.asarray(m, dtype=np.int64)
    grid = grid_named(taus)
    made = [grid(part.largest(size) // part.step) * part.step for part in parts if part.largest(size)]
    if len(made) < 2:
        return made[0] if made else np.empty(0, np.int64)
    early = made[0][made[0] <= row.join * size]
    late = made[1][(made[1] > row.join * size) & (made[1] * parts[1].tau_factor > early[-1:].sum())]
    return np.concatenate((early, late))


def _demand_times(asked: FloatArray, row: Statistic, size: int, rate: float) -> None:
    """Refuse times in seconds that the record is too short for."""
    longest = row.largest(size) * (row.parts or (row,))[-1].tau_factor / rate
    outside = asked[(asked > longest * (1 + 1e-9)) | (asked <= 0)]
    if longest and outside.size:
        raise UsageError(
            f"averaging times of {row.name} are above 0 s and up to {longest:g} s for a record of {size / rate:g} s, "
            f"not {', '.join(f'{tau:g} s' for tau in outside[:3])}; {spelled('--m', 'm')} takes numbers of samples",
            choice="taus",
        )


def grid_named(name: str) -> "Callable[[int], IntArray]":
    """The grid of a name; an unknown one is refused."""
    if name not in GRIDS:
        error = unknown("grid", name, GRIDS, where=" of averaging times", choice="taus")
        raise type(error)(f"{error}, or give seconds", choice=error.choice, cure=error.cure)
    return GRIDS[name]


def checked(m: Sequence[int] | IntArray, row: Statistic, size: int) -> IntArray:
    """Averaging factors, if the statistic allows them for a record of `size` intervals; an error names the largest."""
    factors = np.atleast_1d(np.asarray(m))
    if factors.ndim > 1 or (factors.size and factors.dtype.kind not in "iu"):
        shape = f" of shape {factors.shape}" * (factors.ndim > 1)
        raise UsageError(f"averaging factors must be integers, not {factors.dtype}{shape}; give times in seconds as "
                         "taus")  # fmt: skip
    largest, least = (row.parts or (row,))[-1].largest(size), row.step
    if largest < least:
        fewest = next(n for n in range(1, 1000) if row.largest(n) >= row.step)
        raise UsageError(f"{row.name} needs at least {fewest} samples, but there are {size}")
    outside = factors[(factors < least) | (factors > largest)]
    if outside.size or not factors.size:
        came = ", ".join(map(str, outside[:3])) or "none"
        raise UsageError(
            f"averaging factors of {row.name} must be between {least} and {largest} for {size} samples, not {came}"
        )
    step = np.array([part.step for part in row.parts or (row,)])[row.part_of(factors, size)]
    odd = factors % step != 0
    if odd.any():
        raise UsageError(
            f"averaging factors of {row.name} must be even{' beyond the joint' * (len(row.parts) > 1)}, not "
            f"{factors[odd][0]}; the largest possible is {largest}"
        )
    return np.asarray(factors, dtype=np.int64)


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
    "octave": lambda largest: 2 ** np.arange(largest.bit_length(), dtype=np.int64),
    "decade": _decades,
    "log": _logarithmic,
    "all": lambda largest: np.arange(1, largest + 1, dtype=np.int64),
}
