"""What the weights of an estimator follow from, and what a row of the table of estimators holds."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from allanite.applications.choices import EstimatorChoices
from allanite.extending import FloatArray, Model, Term, UsageError, Value, demand_name, described, say, spelled


@described
@dataclass(frozen=True, repr=False)
class EstimatorSettings(EstimatorChoices, Value):
    """Choices for individual estimators.

    Attributes
    ----------
    window : str
        For "hamming": any window that `scipy.signal.get_window` knows, taken symmetric.
    lines : int, optional
        For "conditional": number of regression lines, each starting one sample later; a 160th of the samples if left
        out, the 300 of 48000 of the paper.
    allowed : float, optional
        For "conditional": a line whose slope is farther from the median of slopes is dropped, SI; twice the robust
        standard deviation of the slopes if omitted (the paper gives no value).
    quantum : float, optional
        For "staircase": size of a step of the angle, in the record's unit (for a rate: times s); counts need none.
    """

    allowed: float | None = None


@dataclass(frozen=True, eq=False)
class Task:
    """What the weights of an estimator follow from: everything but the data."""

    size: int  # number of sample intervals
    rate: float  # sampling rate, Hz
    model: Model | None = None  # the noise
    target: str = "mean"  # a name in `TARGETS`: what is estimated where the rate itself drifts
    dither: tuple[float, ...] = ()  # frequencies of sinusoids to be removed, Hz
    options: EstimatorSettings = field(default_factory=EstimatorSettings)
    pulse: float = float("nan")  # quantum of the angle, SI; NaN where there is none

    def __post_init__(self) -> None:
        if self.size < 3:
            raise UsageError(f"a rate needs at least 3 samples, not {self.size}")
        demand_name("target", self.target, TARGETS)
        if self.target == "constant" and self.wandering:
            walks = ", ".join(t.symbol for t in self.wandering)
            raise UsageError(
                f"a constant rate cannot be separated from {walks}, whose drift is unbounded; use target='mean', "
                "'centre' or 'start': the rate including the drift, over or at that time"
            )
        for frequency in self.dither:
            if not (np.isfinite(frequency) and frequency > 0):
                raise UsageError(f"a dither frequency must be a positive number of Hz, not {frequency!r}")
            alias = abs(frequency - self.rate * round(frequency / self.rate))
            if alias * self.size < 2 * self.rate:
                raise UsageError(
                    f"dither at {frequency:g} Hz, sampled at {self.rate:g} Hz, appears at {alias:.3g} Hz: less than "
                    f"two periods in {self.size / self.rate:g} s cannot be separated from a rate"
                )

    @property
    def duration(self) -> float:
        """Measuring time, s."""
        return self.size / self.rate

    @property
    def needed_model(self) -> Model:
        """The model, or the words that it is needed."""
        if self.model is None:
            raise UsageError(
                "this needs a noise model: pass model=allanite.identify(record), or that of the data sheet"
            )
        return self.model

    @cached_property
    def wandering(self) -> tuple[Term, ...]:
        """Terms whose rate has no mean that more data would give: flicker, random walk, ramp."""
        return tuple(t for t in self.model or () if t.row.slope >= 0 and t.value != 0)

    @cached_property
    def settled(self) -> tuple[Term, ...]:
        """The other terms."""
        return tuple(t for t in self.model or () if not t.row.slope >= 0 and t.value != 0)

    @cached_property
    def aim(self) -> FloatArray:
        """The estimand as weights on the rate without settled noise, shape (size,)."""
        return TARGETS[self.target](self.size)

    @cached_property
    def sinusoids(self) -> FloatArray:
        """Cosine and sine of each dither frequency at the samples, shape (size, 2 k)."""
        t = (np.arange(self.size) - (self.size - 1) / 2) / self.rate
        waves = [wave(2 * np.pi * f * t) for f in self.dither for wave in (np.cos, np.sin)]
        return np.column_stack(waves) if waves else np.empty((self.size, 0))


TARGETS: dict[str, Callable[[int], FloatArray]] = {
    "mean": lambda n: np.full(n, 1 / n), "constant": lambda n: np.full(n, 1 / n),
    "centre": lambda n: np.bincount([(n - 1) // 2, n // 2], minlength=n) / 2, "start": lambda n: np.eye(1, n)[0],
}  # fmt: skip
"""What is estimated: the mean of the drifting rate over the interval, the constant of one that does not drift, its
value in the middle sample, in the first. Without B, K and R in the model all four are the same."""


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
