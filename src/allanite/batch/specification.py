"""The limits that units must keep, as a TOML file gives them, and whether a unit keeps them."""

import math
import os
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from allanite.core.aliases import constructed
from allanite.core.digits import digits, upper_limit
from allanite.core.errors import UsageError
from allanite.core.limits import FAIL, NOT_DECIDED, PASS, held
from allanite.core.model import coefficient_factor
from allanite.core.names import demand_name
from allanite.core.plain import Value
from allanite.core.readings import FALLING, MINIMUM
from allanite.core.syntax import split_quantities
from allanite.core.units import SIGNALS, Signal, signal_with, unit_of
from allanite.phrases.phrase import join, say
from allanite.study.recipe import load_toml
from allanite.study.results import Channel, Study
from allanite.terms import TERMS

EXAMPLE = 'N = { max = "0.15 deg/sqrt(h)" }'
LIMITED = (*(symbol for symbol, row in TERMS.items() if not row.periodic), MINIMUM)  # what can have a limit


@dataclass(frozen=True, repr=False)
class Limit(Value):
    """The largest size that a coefficient may have."""

    symbol: str  # a noise term, or "minimum" for the minimum of the Allan deviation
    maximum: float  # in SI
    unit: str  # the unit in which the limit was given
    signal: Signal  # the kind of sensor that the unit belongs to; other channels are not judged by this limit

    @property
    def factor(self) -> float:
        """Size of `unit` in SI."""
        return unit_of(self.unit).factor

    def words(self) -> str:
        """The limit as it was given: ``0.15 deg/sqrt(h)``."""
        return f"{self.maximum / self.factor:.6g} {self.unit}"

    def _summary(self) -> str:
        return f"{self.symbol} <= {self.words()}"


@constructed
@dataclass(frozen=True, repr=False)
class Specification(Value):
    """Limits of the terms, for all channels and for some of them.

    A term passes if its interval lies below the limit, and fails if it lies above. A term that was not identified, or a
    minimum of a curve that is still falling, passes if its upper limit does not exceed the limit. Everything else is
    "not decided": the record is too short, or its model is not valid.

    Attributes
    ----------
    limits : tuple of Limit
        Of every channel of their kind of sensor.
    channels : dict of str to tuple of Limit
        Of single channels, by name; they replace those of all.
    source : str
        The file.
    """

    limits: tuple[Limit, ...]
    channels: dict[str, tuple[Limit, ...]] = field(default_factory=dict)
    source: str = ""

    def of(self, channel: str, signal: Signal) -> tuple[Limit, ...]:
        """The limits of a channel.

        Raises
        ------
        UsageError
            A limit of this channel is in the unit of another kind of sensor.
        """
        own = self.channels.get(channel, ())
        for limit in own:
            if limit.signal is not signal:
                raise UsageError(f"{self.source}: the limit of {limit.symbol} for the channel {channel!r} "
                                 f"is in {limit.unit}, which is a unit of a {limit.signal.name}; the channel is a "
                                 f"{signal.name}")  # fmt: skip
        common = {limit.symbol: limit for limit in self.limits if limit.signal is signal}
        return tuple((common | {limit.symbol: limit for limit in own}).values())

    @classmethod
    def from_toml(cls, data: dict[str, Any], source: str = "") -> "Specification":
        """The limits in a TOML table.

        Parameters
        ----------
        data : dict
            ``limits``: a table of ``{ max = "0.15 deg/sqrt(h)" }`` by term, or a list of these for different kinds of
            sensors; ``channels``: such tables by the name of a channel.
        source : str
            The name of the file, for messages.

        Raises
        ------
        UsageError
            A key or term is unknown, a limit is not a positive number with a unit, or there is no limit.
        UnitError
            A unit does not fit its term.

        Examples
        --------
        >>> Specification.from_toml({"limits": {"N": {"max": "0.15 deg/sqrt(h)"}}}).limits
        (<Limit N <= 0.15 deg/sqrt(h)>,)
        """
        try:
            if astray := [key for key in data if key in LIMITED]:
                raise UsageError(f"{astray[0]} stands below no heading; write [limits] in the line above it")
            _demand_keys(data, ("limits", "channels"), "the limits file")
            common = tuple(_limits(data.get("limits", {}), "limits"))
            tables = _table(data.get("channels", {}), "channels")
            own = {name: tuple(_limits(table, f"channels.{name}")) for name, table in tables.items()}
            if not common and not any(own.values()):
                raise UsageError(f"there is no limit in it; write {EXAMPLE} below [limits]")
        except UsageError as error:
            raise (error.within(source) if source else error) from None
        return cls(common, own, source)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> "Specification":
        """The limits in a TOML file; errors as of `from_toml`."""
        return cls.from_toml(load_toml(path, "limits file"), os.fspath(path))

    def _summary(self) -> str:
        parts = [f"{limit.symbol} <= {limit.words()}" for limit in self.limits]
        return join(", ", [*parts, *(say("own limits of {channel}", channel=name) for name in self.channels)])


