"""Why a record misses its claim: factors of conventions, or defects that leave other traces."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from allanite.core.arrays import mean_and_deviation
from allanite.core.model import Term
from allanite.core.record import Record
from allanite.phrases.phrase import say
from allanite.study.results import Channel, Study

from .claim import SETTINGS, ClaimedNoise
from .result import Cause, CheckedTerm

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
    Convention(say("rate"), lambda p: p.rate, say("multiplied by the root of the sample interval where it is divided, "
                                                  "or divided where it is multiplied: it depends on the rate"), DRIVEN),
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
        "1/0.664", _constant(1 / 0.664), say("minimum of the Allan deviation and bias instability confused"), ("B",)),
    Convention("sqrt(T/2)", lambda p: math.sqrt(p.time / 2),
               say("standard deviation of the bias and the density that drives it confused"), WALKS),
    Convention("", lambda p: p.claimed, say("the coefficient is squared: variance and standard deviation confused"),
               inverse=False),
    Convention(
        "", lambda p: p.claimed * math.sqrt(p.rate),
        say("the deviation of a sample is squared: variance and standard deviation confused"), ("N",), inverse=False),
    Convention("", lambda p: p.other / p.claimed, say("the value of the other kind of sensor"), inverse=False),
    Convention("1/sqrt(12)", lambda p: 12**-0.5 if p.uniform else NAN,
               say("rand() instead of randn(): uniform over an interval of length 1"), ("N",), inverse=False),
    Convention("1/sqrt(3)", lambda p: 3**-0.5 if p.uniform else NAN,
               say("rand() instead of randn(): uniform from -1 to 1"), ("N",), inverse=False),
    Convention("-1", _constant(-1.0), say("opposite sign"), ("R", "W"), inverse=False),
    Convention("", lambda p: p.other / p.claimed, say("the correlation time of the other kind of sensor"), TIMES,
               inverse=False),
    Convention("60", _constant(60.0), say("minutes and seconds confused"), TIMES),
    Convention("3600", _constant(3600.0), HOURS, TIMES),
    Convention(say("rate"), lambda p: p.rate, say("samples and seconds confused"), TIMES),
)  # fmt: skip
"""What explains a factor: a line each."""


def explaining(low: float, high: float, place: Place) -> list[tuple[str, Convention]]:
    """The conventions whose factor lies within limits, the nearest to their middle first, each after its formula."""
    fitting = list[tuple[float, str, Convention]]()
    for row in CONVENTIONS:
        if place.symbol not in row.symbols and (row.symbols or place.symbol == "T"):
            continue
        factor = row.factor(place)
        for value, name in ((factor, row.name), (1 / factor if factor else NAN,
                                                 say("1/{factor}", factor=row.name)))[: 1 + row.inverse]:  # fmt: skip
            if low <= value <= high:
                fitting.append((_distance(value, low, high), name, row))
    return [(name, row) for _, name, row in sorted(fitting, key=lambda one: one[0])]


def _distance(value: float, low: float, high: float) -> float:
    """How far a value is from the middle of limits that hold it, in logarithms where all are positive."""
    if low > 0 and math.isfinite(high):
        return abs(math.log(value) - math.log(low * high) / 2)
    return abs(value - low)


def pooled(limits: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """Limits of one factor of several axes, from those of each; their weights are the widths of the logarithms."""
    # Where the axes do not agree the limits are empty: low above high.
    inner = max(low for low, _ in limits), min(high for _, high in limits)
    known = all(low > 0 and math.isfinite(high) for low, high in limits)
    if len(limits) == 1 or inner[0] >= inner[1] or not known:
        return inner
    halves = [math.log(high / low) / 2 for low, high in limits]
    weight = [half**-2 for half in halves]
    centre = sum(w * math.log(low * high) / 2 for w, (low, high) in zip(weight, limits, strict=True)) / sum(weight)
    half = sum(weight) ** -0.5
    return math.exp(centre - half), math.exp(centre + half)


NAMED = 3  # conventions that fit, at most, if they are named: more of them explain nothing

WIDE, NEARLY = 15.0, 1.02
"""Ratio of the limits of a factor above which nothing is named, and factor by which they are widened if none is."""

FIRST = 1000  # samples at the start whose mean is looked at
NEAR = 0.1  # relative difference of a mean from what rand() makes of it, up to which rand() is named


def causes_of(study: Study, claim: ClaimedNoise, terms: Sequence[CheckedTerm]) -> tuple[Cause, ...]:
    """The causes of what contradicts a claim, by kind of sensor and quantity."""
    against = [row for row in terms if row.contradicts and row.quantity in SETTINGS]
    terms = [row for row in terms if row.quantity not in SETTINGS]
    light = {row.channel for row in terms if row.quantity == "kurtosis" and row.contradicts}
    causes = list[Cause]()
    for _, rows in groupby(sorted(terms, key=lambda row: row.signal.name), key=lambda row: row.signal.name):
        causes += _of_sensor(study, claim, [row for row in rows if row.contradicts], light)
    by_rand = [cause for cause in causes if any("rand()" in sentence for sentence in cause.sentences)]
    named = {name for cause in by_rand for name in cause.channels}
    rest = tuple(row.channel for row in terms if row.quantity == "kurtosis" and row.channel in light - named)
    if rest:
        causes.append(_trace(rest, "kurtosis", say("the samples are uniform: rand() instead of randn()")))
    told = dict.fromkeys((row.quantity, row.reason) for row in against)
    causes += [_trace(tuple(r.channel for r in against if (r.quantity, r.reason) == each), *each) for each in told]
    return (*causes, *_half(study, light))


def _of_sensor(study: Study, claim: ClaimedNoise, wrong: list[CheckedTerm], light: set[str]) -> list[Cause]:
    """The causes of what is wrong with the channels of a kind of sensor."""
    driven = _driven(study, claim, wrong)
    known = ("T", *WALKS) if driven else ()
    numbers = [row for row in wrong if row.claimed and row.quantity not in ("curve", *known)]
    numbers.sort(key=lambda row: row.quantity)
    groups = [list(rows) for _, rows in groupby(numbers, key=lambda row: row.quantity)]
    causes = [_factor(study, claim, rows, uniform={row.channel for row in rows} <= light) for rows in groups]
    # what explains one quantity, and may explain the others, explains all
    shared = set.intersection(*(set(cause.names) for cause in causes)) if causes else set()
    return [*([driven] if driven else []), *(cause.only(shared) if shared - {""} else cause for cause in causes)]


def _trace(channels: tuple[str, ...], quantity: str, sentence: str) -> Cause:
    """A cause that is no factor."""
    return Cause(channels, quantity, NAN, NAN, NAN, ("",), (sentence,))


def _factor(study: Study, claim: ClaimedNoise, rows: Sequence[CheckedTerm], *, uniform: bool) -> Cause:
    """The factor that the channels of a sensor have in common, and the conventions that explain it."""
    first, channels = rows[0], tuple(row.channel for row in rows)
    if any(row.low <= 0 for row in rows):
        why = say("the record has no such bias; a simulator may not have added it to the samples")
        absent = (why,) * (first.quantity in (*WALKS, "B"))
        high = max(row.high for row in rows)
        return Cause(channels, first.quantity, 0.0, 0.0, high, ("",) * len(absent), absent)
    low, high = pooled([(row.low, row.high) for row in rows])
    centre = math.sqrt(low * high) if 0 < low <= high else float(np.mean([row.ratio for row in rows]))
    kept: dict[str, Convention] = {}
    if 0 < low <= high <= WIDE * low:
        place = _place(study, claim, first, uniform=uniform)
        # a bias that is sampled, and not its mean over each interval, adds a little white noise
        fitting = explaining(low, high, place) or explaining(low / NEARLY, high * NEARLY, place)
        kept = dict(fitting if len(fitting) <= NAMED else ())
    return Cause(channels, first.quantity, centre, low, high, tuple(kept), tuple(row.sentence for row in kept.values()))


def _place(study: Study, claim: ClaimedNoise, row: CheckedTerm, *, uniform: bool) -> Place:
    """What the conventions may depend on."""
    channel = next(c for c in study if c.record.name in row.channel.split(", "))
    others = [term for model in claim.models if model.signal.name != row.signal.name for term in model]
    own = [term for term in claim.of(row.signal) or () if term.shape]
    timed = next((term.shape[0] for term in own), NAN)
    same = (t for t in others if row.quantity in (t.symbol, "T" * len(t.shape)))
    other = next((t.shape[0] if row.quantity == "T" else t.value for t in same), NAN)
    return Place(row.quantity, row.claimed or NAN, channel.record.rate, timed, other, uniform)


def _driven(study: Study, claim: ClaimedNoise, wrong: Sequence[CheckedTerm]) -> Cause | None:
    """Whether the bias of all channels that are wrong rises as if it were driven by rand(), whose mean is 1/2."""
    term = next((t for row in wrong[:1] for t in claim.of(row.signal) or () if t.symbol in WALKS), None)
    channels = list(dict.fromkeys(row.channel for row in wrong if row.quantity != "T"))
    if term is None or not channels or any(abs(_rise(study[name], term) - 1) > NEAR for name in channels):
        return None
    sentence = say("the bias is driven by rand() instead of randn(): its mean is not zero, and the bias rises")
    return _trace(tuple(channels), term.symbol, sentence)


def _rise(channel: Channel, term: Term) -> float:
    """How far the rate rises from the first to the last tenth, over what a driving noise with the mean 1/2 makes."""
    record = channel.record
    if not isinstance(record, Record):
        return NAN
    rates = record.rate_values
    part, step = rates.size // 10, 1 / record.rate
    change = mean_and_deviation(rates[-part:])[0] - mean_and_deviation(rates[:part])[0]
    t = np.arange(rates.size) * step
    if term.symbol == "K":
        mean = t * (0.5 * term.value / math.sqrt(step))
    else:
        T = term.shape[0]
        mean = -np.expm1(-t / T) * (0.5 * term.value * math.sqrt(2 / T) * T / math.sqrt(step))
    return change / float(mean[-part:].mean() - mean[:part].mean())


def _half(study: Study, light: set[str]) -> Iterator[Cause]:
    """Channels of uniform samples whose mean is that of rand(): sqrt(3) standard deviations."""
    names = []
    for channel in study:
        record = channel.record
        if record.name in light and isinstance(record, Record):
            rates = record.rate_values
            fast = np.nanstd(np.diff(rates)) / math.sqrt(2)  # and the mean before the bias has drifted
            names += [record.name] if abs(np.nanmean(rates[:FIRST]) / fast / math.sqrt(3) - 1) < NEAR else []
    if names:
        yield _trace(tuple(names), "mean", say("the mean is not zero, but half the width of the distribution, as that "
                                               "of rand() between 0 and 1"))  # fmt: skip
