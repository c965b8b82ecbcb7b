"""A statistic: differences of the fourth order."""

import numpy as np

from allanite.core.arrays import FloatArray, IntArray
from allanite.phrases.phrase import say
from allanite.statistics.row import Statistic, binomial_window, constant


def _sums(x: FloatArray, m: IntArray) -> FloatArray:
    def differences(s: int) -> FloatArray:
        return x[4 * s :] - 4 * x[3 * s : -s] + 6 * x[2 * s : -2 * s] - 4 * x[s : -3 * s] + x[: -4 * s]

    return np.array([np.sum(np.square(differences(s))) for s in m.tolist()])


FDEV = Statistic(
    name="fdev",
    title=say("fourth-difference deviation"),
    formula=r"\sum_{k=0}^{4} (-1)^k \binom{4}{k} x_{i+km}",
    reference="a paper",
    meaning="How fast the drift of the rate changes.",
    use="A record whose rate drifts as a parabola.",
    limits="Windows are four times as long as tau.",
    cost="Low.",
    order=4,
    norm=constant(20.0),
    span=(4, 0),
    sums=_sums,
    window=binomial_window(4),
    differences=4,
)
