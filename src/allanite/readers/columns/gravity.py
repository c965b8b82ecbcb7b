"""Gravity and noise as a check of units: three axes at rest have its length, and no gyro is noisier than others."""

import math
import re
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from allanite.core.arrays import complete
from allanite.core.errors import UNIT
from allanite.core.units import unit_of
from allanite.core.validity import Finding
from allanite.phrases.phrase import Phrase, join, say, spelled

from . import conventions, headers
from .channels import SignalColumn
from .column import FileColumn, some

RATES: tuple[str, ...] = ("g", "m/s^2", "mg", "mm/s^2")
INCREMENTS: tuple[str, ...] = ("g*s", "m/s")  # units in which loggers write accelerations, and velocity increments
COUNTS = (1024, 8192)  # counts per g of common sensors that are near a thousand mg or 9810 mm/s^2

NAMED = 0.25
"""Share by which accelerometers at rest may miss gravity, by their offsets and scale factors: units are ten apart."""

UNNAMED = 0.05  # the same for columns that nothing but their length makes accelerometers
DOUBTED = 0.1  # the same for axes with a unit, beyond which it is doubted
STILL = 0.02  # standard deviation of an axis at rest, relative to gravity, at most
REMOVED = 0.1  # length, relative to gravity, below which it is no gravity at all

NOISIEST, QUIETEST = 10.0, 1e-5 / 60
"""White noise of any gyro, from the best ring lasers up, deg/s/sqrt(Hz)."""

EARTH, NEAR_EARTH = 15.041, 0.04  # rate of the earth, deg/h, and the share up to which a mean rate is taken for it
BLOCKS = (1, 4, 16, 64, 256)  # samples that are averaged to see the noise of a filtered gyro
FEWEST = 1024  # samples, at least, by which it is judged
FIRST = 1 << 18  # samples by which they are judged, about

_AXIS = re.compile(r"(?<![a-z])[xyz123](?![a-z0-9])|(?<=[a-z])[xyz123]$")
"""The axis in a name: ``rate x``, ``x_rate``, ``rateX``, ``rate[1]``."""


def triples(columns: Sequence[FileColumn]) -> list[list[FileColumn]]:
    """Each three columns whose names differ by the letter or the number of an axis only."""
    stems: dict[str, list[FileColumn]] = {}
    for column in (column for column in columns if column.header):
        stems.setdefault(_AXIS.sub("", column.name.strip().lower()), []).append(column)
    return [three for three in stems.values() if len(three) == 3]


def length_of(columns: Sequence[FileColumn]) -> float:
    """The length of the mean of three axes, 0 if there is none."""
    if len(columns) != 3:
        return 0.0
    with np.errstate(all="ignore"):  # of numbers that are no samples
        length = math.hypot(*(float(np.mean(_some_of(column))) for column in columns))
    return length if 0 < length < math.inf else 0.0


def at_rest(columns: Sequence[FileColumn], length: float) -> bool:
    """Whether axes are at rest if this length of their mean is gravity."""

    def spread(values: NDArray[Any]) -> float:
        # of a normal distribution, without outliers
        return 1.5 * float(np.median(np.abs(values - np.median(values))))

    with np.errstate(all="ignore"):
        return length > 0 and all(spread(_some_of(column)) < STILL * length for column in columns)


