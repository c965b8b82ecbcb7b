"""Estimators whose weights are known beforehand: averaging, windows, regression of the angle, the best for a noise."""

# Derivation: docs/derivations.md.

import math

import numpy as np

from allanite.extending import BoolArray, Covariance, FloatArray, UsageError, say

from .row import Interval, RateEstimator, RateMeasurement, Task, linear

MAX_AWAY = 2 * 1.4826
"""Median absolute deviations from the median within which a line's slope is kept: two standard deviations."""


def _window(task: Task) -> FloatArray:
    n, name = task.size, task.options.window
    if name == "hamming":
        weights = np.hamming(n)
    else:
        from scipy.signal import get_window

        try:
            weights = get_window(name, n, fftbins=False)
        except ValueError as error:
            raise UsageError(f"unknown window {name!r}: {error}; for example hamming, hann, blackman") from None
    total = float(weights.sum())
    if not total > 0:
        raise UsageError(f"the window {name!r} of {n} samples has no positive sum")
    return np.asarray(weights / total, dtype=np.float64)


def parabola(n: int) -> FloatArray:
    """Weights of n rates in the slope of the line through their n + 1 angles."""
    j = np.arange(1.0, n + 1)
    return j * (n + 1 - j) * (6 / (n * (n + 1.0) * (n + 2.0)))


def _lines(task: Task) -> tuple[int, int]:
    """Number of lines and the sample intervals under each."""
    n, lines = task.size, task.options.lines
    if lines is None:
        lines = max(1, n // 160)
    if not 1 <= lines <= n - 1:
        raise UsageError(
            f"{lines} regression lines, each one sample later, do not fit into {n} samples; at most {n - 1} do"
        )
    return lines, n - lines + 1


def _many_parabolas(task: Task) -> FloatArray:
    lines, length = _lines(task)
    total = np.concatenate(([0.0], np.cumsum(parabola(length)), np.ones(lines - 1)))
    shifted = np.concatenate((np.zeros(lines), total[: task.size]))
    # the sum of windows of a running sum: each weight is the mean of those parabolas that cover it
    return np.asarray(total[1 : task.size + 1] - shifted[1 : task.size + 1]) / lines


def regression_lines(interval: Interval, task: Task) -> tuple[FloatArray, BoolArray]:
    """Slopes of the regression lines in samples, and which are near enough to their median, shape (lines,)."""
    lines, length = _lines(task)
    # the line through everything is subtracted first, so that the running sums stay small
    whole = float(parabola(task.size) @ interval.steps)
    angle = np.concatenate(([0.0], np.cumsum(interval.steps - whole)))
    position = np.arange(angle.size, dtype=np.float64)
    level, moment = (np.concatenate(([0.0], np.cumsum(a))) for a in (angle, position * angle))
    start = np.arange(lines)
    sums, moments = (s[start + length + 1] - s[start] for s in (level, moment))
    centred = moments - (start + length / 2) * sums
    slopes = np.asarray(whole + centred * 12 / (length * (length + 1.0) * (length + 2.0)))
    away = np.abs(slopes - float(np.median(slopes)))
    allowed = task.options.allowed
    reach = MAX_AWAY * float(np.median(away)) if allowed is None else allowed / interval.size
    kept = away <= reach
    if not kept.any():
        raise UsageError(f"no regression line is within {allowed:.3g} (SI) of their median; allow at least "
                         f"{float(away.min()) * interval.size:.3g}")  # fmt: skip
    return slopes, kept


def _conditional(interval: Interval, _: FloatArray, task: Task) -> RateMeasurement:
    slopes, kept = regression_lines(interval, task)
    return RateMeasurement(float(slopes[kept].mean()), {"lines": float(slopes.size), "kept": float(kept.mean())})


MEAN = RateEstimator(
    name="mean", title=say("mean of all samples"), formula=r"\hat\Omega = \theta(T) / T",
    reference=say("IEEE Std 647; the mean of means of equal parts is the same number"),
    assumes=say("white rate noise (angle random walk) alone"), weights=lambda task: np.full(task.size, 1 / task.size),
    measure=linear,
)  # fmt: skip
HAMMING = RateEstimator(
    name="hamming", title=say("mean under a window"),
    formula=r"\hat\Omega = \sum a_j \Omega_j / \sum a_j, a_j = 0.54 - 0.46 \cos(2 \pi j / (n - 1))",
    reference=say("R. W. Hamming, Digital Filters, 1977"),
    assumes=say("nothing: a sixth of the accuracy under angle random walk is given up for a low weight of the ends"),
    weights=_window, measure=linear, color="#B97700",
)  # fmt: skip
REGRESSION = RateEstimator(
    name="regression", title=say("slope of the line through the angle"),
    formula=r"\hat\Omega = 12 \sum (t_i - \bar t) \theta_i / (n (n + 1) (n + 2) \tau_0)",
    reference=say("Enin, Saneev, Science and Education of the Bauman MSTU 2017(2) 52, formula (1)"),
    assumes=say("white angle noise (quantization, residual dither) alone"), weights=lambda task: parabola(task.size),
    measure=linear, color="#0072B2",
)  # fmt: skip
CONDITIONAL = RateEstimator(
    name="conditional", title=say("mean of regression lines without outliers"),
    formula=r"\hat\Omega = \overline{\Omega_k}, |\Omega_k - \mathrm{median}| \le 2 \sigma",
    reference=say("Saneev, Engineering Journal 2015(1); Enin, Saneev 2017"),
    assumes=say("as regression, to which it is nearly identical: adjacent lines share all but one sample"),
    weights=_many_parabolas, measure=_conditional, color="#56A0D3",
)  # fmt: skip


def white_and_angle(n: int, kappa: float) -> FloatArray:
    """The closed form; shape (n,)."""
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
    name="optimal", title=say("best linear unbiased for the model"),
    formula=r"\hat\Omega = 1^T C^{-1} \Omega / 1^T C^{-1} 1",
    reference=say("Aitken, Proc. R. Soc. Edinburgh 55 (1935) 42; with a wandering rate: universal kriging"),
    assumes=say("that the noise model holds; under Gaussian noise its variance is the Cramer-Rao bound"),
    weights=_optimal, measure=linear, needs_model=True, color="#008F6B",
)  # fmt: skip
