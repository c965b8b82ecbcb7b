"""The table of units: conversion to SI and back, the data-sheet unit of every noise coefficient, and spellings.

Internally everything is SI: rad, rad/s, m/s, m/s^2, s. Units of inputs and outputs are strings, read by a small
grammar, so that all common spellings work: ``deg/sqrt(h)``, ``deg/h/sqrt(Hz)``, ``°/√h``, ``rad s^-1``, ``dps``,
``ug/rtHz``.
"""

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from allanite.phrases.phrase import say

from .errors import UnitError, UsageError, given
from .names import nearest, row_of
from .ranges import Units
from .syntax import split_quantities

SPELLINGS: dict[str, str] = {
    "°": "deg", "º": "deg", "degree": "deg", "degrees": "deg", "radian": "rad", "radians": "rad",
    "sec": "s", "second": "s", "seconds": "s", "hr": "h", "hrs": "h", "hour": "h", "hours": "h",
    "asec": "arcsec", "as": "arcsec", "micro_g": "ug",
    "dps": "(deg/s)", "mdps": "(mdeg/s)", "dph": "(deg/h)", "rps": "(rad/s)", "mps": "(m/s)",
    "°C": "degC", "ºC": "degC", "degc": "degC", "celsius": "degC", "kelvin": "K", "ampere": "A", "volt": "V",
    "tesla": "T",
}  # fmt: skip

SIGNS = {"√(": "sqrt(", "µ": "u", "μ": "u", "·": "*"}  # signs of units that are no words
RAISED = str.maketrans("-.0123456789", "⁻·⁰¹²³⁴⁵⁶⁷⁸⁹")  # how the letters of a power are printed

_LOWERED = {chr(raised): chr(letter) for letter, raised in RAISED.items()}
_RAISED = re.compile("⁻?[⁰¹²³⁴-⁹]+(?:·[⁰¹²³⁴-⁹]+)?")
_ROOT_SIGN = re.compile(r"√([A-Za-z]+)")

WORDS: dict[str, str] = {
    "угл. сек": "arcsec", "угл.сек": "arcsec", "угл. с": "arcsec", "угл.с": "arcsec", "рад": "rad", "мрад": "mrad",
    "мкрад": "urad", "град": "deg", "°С": "degC", "с": "s", "сек": "s", "мс": "ms", "мкс": "us", "нс": "ns",
    "мин": "min", "ч": "h", "час": "h", "м": "m", "см": "cm", "мм": "mm", "Гц": "Hz", "мg": "mg", "мкg": "ug",
    "弧度": "rad", "毫弧度": "mrad", "度": "deg", "毫度": "mdeg", "角分": "arcmin", "角秒": "arcsec", "秒": "s",
    "毫秒": "ms", "微秒": "us", "纳秒": "ns", "分钟": "min", "小时": "h", "时": "h", "米": "m", "毫g": "mg",
    "微g": "ug", "赫兹": "Hz", "赫": "Hz", "摄氏度": "degC", "℃": "degC", "每": "/", "平方": "^2",
}  # fmt: skip
"""Russian and Chinese words of units. Grams are not among them: мг is a mass, an acceleration is in мg."""

_LETTER = r"[^\W\d_²³]"
_WORD = re.compile(
    "|".join(
        # Chinese writes words without blanks, and a Cyrillic word ends where its letters end
        re.escape(word) if ord(word[0]) > 0x2E00 or word == "℃" else rf"(?<!{_LETTER}){re.escape(word)}(?!{_LETTER})"
        for word in sorted(WORDS, key=len, reverse=True)
    )
)


def latin(text: str) -> str:
    """A unit with its Russian and Chinese words in their Latin spelling; any other text is unchanged."""
    return text if text.isascii() else _WORD.sub(lambda found: WORDS[found[0]], text)


def plain_letters(text: str) -> str:
    """A text with the signs of its units in ASCII; the sign of degrees, which is a word, is unchanged."""
    if text.isascii():
        return text
    text = _ROOT_SIGN.sub(r"sqrt(\1)", text)
    text = _RAISED.sub(lambda found: "^" + "".join(_LOWERED[letter] for letter in found[0]), text)
    for sign, word in SIGNS.items():
        text = text.replace(sign, word)
    return text


