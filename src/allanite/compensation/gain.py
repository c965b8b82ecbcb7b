"""What a correction takes off: mean squares before and after, and what could be expected."""

import math
from dataclasses import dataclass

from allanite.core.plain import Value


@dataclass(frozen=True, repr=False)
class Gain(Value):
    """Mean squares of the rate about its mean, before and after a correction, SI.

    Attributes
    ----------
    before, after : float
    expected : float
        Reduction that could be expected: of the record that was fitted, by chance alone, if there were no dependence at
        all; of another one, by the dependence that was found, less what its errors add.
    low, high : float or None
        95 % limits of the reduction of another record; it may be negative.

    Examples
    --------
    >>> gain = Gain(4.0, 3.0, 0.1)
    >>> gain.reduction, gain.explained
    (1.0, 0.25)
    """

    _also = ("explained", "met")

    before: float
    after: float
    expected: float
    low: float | None = None
    high: float | None = None

    @property
    def reduction(self) -> float:
        """What was taken off, SI squared."""
        return self.before - self.after

    @property
    def explained(self) -> float:
        """Share of the variance that was taken off; negative if the correction does harm."""
        return self.reduction / self.before if self.before > 0 else math.nan

    @property
    def met(self) -> bool | None:
        """Whether the reduction lies within its limits; None where there are none."""
        return None if self.low is None or self.high is None else self.low <= self.reduction <= self.high
