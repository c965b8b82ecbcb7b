"""The noise model that a file states beside the noise that was identified, and the errors of a filter with it.

A filter that knew the angle up to now predicts the angle gained in the time that follows from the rates that it had.
The predictor is linear in these. Its error follows from the structure function D of the noise alone: increments of the
angle between times a, b and c, d have the covariance

    (D(|a - d|) + D(|b - c|) - D(|a - c|) - D(|b - d|)) / 2.

Flicker and random walks, whose rate has no variance, begin with the oldest step of the past: from each increment its
duration times the mean rate of that step is subtracted, which makes of the generalized covariance (Matheron 1973) one.
A predictor with such a term is exact for a constant rate; one of Gauss-Markov noise alone returns to zero.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, reduce
from operator import add
from typing import ClassVar

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.curve import Curve
from allanite.core.estimate import Estimate
from allanite.core.limits import demand_stored_positive
from allanite.core.model import Model, Term
from allanite.core.plain import Value
from allanite.core.units import Signal, unit_of
from allanite.phrases.phrase import join, say
from allanite.statistics import expected
from allanite.terms import TERMS

from .content import Axis, Entry, by_sensor
from .fields import How, fill
from .target import LONG, Target, TargetField

PAST = 40  # steps of the past, evenly spaced in the logarithm, whose mean rates a predictor is made of

FIRST, LAST = 0.25, 10.0
"""The first of them over the shortest time without aid, and their length in all over the longest."""


@dataclass(frozen=True, eq=False)
class Covariances:
    """Covariances of the angles gained: in steps of the past, in these and without aid, without aid."""

    past: FloatArray
    cross: FloatArray
    ahead: FloatArray
    drifts: bool

    def __add__(self, other: "Covariances") -> "Covariances":
        drifts = self.drifts or other.drifts
        return Covariances(self.past + other.past, self.cross + other.cross, self.ahead + other.ahead, drifts)

    def __mul__(self, factor: FloatArray | float) -> "Covariances":
        past, cross, ahead = (np.multiply.outer(factor, part) for part in (self.past, self.cross, self.ahead))
        return Covariances(past, cross, ahead, self.drifts)

    def errors(self, weights: FloatArray) -> FloatArray:
        """Variance of the error of predictors with these weights, shape (n, k), by time without aid, shape (k,)."""
        return np.asarray(self.ahead + ((self.past @ weights - 2 * self.cross) * weights).sum(axis=-2))


@dataclass(frozen=True)
class Outages:
    """Times without aid, s."""

    times: tuple[float, ...]

    @property
    def edges(self) -> FloatArray:
        """How long ago the steps of the past began and ended, s."""
        return np.append(0.0, np.geomspace(FIRST * self.times[0], LAST * self.times[-1], PAST))

    def of(self, model: Model) -> Covariances:
        """The covariances under a model."""
        return reduce(add, (_covariances(self, t.symbol, t.shape) * t.value**2 for t in model))

    def weights(self, cov: Covariances) -> FloatArray:
        """The weights of the best predictor under these covariances, shape (n, k)."""
        length, scale = np.diff(self.edges), cov.past.trace(axis1=-2, axis2=-1)[..., None, None] / PAST
        if not cov.drifts:
            return np.asarray(np.linalg.solve(cov.past, cov.cross))
        system = np.zeros((*cov.past.shape[:-2], PAST + 1, PAST + 1))
        system[..., :PAST, :PAST] = cov.past / scale
        system[..., PAST, :PAST] = system[..., :PAST, PAST] = length / length.max()
        rates = np.broadcast_to(np.array(self.times) / length.max(), (*cov.past.shape[:-2], 1, len(self.times)))
        return np.asarray(np.linalg.solve(system, np.concatenate([cov.cross / scale, rates], axis=-2))[..., :PAST, :])


@lru_cache(maxsize=256)  # several axes, of both sensors, have the same times
def _covariances(outages: Outages, symbol: str, shape: tuple[float, ...]) -> Covariances:
    """Under a term of size 1, SI."""
    row, edges, times = TERMS[symbol], outages.edges, np.array(outages.times)
    points = np.concatenate([-edges, times])
    begin = np.append(np.arange(1, PAST + 1), np.zeros(len(times), dtype=np.int64))
    end = np.append(np.arange(PAST), PAST + 1 + np.arange(len(times)))
    D = np.asarray((row.shaped(shape, 1.0) if row.shaped else row).structure(np.abs(np.subtract.outer(points, points))))
    between, alike = D[np.ix_(begin, end)], D[np.ix_(begin, begin)] + D[np.ix_(end, end)]
    whole = (between + between.T - alike) / 2
    drifts = row.alpha is not None and row.alpha < 0
    if drifts:
        share = (points[end] - points[begin]) / (edges[-1] - edges[-2])
        oldest = np.outer(share, whole[PAST - 1])
        whole += np.outer(share, share) * whole[PAST - 1, PAST - 1] - oldest - oldest.T
    return Covariances(whole[:PAST, :PAST], whole[:PAST, PAST:], np.diag(whole)[PAST:], drifts)


USUAL = 1.0, 1000.0  # averaging times, s, that are compared where there is no record
RESOLVED = 0.1  # share of a record up to which averaging times are compared
PER_DECADE = 20  # averaging times at which two curves are compared, and times without aid, in a decade
CLOSE = 0.9  # ratio of deviations from which a file is not called over-confident


@dataclass(frozen=True, eq=False, repr=False)
class StatedNoise(Value):
    """The noise model that a file states, beside the noise that was identified."""

    _also: ClassVar = ("lowest", "span")
    _alike = ("tau deviation identified upper", "times predicted actual best")
    _checks: ClassVar = dict.fromkeys(
        ("deviation", "identified", "upper", "predicted", "actual", "best"), demand_stored_positive)  # fmt: skip

    channels: tuple[str, ...]
    # model, noise: what the file states, with its inflation; what was identified
    model: Model
    noise: Model
    # tau, deviation, identified, upper: shape (k,); averaging times, s; Allan deviations of the file, of the
    # identified noise, and the upper limit of what it may be, SI
    tau: FloatArray
    deviation: FloatArray
    identified: FloatArray
    upper: FloatArray
    # times, predicted, actual, best: shape (j,); times without aid, s; standard deviation of the angle (of the
    # velocity) that a filter with the file's model predicts after them, that of its error under the identified noise,
    # and that of the best filter, SI
    times: FloatArray
    predicted: FloatArray
    actual: FloatArray
    best: FloatArray
    covers: bool = False  # whether the file was made to cover the upper limit
    curves: tuple[Curve, ...] = ()  # the measured Allan deviations

    @property
    def span(self) -> tuple[float, float]:
        """The averaging times that were compared, s."""
        return float(self.tau[0]), float(self.tau[-1])

    @property
    def lowest(self) -> tuple[float, float]:
        """The lowest ratio of the file's Allan deviation to that of the noise (or its limit), and its time, s."""
        ratio = self.deviation / (self.upper if self.covers else self.identified)
        return float(ratio.min()), float(self.tau[ratio.argmin()])

    @property
    def label(self) -> str:
        """The channels, or that it is a given model."""
        return join(", ", self.channels) or say("given {sensor}", sensor=self.noise.signal.name)

    def words(self) -> tuple[str, ...]:
        """What the file covers and at what cost, or by how much a filter with it errs more than it predicts."""
        (low, high), (ratio, at), wrong = self.span, self.lowest, self.actual / self.predicted
        sensor = say(self.noise.signal.name)
        if not self.covers:
            return (say("{channels}: the Allan deviation of this file is {ratio:.2f} of that of the noise at {at:.4g} "
                        "s", channels=self.label, ratio=ratio, at=at),
                    say("{sensor}: a filter errs up to {wrong:.2g} times what it predicts with this file",
                        sensor=sensor, wrong=float(wrong.max())))  # fmt: skip
        loss = np.round(100 * (self.actual / self.best - 1))  # its maximum is where it is first, not where rounding is
        return (say("{channels}: covers the noise from {low:.4g} to {high:.4g} s, lowest ratio {ratio:.2f} at {at:.4g} "
                    "s", channels=self.label, low=low, high=high, ratio=ratio, at=at),
                say("{sensor}: errors without aid up to {loss:.0f} % above the best filter's ({time:.4g} s), predicted "
                    "up to {wide:.2g} times as large", sensor=sensor, loss=float(loss.max()),
                    time=float(self.times[loss.argmax()]), wide=1 / float(wrong.min())))  # fmt: skip

    @property
    def confident(self) -> bool:
        """Whether a filter with the file is over-confident."""
        return not self.covers and self.lowest[0] < CLOSE

    def _summary(self) -> str:
        return self.words()[0]


