"""ClaimCheck: what of a claim a record confirms, what it contradicts, and why."""

import math
from collections.abc import Container
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.curve import Curve
from allanite.core.encoding import finite
from allanite.core.limits import NOT_DECIDED
from allanite.core.model import Model
from allanite.core.plain import Value
from allanite.core.units import Signal, unit_of
from allanite.phrases.phrase import join, say, say_count
from allanite.statistics.moments.moments import expected
from allanite.study.results import Channel, Study

from .claim import ClaimedNoise

AGREES, DIFFERS, EXCEEDS = "agrees", "differs", "exceeds"
UNCLAIMED = "not claimed"

OUTCOMES = {
    DIFFERS: say("the interval of the factor excludes 1, all comparisons of the record considered"),
    EXCEEDS: say("the interval of the factor lies above 1, all comparisons of the record considered"),
    UNCLAIMED: say("noise that the record has and the claim has not"),
    NOT_DECIDED: say("the record neither confirms nor contradicts it"),
    AGREES: say("the interval of the factor holds 1, or comes near enough to it"),
}
"""What each outcome means, the worst first."""

CONTRADICTS = (DIFFERS, EXCEEDS, UNCLAIMED)  # outcomes by which a record disagrees with a claim


@dataclass(frozen=True, repr=False)
class CheckedTerm(Value):
    """One number of a claim held against the record."""

    # name of the channel; of a correlation time, which the channels of a sensor have in common, their names
    channel: str
    signal: Signal
    # symbol of a term; "minimum" of the Allan deviation; "T", a correlation time; "curve", the Allan deviation where
    # it is farthest from the claimed one; "kurtosis", the excess kurtosis of the residuals; "cutoff" of a low-pass
    # filter, and "rate" of the sensor, Hz
    quantity: str
    # claimed, found: SI; None if it is not claimed, or nothing was found
    claimed: float | None
    found: float | None
    unit: str  # unit in which it is shown
    # ratio, low, high: found over claimed with its interval, whose level considers all comparisons of the record. NaN
    # if unknown.
    ratio: float = float("nan")
    low: float = float("nan")
    high: float = float("nan")
    outcome: str = AGREES  # a key of `OUTCOMES`
    reason: str = ""

    @property
    def contradicts(self) -> bool:
        """Whether the record contradicts the claim."""
        return self.outcome in CONTRADICTS

    def shown(self, value: float | None) -> float | None:
        """A value in `unit`."""
        return value if value is None or not self.unit else value / unit_of(self.unit).factor

    def _summary(self) -> str:
        return f"{self.channel!r}: {self.quantity} {self.outcome}, {self.ratio:.4g} ({self.low:.4g} .. {self.high:.4g})"


@dataclass(frozen=True, repr=False)
class Cause(Value):
    """Why channels of a kind of sensor miss their claim."""

    _alike = ("names sentences",)

    channels: tuple[str, ...]
    quantity: str  # as in `CheckedTerm`
    # factor, low, high: found over claimed, of all these channels together; NaN if it is no factor
    factor: float
    low: float
    high: float
    # factors that lie in the interval, as formulas, the nearest first; empty if none does
    names: tuple[str, ...] = ()
    sentences: tuple[str, ...] = ()  # what each of them means

    def only(self, names: Container[str]) -> "Cause":
        """The cause with some of its factors."""
        kept = [pair for pair in zip(self.names, self.sentences, strict=True) if pair[0] in names]
        return replace(self, names=tuple(name for name, _ in kept), sentences=tuple(sentence for _, sentence in kept))

    @property
    def words(self) -> str:
        """The factor and what explains it: ``N is 1.414 times the claimed: sqrt(2), one-sided density ...``."""
        named = [join(": ", filter(None, pair)) for pair in zip(self.names, self.sentences, strict=True)]
        if math.isnan(self.factor):
            return join("; ", named)
        if math.isinf(self.factor) or math.isinf(self.high):
            words = say("{term} is more than {factor:.3g} times the claimed", term=self.quantity, factor=self.low)
        elif self.low <= 0:
            words = say("{term} is less than {factor:.3g} times the claimed", term=self.quantity, factor=self.high)
        else:
            words = say("{term} is {factor:.4g} times the claimed", term=self.quantity, factor=self.factor)
        return join(": ", (words, join("; ", filter(None, named)) or say("no convention explains it")))

    def _summary(self) -> str:
        return f"{', '.join(self.channels)}: {self.words}"