Dimension = tuple[float, ...]
"""Powers of the quantities in `BASES`: halves and quarters, which a float represents exactly."""

BASES = ("angle", "length", "time", "current", "voltage", "temperature", "flux density", "pressure")
"""Base quantities of the units. Voltage, flux density and pressure are among them: no unit here needs a mass."""


def _powers(**powers: float) -> Dimension:
    return tuple(float(powers.get(base.replace(" ", "_"), 0)) for base in BASES)


_ANGLE, _LENGTH, _TIME = _powers(angle=1), _powers(length=1), _powers(time=1)
_DEGREE, _GRAVITY = math.pi / 180, 9.80665

_PREFIXES = {"k": 1e3, "h": 1e2, "c": 1e-2, "m": 1e-3, "u": 1e-6, "n": 1e-9}

_BASIC: tuple[tuple[str, float, Dimension, str], ...] = (
    ("rad", 1.0, _ANGLE, "mu"), ("deg", _DEGREE, _ANGLE, "m"), ("arcmin", _DEGREE / 60, _ANGLE, ""),
    ("arcsec", _DEGREE / 3600, _ANGLE, ""), ("rev", 2 * math.pi, _ANGLE, ""), ("m", 1.0, _LENGTH, "cmun"),
    ("g", _GRAVITY, _powers(length=1, time=-2), "mun"), ("Gal", 1e-2, _powers(length=1, time=-2), "m"),
    ("s", 1.0, _TIME, "mun"), ("min", 60.0, _TIME, ""), ("h", 3600.0, _TIME, ""), ("Hz", 1.0, _powers(time=-1), ""),
    ("A", 1.0, _powers(current=1), "mu"), ("V", 1.0, _powers(voltage=1), "mu"), ("K", 1.0, _powers(temperature=1), "m"),
    ("degC", 1.0, _powers(temperature=1), ""),  # of differences: the offset is not part of the unit
    ("T", 1.0, _powers(flux_density=1), "mun"), ("gauss", 1e-4, _powers(flux_density=1), ""),
    ("Pa", 1.0, _powers(pressure=1), "kh"), ("bar", 1e5, _powers(pressure=1), "m"),
)  # fmt: skip
"""Name, size in SI, dimension, and the prefixes that it takes."""

ATOMS: dict[str, tuple[float, Dimension]] = {prefix + name: (_PREFIXES.get(prefix, 1.0) * size, dimension)
                                             for name, size, dimension, prefixes in _BASIC
                                             for prefix in ("", *prefixes)}  # fmt: skip

MAX_LETTERS, MAX_SIZE = 200, 1e60  # letters of a unit, and its size in SI, at most

USUAL = ("deg/s", "deg/h", "rad/s", "mdeg/s", "arcsec", "deg", "rad", "g", "mg", "ug", "m/s^2", "m/s", "deg/sqrt(h)",
         "deg/h/sqrt(Hz)", "deg/s/sqrt(Hz)", "rad/s/sqrt(Hz)", "ug/sqrt(Hz)", "m/s/sqrt(h)")  # fmt: skip
"""Units that messages suggest; any other that is made of `ATOMS` is read, too."""

_ROOT = re.compile(
    r"(?<![A-Za-z])(?:sqrt|root|rt)[-_. ]*"
    r"(?:\((?P<inside>[A-Za-z]+)\)|(?P<bare>hours?|hrs?|h|seconds?|secs?|s|Hz)(?![A-Za-z]))"
)
"""A square root as data sheets write it: rt-hr, rt(h), root-hour, rtHz."""

_BARE_POWER = re.compile(r"(?<=[A-Za-z])(-?[1-9])\b")  # a power as written in headers: m/s2, rad s-1

_TOKEN = re.compile(r"\s*(?:(\d+(?:\.\d*)?(?:[eE][-+]?\d+)?|\.\d+)|([A-Za-z°º_]+)|(\^-|.))")


@dataclass(frozen=True)
class Unit:
    """A unit as its size in SI and its powers of `BASES`."""

    factor: float
    dimension: Dimension

    def __mul__(self, other: "Unit") -> "Unit":
        return Unit(self.factor * other.factor, _add(self.dimension, other.dimension))

    def __pow__(self, power: float) -> "Unit":
        return Unit(self.factor**power, tuple(p * power for p in self.dimension))


