"""The columns of a regression: what is requested or may be added, can be separated, and gains by cross-validation."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from allanite.extending import (  # isort: skip
    BoolArray, DataError, FloatArray, Likelihood, Record, Recording, UsageError, join, say, say_count, spelled,
    stretches)  # fmt: skip

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
    optional: BoolArray  # shape (p,); columns that enter only where cross-validation wants them
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

    def demand_separable(self, used: BoolArray) -> None:
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
        raise DataError(say("{regressors} are collinear: the effect of a regressor that follows a straight line cannot "
                            "be separated from a rate ramp R; record until it returns to its initial value, or "
                            "attribute the whole drift to it with {option}", regressors=listed,
                            option=spelled("--no-trend", "trend=False")))  # fmt: skip


def design(record: Record, along: Recording, settings: CompensationSettings) -> Design:
    """The columns of a record."""
    named = dict.fromkeys((*settings.regressors, *settings.derivative_of))
    measured = {name: _measured(name, record, along) for name in named}
    listed = list(_regressors(record, {name: regressor for name, (regressor, _) in measured.items()}, settings))
    regressors, optional = tuple(r for r, _ in listed), np.array([o for _, o in listed])
    X = np.column_stack([regressor.column(record, along) for regressor in regressors])
    y = record.rate_values
    # NaN of the named channels are losses, those of a lag are not
    lost = int(np.isnan(y).sum()), sum(count for _, count in measured.values())
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
            raise DataError(say("the regressor {regressor!r} is constant and cannot explain anything; omit it",
                                regressor=regressor.label))  # fmt: skip
    made = Design(y, X / size, regressors, np.asarray(size), parts, record.rate, optional, notes)
    made.demand_separable(used)
    return made


def _regressors(
    record: Record, channels: Mapping[str, Regressor], settings: CompensationSettings
) -> Iterator[tuple[Regressor, bool]]:
    """Each column, and whether it is optional."""
    yield from ((channels[name], False) for name in settings.regressors)
    for name in settings.derivative_of:
        yield replace(channels[name], centre=0.0, smooth=settings.fit.smooth), False
    for channel in (channels[name] for name in settings.regressors):
        yield from ((replace(channel, power=power), True) for power in range(2, settings.degree + 1))
        for lag in settings.lags:
            if round(lag * record.rate) < 1:
                raise UsageError(f"a lag of {lag:g} s is shorter than the sample interval of {record.interval:g} s")
            yield replace(channel, lag=lag), False
    if settings.trend:
        yield Regressor(TREND, "s"), False


def _measured(name: str, record: Record, along: Recording) -> tuple[Regressor, int]:
    """A channel about its mean, rounded to four digits of its spread so that it can be written down; its losses."""
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
        raise DataError(say("the regressor {regressor!r} is constant (always {value:g} {unit}) and cannot explain "
                            "anything", regressor=name, value=span[0], unit=unit))  # fmt: skip
    return Regressor(name, unit, round(mean, int(4 - np.floor(np.log10(spread)))), span=span), int(np.isnan(x).sum())


def _stretches(fine: BoolArray, n: int) -> tuple[tuple[Stretch, ...], tuple[str, ...]]:
    kept = tuple((int(a), int(b)) for a, b in stretches(fine) if b - a >= MIN_STRETCH)
    count = sum(b - a for a, b in kept)
    if not kept:
        raise DataError(say("no stretch of {least} samples is complete in the record and its regressors",
                            least=MIN_STRETCH))  # fmt: skip
    if count == n:
        return kept, ()
    missing = say("{missing} of {samples} samples are missing, have no regressors, or belong to stretches shorter than "
                  "{least}", missing=n - count, samples=n, least=MIN_STRETCH)  # fmt: skip
    used = say_count(len(kept), "{count} stretch used", "{count} stretches used, each with its own constant")
    return kept, (join("; ", (missing, used)),)


CONDITION = 30.0  # scaled condition number above which coefficients cannot be separated (Belsley, Kuh, Welsch 1980)
TRENDING = 0.5  # share of a ramp explained by the regressors from which on they are confounded with it
BEYOND_DOUBT = 3.0  # standard errors from which on an effect is beyond doubt


def collinearity(
    design: Design, likelihood: Likelihood, theta: FloatArray, symbols: str
) -> tuple[float, FloatArray, tuple[str, ...]]:
    """Scaled condition number and variance inflation of the columns under a noise theta of some terms; warnings."""
    A = information(likelihood, theta)
    size = np.sqrt(np.diag(A))
    values = np.linalg.eigvalsh(A / np.outer(size, size))
    inflation = np.diag(np.linalg.inv(A / np.outer(size, size))).copy()
    condition = float(np.sqrt(values[-1] / max(values[0], 1e-300)))
    notes = []
    if condition > CONDITION:
        factors = zip(design.labels, inflation, strict=True)
        worst = join(", ", [join("", (label, f" ({factor:.3g})")) for label, factor in factors if factor > 10])
        notes.append(say("the regressors can hardly be separated: scaled condition number {condition:.3g}, above "
                         "{limit:g}; variance inflation {worst}. Their sum may be accurate although none of them is",
                         condition=condition, limit=CONDITION, worst=worst or say("spread over all")))  # fmt: skip
    if design.trend:
        return condition, inflation, tuple(notes)
    # the share of a ramp that the columns explain, whitened, and the ramp beside them over its standard error
    wider = replace(design, X=np.column_stack((design.X, np.linspace(-1.0, 1.0, design.y.size)))).likelihood(symbols)
    eta, V, _ = wider.directions(theta)
    share, t = 1 - 1 / float(V[-1, -1] * information(wider, theta)[-1, -1]), float(eta[-1] / np.sqrt(V[-1, -1]))
    why = None
    if share > TRENDING:
        why = say("the regressors have a trend: they explain {percent:.3g} % of a linear drift, so that a rate ramp R "
                  "would be taken for their effect", percent=100 * share)  # fmt: skip
    elif abs(t) > BEYOND_DOUBT:
        why = say("the record shows a rate ramp R beside the regressors ({t:.3g} standard errors): part of it is taken "
                  "for their effect", t=abs(t))  # fmt: skip
    if why:
        notes.append(join("; ", (why, say("omit {option}", option=spelled("--no-trend", "trend=False")))))
    return condition, inflation, tuple(notes)


def information(likelihood: Likelihood, theta: FloatArray) -> FloatArray:
    """X' C^-1 X of the flat directions, shape (p, p), the edges known."""
    flat = np.flatnonzero(likelihood.flat)
    return np.asarray(np.einsum("bij,b->ij", likelihood.UU[:, flat][:, :, flat], 1 / likelihood.expectation(theta)))


