"""Budgets of files: every channel as a rate, its noise, and what the stages of its path add."""

from dataclasses import dataclass
from functools import partial
from typing import Any

from allanite.core.record import Record, Recording
from allanite.study.channels import Inspected, Job, Progress, Source, run
from allanite.study.recipe import Recipe

from .rounding_noise import Budget, budget
from .stage import Stage
from .torque import TorqueScale


@dataclass(frozen=True)
class PathSettings:
    """How a rate came into the file.

    Attributes
    ----------
    stages : tuple of Stage
        The stages that rounded it, in their order.
    scale : TorqueScale or float, optional
        Of the torquer, or rad/s per A.
    sense : float, optional
        Of the sensor of its current, V per A.
    """

    stages: tuple[Stage, ...]
    scale: TorqueScale | float | None = None
    sense: float | None = None

    def to_dict(self) -> dict[str, Any]:
        """Plain data, under the names of the command line."""
        torquer = isinstance(self.scale, TorqueScale)
        found = {
            "stages": [stage.text for stage in self.stages],
            "torquer": self.scale.text if isinstance(self.scale, TorqueScale) else None,
            "scale_factor": None if torquer else self.scale,
            "sense": self.sense,
        }
        return {key: value for key, value in found.items() if value is not None}


@dataclass(frozen=True, eq=False)
class BudgetChannel:
    """One channel: its budget, or why there is none (`refusal`); `alerts` must stand beside the numbers."""

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
class BudgetStudy(Job[BudgetChannel]):
    """Budgets of the channels of a file."""

    settings: PathSettings

    @property
    def rates(self) -> Recording:
        """The channels with a budget, as rates."""
        return Recording(tuple(channel.budget.record for channel in self.channels if channel.budget is not None))

    def choices(self) -> dict[str, Any]:
        """The recipe and the settings that were really used, as plain data."""
        return super().choices() | self.settings.to_dict()

    def to_dict(self) -> dict[str, Any]:
        """Plain data; `scale` is that of the torquer, rad/s per A."""
        scale = self.settings.scale
        return super().to_dict() | {
            "scale": scale.factor if isinstance(scale, TorqueScale) else scale,
            "sense": self.settings.sense,
        }


def budget_file(
    source: Source, recipe: Recipe | None, settings: PathSettings, *, progress: Progress | None = None
) -> BudgetStudy:
    """The budget of every channel of a file.

    Parameters
    ----------
    source : Recording, Record or path
    recipe : Recipe or None
        How it is read, and how the noise is identified.
    settings : PathSettings
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
    recipe = recipe or Recipe()

    def work(seen: Inspected) -> BudgetChannel:
        found = budget(seen.record, settings.stages, scale=settings.scale, sense=settings.sense, recipe=recipe)
        told = {f.name for f in found.findings}
        alerts = tuple(str(f) for f in seen.quality.warnings if f.name not in told)
        return BudgetChannel(seen.record, found, (*found.alerts, *alerts))

    def refused(seen: Inspected, why: str) -> BudgetChannel:
        return BudgetChannel(seen.record, refusal=why)

    return run(partial(BudgetStudy, settings=settings), source, recipe, work, refused, doing="measuring",
               progress=progress)  # fmt: skip
