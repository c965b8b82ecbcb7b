"""Comparison: what has changed between two records of the same type of sensor, and whether it is significant."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.choices import described
from allanite.core.curve import Curve
from allanite.core.encoding import finite, plain
from allanite.core.fit import Fit, chance
from allanite.core.limits import demand_level
from allanite.core.plain import Header, Value
from allanite.core.record import Record
from allanite.phrases.phrase import duration, join, say, say_count
from allanite.study.settings import ComparisonChoices

from .change import Change, ComparedChannel, Together, holm, of_symbol, told

SECOND = 5.0
"""Factor of the p of curves: with it the share of equal records that are called different stays that of the test."""


@dataclass(frozen=True, eq=False, repr=False)
class Ratios(Value):
    """Ratio of two curves' variances, after over before, at the averaging times that both have."""

    _also = ("ratio",)
    _alike = ("before.variance after.variance p",)

    # before, after: with their limits, at the same averaging times
    before: Curve
    after: Curve
    p: FloatArray  # shape (k,); p-value of each ratio, separately for each averaging time
    # interval of the ratio of the variances, from the distribution of a ratio of two weighted sums of chi-squares;
    # with many degrees of freedom it is Fisher's F
    limits: Callable[[float], tuple[FloatArray, FloatArray]]

    @property
    def tau(self) -> FloatArray:
        """Averaging times, s."""
        return self.before.tau

    @property
    def ratio(self) -> FloatArray:
        """Variance after over variance before."""
        with np.errstate(divide="ignore", invalid="ignore"):  # of nothing it is infinite, or not a number
            return np.asarray(self.after.variance / self.before.variance)

    def interval(self, level: float = 0.95) -> tuple[FloatArray, FloatArray]:
        """Confidence limits (low, high) of the ratio of the variances."""
        demand_level(level)
        return self.limits(level)

    def rows(self, level: float = 0.95) -> tuple[list[str], list[list[float]]]:
        """Headings and rows for any table."""
        unit = self.before.unit
        headings = ["tau [s]", f"before [{unit}]", f"after [{unit}]", "edf before", "edf after", "variance ratio",
                    f"low {level:.4g}", f"high {level:.4g}", "p"]  # fmt: skip
        columns = [self.tau, self.before.deviation, self.after.deviation, self.before.edf, self.after.edf, self.ratio,
                   *self.interval(level), self.p]  # fmt: skip
        return headings, [list(row) for row in zip(*(c.tolist() for c in columns), strict=True)]

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data."""
        low, high = self.interval(level)
        return super().to_dict(level) | {"low": plain(low), "high": plain(high), "level": level}

    def apart(self, alpha: float) -> tuple[int, float] | None:
        """The averaging time at which the curves differ most, and its p; None above alpha."""
        # The p is adjusted for the number of times (Holm), and for a second look at records that were compared already.
        adjusted = [min(1.0, SECOND * p) for p in holm(self.p.tolist())]
        least = min(range(len(adjusted)), key=lambda i: (adjusted[i], self.p[i]))
        return (least, adjusted[least]) if adjusted[least] <= alpha else None

    def _summary(self) -> str:
        return f"after over before, {self.tau.size} averaging times, {self.ratio.min():.3g} to {self.ratio.max():.3g}"


@dataclass(frozen=True, eq=False, repr=False)
class Pair(ComparedChannel):
    """One channel before and after; where only fits were at hand there is no test, and there are no records."""

    _keys: ClassVar = {"changes": "terms"}
    _also = ("verdict", "changed")

    fits: tuple[Fit, Fit] | None = None  # type: ignore[assignment]
    records: tuple[Record | Header, Record | Header] | None = None  # type: ignore[assignment]
    changes: tuple[Change, ...] = ()  # one a term
    ratios: Ratios | None = None
    whole: Fit | None = None  # fit of the record of which both are parts, in a study of truncation
    paired: bool = False  # whether both hold the same noise, and are compared sample by sample

    def __getitem__(self, symbol: str) -> Change:
        return of_symbol(self.changes, symbol, "compared")

    @property
    def p(self) -> float:
        """p-value of the whole: by the likelihood ratio, or the least adjusted one of the coefficients."""
        if self.test is not None:
            return self.test.p
        return min((change.adjusted for change in self.changes), default=math.nan)

    @property
    def changed(self) -> bool:
        """Whether the records differ significantly: in their noise, its shape, a sinusoid, or a curve at some time."""
        more = any(c.significant for c in self.changes if c.frequency is not None or c.parameter)
        return self.p <= self.alpha or more or bool(self._curves)

    @property
    def verdict(self) -> str:
        """What has changed and what has not, in a sentence or two."""
        if self.refusal:
            return say("not compared: {reason}", reason=self.refusal)
        named = join(", ", [told(change) for change in self.changes if change.significant])
        first: str = self._headline
        if self.changed:
            first = join(": ", [first, named or say("no single coefficient changes significantly")])
        elif named:
            first = say("{verdict}; by itself {changes}", verdict=first, changes=named)
        parts = [first, *filter(None, [self._curves])]
        same = [c.label for c in self.changes if c.outcome == "no change"]
        if same:
            parts.append(say("unchanged within their intervals: {coefficients}", coefficients=join(", ", same)))
        longer = [c.label if c.needed is None
                  else say("{coefficient} (at {length} or more)", coefficient=c.label, length=duration(c.needed))
                  for c in self.changes if c.outcome == "not resolvable"]  # fmt: skip
        if longer:
            parts.append(say("not resolvable in these records, but in longer ones: {coefficients}, where a coefficient "
                             "as large as its limit changes by a factor of 2",
                             coefficients=join(", ", longer)))  # fmt: skip
        return join("; ", parts)

    @property
    def _headline(self) -> str:
        if self.p <= self.alpha:
            return say("the noise has changed, {evidence}", evidence=self._evidence)
        if self.changed:
            return say("the records differ, although the noise as a whole shows no change, {evidence}",
                       evidence=self._evidence)  # fmt: skip
        return say("no change of the noise is detected, {evidence}", evidence=self._evidence)

    @property
    def _evidence(self) -> str:
        p, test = chance(self.p), self.test
        if test is None:
            return p
        if self.paired:
            freedom = say_count(test.dof, "{count} octave of frequency", "{count} octaves of frequency")
        else:
            freedom = say_count(test.dof, "{count} coefficient", "{count} coefficients")
        return say("{p} (likelihood ratio {ratio:.4g} for {freedom})", p=p, ratio=test.statistic, freedom=freedom)

    @property
    def _curves(self) -> str:
        """Where the curves differ, all averaging times considered; empty if they do not."""
        most = None if self.ratios is None else self.ratios.apart(self.alpha)
        if self.ratios is None or most is None:
            return ""
        at, p = most
        return say_count(self.ratios.tau.size, "the curves differ, most at {tau:.4g} s (variance ratio {ratio:.3g}, "
                         "{p}, adjusted for {count} averaging time)", "the curves differ, most at {tau:.4g} s "
                         "(variance ratio {ratio:.3g}, {p}, adjusted for {count} averaging times)",
                         tau=float(self.ratios.tau[at]), ratio=float(self.ratios.ratio[at]), p=chance(p))  # fmt: skip

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data."""
        return super().to_dict(level) | {"p": finite(self.p)}


