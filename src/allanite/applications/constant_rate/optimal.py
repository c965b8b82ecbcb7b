r"""Best linear unbiased weights for a noise model.

The rates are y = (slow rate) + (settled noise), and the estimand is g'(slow rate). Of all weights w whose sum is 1 and
that a ramp and the dither's sinusoids do not reach, the error w'y - g'(slow) is least for w = g + v with

    C v = -C_s g + (multiples of what is not to be reached),     sum v = 0,

where C_s is the covariance of the settled noise, and C that of all. For angle random walk N and white angle noise Q
alone the weights are closed:

    w_j ~ 1 - cosh(kappa (j - (n + 1) / 2)) / cosh(kappa (n + 1) / 2),     cosh kappa = 1 + q / 2 r

with q = N^2 tau0 and r = Q^2: the mean for r = 0, the regression for q = 0.
"""

import math

import numpy as np

from allanite.extending import Covariance, FloatArray, say

from .linear import parabola
from .row import RateEstimator, linear
from .setting import Task


def white_and_angle(n: int, kappa: float) -> FloatArray:
    """The closed form; shape (n,).

    Examples
    --------
    >>> white_and_angle(3, math.inf).round(9).tolist(), white_and_angle(3, 0.0).round(9).tolist()
    ([0.333333333, 0.333333333, 0.333333333], [0.3, 0.4, 0.3])
    """
    if kappa == 0:
        return parabola(n)
    if math.isinf(kappa):
        return np.full(n, 1 / n)
    j = np.arange(1.0, n + 1)
    # 1 - cosh(a) / cosh(h) without overflow and, where kappa is small, without cancellation:
    # cosh h - cosh a = 2 sinh((h + a) / 2) sinh((h - a) / 2) with (h + a) / 2 = kappa j / 2
    near, far = kappa * j / 2, kappa * (n + 1 - j) / 2
    shape = np.expm1(-2 * near) * np.expm1(-2 * far)
    return np.asarray(shape / shape.sum())


def _optimal(task: Task) -> FloatArray:
    model = task.needed_model
    if not task.settled and not task.wandering:
        return np.full(task.size, 1 / task.size)
    sizes = {t.row.alpha: t.value for t in model if t.value != 0}
    if set(sizes) <= {0, 2} and not task.dither:  # white noise of the rate and of the angle
        ratio = sizes.get(0, 0.0) / math.sqrt(task.rate) / sizes[2] if 2 in sizes else math.inf
        return white_and_angle(task.size, 2 * math.asinh(ratio / 2))
    # the general case, by conjugate gradients
    n, rate, g = task.size, task.rate, task.aim
    noise = tuple(t for t in (*task.settled, *task.wandering) if t.row.waveform is None)
    if not noise:
        return np.full(n, 1 / n)
    covariance = Covariance(noise, n, rate)
    v = covariance.solve(-Covariance(task.settled, n, rate).times(g)) if task.settled else np.zeros(n)
    waves = [wave(n) for t in task.wandering if (wave := t.sampled(rate).waveform) is not None]
    X = np.column_stack([*(wave - wave.mean() for wave in waves), task.sinusoids])
    if X.shape[1]:
        # the slow rate holds the ramp, which g reaches as it should; the sinusoids are no part of it
        aim = np.concatenate((np.zeros(len(waves)), task.sinusoids.T @ g))
        solved = np.column_stack([covariance.solve(column) for column in X.T])
        v = v - solved @ np.linalg.solve(X.T @ solved, X.T @ v + aim)
    return np.asarray(g + v)


OPTIMAL = RateEstimator(
    name="optimal",
    title=say("best linear unbiased for the model"),
    formula=r"\hat\Omega = 1^T C^{-1} \Omega / 1^T C^{-1} 1",
    reference=say("Aitken, Proc. R. Soc. Edinburgh 55 (1935) 42; with a wandering rate: universal kriging"),
    assumes=say("that the noise model holds; under Gaussian noise its variance is the Cramer-Rao bound"),
    weights=_optimal,
    measure=linear,
    needs_model=True,
    color="#008F6B",
)
