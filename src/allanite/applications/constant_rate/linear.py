"""Estimators that are linear in the samples, and recognition of the staircase that an ideal laser gyro would count."""

import math

import numpy as np

from allanite.extending import BoolArray, Covariance, FloatArray, UsageError, say

from .row import EstimatorSettings, Interval, RateEstimator, RateMeasurement, Task, linear

MAX_AWAY = 2 * 1.4826
"""Median absolute deviations from the median within which a line's slope is kept: two standard deviations."""


def _window(task: Task) -> FloatArray:
    from scipy.signal import get_window

    n, name = task.size, task.options.window
    try:
        weights = get_window(name, n, fftbins=False)
    except ValueError:
        raise UsageError(f"unknown window {name!r}; give one of SciPy's: hamming, hann, blackman or another") from None
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
        raise UsageError(f"{lines} regression lines, each one sample later, do not fit into {n} samples; at most "
                         f"{n - 1} do")  # fmt: skip
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
    kept = away <= (MAX_AWAY * float(np.median(away)) if allowed is None else allowed / interval.size)
    if not kept.any():
        raise UsageError(f"no regression line is within {allowed:.3g} (SI) of their median; allow at least "
                         f"{float(away.min()) * interval.size:.3g}")  # fmt: skip
    return slopes, kept


def _conditional(interval: Interval, _: FloatArray, task: Task) -> RateMeasurement:
    slopes, kept = regression_lines(interval, task)
    return RateMeasurement(float(slopes[kept].mean()), {"lines": float(slopes.size), "kept": float(kept.mean())})


MEAN = RateEstimator(name="mean", title=say("mean of all samples"), formula=r"\hat\Omega = \theta(T) / T",
                     reference=say("IEEE Std 647; the mean of means of equal parts is the same number"),
                     assumes=say("white rate noise (angle random walk) alone"),
                     weights=lambda task: np.full(task.size, 1 / task.size), measure=linear)  # fmt: skip
HAMMING = RateEstimator(name="hamming", title=say("mean under a window"),
                        formula=r"\hat\Omega = \sum a_j \Omega_j / \sum a_j, a_j = 0.54 - 0.46 \cos(2 \pi j / (n - 1))",
                        reference=say("R. W. Hamming, Digital Filters, 1977"),
                        assumes=say("nothing: a sixth of the accuracy under angle random walk is given up for a low "
                                    "weight of the ends"),
                        weights=_window, measure=linear, color="#B97700")  # fmt: skip
REGRESSION = RateEstimator(name="regression", title=say("slope of the line through the angle"),
                           formula=r"\hat\Omega = 12 \sum (t_i - \bar t) \theta_i / (n (n + 1) (n + 2) \tau_0)",
                           reference=say("Enin, Saneev, Science and Education of the Bauman MSTU 2017(2) 52, formula "
                                         "(1)"),
                           assumes=say("white angle noise (quantization, residual dither) alone"),
                           weights=lambda task: parabola(task.size), measure=linear, color="#0072B2")  # fmt: skip
CONDITIONAL = RateEstimator(name="conditional", title=say("mean of regression lines without outliers"),
                            formula=r"\hat\Omega = \overline{\Omega_k}, |\Omega_k - \mathrm{median}| \le 2 \sigma",
                            reference=say("Saneev, Engineering Journal 2015(1); Enin, Saneev 2017"),
                            assumes=say("as regression, to which it is nearly identical: adjacent lines share all but "
                                        "one sample"),
                            weights=_many_parabolas, measure=_conditional, color="#56A0D3")  # fmt: skip


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
    sizes = {t.row.alpha: t.value for t in task.model or () if t.value != 0}
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


MAX_WORK = 7e6  # samples that the search may look at before it gives its best so far: some 40 ms
MAX_STEPS = 100  # of a descent, and of the search for an ideal staircase
DIFFERENCES = 0.4, 0.01  # of the descent, pulses: in place of a gradient, first and last
STOP = 1e-3  # last step of the descent, pulses
SHARES = 2.0 ** np.arange(-4, 4.5, 0.5)  # of its gradient over the samples, tried as the next step
NEIGHBOURHOOD = 0.1  # half the side of the box that is searched about the end of the descent, pulses
DITHERED = 0.3  # angle noise, quanta, from which the staircase's error can be predicted

