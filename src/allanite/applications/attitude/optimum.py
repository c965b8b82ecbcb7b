"""The best filter of a gyro-vertical for identified noise, what detuning costs, and how far it is from the bound."""

# Derivation: docs/derivations.md.

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from allanite.extending import DataError, FloatArray, Model, ModelLike, UsageError, Value, public, spelled

from .loop import GRAVITY, ComplexArray, Loop, SensorNoise, kalman
from .prediction import Prediction, biases, noise_errors, predict

MIN_TIME_CONSTANT, MAX_TIME_CONSTANT = 1e-5, 1e6  # time constants between which the best one is sought, s
GRID_POINTS = 89  # time constants that are tried first: eight in a decade
MIN_SETTLINGS = 10.0  # time constants of the bias of a filter of second order in the horizon, at least

Bias = tuple[float, float]  # constant biases of the gyro, rad/s, and of the accelerometer, m/s^2


def _squares(noises: Sequence[SensorNoise], loop: Loop, bias: Bias) -> float:
    return sum(predict(noise, loop, bias).rms ** 2 for noise in noises)


def best_loop(noises: Sequence[SensorNoise], bias: Bias = (0.0, 0.0)) -> Loop:
    """The filter of first order with the least sum of squares of the errors of several angles."""
    from scipy.optimize import minimize_scalar

    def error(log: float) -> float:
        return math.log(_squares(noises, Loop.of(math.exp(log)), bias))

    shortest = max((n.interval or MIN_TIME_CONSTANT) for n in noises)
    grid = np.linspace(math.log(shortest), math.log(MAX_TIME_CONSTANT), GRID_POINTS)
    at = int(np.argmin([error(float(log)) for log in grid]))
    if at in (0, GRID_POINTS - 1):
        short = at == 0
        raise UsageError(f"no time constant is best: the {'shortest' if short else 'longest'} "
                         f"one, {math.exp(grid[at]):.3g} s, has the least error, because the "
                         f"{'accelerometer' if short else 'gyro'} has too little noise; give "
                         + spelled("--time-constant", "time_constant=..."))  # fmt: skip
    minimum = minimize_scalar(error, bounds=(grid[at - 1], grid[at + 1]), method="bounded", options={"xatol": 1e-9})
    return Loop.of(math.exp(minimum.x))


def best_second(noises: Sequence[SensorNoise], first: Loop, bias: Bias = (0.0, 0.0)) -> Loop | None:
    """The filter of second order with the least sum of squares of several angles; None if `first` is as good."""
    # A bias is estimated in time: without a duration there is none, and with one its estimate settles ten times in it.
    from scipy.optimize import minimize

    durations = [n.duration for n in noises if n.duration is not None]
    if len(durations) < len(noises):
        return None
    settling = MIN_SETTLINGS / min(durations)

    def loop_of(logs: np.ndarray) -> Loop:
        k1, k2 = np.exp(np.clip(logs, -60.0, 20.0)).tolist()
        return Loop(k1, max(k2, k1 * settling))

    least = _squares(noises, first, bias)
    starts = [np.log([first.k1, first.k1**2 * share]) for share in (1e-4, 1e-2, 0.3)]
    tries = (minimize(lambda x: _squares(noises, loop_of(x), bias) / least, start, method="Nelder-Mead",
                      options={"xatol": 1e-5, "fatol": 1e-10}) for start in starts)  # fmt: skip
    nearest = min(tries, key=lambda result: float(result.fun))
    return None if nearest.fun > 1 - 2e-4 else loop_of(nearest.x)


def best_second_order(noises: Sequence[SensorNoise]) -> Loop:
    """`best_second` without constant biases, or the filter of first order where that is as good."""
    first = best_loop(noises)
    return best_second(noises, first) or first


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


STEPS = 64.0  # samples to the time constant, where there is no sampling rate
COARSE = 4.0  # how much longer a sample interval may be where the transform would need too many
MEMORY = 400.0  # length of the filter in time constants, where there is no horizon
FINER = 4  # frequencies below the lowest of the horizon
MAX_POINTS = 1 << 21  # points of the transform at most
FALL = 4  # power of the frequency with which the densities fall below the lowest one
PER_OCTAVE = 128  # points of a density between which its logarithm is taken to be straight


