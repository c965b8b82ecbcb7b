"""Noise that is claimed exactly: coefficients by likelihood, correlation time, other noise, curve, distribution."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from allanite.batch.judgement import seen_of
from allanite.core.arrays import FloatArray
from allanite.core.fit import Fit
from allanite.core.model import Model, Term
from allanite.core.record import Record
from allanite.core.units import Signal, unit_of
from allanite.phrases.phrase import say
from allanite.statistics import deviation
from allanite.study.results import Channel, Study

from .claim import ClaimedNoise
from .form import Form, form_of, inside, time_excess
from .result import AGREES, DIFFERS, NOT_SHOWN, UNCLAIMED, CheckedTerm, claimed_deviation, fit_of

DECADES = np.arange(-15, 10) / 6
"""Decades from a claimed correlation time at which others are tried."""

LIGHT = -0.5
"""Excess kurtosis below which residuals are not Gaussian; that of a uniform distribution is -1.2."""


@dataclass(frozen=True, eq=False)
class AxisCheck:
    """A channel and its claimed model; a claimed filter has `settled` from an averaging time on, s."""

    channel: Channel
    model: Model
    settled: float = 0.0

    @property
    def noise(self) -> tuple[Term, ...]:
        """The claimed terms of noise."""
        return tuple(t for t in self.model if t.row.waveform is None)

    @property
    def times(self) -> FloatArray:
        """Correlation times to try beside the claimed one, s."""
        first = next((t for t in self.noise if t.shape), None)
        return np.empty(0) if first is None else first.shape[0] * 10 ** DECADES[DECADES != 0]

    @cached_property
    def form(self) -> Form | None:
        """The likelihood of the claimed noise; None without samples or without claimed noise."""
        fit, record = fit_of(self.channel), self.channel.record
        if fit is None or not isinstance(record, Record) or not self.noise:
            return None
        return form_of(record, self.model, fit, self.times)


@dataclass(frozen=True, eq=False)
class Sensor:
    """The channels of one kind of sensor."""

    signal: Signal
    axes: tuple[AxisCheck, ...]

    @property
    def forms(self) -> list[Form]:
        """The likelihoods of its channels."""
        return [axis.form for axis in self.axes if axis.form is not None]

    @property
    def timed(self) -> int | None:
        """The column of the term whose correlation time is checked."""
        terms = self.forms[0].terms[: self.forms[0].claimed] if self.forms else ()
        return next((i for i, t in enumerate(terms) if t.shape), None)


@dataclass(frozen=True)
class Counts:
    """The chance of a false alarm of each kind of comparison, shared by those of the record, and the tolerance."""

    sensors: list[Sensor]
    alpha: float
    tolerance: float

    @property
    def term(self) -> float:
        """Of each coefficient."""
        return self.alpha / max(sum(len(axis.model.terms) for sensor in self.sensors for axis in sensor.axes), 1)

    @property
    def channel(self) -> float:
        """Of each comparison that a channel has once."""
        return self.alpha / sum(len(sensor.axes) for sensor in self.sensors)

    @property
    def time(self) -> float:
        """Of each correlation time."""
        return self.alpha / max(sum(sensor.timed is not None for sensor in self.sensors), 1)

    def outcome(self, low: float, high: float) -> str:
        """Whether limits of a factor hold 1, as nearly as is tolerated."""
        return AGREES if low <= 1 + self.tolerance and high >= 1 - self.tolerance else DIFFERS


def by_sensor(study: Study, claims: dict[float, ClaimedNoise]) -> list[Sensor]:
    """The kinds of sensors of which something is claimed, by sampling rate of the claims."""
    found: dict[str, list[AxisCheck]] = {}
    for channel in study:
        claim, signal = claims[channel.record.rate], channel.record.signal
        model = claim.of(signal)
        if model is not None:
            settled = max((s.settled for s in claim.settings if s.holds_for(signal)), default=0.0)
            found.setdefault(signal.name, []).append(AxisCheck(channel, model, settled))
    return [Sensor(axes[0].model.signal, tuple(axes)) for axes in found.values()]


def exact_rows(sensor: Sensor, count: Counts) -> Iterator[CheckedTerm]:
    """The rows of a kind of sensor whose noise is claimed exactly."""
    column, scale = sensor.timed, 1.0
    if column is not None:
        time, instead = _time(sensor, column, count)
        yield time
        if time.outcome == DIFFERS:
            # with the time that was found what is compared is the noise that drives the bias, s sqrt(2/T)
            column, scale = instead, math.sqrt(1 / time.ratio)
    for axis in sensor.axes:
        form, channel = axis.form, _row(axis)
        if form is None:
            for term in axis.model:
                yield _estimated(axis.channel, term, count)
            continue
        held = [column if i == sensor.timed and column is not None else i for i in range(form.claimed)]
        found = form.beside(held, count.channel)
        settled, subset = form.settled((*held, *found)), form.having((*held, *found))
        for i, term in enumerate(form.terms[: form.claimed]):
            best, low, high = (scale * v if i == sensor.timed else v for v in form.ratio(settled, held[i], count.term))
            yield replace(
                channel, quantity=term.symbol, claimed=term.value, found=best * term.value,
                unit=sensor.signal.sheet[term.row.power], ratio=best, low=low, high=high,
                outcome=count.outcome(low, high),
            )  # fmt: skip
        for term in (t for t in axis.model if t.row.waveform is not None):
            yield _estimated(axis.channel, term, count)
        for i in found:
            other = form.terms[i]
            yield replace(
                channel, quantity=other.symbol, found=other.value * math.sqrt(float(subset.theta[i])),
                unit=sensor.signal.sheet[other.row.power], outcome=UNCLAIMED,
            )  # fmt: skip
        yield curve_row(axis.channel, axis.model, axis.model, count.channel, count.outcome, settled=axis.settled)
        yield from _distribution(axis, channel, count)


def _row(axis: AxisCheck) -> CheckedTerm:
    """A row of a channel, to be filled in."""
    return CheckedTerm(axis.channel.record.name, axis.channel.record.signal, "", None, None, "")


def _time(sensor: Sensor, column: int, count: Counts) -> tuple[CheckedTerm, int]:
    """The correlation time of all channels of a sensor in common, and the column of the one that was found."""
    forms = sensor.forms
    claimed = forms[0].terms[column].shape[0]
    times, excess = time_excess(forms, column)
    low, high = inside(times, excess, count.time)
    best = float(times[excess.argmin()])
    names = ", ".join(axis.channel.record.name for axis in sensor.axes)
    row = CheckedTerm(
        names, sensor.signal, "T", claimed, best, "s", best / claimed, low / claimed, high / claimed,
        AGREES if low <= claimed <= high else DIFFERS,
    )  # fmt: skip
    nearest = [i for i, t in enumerate(forms[0].terms) if t.shape and math.isclose(t.shape[0], best)]
    return row, nearest[0]


def _estimated(channel: Channel, term: Term, count: Counts) -> CheckedTerm:
    """A coefficient held against the identified noise: of a ramp, or where only sums of the record are kept."""
    seen = seen_of(channel, term.symbol, 1 - count.term)
    unit = channel.record.signal.sheet[term.row.power]
    row = CheckedTerm(channel.record.name, channel.record.signal, term.symbol, term.value, seen.value, unit,
                      reason=seen.reason)  # fmt: skip
    low, high = (0.0, seen.upper) if seen.value is None and seen.upper else (seen.low, seen.high)
    if high is None or not math.isfinite(high):
        return replace(row, outcome=NOT_SHOWN, reason=seen.reason or say("no interval"))
    size = abs(term.value)
    ratio = 0.0 if seen.value is None else seen.value / size
    return replace(row, ratio=ratio, low=low / size, high=high / size, outcome=count.outcome(low / size, high / size))


def curve_row(
    channel: Channel,
    claimed: Model,
    supposed: Model | Fit,
    alpha: float,
    judge: Callable[[float, float], str],
    *,
    settled: float = 0.0,
) -> CheckedTerm:
    """The Allan deviation where it is farthest from the claimed one, all octaves from the time `settled` on considered.

    Its intervals are those under the noise that is `supposed`; `judge` says what limits of the ratio mean.
    """
    record = channel.record
    assert isinstance(record, Record)  # noqa: S101 - the callers have looked
    curve = deviation(record, "oadev", taus="octave", noise=supposed)
    factor, expected = unit_of(curve.unit).factor, claimed_deviation(claimed, curve)
    low, high = (limit / expected for limit in curve.interval(1 - alpha / curve.tau.size))
    outcomes = [judge(float(one), float(other)) for one, other in zip(low, high, strict=True)]
    outside = np.maximum(low, 1 / high)
    outcomes = [o if tau >= settled else AGREES for o, tau in zip(outcomes, curve.tau, strict=True)]
    outside = np.where(curve.tau >= settled, outside, outside - 2 * outside.max())
    most = int(np.argmax(np.where([outcome != AGREES for outcome in outcomes], outside, outside - outside.max())))
    return CheckedTerm(
        record.name, record.signal, "curve", factor * float(expected[most]), factor * float(curve.deviation[most]),
        record.signal.sheet[0], float(curve.deviation[most] / expected[most]), float(low[most]), float(high[most]),
        outcomes[most], say("at {tau:.4g} s", tau=float(curve.tau[most])),
    )  # fmt: skip


def _distribution(axis: AxisCheck, row: CheckedTerm, count: Counts) -> Iterator[CheckedTerm]:
    """The excess kurtosis of the residuals, if it was computed: light tails are those of no Gaussian noise."""
    left = axis.channel.residuals
    tails = next((check for check in left.checks if check.name == "kurtosis"), None) if left else None
    if tails is not None:
        light = tails.value < LIGHT and tails.p < count.channel
        yield replace(row, quantity="kurtosis", claimed=0.0, found=tails.value, outcome=DIFFERS if light else AGREES,
                      reason=say("light tails, as of a uniform distribution") if light else "")  # fmt: skip