TOUCHING = 1e-12  # gap, pulses, within which a line only touches the corners of steps: rounding

CUBE_ROOT = 2.2
"""Standard deviation of (staircase - regression) at the end of n samples, over (angle noise)^(2/3) n^(-1/3) in quanta:
1.98 to 2.37 for noise of 0.4 to 4 quanta and n of 1000 to 48000."""


def _staircase(interval: Interval, _: FloatArray, task: Task) -> RateMeasurement:
    y, line = _steps_and_line(interval)
    p, q, least, bound, slopes = _search(y, line, task.options)
    slope = (line[-1] - line[0] + q - p) / (y.size - 1)
    details = {"misfit": least, "least possible misfit": max(bound, 0.0), "phase": float(line[0] + p) % 1.0,
               "RMS residual": math.sqrt(least / y.size), "pulses": float(y[-1]),
               "rate of a pulse": interval.pulse * interval.size / (y.size - 1)}  # fmt: skip
    limits = None
    if slopes is not None:
        low, high = (a * interval.pulse - interval.offset for a in slopes)
        limits = low, high
    return RateMeasurement(slope * interval.pulse - interval.offset, details, limits)


def _ideal(rest: FloatArray) -> tuple[float, float] | None:
    """Least and greatest a with rest <= a t + b < rest + 1 for some b, t about the middle; None if there is none."""
    # The gap max(rest - a t) - min(rest + 1 - a t) is convex in a, made of straight pieces, and must be negative. The
    # steps of Newton from both sides end at its zeros exactly, or, where it has none, pass each other.
    t = np.arange(rest.size) - (rest.size - 1) / 2

    def gap(a: float) -> tuple[float, float]:
        free = rest - a * t
        high, low = int(free.argmax()), int(free.argmin())
        return float(free[high] - free[low] - 1), float(t[low] - t[high])

    ends = []
    for side in (-1.0, 1.0):
        a = side * 4 / (rest.size - 1)
        value, steep = gap(a)
        for _ in range(MAX_STEPS):
            if value <= TOUCHING or steep * side <= 0:
                break
            a -= value / steep
            value, steep = gap(a)
        if value > TOUCHING:
            return None
        ends.append(a)
    return (ends[0], ends[1]) if gap(sum(ends) / 2)[0] < -TOUCHING else None


def recognized(interval: Interval, options: EstimatorSettings) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The angle in quanta, the line whose floor is the staircase nearest to it, the rates of a descent in samples."""
    y, line = _steps_and_line(interval)
    p, q, *_ = _search(y, line, options)
    path = np.empty(0) if options.descent is None else _descent(y, line, options.descent)[:, 0]
    rates = (path + line[-1] - line[0]) / (y.size - 1) * interval.pulse - interval.offset
    return y, line + p + (q - p) * np.linspace(0.0, 1.0, y.size), rates


def _descent(y: FloatArray, line: FloatArray, most: int) -> FloatArray:
    """Rise and phase less those of `line` after each step of steepest descent, from the interval's own count."""
    from allanite.kernels.staircase import misfit

    samples, steps = _about(y, line, np.linspace(0.0, 1.0, y.size)), DIFFERENCES[0] * np.eye(2)

    def missed(x: FloatArray) -> float:
        return float(misfit(*samples, (x[1], x[1] + x[0])))

    path = [np.array([y[-1] - line[-1] + line[0], 0.5 - line[0]])]
    for _ in range(most):
        gradient = np.array([missed(path[-1] + step) - missed(path[-1] - step) for step in steps]) / (2 * steps.max())
        path.append(min((path[-1], *(path[-1] - z / y.size * gradient for z in SHARES)), key=missed))
        if np.abs(path[-1] - path[-2]).max() < STOP:
            steps = steps * 0.7
            if steps.max() < DIFFERENCES[1]:
                break
    return np.array(path)


