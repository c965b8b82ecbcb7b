"""Estimators whose weights are known beforehand: averaging, windows, regression of the angle."""

import numpy as np

from allanite.extending import BoolArray, FloatArray, UsageError, say

from .row import Interval, RateEstimator, RateMeasurement, linear
from .setting import Task

REACH = 2 * 1.4826
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
    """Weights of n rates in the slope of the line through their n + 1 angles.

    Examples
    --------
    >>> parabola(3).round(12).tolist()
    [0.3, 0.4, 0.3]
    """
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
    reach = REACH * float(np.median(away)) if allowed is None else allowed / interval.size
    kept = away <= reach
    if not kept.any():
        raise UsageError(
            f"no regression line is within {allowed:.3g} (SI) of their median; allow at least "
            f"{float(away.min()) * interval.size:.3g}"
        )
    return slopes, kept


def _conditional(interval: Interval, _: FloatArray, task: Task) -> RateMeasurement:
    slopes, kept = regression_lines(interval, task)
    return RateMeasurement(float(slopes[kept].mean()), {"lines": float(slopes.size), "kept": float(kept.mean())})


MEAN = RateEstimator(
    name="mean",
    title=say("mean of all samples"),
    formula=r"\hat\Omega = \theta(T) / T",
    reference=say("IEEE Std 647; the mean of means of equal parts is the same number"),
    assumes=say("white rate noise (angle random walk) alone"),
    weights=lambda task: np.full(task.size, 1 / task.size),
    measure=linear,
)
HAMMING = RateEstimator(
    name="hamming",
    title=say("mean under a window"),
    formula=r"\hat\Omega = \sum a_j \Omega_j / \sum a_j, a_j = 0.54 - 0.46 \cos(2 \pi j / (n - 1))",
    reference=say("R. W. Hamming, Digital Filters, 1977"),
    assumes=say("nothing: a sixth of the accuracy under angle random walk is given up for a low weight of the ends"),
    weights=_window,
    measure=linear,
    color="#B97700",
)
REGRESSION = RateEstimator(
    name="regression",
    title=say("slope of the line through the angle"),
    formula=r"\hat\Omega = 12 \sum (t_i - \bar t) \theta_i / (n (n + 1) (n + 2) \tau_0)",
    reference=say("Enin, Saneev, Science and Education of the Bauman MSTU 2017(2) 52, formula (1)"),
    assumes=say("white angle noise (quantization, residual dither) alone"),
    weights=lambda task: parabola(task.size),
    measure=linear,
    color="#0072B2",
)
CONDITIONAL = RateEstimator(
    name="conditional",
    title=say("mean of regression lines without outliers"),
    formula=r"\hat\Omega = \overline{\Omega_k}, |\Omega_k - \mathrm{median}| \le 2 \sigma",
    reference=say("Saneev, Engineering Journal 2015(1); Enin, Saneev 2017"),
    assumes=say("as regression, to which it is nearly identical: adjacent lines share all but one sample"),
    weights=_many_parabolas,
    measure=_conditional,
    color="#56A0D3",
)