@dataclass(frozen=True, eq=False, repr=False)
class ClaimCheck(Study):
    """A study of a recording, held against what is claimed of its noise.

    Attributes
    ----------
    claim : ClaimedNoise
    terms : tuple of CheckedTerm
    causes : tuple of Cause
    tolerance : float
        Relative difference that is accepted.
    channels, recipe, findings, notes, provenance
        As for `Study`.
    """

    claim: ClaimedNoise = field(default_factory=lambda: ClaimedNoise("", "model", ()))
    terms: tuple[CheckedTerm, ...] = ()
    causes: tuple[Cause, ...] = ()
    tolerance: float = 0.0

    @property
    def agrees(self) -> bool:
        """Whether the record contradicts nothing that is claimed."""
        return not any(row.contradicts for row in self.terms)

    @property
    def checked(self) -> tuple[Channel, ...]:
        """The channels of which something is claimed."""
        names = {row.channel for row in self.terms}
        return tuple(channel for channel in self.channels if channel.record.name in names)

    @property
    def verdict(self) -> str:
        """The answer in a few words."""
        against = [row for row in self.terms if row.contradicts]
        if all(row.outcome == NOT_DECIDED for row in self.terms):
            return say("the record neither confirms nor contradicts the claim")
        if not against:
            return say("the record agrees with the claim")
        channels = list(dict.fromkeys(row.channel for row in against if row.quantity != "T"))
        if not channels:
            return say("the correlation time of the bias disagrees with the claim")
        return say_count(len(self.checked), "{number} of {count} channel disagrees with the claim",
                         "{number} of {count} channels disagree with the claim", number=len(channels))  # fmt: skip

    def claimed_curve(self, channel: Channel) -> FloatArray | None:
        """The deviation that is claimed of a channel at the averaging times of its curve, in the curve's unit."""
        model = self.claim.of(channel.record.signal)
        noise = None if model is None else model.noise
        if noise is None or channel.curve is None:
            return None
        return claimed_deviation(noise, channel.curve)

    def choices(self) -> dict[str, Any]:
        """The recipe that was actually used, as plain data."""
        return super().choices() | {"claims": self.claim.text, "tolerance": self.tolerance}

    def to_dict(self, level: float | None = None) -> dict[str, Any]:
        """Plain data, with limits at `level`, by default that of the recipe."""
        return super().to_dict(level) | {"agrees": self.agrees, "verdict": self.verdict}

    def rows(self, level: float | None = None) -> tuple[list[str], list[list[Any]]]:
        """Headings and rows: what is claimed and found, their ratio with its interval, the outcome."""
        headings = ["channel", "quantity", "claimed", "found", "unit", "ratio", "low", "high", "outcome", "reason"]
        return headings, [[row.channel, row.quantity, row.shown(row.claimed), row.shown(row.found),
                           row.unit, *map(finite, (row.ratio, row.low, row.high)), row.outcome, row.reason]
                          for row in self.terms]  # fmt: skip

    def _summary(self) -> str:
        return f"against {self.claim.title}: {self.verdict}"


def claimed_deviation(model: Model, curve: Curve) -> FloatArray:
    """The expected deviation of a model at the averaging times of a curve, in its unit."""
    variance = expected(model, curve.statistic, curve.tau, rate=curve.rate, size=curve.size or None)
    return np.sqrt(variance) / unit_of(curve.unit).factor
