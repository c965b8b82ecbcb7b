"""What a result says in sentences, each computed from coefficients that were found."""

import math
from collections.abc import Iterator

from allanite.core.estimate import Estimate
from allanite.core.fit import Fit
from allanite.core.readings import FLICKER, Readings
from allanite.core.units import convert
from allanite.core.wording import duration
from allanite.terms import TERMS, WHITE

from .asymptotes import Span, crossing, least, spans
from .grades import BY_MINIMUM, BY_RANDOM_WALK


def sentences(fit: Fit, readings: Readings | None = None, *, rate: float, length: float) -> tuple[str, ...]:
    """What the coefficients of a fit say, in sentences; none where its model does not explain the record.

    Parameters
    ----------
    fit : Fit
    readings : Readings, optional
        What was read off the curve of the same record.
    rate, length : float
        Sampling rate, Hz, and length of the record, s.

    Examples
    --------
    >>> import numpy as np
    >>> from allanite.core.model import N, R
    >>> from allanite.identification import identify
    >>> from allanite.simulation.record import simulate
    >>> model = N(0.1, "deg/sqrt(h)") + R(3000.0, "deg/h^2")
    >>> record = simulate(model, 6000, 10.0, rng=np.random.default_rng(1))
    >>> sentences(identify(record), rate=10.0, length=600.0)[0]  # doctest: +ELLIPSIS
    'White noise (angle random walk) dominates up to 4.66 s: averaging longer reduces the error more slowly ...'
    """
    if fit.valid is None or not fit.validity:
        return ()
    found = {e.symbol: e for e in fit if e.claimed and e.value}
    parts = [
        *_dominating(found, rate, length),
        *_minimum(fit, readings, rate, length),
        *_drift(fit, found, length),
        *_time_constants(fit, found),
        *_grades(found, readings),
    ]
    return tuple(part[:1].upper() + part[1:] for part in parts)


def _title(estimate: Estimate) -> str:
    from_angle = TERMS[estimate.symbol].title.replace("angle", estimate.signal.integral)
    return from_angle if estimate.signal.name == "gyro" else from_angle.replace("rate ", "")


def _size(value: float, estimate: Estimate, power: float) -> str:
    """A quantity of the signal times time to the power, in the unit of data sheets."""
    sheet = estimate.signal.sheet[power]
    return f"{convert(value, estimate.signal.si[power], sheet):.3g} {sheet}"


def _dominating(found: dict[str, Estimate], rate: float, length: float) -> Iterator[str]:
    """Up to which averaging time the noise is white, and from which one it drifts."""
    places = spans(list(found.values()), 1 / rate, length / 2)
    white = next((span for span in places if TERMS[span.symbol].slope == WHITE), None)
    drift = next((span for span in places if TERMS[span.symbol].slope > 0), None)
    parts = [_white(white, found, (1 / rate, length / 2))] if white else []
    if drift is not None:
        where = "at all averaging times" if drift.start <= 1 / rate else f"from {duration(drift.start)} on"
        parts.append(f"drift ({_title(found[drift.symbol])}) dominates {where}")
    if parts:
        yield ". ".join(part[:1].upper() + part[1:] for part in parts) + "."


def _white(span: Span, found: dict[str, Estimate], limits: tuple[float, float]) -> str:
    title = f"white noise ({_title(found[span.symbol])}) dominates"
    start = f"from {duration(span.start)} " if span.start > limits[0] else ""
    if span.end >= limits[1]:
        where = f"{start}up to half the length of the record" if start else "at all averaging times"
        return f"{title} {where}: averaging reduces the error with the square root of time"
    to = "to" if start else "up to"
    slower = "averaging longer reduces the error more slowly than with the square root of time"
    return f"{title} {start}{to} {duration(span.end)}: {slower}"


def _minimum(fit: Fit, readings: Readings | None, rate: float, length: float) -> Iterator[str]:
    """The minimum of the curve beside the fitted flicker, and what the other terms alone would make of it."""
    if readings is None or readings.minimum is None or not readings.inside:
        return
    flicker = next((e for e in fit if TERMS[e.symbol].slope == 0 and not TERMS[e.symbol].parameters), None)
    if flicker is None:
        return
    tau, level = readings.minimum.tau, readings.minimum.deviation
    said = (
        f"the minimum of the Allan deviation is {_size(level, flicker, 0)} at {duration(tau)}; divided by 0.664 it "
        f"would be a B of {_size(level * FLICKER, flicker, 0)}"
    )
    if flicker.claimed and flicker.value:
        own = _size(flicker.value, flicker, 0)
        yield f"{said}; the identified B is {own}, because the minimum contains the other terms too."
    elif flicker.upper is not None:
        made = _made(fit, rate, length)
        yield f"{said}; flicker was not identified, B is below {_size(flicker.upper, flicker, 0)}{made}."


