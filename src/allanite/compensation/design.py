"""The columns of a regression: what was asked for, what may be added, and whether they can be told apart."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from allanite.core.errors import DataError, UsageError
from allanite.core.record import Record, Recording
from allanite.identification.likelihood.likelihood import Likelihood

from .regressor import TREND, Regressor, readings
from .restricted import FloatArray, Stretch

SHORTEST = 64
"""Readings of a stretch between gaps below which it is left out."""

CONDITION = 30.0
"""Scaled condition number above which coefficients cannot be told apart (Belsley, Kuh, Welsch 1980)."""

SAME = 1e-10
"""Least eigenvalue of the columns' correlation at which one of them is a sum of the others."""

TRENDING = 0.9
"""Share of a ramp that the regressors explain, above which they are confounded with it."""


@dataclass(frozen=True)
class DesignSettings:
    """What a regression is made of.

    Attributes
    ----------
    regressors : tuple of str
        Channels whose readings enter in the first power.
    degree : int
        Highest power that may be added.
    lags : tuple of float
        Seconds by which earlier readings may be added.
    rate_of : tuple of str
        Channels whose rate of change enters.
    trend : bool
        Estimate a steady drift along, which is never taken off.
    """

    regressors: tuple[str, ...]
    degree: int = 1
    lags: tuple[float, ...] = ()
    rate_of: tuple[str, ...] = ()
    trend: bool = False

    def __post_init__(self) -> None:
        if not (self.regressors or self.rate_of):
            raise UsageError("name at least one regressor, for example regressors=('temp',) (--regressors temp)")
        for names in (self.regressors, self.rate_of):
            if len(set(names)) < len(names):
                raise UsageError(f"a regressor is named twice: {', '.join(names)}")
        if TREND in self.regressors:
            raise UsageError("a steady drift is not taken off; it is estimated along with trend=True (--trend)")
        if isinstance(self.degree, bool) or not isinstance(self.degree, int) or not 1 <= self.degree <= 6:
            raise UsageError(f"a degree is a whole number from 1 to 6, not {self.degree!r}")
        if len(set(self.lags)) < len(self.lags) or not all(np.isfinite(lag) and lag > 0 for lag in self.lags):
            raise UsageError(f"lags are different positive numbers of seconds, not {self.lags!r}")


