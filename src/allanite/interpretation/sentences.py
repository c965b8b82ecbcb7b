"""What a result says in sentences: causes, and which term dominates at which averaging time."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import pairwise

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.estimate import Estimate
from allanite.core.fit import Fit
from allanite.core.kinds import title_of
from allanite.core.model import Term
from allanite.core.plain import Value
from allanite.core.readings import FLICKER, IN_RUN, Readings
from allanite.core.units import convert
from allanite.phrases.phrase import averaging, join, say
from allanite.statistics.moments.moments import expected
from allanite.terms import TERMS, WHITE

from .devices import Cause, bounds_of, device as named, grade_of

POINTS_PER_DECADE = 1000  # points of a decade at which humps are held against lines


@dataclass(frozen=True)
class Span:
    """Averaging times, s, at which a term has more part in the Allan deviation than any other."""

    symbol: str
    start: float
    end: float


def straight(estimate: Estimate) -> bool:
    """Whether the asymptote of a term that was found is a straight line: not that of a hump."""
    return estimate.claimed and bool(estimate.value) and not TERMS[estimate.symbol].parameters


def lasting(estimate: Estimate) -> bool:
    """Whether a term has a curve of its own, whatever the record and its rate."""
    row = TERMS[estimate.symbol]
    return row.scatters and not row.per_sample


def height(estimate: Estimate, tau: float) -> float:
    """The asymptote of a term in the Allan deviation at an averaging time, SI."""
    row = TERMS[estimate.symbol]
    return float(abs(estimate.value or 0.0) * math.sqrt(row.level) * tau**row.slope)


def crossing(one: Estimate, other: Estimate) -> float:
    """Averaging time, s, at which the asymptotes of two terms of different slope are equal."""
    slope = TERMS[other.symbol].slope - TERMS[one.symbol].slope
    return float((height(one, 1.0) / height(other, 1.0)) ** (1 / slope))


def spans(estimates: Sequence[Estimate], start: float, end: float) -> tuple[Span, ...]:
    """Where each of the terms that were found dominates, from `start` to `end`, s: by asymptotes, or humps."""
    present = [e for e in estimates if e.claimed and e.value and lasting(e)]
    if not present or not start < end:
        return ()
    tau = np.geomspace(start, end, 2 + math.ceil(POINTS_PER_DECADE * math.log10(end / start)))
    top = np.argmax([_line(e, tau) for e in present], axis=0)
    edges = np.flatnonzero(np.diff(top)) + 1
    bounds = [start]
    for i in edges:  # where one term takes over from another, between two points of the grid
        before, after = present[top[i - 1]], present[top[i]]
        exact = straight(before) and straight(after)
        bounds.append(crossing(before, after) if exact else float(math.sqrt(tau[i - 1] * tau[i])))
    bounds.append(end)
    firsts = [0, *edges.tolist()]
    return tuple(Span(present[top[i]].symbol, *pair) for i, pair in zip(firsts, pairwise(bounds), strict=True))


def least(estimates: Sequence[Estimate], start: float, end: float) -> tuple[float, float] | None:
    """Averaging time and Allan deviation, SI, at the minimum of all terms together; None at an end of the range."""
    present = [e for e in estimates if e.claimed and e.value and lasting(e)]
    tau = np.geomspace(start, end, 2 + math.ceil(POINTS_PER_DECADE * math.log10(end / start)))
    variance = np.sum([_line(e, tau) ** 2 for e in present], axis=0) if present else np.zeros(tau.size)
    at = int(np.argmin(variance))
    return (float(tau[at]), math.sqrt(variance[at])) if 0 < at < tau.size - 1 else None


def _line(estimate: Estimate, tau: FloatArray) -> FloatArray:
    row = TERMS[estimate.symbol]
    if straight(estimate):
        return np.asarray(height(estimate, 1.0) * tau**row.slope)
    term = Term(estimate.symbol, abs(estimate.value or 0.0), estimate.signal, estimate.shape)
    return np.sqrt(expected(term, "adev", tau))


@dataclass(frozen=True, repr=False)
class Meaning(Value):
    """What the coefficients of a record say.

    Attributes
    ----------
    name : str
        Of the channel.
    sentences : tuple of str
        Where white noise and drift dominate, the minimum beside the fitted flicker, systematic and random drift, time
        constants, the grade of a gyroscope. None where the model does not explain the record.
    device : str
        Name in `DEVICES`; empty where none was named.
    symbols : tuple of str
        Terms that were found and are in the device's table.
    note : str
        What must be known to read the table, or why it does not apply.
    """

    name: str
    sentences: tuple[str, ...]
    device: str = ""
    symbols: tuple[str, ...] = ()
    note: str = ""

    @property
    def causes(self) -> dict[str, Cause]:
        """The rows of the device's table for the terms that were found."""
        table = named(self.device).terms if self.device else {}
        return {symbol: table[symbol] for symbol in self.symbols}

    def _summary(self) -> str:
        return f"of {self.name!r}: {len(self.sentences)} sentences{', ' if self.device else ''}{self.device}"


