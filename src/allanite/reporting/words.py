"""The sentences that stand in the table, the page and the figures."""

import math

import numpy as np

from allanite.core.fit import Estimate
from allanite.core.model import coefficient_factor
from allanite.core.record import Header, Record
from allanite.core.units import Signal, convert
from allanite.study.analysis import Channel
from allanite.terms import TERMS

from .digits import Digits, digits
from .sheet import printable, printed_unit

SENSORS = {
    "gyro": "gyroscope",
    "accelerometer": "accelerometer",
    "dimensionless": "sensor of a dimensionless signal",
    "current": "current sensor",
    "voltage": "voltmeter",
    "temperature": "thermometer",
    "displacement": "displacement sensor",
    "flux density": "magnetometer",
}
RATES = {"gyro": "rate", "accelerometer": "acceleration", "dimensionless": "signal"} | {
    name: name for name in ("current", "voltage", "temperature", "displacement", "flux density")
}

LETTERS = {"time_constant": "T", "frequency": "f", "phase": "phase"}
"""Of what a term has beside its coefficient."""

STATUS = {
    "identified": "found, relative standard error at most 25 %",
    "weak": "found, but its relative standard error is above 25 %: an order of magnitude, not a number to specify",
    "absent": "not found; the limit is the one-sided 95 % upper limit",
    "reported": "by a method that gives no evidence for the term: the number may stand for nothing",
}
"""What each status means."""


def title(symbol: str, signal: Signal) -> str:
    """The name of a term in the words of its sensor: an accelerometer has a velocity random walk."""
    words = TERMS[symbol].title.replace("rate", RATES[signal.name])
    return words.replace("angle", signal.integral)


def named(estimate: Estimate, level: float) -> str:
    """The name of an estimate's term, and its shape if it has one."""
    return ", ".join((title(estimate.symbol, estimate.signal), *shapes(estimate, level)))


def shapes(estimate: Estimate, level: float) -> list[str]:
    """What an estimate has beside its coefficient: ``T = 20 (15 .. 28) s``."""
    limits = estimate.shape_limits(level) if estimate.shape_limits else ((math.nan, math.nan),) * len(estimate.shape)
    parts = []
    for parameter, value, (low, high) in zip(TERMS[estimate.symbol].parameters, estimate.shape, limits, strict=False):
        number, interval = digits(value, low, high).plain()
        parts.append(f"{LETTERS[parameter.name]} = {number}{f' ({interval})' if interval else ''} {parameter.unit}")
    return parts


def shown(estimate: Estimate, unit: str, level: float) -> Digits | None:
    """The value and its interval in `unit`, rounded; None where there is no value."""
    if estimate.value is None:
        return None
    factor = coefficient_factor(estimate.symbol, unit, estimate.signal)
    low, high = (v / factor for v in estimate.interval(level))
    return digits(estimate.value / factor, low, high, signed=TERMS[estimate.symbol].waveform is not None)


def limit(estimate: Estimate, unit: str) -> Digits | None:
    """The upper limit of a term without a value in `unit`; None where there is none."""
    if estimate.upper is None:
        return None
    return digits(estimate.upper / coefficient_factor(estimate.symbol, unit, estimate.signal), figures=2)


def below(estimate: Estimate) -> str:
    """The word before a limit: a ramp has a sign, its size is limited."""
    return "below" if TERMS[estimate.symbol].waveform is None else "size below"


def in_print(estimate: Estimate, unit: str, level: float) -> str:
    """A coefficient as printed: ``0.310 (0.302 … 0.318) deg/√h`` or ``below 2.1 deg/h``."""
    number, most = shown(estimate, unit, level), limit(estimate, unit)
    if number is not None:
        return f"{number.pretty()} {printed_unit(unit)}"
    return f"{below(estimate)} {most.pretty()} {printed_unit(unit)}" if most else ""


def duration(seconds: float) -> str:
    """A length of time.

    Examples
    --------
    >>> duration(42), duration(5400), duration(200_000)
    ('42 s', '1.5 h', '2.31 d')
    """
    for size, unit, least in ((86400.0, "d", 172800.0), (3600.0, "h", 3600.0), (60.0, "min", 120.0), (1.0, "s", 0.0)):
        if seconds >= least:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds:.3g} s"


def about(record: Record | Header) -> str:
    """What a channel holds: ``gyroscope, rate in deg/h, 100 Hz, 360000 readings, 1 h``."""
    sensor = SENSORS[record.signal.name]
    scale = "" if record.scale is None else f"{record.scale:g} "
    length = duration(record.duration)
    kind = RATES[record.signal.name] if record.kind == "rate" and not record.signal.inertial else record.kind
    return f"{sensor}, {kind} in {scale}{record.unit}, {record.rate:.8g} Hz, {record.size} readings, {length}"


def fitness(channel: Channel) -> str:
    """Mean and spread of a channel, and that it may be analysed if it may."""
    record = channel.record
    unit = record.signal.sheet[0]
    values = record.rate_values / convert(1.0, unit, record.signal.unit)
    facts = f"mean {np.nanmean(values):.6g}, standard deviation {np.nanstd(values):.4g} {unit}"
    return (
        facts if channel.refusal else f"{facts}; fit for the job" + (", with care" if channel.quality.warnings else "")
    )


def alerts(channel: Channel) -> list[str]:
    """What must stand above the numbers of a channel: its warnings, and that the model does not explain it."""
    # what the residuals name is not said twice; sinusoids that were taken out are said with the goodness of fit
    settled = {finding.name for finding in channel.residuals.findings} if channel.residuals else set()
    settled |= {"lines"} if channel.fit and channel.fit.lines and channel.explained else set()
    found = [str(finding) for finding in channel.quality.warnings if finding.name not in settled]
    if channel.fit is not None and not channel.explained:
        found.insert(0, channel.verdict)
    return found


def verdict(channel: Channel, level: float) -> str:
    """What the sensor is, in one or two plain sentences."""
    name = printable(channel.record.name) or "the channel"
    if channel.fit is None:
        return f"{name} gives no result: {channel.refusal or 'nothing was fitted'}."
    found, absent = [], []
    for e in channel.fit:
        if e.value is None:
            absent.append(title(e.symbol, e.signal))
        else:
            found.append(_found(e, level))
    sensor = SENSORS[channel.record.signal.name]
    start = f"{name} is {'an' if sensor[0] in 'aeiou' else 'a'} {sensor}"
    first = f"{start} with {_join(found)}." if found else f"{start} of which no noise term was identified."
    length = duration(channel.record.duration)
    missing = f" Not identified in {length} of data: {', '.join(absent)}." if absent else ""
    doubt = "" if channel.explained else f"The model does not explain {name}: do not quote its numbers. "
    return doubt + first + missing


def _found(estimate: Estimate, level: float) -> str:
    number = shown(estimate, estimate.sheet_unit, level)
    assert number is not None  # noqa: S101 - asked for values only
    weak = " (weak)" if estimate.status == "weak" else ""
    value = number.value.replace("-", "−") + number.power
    return f"{named(estimate, level)} {value} {printed_unit(estimate.sheet_unit)}{weak}"


def _join(parts: list[str]) -> str:
    return " and ".join(filter(None, (", ".join(parts[:-1]), parts[-1])))


def percent(level: float) -> str:
    """A confidence level: ``95 %``."""
    return f"{100 * level:.6g} %" if math.isfinite(level) else ""
