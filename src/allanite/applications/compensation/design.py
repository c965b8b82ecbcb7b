"""The columns of a regression: those requested, those that may be added, and whether they can be separated."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from allanite.extending import (
    DataError,
    FloatArray,
    Likelihood,
    Record,
    Recording,
    UsageError,
    join,
    say,
    say_count,
    spelled,
    stretches,
)

from .mixture import Stretch, restricted
from .regressor import TREND, Columns, Regressor, readings
from .settings import CompensationSettings

MIN_STRETCH = 64  # minimum number of samples of a stretch between gaps
MIN_EIGENVALUE = 1e-10  # least eigenvalue of the columns' correlation at which one of them is a sum of the others


@dataclass(frozen=True, eq=False)
class Design(Columns):
    """Rates and columns of a record, and where they count."""

    y: FloatArray  # shape (n,); rates, SI
    X: FloatArray  # shape (n, p); columns, each divided by its `size`
    regressors: tuple[Regressor, ...]
    size: FloatArray  # shape (p,)
    stretches: tuple[Stretch, ...]
    rate: float
    optional: NDArray[np.bool_]  # shape (p,); columns that enter only where cross-validation wants them
    notes: tuple[str, ...]

    def only(self, kept: Sequence[int]) -> "Design":
        """The design with some of the columns, at all samples where these have values."""
        some = list(kept)
        X, regressors = self.X[:, some], tuple(self.regressors[i] for i in some)
        parts, notes = _stretches(np.isfinite(self.y) & np.isfinite(X).all(axis=1), self.y.size)
        return Design(self.y, X, regressors, self.size[some], parts, self.rate, self.optional[some], notes)

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of the columns."""
        return tuple(regressor.label for regressor in self.regressors)

    @property
    def count(self) -> int:
        """Samples that count."""
        return sum(b - a for a, b in self.stretches)

    def likelihood(self, symbols: str, *, y: FloatArray | None = None, parts: Sequence[Stretch] = ()) -> Likelihood:
        """Restricted likelihood of these noise terms, of other rates or stretches if they are given."""
        rates = self.y if y is None else y
        return restricted(rates, self.X, parts or self.stretches, rate=self.rate, symbols=symbols)

    def demand_separable(self, used: NDArray[np.bool_]) -> None:
        """Refuse columns of which one is, where the samples are used, a sum of others."""
        Z = self.X[used] - self.X[used].mean(axis=0)
        values, vectors = np.linalg.eigh(Z.T @ Z / used.sum())
        if values[0] > MIN_EIGENVALUE:
            return
        share = np.abs(vectors[:, 0])
        names = [label for label, part in zip(self.labels, share, strict=True) if part > 0.05]
        listed = join(", ", [join("", ("'", name, "'")) for name in names])
        if share[self.trend].max(initial=0.0) <= 0.05:
            raise DataError(say("the regressors {regressors} are collinear: omit one of them", regressors=listed))
        raise DataError(
            say("{regressors} are collinear: the effect of a regressor that follows a straight line cannot be "
                "separated from a rate ramp R; record until it returns to its initial value, or attribute the whole "
                "drift to it with {option}", regressors=listed, option=spelled("--no-trend", "trend=False"))
        )  # fmt: skip


