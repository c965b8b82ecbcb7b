"""Budgets of files: every channel as a rate, its noise, and the noise added by the stages of its path."""

from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from allanite.extending import (
    Inspected,
    Job,
    Noise,
    Progress,
    Recipe,
    Record,
    Recording,
    RecordResult,
    Source,
    Value,
    public,
    run,
    whole_recording,
)

from .axes import Mixed, mixed
from .rounding_noise import Budget, budget
from .stage import Stage
from .torque import TorqueScale, factor_of


@dataclass(frozen=True, repr=False)
class PathSettings(Value):
    """How a rate came into the file.

    Attributes
    ----------
    stages : tuple of Stage
        The stages that rounded it, in their order.
    torquer : TorqueScale or float, optional
        Its scale, or rad/s per A.
    sense : float, optional
        Gain of the current sensor, V per A.
    axes : tuple of 4 float, optional
        The channels are the currents of two torquers: the matrix of `mixed`.
    """

    stages: tuple[Stage, ...]
    torquer: TorqueScale | float | None = None
    sense: float | None = None
    axes: tuple[float, ...] | None = None

    def choices(self) -> dict[str, Any]:
        """Plain data, under the names of the command line."""
        scale: dict[str, Any] = {"scale_factor": self.torquer}
        if isinstance(self.torquer, TorqueScale):
            scale = {"torquer": self.torquer.text}
        found = {"stages": [stage.text for stage in self.stages], **scale, "sense": self.sense,
                 "coupling": None if self.axes is None else list(self.axes)}  # fmt: skip
        return {key: value for key, value in found.items() if value is not None}


@dataclass(frozen=True, eq=False, repr=False)
class BudgetChannel(RecordResult):
    """One channel: its budget, or why there is none (`refusal`); `alerts` must stand beside the numbers."""

    budget: Budget | None = None
    alerts: tuple[str, ...] = ()
    refusal: str = ""

    @property
    def noise(self) -> Noise | None:
        """The rate noise."""
        return None if self.budget is None else self.budget.noise


@dataclass(frozen=True, eq=False, repr=False)
class BudgetStudy(Job[BudgetChannel]):
    """Budgets of the channels of a file."""

    _channel = BudgetChannel

    settings: PathSettings

    @property
    def rates(self) -> Recording:
        """The channels with a budget, as rates."""
        rates = (channel.budget.record for channel in self.channels if channel.budget is not None)
        return Recording(tuple(rate for rate in rates if isinstance(rate, Record)))

    def choices(self) -> dict[str, Any]:
        """The recipe and the settings that were actually used, as plain data."""
        return super().choices() | self.settings.choices()


@public
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
        Called with a description of the current step and the fraction completed.

    Raises
    ------
    DataError
        The file cannot be read, or no channel has a budget.
    UsageError
        A constant is missing or not positive.
    """
    recipe = recipe or Recipe()
    whole = whole_recording(source, recipe, otherwise=("current", "voltage"), progress=progress)
    axes: dict[str, Mixed] = {}
    if settings.axes is not None:  # the currents of both axes combined
        axes = {axis.record.name: axis for axis in mixed(whole, settings.axes, settings.stages)}
        whole = replace(whole, records=tuple(axis.record for axis in axes.values()))

    def work(seen: Inspected) -> BudgetChannel:
        scale: TorqueScale | float | None = settings.torquer
        axis = axes.get(seen.name)
        if axis is not None and scale is not None:
            scale = factor_of(scale) * axis.gain
        found = budget(seen.record, settings.stages, scale=scale, sense=settings.sense, recipe=recipe,
                       clipped=None if axis is None else axis.clipped)  # fmt: skip
        told = {f.name for f in found.findings}
        alerts = tuple(str(f) for f in seen.quality.warnings if f.name not in told)
        return BudgetChannel(seen.record, found, (*found.alerts, *alerts))

    def refused(seen: Inspected, why: str) -> BudgetChannel:
        return BudgetChannel(seen.record, refusal=why)

    return run(partial(BudgetStudy, settings=settings), whole, recipe, work, refused, doing="measuring",
               progress=progress)  # fmt: skip