@dataclass(frozen=True, eq=False)
class AxisNoise:
    """What is known of the noise of an axis between two averaging times: Allan variances at `tau`, SI, shape (k,)."""

    axis: Axis
    model: Model
    tau: FloatArray
    identified: FloatArray
    upper: FloatArray

    @property
    def steady(self) -> Model:
        """The model without a ramp, whose effect depends on how long ago it began."""
        kept = tuple(t for t in self.model if t.row.waveform is None)
        return Model(kept) if kept else self.model


def span_of(axis: Axis) -> tuple[float, float]:
    """The averaging times to compare, s: from 1 s to a tenth of the record."""
    low = max(USUAL[0], 2 / axis.rate) if axis.rate else USUAL[0]
    length = axis.curve.size / axis.curve.rate if axis.curve is not None and axis.curve.size else USUAL[1] / RESOLVED
    return low, max(RESOLVED * length, 10 * low)


def groups_of(axes: Sequence[Axis], how: How) -> list[tuple[AxisNoise, ...]]:
    """The noises of the axes that share the values of the fields: under "worst" all of a sensor, otherwise each."""
    groups: list[tuple[AxisNoise, ...]] = []
    for group in by_sensor(axes).values():
        low, high = how.span or span_of(group[0])
        tau = np.geomspace(low, high, max(2, round(PER_DECADE * np.log10(high / low)) + 1))
        noises = [noise_of(axis, tau, unexplained=how.unexplained) for axis in group]
        known = [noise for noise in noises if noise is not None]
        groups += [tuple(known)] if how.axis == "worst" and known else [(noise,) for noise in known]
    return groups


