"""The sampling rate in the lines above the numbers: ``Sample rate: 100 Hz``, ``fs = 100``, ``采样间隔: 10 ms``."""

import re
from collections.abc import Iterable
from typing import NamedTuple

from allanite.core.units import unit_of
from allanite.phrases.phrase import Phrase, join, say

from . import headers

_RATE = (
    r"sampl(?:e|ing)[ _-]?(?:rate|freq(?:uency|\.)?)|(?:output|imu)[ _]data[ _]rate|odr"
    r"|update[ _](?:rate|freq(?:uency)?)|частота\s+(?:дискретизации|опроса|выборки|регистрации|измерений|съ[её]ма)"
    "|采样(?:频率|速率|率)|更新(?:率|频率)|输出频率"
)
_INTERVAL = (
    r"sampl(?:e|ing)[ _-]?(?:interval|period|time)|time[ _]?step"
    r"|(?:период|интервал|шаг)\s+(?:дискретизации|опроса|выборки)"
    "|采样(?:间隔|周期|时间)"
)
_STATED = re.compile(
    rf"(?:^|[^\w])(?:(?P<rate>{_RATE}|(?-i:[Ff]s))|(?P<interval>{_INTERVAL}))\s*(?:[\[(（,]\s*(?P<before>[^\W\d]+)\s*[\])）]?)?"
    r"[\s\"':=：,;]+(?P<number>\d+(?P<fraction>[.,]\d+)?(?:e[-+]?\d+)?)[\s\"',;]*(?P<after>[^\W\d]+(?:/[^\W\d]+)?)?(?![\w.,%]*\d|[/-])",
    re.IGNORECASE,
)
_SCOPE = re.compile(
    r"\W*(?:sample interval|x ?inc(?:rement)?|sequence(?:,[a-z]+)+,[-+.\de]+)\W*?[:,;\t](?:analog:|[\s\"',;:])*"
    r"(?P<number>\d*\.?\d+(?:e[-+]?\d+)?)[\s\"',;s]*",
    re.IGNORECASE,
)
"""The interval in s of oscilloscopes: ``Sample Interval,1e-6`` of Tektronix, ``Sample Interval,Analog:1e-6`` of
Siglent, ``XInc:,1e-6`` of Keysight, ``Sequence,Volt,-1e-3,1e-6`` of Rigol under ``Start,Increment``."""

_HERTZ = {"hz": 1.0, "гц": 1.0, "赫兹": 1.0, "赫": 1.0, "khz": 1e3, "кгц": 1e3, "sps": 1.0, "samples/s": 1.0}
_FASTEST = 1e7


class StatedRate(NamedTuple):
    """A rate in Hz, and the line that states it."""

    rate: float
    line: int
    text: str


def statement(line: int, text: str, decimal: str = ".") -> StatedRate | None:
    """The sampling rate that a line states; None if it states none."""
    scope = _SCOPE.fullmatch(text) if len(text) <= headers.LONGEST_HEADER else None
    if scope and float(scope["number"]) > 0:
        return StatedRate(1 / float(scope["number"]), line, text[:60])
    stated = _STATED.search(text) if len(text) <= headers.LONGEST_HEADER else None
    if stated is None or (stated["fraction"] or "").startswith(",") > (decimal == ","):
        return None
    number, unit = float(stated["number"].replace(",", ".")), stated["after"] or stated["before"] or ""
    if stated["rate"]:
        value = number * _HERTZ.get(unit.lower(), 0.0 if unit else 1.0)
    else:  # a number without unit may be seconds or milliseconds
        value = 1 / (number * unit_of(unit).factor) if headers.is_time(unit) and number else 0.0
    return StatedRate(value, line, text.lstrip("#%/; ").strip()[:60]) if 0 < value <= _FASTEST else None


def nominal(lines: Iterable[tuple[int, str]], decimal: str) -> tuple[float | None, Phrase]:
    """The rate that the lines above the numbers state, with its place; no rate if they contradict each other."""
    statements = [stated for line, text in lines if (stated := statement(line, text, decimal))]
    places = join(", ", (say("line {line} ({text!r})", line=row.line, text=row.text) for row in statements))
    rates = [stated.rate for stated in statements]
    if not rates or max(rates) > 1.001 * min(rates):
        return None, places
    return rates[0], places
