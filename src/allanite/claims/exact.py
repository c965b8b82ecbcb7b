"""Noise that is claimed exactly: coefficients by likelihood, correlation time, other noise, curve, distribution."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations

import numpy as np

from allanite.batch.specification import seen_of
from allanite.comparison.common_likelihood import common_band, part_of
from allanite.core.arrays import BoolArray, FloatArray
from allanite.core.fit import Fit
from allanite.core.limits import NOT_DECIDED, quantile
from allanite.core.model import Model, Term
from allanite.core.record import Record
from allanite.core.units import Signal, unit_of
from allanite.identification.likelihood.law import Subset, ThetaProfile
from allanite.identification.likelihood.likelihood import Likelihood
from allanite.identification.likelihood.spectrum import BinnedSpectrum, spectrum
from allanite.identification.likelihood.whittle import column, likelihood, with_warm_up
from allanite.phrases.phrase import say
from allanite.prepare.outliers import treated
from allanite.statistics import deviation
from allanite.study.results import Channel, Study
from allanite.terms import TERMS

from .claim import ClaimedNoise
from .result import AGREES, DIFFERS, UNCLAIMED, CheckedTerm, claimed_deviation

WIDTH = 4.0  # coefficients of the transform to either side of a sinusoid that are left out

BESIDE = tuple(s for s, row in TERMS.items() if row.automatic and row.waveform is None)
"""Noise that is looked for beside what is claimed."""

RAMP = next(s for s, row in TERMS.items() if row.automatic and row.waveform is not None)
"""The ramp, which is looked for, too."""


@dataclass(frozen=True, eq=False)
class Form:
    """The likelihood of squared coefficients, SI, of one record; each column has its term."""

    # The first columns are the terms that are claimed, with their coefficients; then come those that may be beside them
    # (`BESIDE`), the first claimed term with a time constant, for other time constants, and a ramp, if none is claimed.
    terms: tuple[Term, ...]
    likelihood: Likelihood
    claimed: int

    def having(self, columns: Sequence[int]) -> Subset:
        """The likelihood with these columns free, at its minimum."""
        free = np.isin(np.arange(len(self.terms)), columns)
        return Subset(self.likelihood, free, *self.likelihood.minimise(free))

    def settled(self, columns: Sequence[int]) -> Subset:
        """The same; a ramp among them, which was not claimed, may have any size and is no column any more."""
        ramps = [i for i in columns if self.terms[i].symbol == RAMP]
        free = np.isin(np.arange(len(self.terms)), columns)
        free[ramps] = False
        part = replace(self.likelihood, flat=self.likelihood.flat | self.likelihood.W[:, ramps].any(axis=1))
        return Subset(part, free, *part.minimise(free))

    def ratio(self, subset: Subset, which: int, alpha: float) -> tuple[float, float, float]:
        """A coefficient over what is claimed, and its profile limits at 1 - alpha."""
        profile, drop = ThetaProfile(subset, which), quantile(1 - alpha / 2) ** 2
        size = self.terms[which].value
        best, low, high = (math.sqrt(theta) / size for theta in
                           (profile.best, profile.lower(drop), profile.upper(drop)))  # fmt: skip
        return best, low, high

    def beside(self, held: Sequence[int], alpha: float) -> tuple[int, ...]:
        """Columns of noise that is there beside the columns `held`, with a chance of alpha of a false one."""
        # A coefficient is not negative, so that its gain in 2 L is zero for half of all records without it.
        others = [i for i in range(self.claimed, len(self.terms)) if not self.terms[i].shape]
        beside, value = tuple[int, ...](), self.having(held).value
        for count in range(1, len(others) + 1):
            values = {more: self.having((*held, *more)).value for more in combinations(others, count)}
            best = min(values, key=values.__getitem__)
            if 2 * (value - values[best]) <= quantile(1 - alpha / len(others)) ** 2:
                break
            beside, value = best, values[best]
        return beside


def form_of(record: Record, model: Model, fit: Fit, times: FloatArray) -> Form:
    """The likelihood of a record under claimed noise."""
    record, claimed = treated(record, "mark"), [t for t in model if t.row.waveform is None]
    symbols = [t.symbol for t in claimed]
    plain = [t for t in claimed if not t.shape]
    plain += [Term(s, 1.0, record.signal) for s in BESIDE if s not in symbols]
    first = next((t for t in claimed if t.shape), None)
    shaped = [t for t in claimed if t.shape]
    shaped += [replace(first, shape=(float(time), *first.shape[1:])) for time in times] if first else []
    bins = spectrum(record, detrend=True)
    whole = likelihood(bins, [*(t.symbol for t in plain), RAMP])
    warm = next((t for t in model if t.row.transient), None)
    if warm is not None:
        whole = with_warm_up(whole, bins, np.ones_like(bins.first, dtype=bool), warm.shape[0] * record.rate)
    for term in shaped:
        whole = whole.with_more(column(term.sampled(record.rate), bins))
    scope, lines = fit.scope, [line.frequency for line in fit.lines]
    lines += [t.shape[0] for t in model if not t.row.scatters and not t.row.transient]
    if scope is not None and lines:
        near = WIDTH * record.rate / (2 * record.size)
        scope = replace(scope, masks=(*scope.masks, *((line - near, line + near) for line in lines)))
    every = [*plain, *shaped]
    band = common_band([record], None, [scope])
    part = part_of(whole, bins, [t.symbol for t in every], scope, band=band, scopes=[scope])
    if part.flat.any() and not model.drifts:
        ramp = Term(RAMP, abs(bins.slope) * bins.rate * bins.unit_factor or 1.0, record.signal)
        part, every = _with_ramp(part, bins, ramp), [*every, ramp]
    order = sorted(range(len(every)), key=lambda i: every[i] not in claimed)
    moved = replace(part, S=part.S[:, order], W=part.W[:, order])
    return Form(tuple(every[i] for i in order), moved, len(claimed))


def _with_ramp(part: Likelihood, bins: BinnedSpectrum, term: Term) -> Likelihood:
    """A likelihood whose ramp, its last direction, has a size drawn at random: one more term beside the others."""
    # Its squared coefficient, over that of `term`, then gains in 2 L as a random walk does, which may be in its place.
    ramp = np.arange(part.flat.size) == part.flat.size - 1
    slope = bins.slope * ramp  # what was subtracted before comes back
    squares = (part.UU @ slope) @ slope + 2 * part.Uc @ slope
    return replace(part, S=np.column_stack((part.S, np.zeros(part.power.size))),
                   W=np.column_stack((part.W, ramp * (term.value / (bins.rate * bins.unit_factor)) ** 2)),
                   power=part.power + squares / part.count, Uc=part.Uc + part.UU @ slope,
                   flat=part.flat & ~ramp)  # fmt: skip


def time_excess(forms: Sequence[Form], which: int) -> tuple[FloatArray, FloatArray]:
    """Time constants, s, and 2 L of several records at each, less its minimum: one that all have in common."""
    # `which` is the column of the term with the claimed time constant, which is among them.
    columns = [which, *(i for i in range(forms[0].claimed, len(forms[0].terms)) if forms[0].terms[i].shape)]
    times = np.array([forms[0].terms[i].shape[0] for i in columns])
    others = [i for i in range(forms[0].claimed) if i != which]
    value = np.array([sum(2 * form.having((*others, i)).value for form in forms) for i in columns])
    order = np.argsort(times)
    return times[order], (value - value.min())[order]


def inside(times: FloatArray, excess: FloatArray, alpha: float) -> tuple[float, float]:
    """Limits of a time constant at 1 - alpha; 0 or infinity where the times that were tried do not reach them."""
    most = quantile(1 - alpha / 2) ** 2
    kept: BoolArray = excess <= most
    first, last = int(kept.argmax()), int(kept.size - 1 - kept[::-1].argmax())
    # interpolated, at either end, between the last two times
    pairs = [first, max(first - 1, 0)], [last, min(last + 1, times.size - 1)]
    low, high = (float(np.exp(np.interp(most, excess[pair], np.log(times[pair])))) for pair in pairs)
    return (low if first else 0.0), (high if last < times.size - 1 else np.inf)


DECADES = np.arange(-15, 10) / 6  # decades from a claimed correlation time at which others are tried
LIGHT = -0.5  # excess kurtosis below which residuals are not Gaussian; that of a uniform distribution is -1.2


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
        fit, record = self.channel.fit, self.channel.record
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
    by_name: dict[str, list[AxisCheck]] = {}
    for channel in study:
        claim, signal = claims[channel.record.rate], channel.record.signal
        model = claim.of(signal)
        if model is not None:
            settled = max((s.settled for s in claim.settings if s.holds_for(signal)), default=0.0)
            by_name.setdefault(signal.name, []).append(AxisCheck(channel, model, settled))
    return [Sensor(axes[0].model.signal, tuple(axes)) for axes in by_name.values()]


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
        record = axis.channel.record
        form, channel = axis.form, CheckedTerm(record.name, record.signal, "", None, None, "")  # to be filled in
        if form is None:
            for term in axis.model:
                yield _estimated(axis.channel, term, count)
            continue
        held = [column if i == sensor.timed and column is not None else i for i in range(form.claimed)]
        beside = form.beside(held, count.channel)
        settled, subset = form.settled((*held, *beside)), form.having((*held, *beside))
        for i, term in enumerate(form.terms[: form.claimed]):
            best, low, high = (scale * v if i == sensor.timed else v for v in form.ratio(settled, held[i], count.term))
            yield replace(channel, quantity=term.symbol, claimed=term.value, found=best * term.value,
                          unit=sensor.signal.sheet[term.row.power], ratio=best, low=low, high=high,
                          outcome=count.outcome(low, high))  # fmt: skip
        for term in (t for t in axis.model if t.row.waveform is not None):
            yield _estimated(axis.channel, term, count)
        for i in beside:
            other = form.terms[i]
            yield replace(channel, quantity=other.symbol, found=other.value * math.sqrt(float(subset.theta[i])),
                          unit=sensor.signal.sheet[other.row.power], outcome=UNCLAIMED)  # fmt: skip
        yield curve_row(axis.channel, axis.model, axis.model, count.channel, count.outcome, settled=axis.settled)
        yield from _distribution(axis, channel, count)


def _time(sensor: Sensor, column: int, count: Counts) -> tuple[CheckedTerm, int]:
    """The correlation time of all channels of a sensor in common, and the column of the one that was found."""
    forms = sensor.forms
    claimed = forms[0].terms[column].shape[0]
    times, excess = time_excess(forms, column)
    low, high = inside(times, excess, count.time)
    best = float(times[excess.argmin()])
    names = ", ".join(axis.channel.record.name for axis in sensor.axes)
    row = CheckedTerm(names, sensor.signal, "T", claimed, best, "s", best / claimed, low / claimed, high / claimed,
                      AGREES if low <= claimed <= high else DIFFERS)  # fmt: skip
    nearest = [i for i, t in enumerate(forms[0].terms) if t.shape and math.isclose(t.shape[0], best)]
    return row, nearest[0]


def _estimated(channel: Channel, term: Term, count: Counts) -> CheckedTerm:
    """A coefficient held against the identified noise: of a ramp, or where only sums of the record are kept."""
    reading = seen_of(channel, term.symbol, 1 - count.term)
    unit = channel.record.signal.sheet[term.row.power]
    row = CheckedTerm(channel.record.name, channel.record.signal, term.symbol, term.value, reading.value, unit,
                      reason=reading.reason)  # fmt: skip
    low, high = (0.0, reading.upper) if reading.value is None and reading.upper else (reading.low, reading.high)
    if high is None or not math.isfinite(high):
        return replace(row, outcome=NOT_DECIDED, reason=reading.reason or say("no interval"))
    size = abs(term.value)
    ratio = 0.0 if reading.value is None else reading.value / size
    return replace(row, ratio=ratio, low=low / size, high=high / size, outcome=count.outcome(low / size, high / size))


def curve_row(channel: Channel, claimed: Model, supposed: Model | Fit, alpha: float,
              judge: Callable[[float, float], str], *, settled: float = 0.0) -> CheckedTerm:  # fmt: skip
    """The Allan deviation where it is farthest from the claimed one, at octaves from the time `settled` on."""
    # Its intervals are those under the noise that is `supposed`; `judge` says what limits of the ratio mean.
    record = channel.record
    assert isinstance(record, Record)  # noqa: S101 - the callers have looked
    curve = deviation(record, "oadev", taus="octave", noise=supposed)
    factor, expected = unit_of(curve.unit).factor, claimed_deviation(claimed, curve)
    low, high = (limit / expected for limit in curve.interval(1 - alpha / curve.tau.size))
    outcomes = [judge(least, most) for least, most in zip(low.tolist(), high.tolist(), strict=True)]
    outside = np.maximum(low, 1 / np.maximum(high, 1e-300))  # of a record that alternates the deviation may be zero
    outcomes = [o if tau >= settled else AGREES for o, tau in zip(outcomes, curve.tau, strict=True)]
    outside = np.where(curve.tau >= settled, outside, outside - 2 * outside.max())
    most = int(np.argmax(np.where([outcome != AGREES for outcome in outcomes], outside, outside - outside.max())))
    return CheckedTerm(record.name, record.signal, "curve",
                       factor * float(expected[most]), factor * float(curve.deviation[most]), record.signal.sheet[0],
                       float(curve.deviation[most] / expected[most]), float(low[most]), float(high[most]),
                       outcomes[most], say("at {tau:.4g} s", tau=float(curve.tau[most])))  # fmt: skip


def _distribution(axis: AxisCheck, row: CheckedTerm, count: Counts) -> Iterator[CheckedTerm]:
    """The excess kurtosis of the residuals, if it was computed: light tails are those of no Gaussian noise."""
    residuals = axis.channel.residuals
    tails = next((check for check in residuals.checks if check.name == "kurtosis"), None) if residuals else None
    if tails is not None:
        light = tails.value < LIGHT and tails.p < count.channel
        yield replace(row, quantity="kurtosis", claimed=0.0, found=tails.value, outcome=DIFFERS if light else AGREES,
                      reason=say("light tails, as of a uniform distribution") if light else "")  # fmt: skip
