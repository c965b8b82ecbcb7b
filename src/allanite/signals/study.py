"""Budgets of files: every channel as a rate, its noise, and what the stages of its path add."""

import os
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from allanite.core.errors import DataError
from allanite.core.record import Record
from allanite.prepare import inspect
from allanite.signals import Budget, Stage, TorqueScale, budget
from allanite.study.analysis import Recipe, provenance_of, recording_of


@dataclass(frozen=True)
class SignalPath:
    """How a rate came into the file: the stages that rounded it, the torquer, the sensor of its current."""

    stages: tuple[Stage, ...]
    scale: TorqueScale | float | None = None
    sense: float | None = None


@dataclass(frozen=True, eq=False)
class BudgetChannel:
    """One channel: its budget, or why there is none."""

    record: Record
    budget: Budget | None = None
    alerts: tuple[str, ...] = ()
    refusal: str = ""

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data."""
        return {
            "name": self.record.name,
            "unit": self.record.unit,
            "budget": None if self.budget is None else self.budget.to_dict(level),
            "alerts": list(self.alerts),
            "refusal": self.refusal,
        }


@dataclass(frozen=True, eq=False)
class BudgetStudy:
    """Budgets of the channels of a file."""

    channels: tuple[BudgetChannel, ...]
    path: SignalPath
    recipe: Recipe
    notes: tuple[str, ...]
    provenance: dict[str, str]

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        scale = self.path.scale
        return {
            "allanite": 1,
            "type": "BudgetStudy",
            "channels": [channel.to_dict(self.recipe.level) for channel in self.channels],
            "scale": scale.factor if isinstance(scale, TorqueScale) else scale,
            "sense": self.path.sense,
            "recipe": self.recipe.to_dict(),
            "notes": list(self.notes),
            "provenance": self.provenance,
        }


def budget_file(
    source: str | os.PathLike[str],
    recipe: Recipe,
    path: SignalPath,
    *,
    progress: Callable[[str, float], None] | None = None,
) -> BudgetStudy:
    """The budget of every channel of a file.

    Parameters
    ----------
    source : path
    recipe : Recipe
        How it is read.
    path : Path
        How the rates came into it.
    progress : callable, optional
        Called with what is being done and the fraction that is finished.

    Raises
    ------
    DataError
        The file cannot be read, or no channel has a budget.
    UsageError
        A constant is missing or not positive.
    """
    tell = progress or (lambda what, fraction: None)
    tell("reading", 0.0)
    recording = recording_of(source, recipe)
    channels = []
    for i, record in enumerate(recording):
        tell(f"measuring {record.name}", (i + 0.3) / (len(recording) + 0.3))
        channels.append(_channel(record, path))
    if all(channel.refusal for channel in channels):
        raise DataError("; ".join(f"{channel.record.name or 'the record'}: {channel.refusal}" for channel in channels))
    tell("done", 1.0)
    return BudgetStudy(tuple(channels), path, recipe, recording.notes, provenance_of(recording))


def _channel(record: Record, path: SignalPath) -> BudgetChannel:
    quality = inspect(record)
    if quality.refusal:
        return BudgetChannel(record, refusal=quality.refusal)
    try:
        found = budget(record, path.stages, scale=path.scale, sense=path.sense)
    except DataError as error:
        return BudgetChannel(record, refusal=str(error))
    told = {f.name for f in found.findings}
    return BudgetChannel(record, found, tuple(str(f) for f in quality.warnings if f.name not in told))
