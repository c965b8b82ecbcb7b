"""Why a record misses its claim: a convention that explains the factor, or a defect that leaves other traces."""

import math
from collections.abc import Iterator, Sequence
from itertools import groupby

import numpy as np

from allanite.core.model import Term
from allanite.core.record import Record
from allanite.phrases.phrase import say
from allanite.study.results import Channel, Study

from .claim import ClaimedNoise
from .convention import NAN, WALKS, Convention, Place, explaining, pooled
from .result import Cause, CheckedTerm
from .settings import SETTINGS

NAMED = 3
"""Conventions that fit, at most, if they are named: more of them explain nothing."""

WIDE, NEARLY = 15.0, 1.02
"""Ratio of the limits of a factor above which nothing is named, and factor by which they are widened if none is."""

FIRST = 1000
"""Samples at the start whose mean is looked at."""

NEAR = 0.1
"""Relative difference of a mean from what rand() makes of it, up to which rand() is named."""


def causes_of(study: Study, claim: ClaimedNoise, terms: Sequence[CheckedTerm]) -> tuple[Cause, ...]:
    """The causes of what contradicts a claim, by kind of sensor and quantity."""
    against = [row for row in terms if row.contradicts and row.quantity in SETTINGS]
    terms = [row for row in terms if row.quantity not in SETTINGS]
    light = {row.channel for row in terms if row.quantity == "kurtosis" and row.contradicts}
    found = list[Cause]()
    for _, rows in groupby(sorted(terms, key=lambda row: row.signal.name), key=lambda row: row.signal.name):
        found += _of_sensor(study, claim, [row for row in rows if row.contradicts], light)
    named = {name for cause in found if any("rand()" in said for said in cause.sentences) for name in cause.channels}
    rest = tuple(row.channel for row in terms if row.quantity == "kurtosis" and row.channel in light - named)
    if rest:
        found.append(_trace(rest, "kurtosis", say("the samples are uniform: rand() instead of randn()")))
    told = dict.fromkeys((row.quantity, row.reason) for row in against)
    found += [_trace(tuple(r.channel for r in against if (r.quantity, r.reason) == each), *each) for each in told]
    return (*found, *_half(study, light))


def _of_sensor(study: Study, claim: ClaimedNoise, wrong: list[CheckedTerm], light: set[str]) -> list[Cause]:
    """The causes of what is wrong with the channels of a kind of sensor."""
    driven = _driven(study, claim, wrong)
    known = ("T", *WALKS) if driven else ()
    numbers = [row for row in wrong if row.claimed and row.quantity not in ("curve", *known)]
    numbers.sort(key=lambda row: row.quantity)
    groups = [list(rows) for _, rows in groupby(numbers, key=lambda row: row.quantity)]
    found = [_factor(study, claim, rows, uniform={row.channel for row in rows} <= light) for rows in groups]
    # what explains one quantity, and may explain the others, explains all
    shared = set.intersection(*(set(cause.names) for cause in found)) if found else set()
    return [*([driven] if driven else []), *(cause.only(shared) if shared - {""} else cause for cause in found)]


def _trace(channels: tuple[str, ...], quantity: str, sentence: str) -> Cause:
    """A cause that is no factor."""
    return Cause(channels, quantity, NAN, NAN, NAN, ("",), (sentence,))


def _factor(study: Study, claim: ClaimedNoise, rows: Sequence[CheckedTerm], *, uniform: bool) -> Cause:
    """The factor that the channels of a sensor have in common, and the conventions that explain it."""
    first, channels = rows[0], tuple(row.channel for row in rows)
    if any(row.low <= 0 for row in rows):
        absent = (say("the bias is not added to the samples"),) * (first.quantity in (*WALKS, "B"))
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
    same = [
        t.shape[0] if row.quantity == "T" else t.value for t in others if row.quantity in (t.symbol, "T" * len(t.shape))
    ]
    other = next(iter(same), NAN)
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
    rates = record.rate_values * record.rate_factor
    part, step = rates.size // 10, 1 / record.rate
    seen = float(np.nanmean(rates[-part:]) - np.nanmean(rates[:part]))
    t = np.arange(rates.size) * step
    if term.symbol == "K":
        mean = t * (0.5 * term.value / math.sqrt(step))
    else:
        T = term.shape[0]
        mean = -np.expm1(-t / T) * (0.5 * term.value * math.sqrt(2 / T) * T / math.sqrt(step))
    return seen / float(mean[-part:].mean() - mean[:part].mean())


def _half(study: Study, light: set[str]) -> Iterator[Cause]:
    """Channels of uniform samples whose mean is that of rand(): sqrt(3) standard deviations."""
    found = []
    for channel in study:
        record = channel.record
        if record.name in light and isinstance(record, Record):
            rates = record.rate_values
            fast = np.nanstd(np.diff(rates)) / math.sqrt(2)  # and the mean before the bias has drifted
            found += [record.name] if abs(np.nanmean(rates[:FIRST]) / fast / math.sqrt(3) - 1) < NEAR else []
    if found:
        yield _trace(tuple(found), "mean", say("the mean is not zero, but half the width of the distribution, as that "
                                               "of rand() between 0 and 1"))  # fmt: skip