class Products(NamedTuple):
    """Products of columns and rates over some stretches: X'X, X'y and y'y."""

    A: FloatArray
    b: FloatArray
    squares: float

    def misfit(self, beta: FloatArray, kept: list[int]) -> float:
        """Sum of squares of the rates less the columns `kept` with these coefficients."""
        return float(self.squares - 2 * beta @ self.b[kept] + beta @ self.A[np.ix_(kept, kept)] @ beta)


def products(likelihood: Likelihood, theta: FloatArray) -> tuple[Products, Products]:
    """From a likelihood of `restricted`: whitened under the noise theta, and plain."""
    flat = np.flatnonzero(likelihood.flat)
    UU, Uc, m = likelihood.UU[:, flat][:, :, flat], likelihood.Uc[:, flat], likelihood.expectation(theta)
    squares = likelihood.count * likelihood.power
    whitened = Products(information(likelihood, theta), (1 / m) @ Uc, float((1 / m) @ squares))
    return whitened, Products(UU.sum(axis=0), Uc.sum(axis=0), float(squares.sum()))


@dataclass(frozen=True, eq=False)
class HeldBlock:
    """A block that is held back, whitened and plain, and the rest of the record, whitened."""

    rest: Products
    whitened: Products
    plain: Products

    def coefficients(self, kept: list[int]) -> FloatArray:
        """Generalized least squares of the rest; the shortest ones where columns are alike there."""
        A, b = self.rest.A[np.ix_(kept, kept)], self.rest.b[kept]
        size = np.sqrt(np.maximum(np.diag(A), 1e-300))
        return np.asarray(np.linalg.lstsq(A / np.outer(size, size), b / size, rcond=1e-10)[0] / size)

    def misfit(self, kept: list[int], *, plain: bool = False) -> float:
        """Sum of squares, whitened or plain (about its mean), of the held block less what the rest predicts of it."""
        block = self.plain if plain else self.whitened
        return block.misfit(self.coefficients(kept), kept) if kept else block.squares


def folds(design: Design, theta: FloatArray, symbols: str, blocks: int) -> list[HeldBlock]:
    """The record in so many blocks of equal length, each held back once; those without enough samples are omitted."""
    first, last = design.stretches[0][0], design.stretches[-1][1]
    edges = np.linspace(first, last, blocks + 1).astype(int)
    held = []
    for a, b in pairwise(edges.tolist()):
        parts = [[(max(i, c), min(j, d))
                  for i, j in design.stretches for c, d in windows if min(j, d) - max(i, c) >= MIN_STRETCH]
                 for windows in ([(first, a), (b, last)], [(a, b)])]  # fmt: skip
        if all(parts):
            (rest, _), block = (products(design.likelihood(symbols, parts=p), theta) for p in parts)
            held.append(HeldBlock(rest, *block))
    return held


def choose(design: Design, folds: Sequence[HeldBlock]) -> list[int]:
    """The columns that are kept: all that were requested, and one after the other what held-back blocks gain from."""
    # An optional column enters if it lowers the whitened misfit of the held-back blocks by more than one standard error
    # of that gain over the blocks, a power with those below it. What takes in fewer columns comes first: a square alone
    # may do harm where a third power beside it is wanted, too.
    kept = [i for i, optional in enumerate(design.optional) if not optional]
    columns = [(r.channel, r.power) for r in design.regressors]
    while True:
        open_ = [i for i, optional in enumerate(design.optional) if optional and i not in kept]
        # each column with the lower powers of its channel
        steps = [[j for j in open_ if j == i or (columns[j][0] == columns[i][0] and 1 < columns[j][1] < columns[i][1])]
                 for i in open_]  # fmt: skip
        base = np.array([fold.misfit(kept) for fold in folds])
        for size in sorted({len(step) for step in steps}):
            some = [step for step in steps if len(step) == size]
            gains = [base - [fold.misfit([*kept, *step]) for fold in folds] for step in some]
            errors = [g.std(ddof=1) / np.sqrt(g.size) for g in gains]
            tried = zip([float(g.mean()) for g in gains], errors, some, strict=True)
            good = [(mean, step) for mean, error, step in tried if mean > error]
            if good:
                kept += max(good)[1]
                break
        else:
            return sorted(kept)