def noise_of(axis: Axis, tau: FloatArray, *, unexplained: bool) -> AxisNoise | None:
    """The noise of an axis, and the smaller of two upper limits: of the terms, of the curve; None without terms."""
    known, limits, struck = [], [], False
    for e in axis.fit:
        row = TERMS[e.symbol]
        if not row.scatters or len(e.shape) != len(row.parameters):
            continue
        forced = unexplained and e.status == "not valid"
        value = e.value if e.valued or forced else None
        most = _most(e, axis.level)
        known += [Term(e.symbol, value, e.signal, e.shape)] if value else []
        limits += [Term(e.symbol, most, e.signal, e.shape)] if most else []
        struck = struck or (e.status == "not valid" and not most)
    if not limits:
        return None
    identified = _allan(known, tau, axis.rate)
    upper = np.minimum(np.full(tau.shape, np.inf) if struck else _allan(limits, tau, axis.rate), _measured(axis, tau))
    upper = np.maximum(np.where(np.isfinite(upper), upper, _allan(limits, tau, axis.rate)), identified)
    return AxisNoise(axis, Model(known or limits), tau, identified if known else upper, upper)


def _most(e: Estimate, level: float) -> float:
    """The upper limit of a coefficient, or its value if there is none."""
    if not e.valued:
        return e.upper or 0.0
    high = e.interval(level)[1]
    return float(high if np.isfinite(high) else e.value or 0.0)


def _allan(terms: Sequence[Term], tau: FloatArray, rate: float | None) -> FloatArray:
    if not terms:
        return np.zeros(tau.shape)
    model = Model(tuple(t for t in terms if not t.row.per_sample or rate))
    if rate and any(t.row.per_sample or t.row.transient for t in model):  # known at whole samples only
        tau = np.maximum(np.rint(tau * rate), 1) / rate
    return expected(model, "oadev", tau, rate=rate) if rate else expected(model, "oadev", tau)


def _measured(axis: Axis, tau: FloatArray) -> FloatArray:
    """The upper limit of the measured Allan variance; infinity where there is none."""
    none = np.full(tau.shape, np.inf)
    if axis.curve is None or axis.curve.law is None:
        return none
    upper = axis.curve.to(axis.fit.signal.unit).interval(axis.level)[1]
    upper = np.where(np.isfinite(upper) & (upper > 0), upper, np.inf)
    return np.exp(2 * np.interp(np.log(tau), np.log(axis.curve.tau), np.log(upper), left=np.inf, right=np.inf))


