"""The gains of a filter that are best for the noise of its gyros and accelerometers."""

import math
from collections.abc import Sequence

import numpy as np

from allanite.extending import DataError, Model, UsageError, spelled

from .density import GRAVITY, SensorNoise
from .loop import Loop, kalman
from .prediction import predict

SHORTEST, LONGEST = 1e-5, 1e6
"""Time constants between which the best one is sought, s."""

GRID = 89
"""Time constants that are tried first: eight in a decade."""

SETTLED = 10.0
"""Time constants of the bias of a filter of second order in the horizon, at least."""

Bias = tuple[float, float]
"""Constant biases of the gyro, rad/s, and of the accelerometer, m/s^2."""


def best_loop(noises: Sequence[SensorNoise], bias: Sequence[Bias]) -> Loop:
    """The filter of first order with the least sum of squares of the errors of several angles."""
    from scipy.optimize import minimize_scalar

    def error(log: float) -> float:
        loop = Loop.of(math.exp(log))
        return math.log(sum(predict(n, loop, b).rms ** 2 for n, b in zip(noises, bias, strict=True)))

    shortest = max((n.interval or SHORTEST) for n in noises)
    grid = np.linspace(math.log(shortest), math.log(LONGEST), GRID)
    at = int(np.argmin([error(float(log)) for log in grid]))
    if at in (0, GRID - 1):
        short = at == 0
        raise UsageError(
            f"no time constant is best: the {'shortest' if short else 'longest'} one, {math.exp(grid[at]):.3g} s, has "
            f"the least error, because the {'accelerometer' if short else 'gyro'} has too little noise; give "
            + spelled("--time-constant", "time_constant=...")
        )
    found = minimize_scalar(error, bounds=(grid[at - 1], grid[at + 1]), method="bounded", options={"xatol": 1e-9})
    return Loop.of(math.exp(found.x))


def best_second(noises: Sequence[SensorNoise], bias: Sequence[Bias], first: Loop) -> Loop | None:
    """The filter of second order with the least sum of squares of several angles; None if `first` is as good.

    A bias is estimated in time: without a duration there is none, and with one its estimate settles ten times in it.
    """
    from scipy.optimize import minimize

    durations = [n.duration for n in noises if n.duration is not None]
    if len(durations) < len(noises):
        return None
    settling = SETTLED / min(durations)

    def loop_of(logs: np.ndarray) -> Loop:
        k1, k2 = np.exp(np.clip(logs, -60.0, 20.0)).tolist()
        return Loop(k1, max(k2, k1 * settling))

    def squares(loop: Loop) -> float:
        return sum(predict(n, loop, b).rms ** 2 for n, b in zip(noises, bias, strict=True))

    least = squares(first)
    starts = [np.log([first.k1, first.k1**2 * share]) for share in (1e-4, 1e-2, 0.3)]
    tries = (
        minimize(lambda x: squares(loop_of(x)) / least, start, method="Nelder-Mead",
                 options={"xatol": 1e-5, "fatol": 1e-10}) for start in starts
    )  # fmt: skip
    found = min(tries, key=lambda result: float(result.fun))
    return None if found.fun > 1 - 2e-4 else loop_of(found.x)


def best_first_order(noises: Sequence[SensorNoise]) -> Loop:
    """`best_loop` without constant biases: the mean rates are subtracted."""
    return best_loop(noises, [(0.0, 0.0)] * len(noises))


def best_second_order(noises: Sequence[SensorNoise]) -> Loop:
    """`best_second` without constant biases, or the filter of first order where that is as good."""
    first = best_first_order(noises)
    return best_second(noises, [(0.0, 0.0)] * len(noises), first) or first


def best_kalman(noises: Sequence[SensorNoise]) -> Loop:
    """The steady Kalman filter for the mean power of several angles."""

    def size(models: Sequence[Model], symbol: str) -> float:
        return math.sqrt(sum(t.value**2 for m in models for t in m if t.symbol == symbol) / len(models))

    gyros = [n.gyro for n in noises]
    tilt = size([n.accelerometer for n in noises], "N") / GRAVITY
    if not tilt:
        raise DataError("the Kalman filter needs white noise (N) of the accelerometers, and none was identified; use "
                        + spelled("--filter second-order", "method='second-order'"))  # fmt: skip
    return kalman(size(gyros, "N"), tilt, size(gyros, "K"))