def limits_of(given: "Specification | str | os.PathLike[str] | None") -> Specification | None:
    """Limits, given or in a file."""
    if isinstance(given, str) and "<" in given:  # 'N < 0.15 deg/sqrt(h), B < 3 deg/h'
        pairs = (re.split("<=?", part, maxsplit=1) for part in given.split(","))
        rows = {symbol.strip(): {"max": "".join(size).strip()} for symbol, *size in pairs}
        return Specification.from_toml({"limits": rows}, "the limits")
    return given if given is None or isinstance(given, Specification) else Specification.load(given)


def _demand_keys(table: dict[str, Any], known: tuple[str, ...], where: str) -> None:
    for key in table:
        demand_name("key", key, known, where=f" in {where}")


def _table(found: Any, name: str) -> dict[str, Any]:
    if not isinstance(found, dict):
        raise UsageError(f"{name} is a table, as [{name}] and below it {EXAMPLE}; {found!r} came")
    return found


def _limits(table: Any, where: str) -> Iterator[Limit]:
    """The limits of a table, for each kind of sensor at most one."""
    for symbol, entries in _table(table, where).items():
        demand_name("term", symbol, {name: TERMS.get(name) for name in LIMITED}, where=f" in [{where}]")
        met = set()
        for entry in entries if isinstance(entries, list) else [entries]:
            if not isinstance(entry, dict) or not isinstance(entry.get("max"), str):
                raise UsageError(f"the limit of {symbol} in [{where}] is written as {EXAMPLE}, with the unit; "
                                 f"{entry!r} came")  # fmt: skip
            _demand_keys(entry, ("max",), f"the limit of {symbol} in [{where}]")
            quantities = split_quantities(entry["max"].split())
            if len(quantities) != 1 or not quantities[0][0] > 0 or not quantities[0][1]:
                raise UsageError(f"the limit of {symbol} in [{where}] is a positive number with a unit, as in "
                                 f"{EXAMPLE}; {entry['max']!r} came")  # fmt: skip
            number, unit = quantities[0]
            factor = unit_of(unit).factor if symbol == MINIMUM else coefficient_factor(symbol, unit)
            signal = signal_with(unit_of(unit).dimension, 0 if symbol == MINIMUM else TERMS[symbol].power, values=True)
            if signal is None:  # of a coefficient the factor was found
                usual = ", ".join(s.sheet[0] for s in SIGNALS if s.inertial)
                raise UsageError(f"{unit!r} is not a unit of a {MINIMUM} of the Allan deviation; usual ones are "
                                 f"{usual}")  # fmt: skip
            if signal.name in met:
                raise UsageError(f"{symbol} in [{where}] has two limits for a {signal.name}; keep one")
            met.add(signal.name)
            yield Limit(symbol, number * factor, unit, signal)


OUTCOMES = (FAIL, NOT_DECIDED, PASS)  # outcomes, the worst first


def worst_of(outcomes: "list[str]") -> str:
    """The worst of several outcomes; empty where there is none."""
    return next((outcome for outcome in OUTCOMES if outcome in outcomes), "")


@dataclass(frozen=True, repr=False)
class Judgement(Value):
    """What a limit says of one coefficient of one channel."""

    channel: str
    limit: Limit
    outcome: str  # One of "pass", "fail", "not decided"
    reason: str  # the value with its interval, in the unit of the limit

    def _summary(self) -> str:
        return f"{self.channel!r}: {self.limit.symbol} {self.outcome}, {self.reason}"


class Seen(NamedTuple):
    """What is known of the size of a coefficient, SI: a value with its interval, an upper limit, or why neither."""

    value: float | None = None
    low: float = math.nan
    high: float = math.nan
    upper: float | None = None
    reason: str = ""

    @property
    def limits(self) -> tuple[float, float]:
        """Between which sizes it is: NaN if nothing is known, the value alone where it has no interval."""
        if self.upper is not None:
            return 0.0, self.upper
        value = math.nan if self.value is None else self.value
        return (self.low, self.high) if math.isfinite(self.low) and math.isfinite(self.high) else (value, value)

    def words(self, limit: Limit) -> str:
        """The value with its interval, or the upper limit, in the unit of a limit."""
        if self.value is None and self.upper is None:
            return self.reason
        if self.value is None:
            most = upper_limit((self.upper or 0.0) / limit.factor).plain()[0]
            reason = self.reason or say("not identified")
            return say("{reason}, below {limit} {unit}", reason=reason, limit=most, unit=limit.unit)
        size = digits(*(v / limit.factor for v in (self.value, self.low, self.high)))
        return join(", ", (f"{size.words()} {limit.unit}", *([] if size.low else [say("no interval")]),
                           *filter(None, [self.reason])))  # fmt: skip


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
            judgements += [Judgement(name, limit, NOT_DECIDED, reason) for limit in limits]
    return tuple(judgements)


def judge(channel: str, limit: Limit, seen: Seen) -> Judgement:
    """Hold what is known of a coefficient against its limit; see `Specification` for the rule."""
    return Judgement(channel, limit, held(*seen.limits, limit.maximum), seen.words(limit))


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
        low, high = minimum.interval(level)
        return Seen(minimum.deviation, low, high, high, FALLING)
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