def _search(
    y: FloatArray, line: FloatArray, options: EstimatorSettings
) -> tuple[float, float, float, float, tuple[float, float] | None]:
    """Heights p, q over the ends of `line` at which the staircase is nearest, its misfit, the least possible one."""
    # Of an ideal staircase also the limits of its slope, and no search; else a descent, the whole neighbourhood of
    # where it ends, then whatever could be better.
    slopes = _ideal(y - line) if options.descent is None else None
    if slopes is not None:
        steep, reach = sum(slopes) / 2, (y.size - 1) / 2
        free = y - line - steep * np.linspace(-reach, reach, y.size)
        middle = float(free.max() + free.min() + 1) / 2
        slope = float(line[-1] - line[0]) / (y.size - 1)
        return middle - steep * reach, middle + steep * reach, 0.0, 0.0, (slope + slopes[0], slope + slopes[1])
    from allanite.kernels.staircase import misfit, nearest_staircase

    right, work = np.linspace(0.0, 1.0, y.size), math.inf if options.certified else MAX_WORK
    samples = _about(y, line, right)
    whole = math.sqrt(misfit(*samples, (0.0, 0.0)))
    rise, p = _descent(y, line, MAX_STEPS if options.descent is None else options.descent)[-1]
    q, least = p + rise, misfit(*samples, (p, p + rise))
    if options.descent is not None:
        return p, q, least, 0.0, None
    near = _about(y, line + p + (q - p) * right, right)
    p_, q_, least, _, looked = nearest_staircase(near, (0.0, 0.0, least), NEIGHBOURHOOD, work)
    known = (p + p_, q + q_, least)
    # |floor(x) + 1/2 - x| <= 1/2 puts the best staircase's line into an ellipse about the line through the steps'
    # middles; in the heights p, q of the two ends it is n (p^2 + p q + q^2) / 3 <= square, so |p|, |q| <= half
    square = (whole + 0.5 * math.sqrt(y.size)) ** 2 - float(np.square(y + 0.5 - line).sum())
    half = 2 * math.sqrt(max(square, 0.0) / y.size) * (1 + 1e-6) + 1e-6
    p, q, least, bound, _ = nearest_staircase(samples, known, half, work - looked)
    return p, q, least, bound, None


def _about(y: FloatArray, line: FloatArray, right: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """What the search is given: whole pulses of the line subtracted, so that no digit is lost to their number."""
    whole = np.floor(line)
    return y - whole, line - whole, right


def _steps_and_line(interval: Interval) -> tuple[FloatArray, FloatArray]:
    """The angle in quanta, and the line through the middles of its steps."""
    angle = np.concatenate(([0.0], np.cumsum((interval.steps + interval.offset) / interval.pulse)))
    # whole quanta, except for the rounding of samples that are multiples of one
    near = np.rint(angle)
    y = near if np.abs(angle - near).max() < 1e-6 else angle
    t = np.arange(y.size) - (y.size - 1) / 2
    return y, y.mean() + 0.5 + float(t @ y) / float(t @ t) * t


def _excess(task: Task) -> float:
    """What the steps add to the regression's variance: n^(-1/3) pulses; unknown where no angle noise blurs them."""
    # J. Kim, D. Pollard, Ann. Statist. 18 (1990) 191, for the power of n; the factor is simulated (benchmarks/rate.py)
    noise = next((t.value for t in task.settled if t.row.alpha == 2), 0.0) / task.pulse
    if not noise >= DITHERED or task.options.descent is not None:
        return math.nan
    ends = CUBE_ROOT * noise ** (2 / 3) * (task.size + 1) ** (-1 / 3)
    return float((ends * task.pulse / task.duration) ** 2)


STAIRCASE = RateEstimator(
    name="staircase", title=say("recognition of the staircase of counts"),
    formula=r"\min_{U, \varphi} \sum (y_i - \lfloor U t_i + \varphi \rfloor)^2",
    reference=say("Enin, Saneev, Science and Education of the Bauman MSTU 2017(2) 52, formula (2)"),
    assumes=say("counts without noise, for which its limits are certain; with noise above a fraction of a pulse it is "
                "slightly worse than regression"),
    weights=lambda task: parabola(task.size), measure=_staircase, excess=_excess, needs_quantum=True, color="#AA4499",
)  # fmt: skip
