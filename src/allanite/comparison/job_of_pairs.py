"""What a comparison and a pool have in common: a job on the channels of several recordings."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from allanite.core.errors import UsageError
from allanite.phrases.phrase import join
from allanite.study.job import Job

Compared = TypeVar("Compared", bound=Any)
"""The result of one channel: it has a name, a verdict and a refusal."""


def of_symbol(found: Sequence[Compared], symbol: str, done: str) -> Compared:
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

    def _around(self, level: float, channels: list[Any]) -> dict[str, Any]:
        return super()._around(level, channels) | {"verdict": self.verdict}