@described
@dataclass(frozen=True, repr=False)
class ComparisonSettings(ComparisonChoices, Value):
    """What is held against what."""


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Together[Pair]):
    """Every channel of two recordings, compared.

    ``comparison["z"]`` is the `Pair` of a channel; of a single channel ``comparison["N"]`` is the `Change` of a term.

    Attributes
    ----------
    channels : tuple of Pair
    names : tuple of str
        Names of the recordings.
    settings : ComparisonSettings
    recipe, findings, notes, provenance
        As for `Study`; ``source 2`` is the second recording.
    """

    _channel = Pair

    settings: ComparisonSettings = field(default_factory=ComparisonSettings)

    @property
    def pairs(self) -> tuple[Pair, ...]:
        """The channels."""
        return self.channels

    def __getitem__(self, key: str | int) -> Any:
        if isinstance(key, str) and len(self.pairs) == 1 and self.pairs[0].name != key:
            return self.pairs[0][key]
        return super().__getitem__(key)

    @property
    def terms(self) -> tuple[Change, ...]:
        """The changes of all coefficients, channel after channel."""
        return tuple(change for pair in self.pairs for change in pair.changes)

    def choices(self) -> dict[str, Any]:
        """The recipe that was actually used, as plain data; for two fits only the level applies."""
        if not any(pair.records for pair in self.pairs):
            return self.recipe.to_dict(("level",))
        own = {"against": self.settings.against and list(self.settings.against), "part": self.settings.part}
        return super().choices() | {key: value for key, value in own.items() if value is not None}

    def rows(self, level: float | None = None) -> tuple[list[str], list[list[Any]]]:
        """Headings and rows: a coefficient before and after, its change in percent, and what that means."""
        level = level or self.level
        headings = ["channel", "term", "", "before", "after", "unit", "change %", f"low {level:.4g}",
                    f"high {level:.4g}", "p", "p (Holm)", "outcome"]  # fmt: skip
        return headings, [[pair.name, *change.row(level)] for pair in self.pairs for change in pair.changes]

    def _summary(self) -> str:
        return f"{' with '.join(self.names)}: {self.verdict}"
