"""The best filter of a gyro-vertical for identified noise, what detuning costs, and how far it is from the bound."""

import math
from dataclasses import dataclass
from typing import Any

from allanite.extending import ModelLike, Value, public

from .density import SensorNoise
from .gains import Bias, best_loop, best_second
from .prediction import Prediction, biases, predict
from .wiener import random_error, wiener_error

DETUNING = (0.25, 0.5, 1.0, 2.0, 4.0)
"""Factors of the time constant at which the error is given."""

WORTH = 0.02
"""Share of the error by which a filter of second order must be better to be recommended."""


@dataclass(frozen=True, eq=False, repr=False)
class Optimum(Value):
    """The best complementary filters for the noise of one gyro and one accelerometer.

    Attributes
    ----------
    first : Prediction
        With the best filter of first order.
    second : Prediction or None
        With the best filter of second order; None if it is not better, as for white noises.
    bound : float
        Standard deviation of the optimal causal filter (of Wiener), rad, to which biases and sinusoids are known.
    noise : float
        Standard deviation of the first-order filter from noise alone, rad, at the time constant that is best for it.
    detuning : tuple of (factor, rms)
        RMS error of the first-order filter, rad, with the time constant multiplied by a factor.

    Examples
    --------
    >>> from allanite import N
    >>> found = optimal_time_constant(N(0.3, "deg/sqrt(h)"), N(100, "ug/sqrt(Hz)"))
    >>> f"{found.time_constant:.4f} s, {found.first.to('arcsec'):.2f} arcsec, loss {abs(found.loss):.1g}"
    '1.1459 s, 19.27 arcsec, loss 0'
    """

    _also = ("time_constant", "loss", "order")

    first: Prediction
    second: Prediction | None
    bound: float
    noise: float
    detuning: tuple[tuple[float, float], ...]

    @property
    def time_constant(self) -> float:
        """The best time constant of a filter of first order, s."""
        return self.first.loop.time_constant

    @property
    def loss(self) -> float:
        """How much larger the noise of the first-order filter is than that of the optimal one, as a share."""
        return round(self.noise / self.bound - 1, 6) + 0.0

    @property
    def order(self) -> int:
        """The recommended order: 2 if that is better by more than 2 %."""
        return 2 if self.second is not None and self.second.rms < (1 - WORTH) * self.first.rms else 1

    @property
    def best(self) -> Prediction:
        """With the filter of the recommended order."""
        return self.second if self.second is not None and self.order == 2 else self.first

    def rows(self) -> tuple[list[str], list[list[Any]]]:
        """Headings and rows: RMS by source of each filter, arcsec."""
        headings = ["order", "k1", "k2", "sensor", "symbol", "term", "rms"]
        found = [p for p in (self.first, self.second) if p is not None]
        size = math.pi / 648_000
        rows: list[list[Any]] = []
        for p in found:
            gains = [p.loop.order, p.loop.k1, p.loop.k2]
            rows += [[*gains, s.sensor, s.symbol, s.text, s.rms / size] for s in p.sources]
            rows.append([*gains, "all", "", "", p.rms / size])
        return headings, rows

    def _summary(self) -> str:
        return f"{self.time_constant:.4g} s, {self.first.to('arcsec'):.4g} arcsec"


@public
def optimal_time_constant(
    gyro: ModelLike,
    accelerometer: ModelLike,
    *,
    duration: float | None = None,
    rate: float | None = None,
    gyro_bias: str | float = 0.0,
    accelerometer_bias: str | float = 0.0,
) -> Optimum:
    """Find the time constant with the smallest error, and the best filter of second order.

    Parameters
    ----------
    gyro, accelerometer : Model, Term or Fit
    duration, rate, gyro_bias, accelerometer_bias
        As for `predicted_error`.

    Returns
    -------
    Optimum

    Raises
    ------
    UsageError, UnitError
        As for `predicted_error`; or no time constant is best, because one of the sensors has no noise.
    """
    noise = SensorNoise.of(gyro, accelerometer, duration, rate)
    return optimum(noise, biases(gyro_bias, accelerometer_bias))


def optimum(noise: SensorNoise, bias: Bias = (0.0, 0.0)) -> Optimum:
    """`optimal_time_constant` of densities that were checked, with biases in SI."""
    loop = best_loop([noise], [bias])
    other = best_second([noise], [bias], loop)
    first, second = predict(noise, loop, bias), None if other is None else predict(noise, other, bias)
    alone = best_loop([noise], [(0.0, 0.0)]) if any(bias) else loop
    detuned = tuple((k, predict(noise, loop.scaled(k), bias).rms) for k in DETUNING)
    return Optimum(first, second, wiener_error(noise, alone), random_error(noise, alone), detuned)