def meaning(
    fit: Fit, readings: Readings | None = None, *, rate: float, length: float, device: str | None = None
) -> Meaning:
    """What the coefficients of a fit say, and what may cause them."""
    texts = sentences(fit, readings, rate=rate, length=length)
    if device is None:
        return Meaning(fit.name, texts)
    row = named(device)
    if fit.signal.name not in row.signals:
        note = say("the table of {device} is about {signals} signals, not about this {sensor}", device=row.title,
                   signals=reduce(lambda first, second: say("{first} or {second}", first=first, second=second),
                                  row.signals),
                   sensor=fit.signal.name)  # fmt: skip
        return Meaning(fit.name, texts, device, (), note)
    symbols = tuple(e.symbol for e in fit if e.claimed and e.symbol in row.terms) if fit.valid is not None else ()
    return Meaning(fit.name, texts, device, symbols, row.note)


HUMP_PERIODS = 0.37  # averaging time of the first hump of a damped oscillation, in its periods


def sentences(fit: Fit, readings: Readings | None = None, *, rate: float, length: float) -> tuple[str, ...]:
    """What the coefficients of a fit say, in sentences; none where its model does not explain the record."""
    if fit.valid is None or not fit.validity:
        return ()
    present = {e.symbol: e for e in fit if e.claimed and e.value}
    return (*_dominating(present, rate, length), *_minimum(fit, readings, rate, length), *_drift(fit, present, length),
            *_time_constants(fit, present), *_grade(readings))  # fmt: skip


def _title(estimate: Estimate) -> str:
    if estimate.signal.name == "gyro" or estimate.symbol not in "KR":
        return title_of(estimate.symbol, estimate.signal)
    return say("random walk") if estimate.symbol == "K" else say("ramp")


def _size(value: float, estimate: Estimate, power: float) -> str:
    """A quantity of the signal times time to the power, in the unit of data sheets."""
    sheet = estimate.signal.sheet[power]
    return say("{size:.3g} {unit}", size=convert(value, estimate.signal.si[power], sheet), unit=sheet)


def _dominating(found: dict[str, Estimate], rate: float, length: float) -> Iterator[str]:
    """Up to which averaging time the noise is white, and from which one it drifts."""
    places = spans(list(found.values()), 1 / rate, length / 2)
    white = next((span for span in places if TERMS[span.symbol].slope == WHITE), None)
    drift = next((span for span in places if TERMS[span.symbol].slope > 0), None)
    parts = [_white(white, found, (1 / rate, length / 2))] if white else []
    if drift is not None:
        title = _title(found[drift.symbol])
        parts.append(say("Drift ({term}) dominates at all averaging times", term=title) if drift.start <= 1 / rate
                     else say("Drift ({term}) dominates from {start} on", term=title,
                              start=averaging(drift.start)))  # fmt: skip
    if parts:
        yield _ended(join(". ", parts))


def _ended(sentence: str) -> str:
    return join("", (sentence, "."))


def _white(span: Span, found: dict[str, Estimate], limits: tuple[float, float]) -> str:
    title, start, end = _title(found[span.symbol]), averaging(span.start), averaging(span.end)
    late = span.start > limits[0]
    if span.end >= limits[1]:
        where = (say("White noise ({term}) dominates from {start} up to half the length of the record", term=title,
                     start=start) if late
                 else say("White noise ({term}) dominates at all averaging times", term=title))  # fmt: skip
        return join(": ", (where, say("averaging reduces the error with the square root of time")))
    where = (say("White noise ({term}) dominates from {start} to {end}", term=title, start=start, end=end) if late
             else say("White noise ({term}) dominates up to {end}", term=title, end=end))  # fmt: skip
    slower = say("beyond that, averaging longer reduces the error more slowly than with the square root of time")
    return join(": ", (where, slower))


