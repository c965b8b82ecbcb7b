"""What a row of the table of estimators holds, and what it measures."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

from allanite.extending import FloatArray, say, spelled

from .setting import Task


@dataclass(frozen=True, eq=False)
class Interval:
    """The data of one measurement."""

    steps: FloatArray  # shape (n,); samples per sample interval, `offset` subtracted, dither sinusoids removed
    offset: float  # in samples
    size: float  # rate of one sample, SI
    pulse: float  # quantum of the angle in samples; NaN where there is none


class RateMeasurement(NamedTuple):
    """What an estimator found: in samples beyond the offset, what else there is to say, limits that are certain."""

    value: float
    details: Mapping[str, float]
    bounds: tuple[float, float] | None = None


@dataclass(frozen=True)
class RateEstimator:
    """A row of `RATE_ESTIMATORS`."""

    # name, title, formula, reference: what it is called, as text, LaTeX, source
    name: str
    title: str
    formula: str
    reference: str
    assumes: str  # when it is the best there is
    # shape (n,); the weights of the rates, their sum is 1; of a method that is not linear, those to which it tends
    weights: Callable[[Task], FloatArray]
    measure: Callable[[Interval, FloatArray, Task], RateMeasurement]
    # variance beyond that of the weights, SI; NaN where it is not known
    excess: Callable[[Task], float] = lambda task: 0.0
    needs_model: bool = False
    needs_quantum: bool = False
    # color of its line in figures, ``#RRGGBB``
    color: str = "#6B6B6B"

    def lacks(self, task: Task) -> str:
        """What the method needs and a task does not have; empty if it can be used."""
        if self.needs_quantum and not math.isfinite(task.pulse):
            option = spelled("--quantum", "quantum=...")
            return say("it needs counts, or the quantum of the angle ({option})", option=option)
        return say("it needs a noise model") if self.needs_model and task.model is None else ""


def linear(interval: Interval, weights: FloatArray, _: Task) -> RateMeasurement:
    """The weighted mean."""
    return RateMeasurement(float(weights @ interval.steps), {})