def wiener_error(noise: SensorNoise, best: Loop) -> float:
    """Standard deviation of the angle of the optimal causal filter, rad; sinusoids and biases are taken to be known."""
    # Computed as the ratio of its error to that of the filter of first order, both on one grid of frequencies. Without
    # a sampling rate the grid is that of a fine one.
    interval, longest = noise.interval or best.time_constant / STEPS, MEMORY * best.time_constant
    if noise.duration:
        longest = FINER * 2 * noise.duration
    n = 1 << math.ceil(math.log2(min(MAX_POINTS, max(1024, longest / interval))))
    interval = interval if noise.interval else min(max(interval, longest / n), COARSE * interval)
    sampled = SensorNoise(noise.gyro, noise.accelerometer, noise.duration, interval)
    f = np.asarray(np.fft.rfftfreq(n, interval), dtype=np.float64)
    low = sampled.lowest if noise.duration else float(f[1])
    x = np.geomspace(low, f[-1], max(16, math.ceil(PER_OCTAVE * math.log2(f[-1] / low))))
    below = np.maximum(f, f[1] / 4) / low if noise.duration else np.ones(f.size)

    def held(sensor: str) -> FloatArray:
        """Density of a sensor, which falls steeply below the lowest frequency."""
        density = sampled.total(sensor, x)
        if not density.all():
            raise UsageError(f"the bound needs noise of both sensors, but that of the {sensor} is 0")
        smooth = np.exp(np.interp(np.log(np.maximum(f, low)), np.log(x), np.log(density)))
        return np.asarray(smooth * np.minimum(below, 1.0) ** FALL)

    rate, tilt = held("gyro"), held("accelerometer")
    # responses of the optimal filter to dt n_g and to n_a, from their densities
    rise = 1 - np.exp(-2j * math.pi / n * np.arange(n // 2 + 1))
    cepstrum = np.fft.irfft(np.log(rate * interval**2 + np.abs(rise) ** 2 * tilt), n) / 2
    cepstrum[1 : n // 2] *= 2
    cepstrum[n // 2 + 1 :] = 0.0
    L = np.exp(np.fft.rfft(cepstrum))
    cross = np.fft.irfft(tilt * np.conj(rise / L), n)
    cross[n // 2 :] = 0.0  # what precedes the innovation
    causal = np.fft.rfft(cross)
    optimal = _error((causal / L * interval, 1 - causal * rise / L), (rate, tilt))
    return random_error(noise, best) * optimal / _error(best.responses(np.maximum(f, f[1] / 4), interval), (rate, tilt))


def random_error(noise: SensorNoise, loop: Loop) -> float:
    """Standard deviation of the angle from noise alone, rad."""
    return math.hypot(*(rms for _, _, rms in noise_errors(noise, loop)))


def _error(responses: tuple[ComplexArray, ComplexArray], densities: tuple[FloatArray, FloatArray]) -> float:
    """Standard deviation of the error, in steps of the grid."""
    density = np.abs(responses[0]) ** 2 * densities[0] + np.abs(responses[1]) ** 2 * densities[1]
    return math.sqrt(float(np.sum(density[1:-1])) + float(density[0] + density[-1]) / 2)


DETUNING = (0.25, 0.5, 1.0, 2.0, 4.0)  # factors of the time constant at which the error is given
WORTH = 0.02  # share of the error by which a filter of second order must be better to be recommended


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
        size, rows = math.pi / 648_000, list[list[Any]]()
        for p in (self.first, self.second):
            if p is not None:
                gains = [p.loop.order, p.loop.k1, p.loop.k2]
                rows += [[*gains, s.sensor, s.symbol, s.text, s.rms / size] for s in p.sources]
                rows.append([*gains, "all", "", "", p.rms / size])
        return ["order", "k1", "k2", "sensor", "symbol", "term", "rms"], rows

    def _summary(self) -> str:
        return f"{self.time_constant:.4g} s, {self.first.to('arcsec'):.4g} arcsec"


@public
def optimal_time_constant(
    gyro: ModelLike, accelerometer: ModelLike, *, duration: float | None = None, rate: float | None = None,
    gyro_bias: str | float = 0.0, accelerometer_bias: str | float = 0.0,
) -> Optimum:  # fmt: skip
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
    return optimum(SensorNoise.of(gyro, accelerometer, duration, rate), biases(gyro_bias, accelerometer_bias))


def optimum(noise: SensorNoise, bias: Bias = (0.0, 0.0)) -> Optimum:
    """`optimal_time_constant` of densities that were checked, with biases in SI."""
    loop = best_loop([noise], bias)
    other = best_second([noise], loop, bias)
    first, second = predict(noise, loop, bias), None if other is None else predict(noise, other, bias)
    alone = best_loop([noise]) if any(bias) else loop
    detuned = tuple((k, predict(noise, loop.scaled(k), bias).rms) for k in DETUNING)
    return Optimum(first, second, wiener_error(noise, alone), random_error(noise, alone), detuned)
