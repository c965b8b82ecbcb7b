"""The effect of a correction: mean squares before and after, and the expected reduction."""

import math
from dataclasses import dataclass

import numpy as np

from allanite.extending import FloatArray, Value


@dataclass(frozen=True, repr=False)
class Gain(Value):
    """Mean squares of the rate before and after a correction, SI.

    They are about the mean; where a linear drift was estimated beside the regressors, about a straight line, since the
    correction leaves a drift.

    Attributes
    ----------
    before, after : float
    expected : float
        Expected reduction: for the fitted record, by chance alone without any dependence; for another record, from the
        estimated dependence minus the effect of its errors.
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
        """Reduction of the mean square, SI squared."""
        return self.before - self.after

    @property
    def explained(self) -> float:
        """Share of the variance that was removed; negative if the correction does harm."""
        return self.reduction / self.before if self.before > 0 else math.nan

    @property
    def met(self) -> bool | None:
        """Whether the reduction lies within its interval; None if there is none."""
        return None if self.low is None or self.high is None else self.low <= self.reduction <= self.high


def about_line(values: FloatArray, trend: FloatArray) -> FloatArray:
    """Centred values, shape (n,) or (n, p), less their projection on the columns of `trend`, if there are any.

    Examples
    --------
    >>> about_line(np.array([-1.0, -0.5, 1.5]), np.array([[-1.0], [0.0], [1.0]])).round(9).tolist()
    [0.25, -0.5, 0.25]
    """
    Q, _ = np.linalg.qr(trend)
    return np.asarray(values - Q @ (Q.T @ values))
