"""Change: one coefficient before and after. Homogeneity: whether several records have the same noise."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Self, TypeVar

from allanite.core.encoding import finite, plain
from allanite.core.errors import UsageError
from allanite.core.estimate import TERM, Estimate
from allanite.core.fit import Fit, chance
from allanite.core.kinds import title_of
from allanite.core.limits import Remembered, demand_level
from allanite.core.names import demand_name
from allanite.core.plain import Header, Value
from allanite.core.record import Record
from allanite.core.units import Signal
from allanite.phrases.phrase import join, say
from allanite.study.channels import Inspected
from allanite.study.job import Job
from allanite.terms import TERMS
from allanite.terms.row import Parameter

Limits = Callable[[float], tuple[float, float]]

RESOLVED = 2.0
"""If the interval of a ratio contains this factor or its inverse, the record does not resolve the coefficient."""

OUTCOMES = {
    "smaller": say("the coefficient is smaller in the second record, with the adjusted p-value"),
    "larger": say("the coefficient is larger in the second record, with the adjusted p-value"),
    "no change": say("no significant change, and a change by a factor of 2 is excluded by the interval"),
    "not resolvable": say(
        "no significant change, but a change by a factor of 2 is not excluded either: a longer record would decide. "
        "The length that is named is that for a coefficient as large as its upper limit"
    ),
}
"""What each outcome means."""


@dataclass(frozen=True, repr=False)
class Homogeneity(Value):
    """Test of whether several records have the same noise."""

    statistic: float  # twice the gain in log-likelihood of separate models over one common model
    dof: int  # number of additional coefficients
    p: float  # p-value: by bootstrap as far as its draws permit, by chi-square beyond
    draws: int  # number of draws; 0 where chi-square was clear enough


@dataclass(frozen=True, eq=False, repr=False)
class Change(Value):
    """One coefficient before and after."""

    _keys: ClassVar = {"adjusted": "p_holm"}
    _also = ("outcome",)

    _checks = TERM

    # symbol, signal: the term, and the kind of sensor
    symbol: str
    signal: Signal
    before: Estimate
    after: Estimate
    ratio: float  # the coefficient after over that before, with its sign for a ramp; NaN where neither record has any
    # p, adjusted: p-value of the difference; the same after Holm's correction for all terms
    p: float
    adjusted: float
    limits: Limits  # interval of the ratio
    alpha: float = 0.05  # adjusted p below which the change is significant
    frequency: float | None = None  # frequency of a sinusoid, Hz
    parameter: str = ""  # that of the shape of the term which is compared, not the coefficient: "frequency"
    # length of each record, s, needed to detect a change by a factor of 2 of a coefficient that is as large as its
    # upper limit, if these records do not resolve it
    needed: float | None = None

    def __post_init__(self) -> None:
        demand_name("parameter", self.parameter, [*(p.name for p in TERMS[self.symbol].parameters), ""])

    @property
    def label(self) -> str:
        """The symbol; of a sinusoid with its frequency."""
        return self.named(self.symbol)

    def named(self, term: str) -> str:
        """A symbol or title of its term; of a sinusoid with its frequency."""
        if self.parameter:
            return join(" ", (term, self.shape.title))
        if self.frequency is None:
            return term
        return say("{term} at {frequency:.4g} Hz", term=term, frequency=self.frequency)

    @property
    def shape(self) -> Parameter:
        """The row of its parameter."""
        return next(p for p in TERMS[self.symbol].parameters if p.name == self.parameter)

    @property
    def unit(self) -> str:
        """Unit in which it is shown."""
        return self.shape.unit if self.parameter else self.before.sheet_unit

    @property
    def sizes(self) -> list[float | None]:
        """Before and after, in the unit that is shown; None where there is none."""
        each = (self.before, self.after)
        if self.parameter:
            return [next((v for p, v, *_ in e.shaped() if p.name == self.parameter), None) for e in each]
        return [None if e.value is None else e.to(self.unit) for e in each]

    @property
    def percent(self) -> float:
        """Change in percent of the coefficient before."""
        return 100 * (self.ratio - 1)

    def interval(self, level: float = 0.95) -> tuple[float, float]:
        """Confidence limits (low, high) of the change in percent; -100 and infinity where there are none."""
        demand_level(level)
        low, high = self.limits(level)
        return 100 * (low - 1), 100 * (high - 1)

    @property
    def significant(self) -> bool:
        """Whether the change is significant, all terms considered."""
        return self.adjusted <= self.alpha

    @property
    def outcome(self) -> str:
        """A key of `OUTCOMES`."""
        low, high = self.limits(1 - self.alpha)
        if self.significant:
            return "smaller" if abs(self.ratio) < 1 else "larger"
        return "no change" if low > 1 / RESOLVED and high < RESOLVED else "not resolvable"

    def row(self, level: float = 0.95) -> list[Any]:
        """Symbol, name, coefficients before and after, unit, change in percent, its limits, p, adjusted p, outcome."""
        title = self.shape.title if self.parameter else title_of(self.symbol, self.signal)
        return [self.label, title, *self.sizes, self.unit, self.percent, *self.interval(level), self.p, self.adjusted,
                self.outcome]  # fmt: skip

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data."""
        low, high = self.interval(level)
        change = {"change_percent": self.percent, "low_percent": low, "high_percent": high}
        data = super().to_dict(level) | {key: finite(value) for key, value in change.items()} | {"level": level}
        if not math.isclose(level, 1 - self.alpha):  # the outcome is read off the limits at this level
            data["limits"]["also"] = {"level": 1 - self.alpha, "values": plain(self.limits(1 - self.alpha))}
        return data

    def _summary(self) -> str:
        return told(self) if self.significant else f"{self.label}: {self.outcome}, {chance(self.p)}"


