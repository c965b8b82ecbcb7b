"""What a comparison and a pool have in common: a job on the channels of several recordings."""

from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import Any, Self, TypeVar

from allanite.core.errors import UsageError
from allanite.core.plain import Value
from allanite.study.channels import Job
from allanite.study.recipe import Recipe

Compared = TypeVar("Compared", bound=Any)
"""The result of one channel: it has a name, a verdict and a refusal."""


@dataclass(frozen=True, eq=False, repr=False)
class Together(Value, Job[Compared]):
    """A result for each channel of several recordings.

    Attributes
    ----------
    channels : tuple
    names : tuple of str
        Of the recordings.
    recipe, findings, notes, provenance
        As of `Job`; ``source 2`` and so on are the other recordings.
    """

    names: tuple[str, ...]

    def __iter__(self) -> Iterator[Compared]:
        return iter(self.channels)

    def __getitem__(self, key: str | int) -> Compared:
        if isinstance(key, int):
            return self.channels[key]
        for channel in self.channels:
            if channel.name == key:
                return channel
        raise UsageError(f"no channel {key!r}; there are {', '.join(channel.name for channel in self.channels)}")

    @property
    def level(self) -> float:
        """Confidence level of all limits."""
        return self.recipe.level

    @property
    def verdict(self) -> str:
        """The verdicts, a line a channel."""
        many = len(self.channels) > 1
        return "\n".join(f"{c.name}: {c.verdict}" if many else c.verdict for c in self.channels)

    def choices(self) -> dict[str, Any]:
        """The recipe that was really used, as plain data."""
        return self.recipe.to_dict()

    def to_dict(self, level: float | None = None) -> dict[str, Any]:
        """Plain data, with the limits of the recipe's level if no other is given."""
        data = Job.to_dict(self) | {"names": list(self.names), "verdict": self.verdict}
        return data if level is None else data | {"channels": [channel.to_dict(level) for channel in self.channels]}

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> Self:
        """What `to_dict` has written; its limits are known for the stored level only."""
        known = {f.name for f in fields(Recipe)}
        chosen = data.get("recipe", {})
        recipe, own = ({k: v for k, v in chosen.items() if (k in known) is ours} for ours in (True, False))
        return super().from_dict({**data, "recipe": recipe, "settings": own} if "recipe" in data else data)