def _add(a: Dimension, b: Dimension) -> Dimension:
    return tuple(p + q for p, q in zip(a, b, strict=True))


class _Parser:
    """Recursive descent over ``expression = power (('*' | '/' | nothing) power)*``."""

    def __init__(self, text: str) -> None:
        text = plain_letters(latin(text)).replace("**", "^").replace("mps2", "m/s^2")
        text = _ROOT.sub(lambda root: f"sqrt({root['inside'] or root['bare']})", text)
        text = _BARE_POWER.sub(r"^\1", text)
        self.tokens = [m.group(1) or m.group(2) or m.group(3) for m in _TOKEN.finditer(text.strip())]

    def take(self) -> str:
        return self.tokens.pop(0) if self.tokens else ""

    def expression(self) -> Unit:
        unit = self.power()
        while self.tokens and self.tokens[0] != ")":
            if self.tokens[0] == "/":
                self.take()
                unit = unit * self.power() ** -1.0
            else:
                if self.tokens[0] == "*":
                    self.take()
                unit = unit * self.power()
        return unit

    def power(self) -> Unit:
        unit = self.base()
        if self.tokens and self.tokens[0] in ("^", "^-"):
            sign = -1 if self.take() == "^-" else 1
            unit = unit ** (sign * float(self.take()))
        return unit

    def base(self) -> Unit:
        word = self.take()
        if word in ("sqrt", "("):
            if word == "sqrt" and self.take() != "(":
                raise ValueError
            unit = self.expression()
            if self.take() != ")":
                raise ValueError
            return unit**0.5 if word == "sqrt" else unit
        if word == "1":
            return Unit(1.0, _powers())
        for key in (word, word.lower()):
            if key in ATOMS:
                return Unit(*ATOMS[key])
            if key in SPELLINGS:
                return _Parser(SPELLINGS[key]).expression()
        raise ValueError(word)


@lru_cache(maxsize=1024)
def unit_of(text: str) -> Unit:
    """Read a unit; a UnitError suggests one if a part of `text` is unknown.

    >>> round(unit_of("deg/h").factor, 12), unit_of("rad/sqrt(s)") == unit_of("rad/s/sqrt(Hz)")
    (4.848137e-06, True)
    """
    try:
        if len(text) > MAX_LETTERS:
            raise ValueError(text)
        parser = _Parser(text)
        unit = parser.expression()
        if parser.tokens or not 1 / MAX_SIZE < unit.factor < MAX_SIZE:
            raise ValueError(text)
    except (ValueError, ZeroDivisionError, OverflowError, RecursionError):
        rooted = bool(re.search("rt|root|√", text))  # a density is never meant by a rate, nor the other way round
        alike = [unit for unit in USUAL if ("sqrt" in unit) == rooted]
        meant = nearest(text[:MAX_LETTERS], alike)
        words = f"did you mean {meant}?" if meant else f"units are written as {', '.join(alike)}"
        raise UnitError(f"unknown unit {given(text)}; {words}", cure=(text, meant) if meant else ("", "")) from None
    return unit


def convert(value: float, unit: str, to: str) -> float:
    """`value` of `unit` in `to`.

    >>> convert(1.0, "deg/sqrt(h)", "deg/h/sqrt(Hz)")
    60.0
    """
    source, target = unit_of(unit), unit_of(to)
    if source.dimension != target.dimension:
        raise UnitError(f"{unit!r} cannot be converted to {to!r}: their dimensions differ")
    return value * (source.factor / target.factor)


A_DURATION = "a time in s such as 600, or '10 min' or 1h"


def seconds_of(text: Any) -> float:
    """Seconds of ``600``, ``10 min`` or ``1h``; days are ``d``."""
    try:
        if isinstance(text, (int, float)):
            return float(text)
        ((value, unit),) = split_quantities(str(text).split())
        seconds = 86400 * value if unit == "d" else convert(value, unit or "s", "s")
    except (ValueError, OverflowError):
        seconds = 0.0
    if not seconds > 0:
        raise UsageError(f"expected {A_DURATION}, not {given(text)}")
    return seconds


