"""What a comparison and a pool have in common: a job on the channels of several recordings, and its result for one."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self, TypeVar

from allanite.core.errors import UsageError
from allanite.core.fit import Fit
from allanite.core.plain import Header, Value
from allanite.core.record import Record
from allanite.phrases.phrase import join
from allanite.study.channels import Inspected
from allanite.study.job import Job

from .change import Homogeneity

Compared = TypeVar("Compared", bound="ComparedChannel")
OfTerm = TypeVar("OfTerm", bound=Any)
"""A result for one coefficient: it has a symbol."""


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
    def refused(cls, seen: Inspected, why: str) -> Self:
        """A channel without a result."""
        return cls(seen.name, records=seen.records, alerts=seen.alerts, refusal=why)

    @property
    def verdict(self) -> str:
        """What was found, in a sentence or two."""
        raise NotImplementedError

    def _summary(self) -> str:
        return f"{self.name!r}: {self.verdict}"


def of_symbol(found: Sequence[OfTerm], symbol: str, done: str) -> OfTerm:
    """The one of that symbol; where there is none, an error says what was `done` instead."""
    for one in found:
        if one.symbol == symbol:
            return one
    raise UsageError(f"{symbol!r} was not {done}; terms: {', '.join(one.symbol for one in found)}")


@dataclass(frozen=True, eq=False, repr=False)
class Together(Job[Compared]):
    """A result for each channel of several recordings.

    Attributes
    ----------
    channels : tuple
    names : tuple of str
        Names of the recordings.
    recipe, findings, notes, provenance
        As for `Job`; ``source 2`` and so on are the other recordings.
    """

    names: tuple[str, ...]

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

    def choices(self) -> dict[str, Any]:
        """The recipe that was actually used, as plain data."""
        return self.recipe.to_dict()

    def to_dict(self, level: float | None = None) -> dict[str, Any]:
        """Plain data, with limits at `level`, by default that of the recipe."""
        return super().to_dict(level) | {"verdict": self.verdict}
