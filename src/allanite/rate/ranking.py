"""Which method is the best for a gyro, and by how much."""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from allanite.core.model import Model
from allanite.core.plain import Value
from allanite.core.units import Signal, unit_of

NEAR = 0.02
"""Loss of accuracy that is not worth another method."""


@dataclass(frozen=True, repr=False)
class Ranking(Value):
    """Predicted standard errors of all methods, the best first.

    Attributes
    ----------
    signal : Signal
    duration : float
        Measuring time, s.
    model : Model
    errors : dict
        Method -> standard error, SI; NaN where it cannot be predicted.
    """

    _also: ClassVar[tuple[str, ...]] = ("unit", "verdict")

    signal: Signal
    duration: float
    model: Model
    errors: dict[str, float]

    @property
    def unit(self) -> str:
        """SI unit."""
        return self.signal.unit

    @property
    def best(self) -> float:
        """The bound: the least standard error any unbiased linear method has, SI."""
        return self.errors["optimal"]

    def ratio(self, method: str) -> float:
        """Standard error of a method over the bound."""
        return self.errors[method] / self.best if self.best > 0 else math.nan

    @property
    def verdict(self) -> str:
        """Which method to use, in a sentence."""
        if not self.best > 0:
            return "under this model the rate is measured without error"
        loss = self.ratio("mean") - 1
        if loss <= NEAR:
            return f"for this gyro averaging is already within {max(100 * loss, 0.1):.2g} % of the optimum"
        simple = [m for m in self.errors if self.ratio(m) <= 1 + NEAR and m != "optimal"]
        use = simple[0] if simple else "optimal"
        gain = self.errors["mean"] / self.errors[use]
        text = f"use {use}: {gain:.3g} times better than averaging"
        if use == "optimal" and self.ratio("regression") < self.ratio("mean"):
            text += f", and {100 * (self.ratio('regression') - 1):.2g} % better than regression"
        return text

    def rows(self, unit: str | None = None) -> tuple[list[str], list[list[Any]]]:
        """Headings and rows: method, standard error in `unit`, its ratio to the bound."""
        unit = unit or self.signal.sheet[0]
        factor = unit_of(unit).factor
        ordered = sorted(self.errors, key=lambda m: math.inf if math.isnan(self.errors[m]) else self.errors[m])
        rows: list[list[Any]] = [[m, self.errors[m] / factor, self.ratio(m)] for m in ordered]
        return ["method", f"standard error, {unit}", "over the bound"], rows