def _made(fit: Fit, rate: float, length: float) -> str:
    """The minimum that the other terms have together, if they have one within the record."""
    lowest = least(fit.estimates, 1 / rate, length / 2)
    if lowest is None:
        return ""
    tau, level = lowest
    return f"; the other terms alone make a minimum of {_size(level, fit.estimates[0], 0)} at {duration(tau)}"


def _drift(fit: Fit, found: dict[str, Estimate], length: float) -> Iterator[str]:
    """Whether the drift is systematic, a ramp, or random, a random walk."""
    ramp, walk = found.get("R"), found.get("K")
    if ramp is not None and walk is not None:
        yield (
            f"the drift has a systematic part, R, which changes the output by {_over(ramp, length)} over the record, "
            f"and a random part, K, of {_over(walk, length)} (1 sigma); R is larger than K beyond "
            f"{duration(crossing(walk, ramp))}."
        )
    elif ramp is not None:
        other = _absent(fit, "K")
        yield f"the drift is systematic: R changes the output by {_over(ramp, length)} over the record{other}."
    elif walk is not None:
        other = _absent(fit, "R")
        yield f"the drift is random: K changes the output by {_over(walk, length)} (1 sigma) over the record{other}."


def _over(estimate: Estimate, length: float) -> str:
    """What a ramp or a random walk changes over the record."""
    power = -TERMS[estimate.symbol].power  # of time: 1 for a ramp, 1/2 for a random walk
    return _size(abs(estimate.value or 0.0) * length**power, estimate, 0)


def _absent(fit: Fit, symbol: str) -> str:
    """That the other kind of drift was not identified, with its limit."""
    other = next((e for e in fit if e.symbol == symbol), None)
    if other is None or other.status != "absent" or other.upper is None:
        return ""
    return f"; {symbol} was not identified, its size is below {_size(other.upper, other, TERMS[symbol].power)}"


def _time_constants(fit: Fit, found: dict[str, Estimate]) -> Iterator[str]:
    """The time constant of a Gauss-Markov process or of a filter."""
    process = found.get("GM")
    if process is not None and process.shape:
        yield (
            f"a Gauss-Markov process with a time constant of {duration(process.shape[0])} was identified: look for a "
            "control loop, a temperature or a filter with this time constant."
        )
    if fit.scope is not None and fit.scope.filter is not None:
        cutoff = fit.scope.filter.cutoff
        time = f"{1000 / (2 * math.pi * cutoff):.3g} ms"
        yield (
            f"a low-pass filter of {cutoff:.3g} Hz was identified (time constant {time} if it is of first order): the "
            "bandwidth of the sensor, or a filter before the output."
        )


def _grades(found: dict[str, Estimate], readings: Readings | None) -> Iterator[str]:
    """The grade of a gyroscope by in-run bias stability and by angle random walk."""
    parts = []
    if readings is not None and readings.minimum is not None and readings.signal.name == "gyro":
        level = readings.minimum.deviation if readings.inside else readings.minimum.interval(0.95)[1]
        size = convert(level, readings.unit, BY_MINIMUM.unit)
        grade = BY_MINIMUM.of(size, BY_MINIMUM.unit)
        better = "" if readings.inside else " or better"
        parts.append(
            f"{grade.name} grade{better} by its {BY_MINIMUM.title} ({BY_MINIMUM.words(grade)}: "
            f"{'' if readings.inside else 'below '}{size:.3g})"
        )
    white = found.get("N")
    if white is not None and white.signal.name == "gyro":
        size = white.to(BY_RANDOM_WALK.unit)
        grade = BY_RANDOM_WALK.of(size, BY_RANDOM_WALK.unit)
        parts.append(f"{grade.name} grade by its {BY_RANDOM_WALK.title} ({BY_RANDOM_WALK.words(grade)}: {size:.3g})")
    if parts:
        yield f"{', and '.join(parts)}; grades are conventions, and a data sheet needs more than noise."