def model_of_fields(
    target: Target, entries: Sequence[Entry], axis: Axis, rate: float | None, which: int
) -> Model | None:
    """The noise model that the fields of a file state for axis `which` of a sensor; None if one is missing."""
    by_name = {entry.full: entry.values[min(which, len(entry.values) - 1)] for entry in entries}
    fields = [field for field in target.fields if field.sensor == axis.sensor]
    if any(field.needed and field.full not in by_name for field in fields):
        return None
    times = [by_name[f.full] * unit_of(f.unit).factor for f in target.fields if not f.term and f.full in by_name]
    own = [by_name[f.full] * unit_of(f.unit).factor for f in fields if not f.term]
    time = (own or times or [LONG])[0]
    terms = [_term(f,
                   f.coefficient(by_name[f.full], rate or 1.0, time), axis.fit.signal, time if own or times else None)
             for f in fields if f.term and by_name.get(f.full)]  # fmt: skip
    return Model(tuple(terms)) if terms else None


def _term(field: TargetField, coefficient: float, signal: Signal, time: float | None) -> Term:
    if time is None or TERMS[field.term].slope <= 0:
        return Term(field.term, coefficient, signal)
    return Term("GM", coefficient * (time / 2) ** 0.5, signal, (time,))


def to_cover(
    target: Target, axes: Sequence[Axis], groups: Sequence[tuple[AxisNoise, ...]], how: How
) -> list[tuple[AxisNoise, ...]]:
    """The groups to cover: if that is not said, those of a filter that would be over-confident with what was found."""
    if how.cover is not None or target.simulates:
        return list(groups) if how.cover else []
    entries = fill(target, axes, replace(how, partial=True))[0]
    noises = ((group, compared(target, entries, group, how)) for group in groups)
    return [group for group, made in noises if (made.confident if made else _lacking(target, group))]


def _lacking(target: Target, group: Sequence[AxisNoise]) -> bool:
    """Whether the target has no field for a slow term of the group; no white noise is invented for a model of none."""
    white = any(t.symbol == "N" for noise in group for t in noise.model)
    return bool(unfielded(target, group)) and (white or any(noise.axis.fit.method != "given" for noise in group))


def unfielded(target: Target, group: Iterable[AxisNoise]) -> tuple[Term, ...]:
    """The slow terms of a group for which the target has no field, the largest of the axes."""
    fields = {field.term for field in target.fields}
    slow = (term for noise in group for term in noise.model if not term.row.slope < 0)
    return largest(term for term in slow if term.symbol not in fields)


def largest(terms: Iterable[Term]) -> tuple[Term, ...]:
    """The largest term of each symbol."""
    known = dict[str, Term]()
    for term in terms:
        known[term.symbol] = max(known.get(term.symbol, term), term, key=lambda t: t.value)
    return tuple(known.values())


def compared(target: Target, entries: Sequence[Entry], noises: Sequence[AxisNoise], how: How) -> StatedNoise | None:
    """How the fields of a file compare with the noise of the axes that share them; None if some are missing."""
    axis = noises[0].axis
    own = [entry for entry in entries if entry.sensor == axis.sensor]
    places = [entry.channels.index(axis.name) for entry in own if axis.name in entry.channels]
    if how.axis in "xyz" and axis.name and not places:
        return None  # another axis was asked for
    model = model_of_fields(target, entries, axis, target.rate(axis.rate, how.filter_rate), max(places, default=0))
    return None if model is None else beside(noises, model, covers=any(entry.covers for entry in own))


def beside(noises: Sequence[AxisNoise], model: Model, *, covers: bool) -> StatedNoise:
    """The comparison of a file's model with the noise of its axes: the largest of it at each averaging time."""
    first, tau = noises[0], noises[0].tau
    times = np.geomspace(tau[0], tau[-1], max(2, round(np.log10(tau[-1] / tau[0]) * PER_DECADE / 2) + 1))
    outages = Outages(tuple(times.tolist()))
    own = outages.of(model)
    weights = outages.weights(own)
    truths = [outages.of(noise.steady) for noise in noises]
    best = np.max([cov.errors(outages.weights(cov)) for cov in truths], axis=0)
    actual = np.max([cov.errors(weights) for cov in truths], axis=0)
    return StatedNoise(
        tuple(noise.axis.name for noise in noises if noise.axis.name), model, first.model, tau,
        np.sqrt(_allan(tuple(model), tau, first.axis.rate)), np.sqrt(np.max([n.identified for n in noises], axis=0)),
        np.sqrt(np.max([n.upper for n in noises], axis=0)), times, np.sqrt(own.errors(weights)), np.sqrt(actual),
        np.sqrt(best), covers, tuple(noise.axis.curve for noise in noises if noise.axis.curve is not None),
    )  # fmt: skip