def alpha_of(level: float) -> float:
    """The p up to which a difference is called one, at a confidence level: 0.05, not 0.050000000000000044."""
    return round(1 - level, 12)


def holm(p: list[float]) -> list[float]:
    """P-values adjusted for their number (S. Holm, Scandinavian J. Statistics 6 (1979) 65)."""
    adjusted, least = [0.0] * len(p), 0.0
    for rank, i in enumerate(sorted(range(len(p)), key=lambda i: p[i])):
        least = max(least, min(1.0, (len(p) - rank) * p[i]))
        adjusted[i] = least
    return adjusted


def changes_of(contrasts: Mapping[tuple[str, str], Any], fits: tuple[Fit, Fit], level: float,
               lines: Sequence[tuple[float, Any]] = ()) -> tuple[Change, ...]:  # fmt: skip
    """The change of each coefficient, by symbol and parameter, and of each sinusoid, from what contrasts it."""
    each: list[tuple[Any, ...]] = []
    each += [(c, s, fits[0][s], fits[1][s], parameter, None) for (s, parameter), c in contrasts.items()]
    each += [(c, "Sine", c.first, c.second, "", frequency) for frequency, c in lines]
    chances = [contrast.p for contrast, *_ in each]
    return tuple(
        Change(symbol, fits[0].signal, before, after, c.ratio, p, adjusted, Remembered(c.limits), alpha_of(level),
               frequency, parameter)
        for (c, symbol, before, after, parameter, frequency), p, adjusted
        in zip(each, chances, holm(chances), strict=True)
    )  # fmt: skip


def told(change: Change) -> str:
    """A significant change in a few words: ``N -6.29 % (-6.46 to -6.12 %)``."""
    low, high = change.interval(1 - change.alpha)
    valued = [e.value is not None for e in (change.before, change.after)]
    if valued == [False, True]:
        return say("{coefficient} is detected only in the second record", coefficient=change.label)
    if valued == [True, False] and change.frequency is None:
        return say("{coefficient} is detected only in the first record", coefficient=change.label)
    if TERMS[change.symbol].waveform is not None and change.ratio < 0:
        return say("{coefficient} has changed its sign", coefficient=change.symbol)
    if not (math.isfinite(low) and math.isfinite(high)):
        return join(" ", (change.label, f"{change.percent:+.3g} %"))
    return say("{coefficient} {percent:+.3g} % ({low:+.3g} to {high:+.3g} %)",
               coefficient=change.label, percent=change.percent, low=low, high=high)  # fmt: skip


Compared = TypeVar("Compared", bound="ComparedChannel")
OfTerm = TypeVar("OfTerm", bound=Any)  # a result for one coefficient: it has a symbol


@dataclass(frozen=True, eq=False, repr=False)
class ComparedChannel(Value):
    """One channel of several recordings; `refusal` says why it has no result."""

    name: str  # name of the channel; of all if they differ
    test: Homogeneity | None = None  # the likelihood ratio of one common model against one for each record
    fits: tuple[Fit, ...] = ()
    explained: tuple[bool, ...] = ()  # whether each fit explains its record
    grades: tuple[str, ...] = ()  # how well, as text
    records: tuple[Record | Header, ...] = ()  # only the header of each where the result was stored
    band: tuple[float, float] | None = None  # frequencies that were compared, Hz
    alerts: tuple[str, ...] = ()  # what must stand beside the numbers
    refusal: str = ""
    alpha: float = 0.05  # the p up to which a difference is called one

    @classmethod
    def refused(cls, channel: Inspected, why: str) -> Self:
        """A channel without a result."""
        return cls(channel.name, records=channel.records, alerts=channel.alerts, refusal=why)

    @property
    def verdict(self) -> str:
        """What was found, in a sentence or two."""
        raise NotImplementedError

    def _summary(self) -> str:
        return f"{self.name!r}: {self.verdict}"


def of_symbol(results: Sequence[OfTerm], symbol: str, done: str) -> OfTerm:
    """The one of that symbol; where there is none, an error says what was `done` instead."""
    for result in results:
        if result.symbol == symbol:
            return result
    raise UsageError(f"{symbol!r} was not {done}; terms: {', '.join(result.symbol for result in results)}")


@dataclass(frozen=True, eq=False, repr=False)
class Together(Job[Compared]):
    """A result for each channel of several recordings; ``source 2`` and so on are the other recordings."""

    _used = None

    names: tuple[str, ...]  # of the recordings

    @property
    def level(self) -> float:
        """Confidence level of all limits."""
        return self.recipe.level

    @property
    def verdict(self) -> str:
        """The verdicts, a line a channel."""
        many = len(self.channels) > 1
        return join("\n", [join(": ", (c.name, c.verdict)) if many else c.verdict for c in self.channels])

    def _explained(self, channel: Any) -> bool:
        """Whether a model explains each record of a channel."""
        return all(channel.explained)

    def to_dict(self, level: float | None = None) -> dict[str, Any]:
        """Plain data, with limits at `level`, by default that of the recipe."""
        return super().to_dict(level) | {"verdict": self.verdict}
