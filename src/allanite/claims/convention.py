"""Conventions: factors by which noise misses its claim if a unit, density or distribution is taken for another."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from allanite.phrases.phrase import say

NAN = math.nan


@dataclass(frozen=True)
class Place:
    """What a factor may depend on."""

    symbol: str  # the term, or "T" for a correlation time
    claimed: float  # its coefficient, SI
    rate: float  # sampling rate, Hz
    time: float = NAN  # correlation time that is claimed, s
    other: float = NAN  # what is claimed of the same term of the other kind of sensor, SI
    uniform: bool = False  # whether the samples are distributed uniformly


@dataclass(frozen=True)
class Convention:
    """A row of `CONVENTIONS`."""

    name: str  # the factor as a formula; empty if it follows from what is claimed
    factor: Callable[[Place], float]  # found over claimed, or its inverse; NaN where the convention does not apply
    sentence: str  # what was taken for what
    symbols: tuple[str, ...] = ()  # the terms that it applies to; empty: all coefficients of noise
    inverse: bool = True  # whether the inverse factor has the same cause


def _constant(value: float) -> Callable[[Place], float]:
    return lambda place: value


WALKS = ("K", "GM")
DRIVEN = ("N", *WALKS)
TIMES = ("T",)
DEGREE = 180 / math.pi
HOURS = say("hours and seconds confused")

CONVENTIONS = (
    Convention("sqrt(2)", _constant(math.sqrt(2)), say("one-sided and two-sided density confused"), ("N", "K")),
    Convention(say("sqrt(rate)"), lambda p: math.sqrt(p.rate), say("value per sample and density confused"), DRIVEN),
    Convention(
        say("rate"), lambda p: p.rate, say("multiplied by the root of the sample interval where it is divided, or "
                                           "divided where it is multiplied: it depends on the rate"), DRIVEN,
    ),
    Convention("57.3", _constant(DEGREE), say("degrees and radians confused")),
    Convention("60", _constant(60.0), say("sqrt(h) and sqrt(s) confused"), ("N", "K")),
    Convention("3600", _constant(3600.0), HOURS, ("B", *WALKS)),
    Convention("57.3 x 60", _constant(DEGREE * 60), say("deg/sqrt(h) and rad/sqrt(s) confused"), ("N",)),
    Convention("57.3 x 3600", _constant(DEGREE * 3600), say("deg/h and rad/s confused"), ("B", *WALKS)),
    Convention("9.81", _constant(9.80665), say("g and m/s^2 confused")),
    Convention("1000", _constant(1e3), say("a prefix milli is missing, or taken twice")),
    Convention("1e6", _constant(1e6), say("a prefix micro is missing, or taken twice")),
    Convention("1e6/9.81", _constant(1e6 / 9.80665), say("ug and m/s^2 confused")),
    Convention(say("pi"), _constant(math.pi), say("a factor of pi is missing, or taken twice")),
    Convention(say("2 pi"), _constant(2 * math.pi), say("frequency in Hz and in rad/s confused")),
    Convention("sqrt(3)", _constant(math.sqrt(3)), say("K read off the Allan deviation at 1 s, not at 3 s"), ("K",)),
    Convention(
        "1/0.664", _constant(1 / 0.664), say("minimum of the Allan deviation and bias instability confused"), ("B",),
    ),
    Convention(
        "sqrt(T/2)", lambda p: math.sqrt(p.time / 2),
        say("standard deviation of the bias and the density that drives it confused"), WALKS,
    ),
    Convention(
        "", lambda p: p.claimed, say("the coefficient is squared: variance and standard deviation "
                                                       "confused"), inverse=False,
    ),
    Convention(
        "", lambda p: p.claimed * math.sqrt(p.rate),
        say("the deviation of a sample is squared: variance and standard deviation confused"), ("N",), inverse=False,
    ),
    Convention(
        "", lambda p: p.other / p.claimed, say("the value of the other kind of sensor"), inverse=False,
    ),
    Convention(
        "1/sqrt(12)", lambda p: 12**-0.5 if p.uniform else NAN,
        say("rand() instead of randn(): uniform over an interval of length 1"), ("N",), inverse=False,
    ),
    Convention(
        "1/sqrt(3)", lambda p: 3**-0.5 if p.uniform else NAN, say("rand() instead of randn(): uniform from -1 to 1"),
        ("N",), inverse=False,
    ),
    Convention("-1", _constant(-1.0), say("opposite sign"), ("R", "W"), inverse=False),
    Convention(
        "", lambda p: p.other / p.claimed,
        say("the correlation time of the other kind of sensor"), TIMES, inverse=False,
    ),
    Convention("60", _constant(60.0), say("minutes and seconds confused"), TIMES),
    Convention("3600", _constant(3600.0), HOURS, TIMES),
    Convention(say("rate"), lambda p: p.rate, say("samples and seconds confused"), TIMES),
)  # fmt: skip
"""What explains a factor: a line each."""


def explaining(low: float, high: float, place: Place) -> list[tuple[str, Convention]]:
    """The conventions whose factor lies within limits, the nearest to their middle first, each after its formula.

    Examples
    --------
    >>> [name for name, _ in explaining(1.40, 1.43, Place("N", 1e-4, 100.0))]
    ['sqrt(2)']
    >>> [name for name, _ in explaining(0.09, 0.11, Place("N", 1e-4, 100.0))]
    ['1/sqrt(rate)', '1/9.81']
    """
    found = list[tuple[float, str, Convention]]()
    for row in CONVENTIONS:
        if place.symbol not in row.symbols and (row.symbols or place.symbol == "T"):
            continue
        factor = row.factor(place)
        for value, name in ((factor, row.name), (1 / factor if factor else NAN, say("1/{factor}", factor=row.name)))[
            : 1 + row.inverse
        ]:
            if low <= value <= high:
                found.append((_distance(value, low, high), name, row))
    return [(name, row) for _, name, row in sorted(found, key=lambda one: one[0])]


def _distance(value: float, low: float, high: float) -> float:
    """How far a value is from the middle of limits that hold it, in logarithms where all are positive."""
    if low > 0 and math.isfinite(high):
        return abs(math.log(value) - math.log(low * high) / 2)
    return abs(value - low)


def pooled(limits: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """Limits of one factor of several axes, from those of each; their weights are the widths of the logarithms.

    Where the axes do not agree the limits are empty: low above high.

    Examples
    --------
    >>> low, high = pooled([(1.0, 4.0), (1.0, 4.0)])
    >>> round(low, 3), round(high, 3)
    (1.225, 3.265)
    >>> pooled([(1.0, 1.1), (2.0, 2.2)])
    (2.0, 1.1)
    """
    inner = max(low for low, _ in limits), min(high for _, high in limits)
    known = all(low > 0 and math.isfinite(high) for low, high in limits)
    if len(limits) == 1 or inner[0] >= inner[1] or not known:
        return inner
    halves = [math.log(high / low) / 2 for low, high in limits]
    weight = [half**-2 for half in halves]
    centre = sum(w * math.log(low * high) / 2 for w, (low, high) in zip(weight, limits, strict=True)) / sum(weight)
    half = sum(weight) ** -0.5
    return math.exp(centre - half), math.exp(centre + half)
