"""What a row of the table of statistics holds."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True)
class Statistic:
    """A statistic as a quadratic form in the angle x.

    Attributes
    ----------
    name, title, formula, reference
        The field's name, in words, LaTeX of the variance, source.
    order : int
        Differences of x it takes: 2 removes a constant rate, 3 a ramp of the rate too.
    norm : float
        The variance is the mean of squared differences over ``norm tau^2``.
    overlapped : bool
        Whether windows start at every sample or every m samples.
    largest : n intervals -> the largest averaging factor
    count : (n, m) -> number of squared differences in the sum
    sums : (x, m) -> sums of squared differences, all m at once
    """

    name: str
    title: str
    formula: str
    reference: str
    order: int
    norm: float
    overlapped: bool
    largest: Callable[[int], int]
    count: Callable[[int, IntArray], IntArray]
    sums: Callable[[FloatArray, IntArray], FloatArray]