def _minimum(fit: Fit, readings: Readings | None, rate: float, length: float) -> Iterator[str]:
    """The minimum of the curve beside the fitted flicker, and what the other terms alone would make of it."""
    if readings is None or readings.minimum is None or not readings.inside:
        return
    flicker = next((e for e in fit if TERMS[e.symbol].slope == 0 and not TERMS[e.symbol].parameters), None)
    if flicker is None:
        return
    stated = say("The minimum of the Allan deviation is {minimum}; divided by 0.664 it would be a B of {flicker}",
                 minimum=readings.lowest_words(),
                 flicker=_size(readings.minimum.deviation * FLICKER, flicker, 0))  # fmt: skip
    if flicker.claimed and flicker.value:
        own = _size(flicker.value, flicker, 0)
        because = say("the identified B is {value}, because the minimum contains the other terms too.", value=own)
        yield join("; ", (stated, because))
    elif flicker.upper is not None:
        parts = [stated, say("flicker was not identified, B is below {limit}", limit=_size(flicker.upper, flicker, 0))]
        lowest = least(fit.estimates, 1 / rate, length / 2)
        if lowest is not None:  # the minimum that the other terms have together, if they have one within the record
            size, at = _size(lowest[1], fit.estimates[0], 0), averaging(lowest[0])
            parts.append(say("the other terms alone make a minimum of {minimum} at {tau}", minimum=size, tau=at))
        yield _ended(join("; ", parts))


def _drift(fit: Fit, found: dict[str, Estimate], length: float) -> Iterator[str]:
    """Whether the drift is systematic, a ramp, or random, a random walk."""
    ramp, walk = found.get("R"), found.get("K")
    if ramp is not None and walk is not None:
        yield say("The drift has a systematic part, R, which changes the output by {systematic} over the record, and a "
                  "random part, K, of {random} (1 sigma); R is larger than K beyond {tau}.",
                  systematic=_over(ramp, length), random=_over(walk, length),
                  tau=averaging(crossing(walk, ramp)))  # fmt: skip
    elif ramp is not None:
        stated = say("The drift is systematic: R changes the output by {change} over the record",
                     change=_over(ramp, length))  # fmt: skip
        yield _ended(join("; ", (stated, *_absent(fit, "K"))))
    elif walk is not None:
        stated = say("The drift is random: K changes the output by {change} (1 sigma) over the record",
                     change=_over(walk, length))  # fmt: skip
        yield _ended(join("; ", (stated, *_absent(fit, "R"))))


def _over(estimate: Estimate, length: float) -> str:
    """What a ramp or a random walk changes over the record."""
    power = -TERMS[estimate.symbol].power  # of time: 1 for a ramp, 1/2 for a random walk
    return _size(abs(estimate.value or 0.0) * length**power, estimate, 0)


def _absent(fit: Fit, symbol: str) -> Iterator[str]:
    """That the other kind of drift was not identified, with its limit."""
    other = next((e for e in fit if e.symbol == symbol), None)
    if other is None or other.status != "absent" or other.upper is None:
        return
    limit = _size(other.upper, other, TERMS[symbol].power)
    yield say("{symbol} was not identified, its size is below {limit}", symbol=symbol, limit=limit)


def _time_constants(fit: Fit, found: dict[str, Estimate]) -> Iterator[str]:
    """The time constants of Gauss-Markov processes, of an oscillation and of a filter."""
    for process in (found[symbol] for symbol in ("GM", "GML") if symbol in found):
        yield say("A Gauss-Markov process with a time constant of {time} was identified: look for a control loop, a "
                  "temperature or a filter with this time constant.", time=averaging(process.shape[0]))  # fmt: skip
    if "GM2" in found:
        frequency, damping = found["GM2"].shape
        yield say("A damped oscillation of {frequency:.3g} Hz with a damping ratio of {damping:.2g} was identified: "
                  "look for a control loop, a resonance or sway with this frequency; it makes a hump near {time}.",
                  frequency=frequency, damping=damping, time=averaging(HUMP_PERIODS / frequency))  # fmt: skip
    if fit.scope is not None and fit.scope.filter is not None:
        cutoff = fit.scope.filter.cutoff
        yield say("A low-pass filter of {cutoff:.3g} Hz was identified (time constant {time:.3g} ms if it is of first "
                  "order): the bandwidth of the sensor, or a filter before the output.", cutoff=cutoff,
                  time=1000 / (2 * math.pi * cutoff))  # fmt: skip


def _grade(readings: Readings | None) -> Iterator[str]:
    """The grade of a gyroscope by its in-run bias stability; if the minimum was not reached, it may be a better one."""
    if readings is None or readings.minimum is None or readings.signal.name != "gyro":
        return
    level = readings.minimum.deviation if readings.inside else readings.minimum.interval(0.95)[1]
    grade = grade_of(convert(level, readings.unit, "deg/h"))
    facts = {"grade": grade, "scale": IN_RUN, "span": bounds_of(grade), "size": readings.lowest_words()}
    text = (say("{grade} by its {scale}, {size} ({span})", **facts) if readings.inside
            else say("{grade} or better by its {scale}, {size} ({span})", **facts))  # fmt: skip
    yield join("; ", (text, say("grades are conventions, and a data sheet needs more than noise.")))
