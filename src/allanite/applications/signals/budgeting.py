"""Budgets of files: every channel as a rate, its noise, and the noise added by the stages of its path."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from allanite.extending import (  # isort: skip
    DataError, Inspected, Job, Noise, Progress, Recipe, Record, Recording, RecordResult, Source, UsageError, Value,
    constructed, public, run, say, unit_of, whole_recording)  # fmt: skip

from .rounding_noise import Budget, budget
from .stage import Stage, TorqueScale, demand_in_range, factor_of

NAMES = ("wx", "wy")  # channels of the rates about x and y


class Mixed(NamedTuple):
    """The current that a torquer of one axis would have needed, and its scale over that of a torquer."""

    # `clipped` counts the samples of both currents at the ends of each stage, which cannot be seen in their sum.
    record: Record
    gain: float
    clipped: tuple[int, ...]


def mixed(currents: Recording, axes: Sequence[float], stages: Sequence[Stage] = ()) -> tuple[Mixed, Mixed]:
    r"""Combine the currents of the x and the y torquer.

    A torque about x turns the momentum of the rotor about y. With the scale K_i of one torquer

        (w_x, w_y)' = K_i [[xx, xy], [yx, yy]] (i_x, i_y)'

    where an ideal pair has 0, -1, 1, 0, signs by the winding, and cross-coupling stands in the diagonal. Each row is
    given as a current of unit weight and its length, so that rounding errors of both converters, which are independent
    and alike, are those of one converter of that scale.
    """
    if len(axes) != 4 or not all(math.isfinite(v) for v in axes):
        raise UsageError("the axes of two torquers are four numbers XX,XY,YX,YY, for example 0,-1,1,0, not "
                         f"{list(axes)!r}")  # fmt: skip
    xx, xy, yx, yy = (float(v) for v in axes)
    if abs(xx * yy - xy * yx) <= 1e-9 * math.hypot(xx, xy) * math.hypot(yx, yy):
        raise UsageError(f"the axes {list(axes)!r} give both rates from the same current: the matrix is singular")
    names = ", ".join(repr(record.name) for record in currents)
    if len(currents.records) != 2:
        raise DataError(say("the axes of two torquers need two currents, but there are {channels}", channels=names))
    first, second = currents
    if first.signal is not second.signal or first.signal.inertial:
        raise DataError(say("the axes of two torquers need two currents of one kind, not {channels}", channels=names))
    clipped = tuple(demand_in_range(first, stage) + demand_in_range(second, stage) for stage in stages)
    x, y = (record.rate_values / unit_of(first.unit).factor for record in currents)
    mixtures = []
    for name, row in zip(NAMES, ((xx, xy), (yx, yy)), strict=True):
        gain = math.hypot(*row)
        words = say("{x:.6g} of {first!r} and {y:.6g} of {second!r}", x=row[0], y=row[1], first=first.name,
                   second=second.name)  # fmt: skip
        values = np.asarray((row[0] * x + row[1] * y) / gain + 0.0)
        record = Record(values, first.rate, first.unit, name=name, start=first.start, history=(*first.history, words))
        mixtures.append(Mixed(record, gain, clipped))
    return mixtures[0], mixtures[1]


@constructed
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
        choices = {"stages": [stage.text for stage in self.stages], **scale, "sense": self.sense,
                 "coupling": None if self.axes is None else list(self.axes)}  # fmt: skip
        return {key: value for key, value in choices.items() if value is not None}


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
        result = budget(seen.record, settings.stages, scale=scale, sense=settings.sense, recipe=recipe,
                        clipped=None if axis is None else axis.clipped)  # fmt: skip
        told = {f.name for f in result.findings}
        alerts = tuple(str(f) for f in seen.quality.warnings if f.name not in told)
        return BudgetChannel(seen.record, result, (*result.alerts, *alerts))

    return run(partial(BudgetStudy, settings=settings), whole, recipe, work,
               lambda seen, why: BudgetChannel(seen.record, refusal=why), doing="measuring",
               progress=progress)  # fmt: skip
