"""Whether a unit keeps its limits."""

import math
from dataclasses import dataclass
from typing import NamedTuple

from allanite.core.plain import Value
from allanite.core.readings import MINIMUM
from allanite.phrases.phrase import join, say
from allanite.study.results import Channel, Study

from .specification import Limit, Specification

PASS, FAIL, NOT_SHOWN = "pass", "fail", "not shown"

OUTCOMES = (FAIL, NOT_SHOWN, PASS)
"""Outcomes, the worst first."""


def worst_of(outcomes: "list[str]") -> str:
    """The worst of several outcomes; empty where there is none."""
    return next((outcome for outcome in OUTCOMES if outcome in outcomes), "")


@dataclass(frozen=True, repr=False)
class Judgement(Value):
    """What a limit says of one coefficient of one channel."""

    channel: str
    limit: Limit
    outcome: str  # One of "pass", "fail", "not shown"
    # what was held against the limit, SI: the value or the upper end of its interval; of a term that was not
    # identified its upper limit. None where nothing is known.
    size: float | None
    reason: str  # the numbers, in the unit of the limit
    # whether the interval of the value holds the limit: another record of this unit may fall on its other side
    near: bool = False

    def _summary(self) -> str:
        return f"{self.channel!r}: {self.limit.symbol} {self.outcome}, {self.reason}"


class Seen(NamedTuple):
    """What is known of the size of a coefficient, SI: a value with its interval, or an upper limit, or the reason."""

    value: float | None = None
    low: float = math.nan
    high: float = math.nan
    upper: float | None = None
    reason: str = ""


def judge_study(study: Study, specification: Specification) -> tuple[Judgement, ...]:
    """Every limit of a specification, held against the channels of a study."""
    judgements = []
    for channel in study:
        name = channel.record.name
        for limit in specification.of(name, channel.record.signal):
            judgements.append(judge(name, limit, seen_of(channel, limit.symbol, study.recipe.level)))
    known = {channel.record.name for channel in study}
    for name, limits in specification.channels.items():
        if name not in known:
            reason = say("there is no channel {name!r}", name=name)
            judgements += [Judgement(name, limit, NOT_SHOWN, None, reason) for limit in limits]
    return tuple(judgements)


def judge(channel: str, limit: Limit, seen: Seen) -> Judgement:
    """Hold what is known of a coefficient against its limit; see `Specification` for the rule.

    Examples
    --------
    >>> limit = Specification.from_toml({"limits": {"B": {"max": "2 deg/h"}}}).limits[0]
    >>> unit = limit.factor
    >>> judge("gz", limit, Seen(1.9 * unit, 1.7 * unit, 2.1 * unit))
    <Judgement 'gz': B pass, 1.9 deg/h (1.7 .. 2.1), the interval contains the limit>
    >>> judge("gz", limit, Seen(upper=3 * unit))
    <Judgement 'gz': B not shown, not identified, below 3 deg/h>
    """
    most, unit = limit.maximum, limit.unit
    if seen.value is None:
        if seen.upper is None:
            return Judgement(channel, limit, NOT_SHOWN, None, seen.reason)
        text = say(
            "{reason}, below {limit:.3g} {unit}",
            reason=seen.reason or say("not identified"),
            limit=seen.upper / limit.factor,
            unit=unit,
        )
        return Judgement(channel, limit, PASS if seen.upper <= most else NOT_SHOWN, seen.upper, text)
    known = math.isfinite(seen.low) and math.isfinite(seen.high)
    near = known and seen.low <= most <= seen.high
    value = f"{seen.value / limit.factor:.4g} {unit}"
    if known:
        parts = [f"{value} ({seen.low / limit.factor:.4g} .. {seen.high / limit.factor:.4g})"]
    else:
        parts = [value, say("no interval")]
    parts += [say("the interval contains the limit")] if near else []
    parts += [seen.reason] if seen.reason else []
    upper = limit.judge == "upper"
    outcome = FAIL if seen.value > most else NOT_SHOWN if upper and not seen.high <= most else PASS
    size = seen.high if upper and known else seen.value
    return Judgement(channel, limit, outcome, size, join(", ", parts), near)


def seen_of(channel: Channel, symbol: str, level: float) -> Seen:
    """What is known of a coefficient of a channel, or of the minimum of its curve."""
    if channel.refusal:
        return Seen(reason=say("no result: {reason}", reason=channel.refusal))
    if symbol != MINIMUM:
        return _coefficient(channel, symbol, level)
    minimum = channel.readings.minimum if channel.readings else None
    if channel.readings is None or minimum is None:
        return Seen(reason=say("the curve has no minimum; it is determined for oadev at averaging times 'log' only"))
    if not channel.readings.inside:
        return Seen(upper=minimum.interval(level)[1], reason=say("not reached in this record"))
    return Seen(minimum.deviation, *minimum.interval(level))


def _coefficient(channel: Channel, symbol: str, level: float) -> Seen:
    if not channel.fit:
        return Seen(reason=say("nothing was fitted"))
    e = next((e for e in channel.fit if e.symbol == symbol), None)
    if e is None:
        terms = ", ".join(e.symbol for e in channel.fit)
        return Seen(reason=say("{symbol!r} is not a term of this fit; its terms: {terms}", symbol=symbol, terms=terms))
    if e.status == "absent" and e.upper is not None:
        return Seen(upper=e.upper)
    if e.value is None or not e.valued:
        return Seen(reason=join(": ", [e.row.name, *([e.reason] if e.reason else [])]))
    low, high = e.interval(level)
    if low < 0 and math.isfinite(low):  # limits of the size of what has a sign
        low, high = (0.0 if high > 0 else -high), max(-low, high)
    return Seen(abs(e.value), low, high)