def design(record: Record, along: Recording, settings: CompensationSettings) -> Design:
    """The columns of a record."""
    named = dict.fromkeys((*settings.regressors, *settings.derivative_of))
    channels = {name: _measured(name, record, along) for name in named}
    listed = list(_regressors(record, channels, settings))
    regressors, optional = tuple(r for r, _ in listed), np.array([o for _, o in listed])
    X = np.column_stack([regressor.column(record, along) for regressor in regressors])
    y = record.rate_values
    # NaN of the named channels are losses, those of a lag are not
    lost = int(np.isnan(y).sum()), sum(int(np.isnan(channel.x).sum()) for channel in channels.values())
    if any(lost) and not settings.fit.split_gaps:
        raise DataError(say("{samples} samples of {name!r} and {regressors} of its regressors are missing; use the "
                            "stretches between them, each with its own constant: {option}", samples=lost[0],
                            name=record.name, regressors=lost[1],
                            option=spelled("--split-gaps", "FitSettings(split_gaps=True)")))  # fmt: skip
    parts, notes = _stretches(np.isfinite(y) & np.isfinite(X).all(axis=1), y.size)
    used = np.zeros(y.size, dtype=bool)
    for a, b in parts:
        used[a:b] = True
    inner = np.where(used[:, None], X, 0.0) - np.where(used[:, None], X[used].mean(axis=0), 0.0)
    size = np.sqrt((inner**2).sum(axis=0) / used.sum())
    for regressor, rms in zip(regressors, size, strict=True):
        if not rms > 1e-12 * max(abs(regressor.centre), 1e-300):
            raise DataError(
                say("the regressor {regressor!r} is constant and cannot explain anything; omit it",
                    regressor=regressor.label)
            )  # fmt: skip
    made = Design(y, X / size, regressors, np.asarray(size), parts, record.rate, optional, notes)
    made.demand_separable(used)
    return made


class _Readings(NamedTuple):
    """Unit, mean, samples, least and greatest reading of a channel."""

    unit: str
    centre: float
    x: FloatArray
    span: tuple[float, float]


def _regressors(
    record: Record, channels: Mapping[str, _Readings], settings: CompensationSettings
) -> Iterator[tuple[Regressor, bool]]:
    """Each column, and whether it is optional."""
    for name in settings.regressors:
        unit, centre, _, span = channels[name]
        yield Regressor(name, unit, centre, span=span), False
    for name in settings.derivative_of:
        unit, _, _, span = channels[name]
        yield Regressor(name, unit, smooth=settings.fit.smooth, span=span), False
    for name in settings.regressors:
        unit, centre, _, span = channels[name]
        yield from ((Regressor(name, unit, centre, power, span=span), True) for power in range(2, settings.degree + 1))
        for lag in settings.lags:
            if round(lag * record.rate) < 1:
                raise UsageError(f"a lag of {lag:g} s is shorter than the sample interval of {record.interval:g} s")
            yield Regressor(name, unit, centre, lag=lag, span=span), False
    if settings.trend:
        yield Regressor(TREND, "s"), False


def _measured(name: str, record: Record, along: Recording) -> _Readings:
    """A channel; its mean rounded to four digits of its spread, so that it can be written down."""
    if name not in along.channels:
        raise UsageError(f"the regressor {name!r} is missing; channels: {', '.join(along.channels)}")
    channel = along[name]
    unit = channel.signal.unit if channel.integrated else channel.unit
    x = readings(name, unit, record, along)
    finite = x[np.isfinite(x)]
    if not finite.size:
        raise DataError(say("the regressor {regressor!r} has no finite sample", regressor=name))
    mean, spread, span = float(finite.mean()), float(finite.std()), (float(finite.min()), float(finite.max()))
    if span[0] == span[1]:
        raise DataError(
            say("the regressor {regressor!r} is constant (always {value:g} {unit}) and cannot explain anything",
                regressor=name, value=span[0], unit=unit)
        )  # fmt: skip
    return _Readings(unit, round(mean, int(4 - np.floor(np.log10(spread)))), x, span)


def _stretches(fine: NDArray[np.bool_], n: int) -> tuple[tuple[Stretch, ...], tuple[str, ...]]:
    kept = tuple((int(a), int(b)) for a, b in stretches(fine) if b - a >= MIN_STRETCH)
    count = sum(b - a for a, b in kept)
    if not kept:
        raise DataError(
            say("no stretch of {least} samples is complete in the record and its regressors", least=MIN_STRETCH)
        )
    if count == n:
        return kept, ()
    missing = say(
        "{missing} of {samples} samples are missing, have no regressors, or belong to stretches shorter than {least}",
        missing=n - count, samples=n, least=MIN_STRETCH,
    )  # fmt: skip
    used = say_count(len(kept), "{count} stretch used", "{count} stretches used, each with its own constant")
    return kept, (join("; ", (missing, used)),)
