"""What the next power of a regressor would remove beyond all lower ones, over the range of its readings."""

import math
from dataclasses import dataclass

from allanite.extending import Value

from .regression import Regression


@dataclass(frozen=True, repr=False)
class Order(Value):
    """Root mean square over the range of the part of the highest power that no lower one follows, SI."""

    power: int
    # rms, low, high: it is |b_n| h^n 2^n n!^2 / (2n)! / sqrt(2n + 1), with the coefficient b_n of a fit of all powers
    # up to n and h half the range: x^n less its best fit of lower powers is a Legendre polynomial
    rms: float
    low: float
    high: float
    p: float  # p-value of the coefficient
    explained: float | None  # share of the variance that all powers up to n remove from blocks that were held back


def order(regression: Regression, level: float = 0.95) -> Order:
    """The order that the highest power of a regression adds; it was fitted with all powers below it.

    Examples
    --------
    >>> import numpy as np
    >>> import allanite as al
    >>> rng, x = np.random.default_rng(1), np.sin(np.arange(3600) / 600)
    >>> temp = al.Record(40 + 20 * x, rate=1.0, unit="degC", name="temp")
    >>> noise = al.simulate(al.N(0.1, "deg/sqrt(h)"), 3600, 1.0, rng=rng)
    >>> gyro = noise.with_values(noise.values + 1e-4 * x**2, "warmed")
    >>> settings = al.compensation.FitSettings(every=True)
    >>> found = order(al.compensate(gyro, temp, ["temp"], degree=2, settings=settings))
    >>> found.low < 1e-4 * (2 / 3) / 5**0.5 < found.high
    True
    """
    effect = max((e for e in regression if e.taken_off), key=lambda e: e.regressor.power)
    effect = regression.effect(regression.regressors.index(effect.regressor), level)
    n, span = effect.regressor.power, effect.regressor.span or (0.0, 0.0)
    size = (span[1] - span[0]) ** n * math.factorial(n) ** 2 / math.factorial(2 * n) / math.sqrt(2 * n + 1)
    low, high = sorted((abs(effect.low), abs(effect.high)))
    crosses = effect.low < 0 < effect.high
    held = regression.held
    return Order(
        n, abs(effect.value) * size, 0.0 if crosses else low * size, high * size, effect.p,
        None if held is None else held.explained,
    )  # fmt: skip