@dataclass(frozen=True)
class Signal:
    """A type of sensor output: its SI unit, what it, its integral and its sensor are called, and its other units.

    `sensor` is the name of the sensor, `a_sensor` the same with its article. `si` and `sheet` are the SI and data-sheet
    units of signal x time^p by the power p.

    `inertial`: the output of a gyro or accelerometer; the other types are recorded along with them, or converted to a
    rate. `density` are the units in which data sheets give the amplitude spectral density of white noise. `kind` is
    the kind of records of its samples: "value" if only that kind says that the signal is meant, because its unit is
    also that of something else, as an angle's is that of an integrated rate.
    """

    name: str
    unit: str
    quantity: str
    integral: str
    sensor: str
    a_sensor: str
    si: Units
    sheet: Units
    inertial: bool = False
    density: tuple[str, ...] = ()
    kind: str = "rate"

    @property
    def dimension(self) -> Dimension:
        """Powers of `BASES` of the signal."""
        return unit_of(self.unit).dimension

    def __reduce__(self) -> "tuple[Callable[[str], Signal], tuple[str]]":
        """The row of `SIGNALS` by its name, so that unpickling returns the row itself."""
        return signal_named, (str(self.name),)


def _plain(name: str, unit: str, sensor: tuple[str, str], *, sheet: str = "", named: dict[float, str] | None = None,
           kind: str = "rate") -> Signal:  # fmt: skip
    """A signal that is called as its quantity, and whose noise has the units of `sheet` times time."""
    si, shown = (Units(u, "s", named) for u in (unit, sheet or unit))
    integral = say("integrated {quantity}", quantity=name)
    density = (f"{sheet or unit}/sqrt(Hz)",)
    return Signal(name, unit, name, integral, *sensor, si, shown, density=density, kind=kind)


SIGNALS = (
    Signal(
        say("gyro"), "rad/s", say("rate"), say("angle"), say("gyroscope"), say("a gyroscope"), Units("rad/s"),
        Units("deg/h", "h", {1: "arcsec", -0.5: "deg/h/sqrt(h)"}), inertial=True,
        density=("deg/s/sqrt(Hz)", "deg/h/sqrt(Hz)"),
    ),
    Signal(
        say("accelerometer"), "m/s^2", say("acceleration"), say("velocity"), say("accelerometer"),
        say("an accelerometer"), Units("m/s^2"), Units("ug", "h", {1: "m/s", 0.5: "m/s/sqrt(h)"}), inertial=True,
        density=("ug/sqrt(Hz)", "m/s^2/sqrt(Hz)"),
    ),
    Signal(
        say("dimensionless"), "1", say("signal"), say("time"),
        say("sensor of a dimensionless signal"), say("a sensor of a dimensionless signal"), Units("1"), Units("1"),
    ),
    _plain(say("current"), "A", (say("current sensor"), say("a current sensor"))),
    _plain(say("voltage"), "V", (say("voltmeter"), say("a voltmeter"))),
    _plain(say("temperature"), "K", (say("thermometer"), say("a thermometer"))),
    _plain(say("displacement"), "m", (say("displacement sensor"), say("a displacement sensor"))),
    _plain(say("flux density"), "T", (say("magnetometer"), say("a magnetometer"))),
    _plain(say("pressure"), "Pa", (say("pressure sensor"), say("a pressure sensor"))),
    _plain(say("angle"), "rad", (say("measured angle"), say("a measured angle")), sheet="arcsec", kind="value"),
    _plain(say("velocity"), "m/s", (say("measured velocity"), say("a measured velocity")), kind="value"),
    _plain(say("time"), "s", (say("measured time"), say("a measured time")), kind="value"),
    _plain(
        say("frequency"), "Hz", (say("measured frequency"), say("a measured frequency")),
        named={1: "1", 0.5: "1/sqrt(s)"}, kind="value",
    ),
)  # fmt: skip


def signal_named(name: str) -> Signal:
    """The row of `SIGNALS` called `name`; an unknown one is a UsageError."""
    return row_of("quantity", name, {signal.name: signal for signal in SIGNALS})


def signal_with(dimension: Dimension, time_power: float = 0, *, values: bool = False) -> Signal | None:
    """The signal that, multiplied by time to the power `time_power`, has `dimension`; None if there is none.

    With `values` it may be one that only the kind "value" means.
    """
    wanted = _add(dimension, _powers(time=-time_power))
    match = next((signal for signal in SIGNALS if signal.dimension == wanted), None)
    return match if match is None or values or match.kind != "value" else None