def _some_of(column: FileColumn) -> NDArray[Any]:
    return column.values[:: max(1, len(column.values) // FIRST)]


def weighed(columns: Sequence[FileColumn], known: Sequence[str], rate: float, share: float) -> tuple[str, str]:
    """The unit in which three means, times a rate, have the length of gravity within a share, and why; or none."""
    length = length_of(columns)
    if not length * rate or (share <= UNNAMED and not at_rest(columns, length)):
        return "", ""
    whole = all(column.values.dtype.kind == "i" for column in columns)
    unit, off = _nearest(length * rate, known)
    if off > math.log1p(share) or (whole and any(abs(length / count - 1) < UNNAMED for count in COUNTS)):
        return "", ""
    return unit, say("the mean has the length of gravity in {unit} ({length:.4g})", unit=unit, length=length * rate)


def _nearest(length: float, known: Sequence[str]) -> tuple[str, float]:
    """The unit in which a length is nearest to gravity, and the logarithm of their ratio."""
    off = {unit: abs(math.log(length * unit_of(unit).factor / unit_of("g").factor)) for unit in known}
    return min(off.items(), key=lambda item: item[1])


class Doubt(NamedTuple):
    """Signals whose numbers contradict their unit: what they show, the unit that would fit, and the sensor."""

    columns: tuple[FileColumn, ...]
    what: Phrase
    unit: str
    sensor: str

    def finding(self) -> Finding:
        """The warning."""
        words = f"{self.sensor}={self.unit}"
        effect = say("if the unit or the scale is wrong, so are the coefficients, by the same factor")
        option = "" if self.unit == UNIT else spelled(f"--unit {words}", f"unit={words!r}")
        remedy = say("check the unit: {option}", option=option) if option else say("check the unit and the scale")
        return Finding("unit", self.what, effect, remedy)


def doubts(signals: Sequence[SignalColumn], rate: float) -> Iterator[Doubt]:
    """The doubts about the units of signals at a rate in Hz."""
    gyros, accelerometers = _inertial(signals, "rate", "increment")
    axes = {signal.column: signal for signal in accelerometers}
    for three in [list(axes)] if len(axes) == 3 else triples(list(axes)):
        yield from _of_gravity(three, axes[three[0]], rate)
    yield from _of_noise(gyros, rate)


def _inertial(signals: Sequence[SignalColumn], *kinds: str) -> Iterator[list[SignalColumn]]:
    """Those of gyros, and those of accelerometers, whose samples are of these kinds."""
    sensors = [(headers.inertial(signal.unit), signal) for signal in signals if signal.kind in kinds]
    for name in ("gyro", "accelerometer"):
        yield [signal for sensor, signal in sensors if sensor is not None and sensor.name == name]


def earth(signals: Sequence[SignalColumn], rate: float) -> Iterator[Phrase]:
    """A note where three gyros that are quiet enough show the rate of the earth, with its angle to gravity."""
    gyros, axes = _inertial(signals, "rate", "increment", "count")
    if len(gyros) != 3:
        return
    means = [_mean_of(signal, "deg/h", rate) for signal in gyros]
    length = math.hypot(*means)
    if not abs(length / EARTH - 1) < NEAR_EARTH:
        return
    noise = max(_noise_of(signal, rate)[0] * 3600 for signal in gyros) / math.sqrt(len(gyros[0].column.values) / rate)
    if not 0 < noise < NEAR_EARTH * EARTH:
        return
    yield say("the mean rate of the gyros has a length of {length:.4g} deg/h; that of the earth is {earth:g} deg/h",
              length=length, earth=EARTH)  # fmt: skip
    if len(axes) == 3 and at_rest(columns := [signal.column for signal in axes], length_of(columns)):
        up = [_mean_of(signal, "g", rate) for signal in axes]
        sine = sum(x * y for x, y in zip(means, up, strict=True)) / length / math.hypot(*up)
        yield say("the angle between the rate of the earth and gravity is that at a latitude of {latitude:.3g} deg",
                  latitude=math.degrees(math.asin(min(max(sine, -1.0), 1.0))))  # fmt: skip


def _mean_of(signal: SignalColumn, unit: str, rate: float) -> float:
    """The mean of a signal as a rate in a unit; NaN where there is none."""
    values, size = signal.column.values, (signal.scale or 1.0) * unit_of(signal.unit).factor / unit_of(unit).factor
    with np.errstate(all="ignore"):  # of numbers that are no samples
        mean = float(np.mean(values))
        if not math.isfinite(mean):
            known = values[np.isfinite(values)]
            mean = float(np.mean(known)) if known.size else math.nan
    return mean * size * (1.0 if signal.kind == "rate" else rate)


def contradiction(signals: Sequence[SignalColumn], doubted: Sequence[Doubt]) -> tuple[Phrase, str] | None:
    """What contradicts the units that conventions define, and the units to type instead; None if nothing does."""
    known = {doubt: conventions.convention_of(doubt.columns[0]) for doubt in doubted}
    wrong = {doubt: convention for doubt, convention in known.items() if convention is not None}
    if not wrong:
        return None
    # if one unit is not that of the definition, the other may not be, either, unless gravity has shown it
    gyros = [signal for signal in signals if headers.signal_of(signal.unit) is headers.signal_of("rad/s")]
    units = ({"gyro": UNIT} if gyros else {}) | {doubt.sensor: doubt.unit for doubt in wrong}
    families = ", ".join(sorted({convention.family for convention in wrong.values()}))
    why = say("this contradicts the unit that {family} defines; state the unit", family=families)
    stated = ",".join(f"{name}={unit}" for name, unit in units.items())
    return join("; ", (*(doubt.what for doubt in wrong), why)), stated


def _of_gravity(three: Sequence[FileColumn], signal: SignalColumn, rate: float) -> Iterator[Doubt]:
    """A doubt about three accelerometer axes at rest whose mean does not have the length of gravity."""
    mean = length_of(three)
    length = mean * (signal.scale or 1.0) * (rate if signal.kind == "increment" else 1.0)
    ratio = length * unit_of(signal.unit).factor / unit_of("g").factor
    if abs(ratio - 1) <= DOUBTED or not at_rest(three, mean):
        return
    fit, off = _nearest(length, INCREMENTS if signal.kind == "increment" else RATES)
    fits = off < math.log1p(NAMED) and unit_of(fit).factor != unit_of(signal.unit).factor
    if not fits and ratio < REMOVED:
        return
    what = say("{columns}: at rest the mean has a length of {length:.4g} {unit}, which is {ratio:.3g} times gravity",
               columns=_names(three), length=length, unit=signal.unit, ratio=ratio)  # fmt: skip
    what = say("{what}, and is gravity in {unit}", what=what, unit=fit) if fits else what
    yield Doubt(tuple(three), what, fit if fits else UNIT, "accel")


def _names(columns: Sequence[FileColumn]) -> Phrase:
    return some([repr(column.header or column.name) for column in columns], 6)


def _of_noise(signals: Sequence[SignalColumn], rate: float) -> Iterator[Doubt]:
    """A doubt about gyros all of which are noisier than any sensor, or quieter."""
    levels = [_noise_of(signal, rate) for signal in signals]
    if not levels or not all(most for _, most in levels):
        return
    loud, quiet = min(levels)[0] > NOISIEST, max(most for _, most in levels) < QUIETEST
    if not loud and not quiet:
        return
    level, columns = NOISIEST if loud else QUIETEST, tuple(signal.column for signal in signals)
    limit = f"> {level:.2g} deg/s/sqrt(Hz)" if loud else f"< {level:.2g} deg/s/sqrt(Hz)"
    what = say("{columns}: in {unit} the white noise is {limit}, beyond that of any gyro",
               columns=_names(columns), unit=signals[0].unit, limit=limit)  # fmt: skip
    yield Doubt(columns, what, UNIT, "gyro")


def _noise_of(signal: SignalColumn, rate: float) -> tuple[float, float]:
    """The white noise by the differences of samples and of means of several, least and most, deg/s/sqrt(Hz)."""
    values = np.asarray(signal.column.values[:FIRST], np.float64)
    size = (signal.scale or 1.0) * unit_of(signal.unit).factor / unit_of("deg/s").factor
    size *= 1.0 if signal.kind == "rate" else rate
    levels = list[float]()
    for block in BLOCKS:
        with np.errstate(all="ignore"):  # of numbers that are no samples
            means = values[: values.size // block * block].reshape(-1, block).mean(axis=1) if block > 1 else values
            steps = np.diff(means)
            steps = steps if complete(steps) else steps[np.isfinite(steps)]
            if steps.size > FEWEST // BLOCKS[-1]:
                levels.append(float(np.std(steps)) * math.sqrt(block / rate / 2) * size)
    judged = len(signal.column.values) >= FEWEST and bool(levels) and math.isfinite(sum(levels))
    return (min(levels), max(levels)) if judged else (0.0, 0.0)