@dataclass(frozen=True, eq=False)
class Design:
    """Rates and columns of a record, and where they count.

    Attributes
    ----------
    y : array, shape (n,)
        Rates, SI.
    X : array, shape (n, p)
        Columns, each divided by its `size`.
    regressors : tuple of Regressor
    size : array, shape (p,)
    stretches : tuple of (first, behind last)
    rate : float
    optional : bool array, shape (p,)
        Columns that enter only where cross-validation wants them.
    notes : tuple of str
    """

    y: FloatArray
    X: FloatArray
    regressors: tuple[Regressor, ...]
    size: FloatArray
    stretches: tuple[Stretch, ...]
    rate: float
    optional: NDArray[np.bool_]
    notes: tuple[str, ...] = field(default=())

    def only(self, kept: Sequence[int]) -> "Design":
        """The design with some of the columns, at all readings where these have values."""
        some = list(kept)
        X, regressors = self.X[:, some], tuple(self.regressors[i] for i in some)
        stretches, notes = _stretches(np.isfinite(self.y) & np.isfinite(X).all(axis=1), self.y.size)
        return Design(self.y, X, regressors, self.size[some], stretches, self.rate, self.optional[some], notes)

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of the columns."""
        return tuple(regressor.label for regressor in self.regressors)


def design(record: Record, along: Recording, settings: DesignSettings, *, smooth: float, split_gaps: bool) -> Design:
    """The columns of a record.

    Raises
    ------
    UsageError
        A regressor is missing.
    DataError
        One never changes, or is a sum of others; readings are lost and not split at; nothing is left.
    """
    listed = list(_regressors(record, along, settings, smooth))
    X = np.column_stack([regressor.column(record, along) for regressor, _ in listed])
    y = record.rate_values
    lost = int(np.isnan(y).sum()), int(np.isnan(_base(record, along, settings)).sum())
    if any(lost) and not split_gaps:
        raise DataError(
            f"{lost[0]} readings of {record.name!r} and {lost[1]} of its regressors are lost; take the stretches "
            "between them, each with its own constant, with FitSettings(split_gaps=True) (--split-gaps)"
        )
    stretches, notes = _stretches(np.isfinite(y) & np.isfinite(X).all(axis=1), y.size)
    used = np.zeros(y.size, dtype=bool)
    for a, b in stretches:
        used[a:b] = True
    inner = np.where(used[:, None], X, 0.0) - np.where(used[:, None], X[used].mean(axis=0), 0.0)
    size = np.sqrt((inner**2).sum(axis=0) / used.sum())
    for regressor, rms in zip((r for r, _ in listed), size, strict=True):
        if not rms > 1e-12 * max(abs(regressor.centre), 1e-300):
            raise DataError(f"the regressor {regressor.label!r} never changes: it can explain nothing; leave it out")
    regressors = tuple(regressor for regressor, _ in listed)
    found = Design(y, X / size, regressors, size, stretches, record.rate, np.array([o for _, o in listed]), notes)
    _demand_different(found, used)
    return found


def _regressors(
    record: Record, along: Recording, settings: DesignSettings, smooth: float
) -> Iterator[tuple[Regressor, bool]]:
    """Each column, and whether it is optional."""
    for name in settings.regressors:
        unit, centre = _measured(name, record, along)
        yield Regressor(name, unit, centre), False
    for name in settings.rate_of:
        yield Regressor(name, _measured(name, record, along)[0], smooth=smooth), False
    if settings.trend:
        yield Regressor(TREND, "s"), False
    for name in settings.regressors:
        unit, centre = _measured(name, record, along)
        yield from ((Regressor(name, unit, centre, power), True) for power in range(2, settings.degree + 1))
        for lag in settings.lags:
            if round(lag * record.rate) < 1:
                raise UsageError(f"a lag of {lag:g} s is shorter than the sample interval of {record.interval:g} s")
            yield Regressor(name, unit, centre, lag=lag), True


def _measured(name: str, record: Record, along: Recording) -> tuple[str, float]:
    """Unit and mean of a channel; the mean rounded to four digits of its spread, so that it can be written down."""
    if name not in along.channels:
        raise UsageError(f"the regressor {name!r} is missing: there are {', '.join(along.channels)}")
    channel = along[name]
    unit = channel.unit if channel.kind == "rate" else channel.signal.unit
    x = readings(name, unit, record, along)
    x = x[np.isfinite(x)]
    if not x.size:
        raise DataError(f"the regressor {name!r} has no finite reading")
    mean, spread = float(x.mean()), float(x.std())
    if x.min() == x.max():
        raise DataError(f"the regressor {name!r} never changes (always {x[0]:g} {unit}): it can explain nothing")
    return unit, round(mean, int(4 - np.floor(np.log10(spread))))


def _base(record: Record, along: Recording, settings: DesignSettings) -> FloatArray:
    """Readings of the named channels, shape (n, channels): their NaN are losses, those of a lag are not."""
    names = dict.fromkeys((*settings.regressors, *settings.rate_of))
    return np.column_stack([readings(name, _measured(name, record, along)[0], record, along) for name in names])


def _stretches(fine: NDArray[np.bool_], n: int) -> tuple[tuple[Stretch, ...], tuple[str, ...]]:
    edges = np.flatnonzero(np.diff(np.concatenate(([False], fine, [False])).astype(np.int8)))
    whole = [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]
    kept = tuple((a, b) for a, b in whole if b - a >= SHORTEST)
    count = sum(b - a for a, b in kept)
    if not kept:
        raise DataError(f"no stretch of {SHORTEST} readings is without a loss in the record or its regressors")
    if count == n:
        return kept, ()
    words = f"{n - count} of {n} readings are lost, or have no regressors, or stand in stretches below {SHORTEST}"
    return kept, (f"{words}; {len(kept)} stretch(es) are used" + (", each with its own constant" * (len(kept) > 1)),)


def _demand_different(design: Design, used: NDArray[np.bool_]) -> None:
    Z = design.X[used] - design.X[used].mean(axis=0)
    values, vectors = np.linalg.eigh(Z.T @ Z / used.sum())
    if values[0] > SAME:
        return
    share = np.abs(vectors[:, 0])
    names = [label for label, part in zip(design.labels, share, strict=True) if part > 0.05]
    raise DataError(f"the regressors {', '.join(map(repr, names))} are collinear: leave one of them out")


@dataclass(frozen=True, eq=False)
class Collinearity:
    """How well columns can be told apart: scaled condition number, variance inflation of each, share of a ramp."""

    condition: float
    inflation: FloatArray
    ramp: float


def collinearity(design: Design, likelihood: Likelihood, theta: FloatArray) -> Collinearity:
    """As the noise sees the columns: whitened."""
    A = information(likelihood, theta)
    size = np.sqrt(np.diag(A))
    values = np.linalg.eigvalsh(A / np.outer(size, size))
    inverse = np.linalg.inv(A / np.outer(size, size))
    condition = float(np.sqrt(values[-1] / max(values[0], 1e-300)))
    return Collinearity(condition, np.diag(inverse).copy(), _of_ramp(design, likelihood, theta))


def information(likelihood: Likelihood, theta: FloatArray) -> FloatArray:
    """X' C^-1 X of the flat directions, shape (p, p), the edges known."""
    m = likelihood.expectation(theta)
    flat = np.flatnonzero(likelihood.flat)
    return np.asarray(np.einsum("bij,b->ij", likelihood.UU[:, flat][:, :, flat], 1 / m))


def _of_ramp(design: Design, likelihood: Likelihood, theta: FloatArray) -> float:
    """Share of a ramp that the columns explain, whitened; 0 where time is one of them."""
    from .restricted import restricted

    if any(regressor.is_trend for regressor in design.regressors):
        return 0.0
    ramp = np.linspace(-1.0, 1.0, design.y.size)
    # the ramp takes the place of the rates: its products with the columns are all that is wanted
    seen = restricted(ramp, design.X, design.stretches, rate=design.rate, symbols="N")
    m = likelihood.expectation(theta)
    flat = np.flatnonzero(seen.flat)
    b = (1 / m) @ seen.Uc[:, flat]
    whole = float((1 / m) @ (seen.count * seen.power))
    return float(b @ np.linalg.solve(information(likelihood, theta), b) / whole)
