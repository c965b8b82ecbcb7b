"""Recognition of the staircase floor(k U t + phi0) that an ideal laser gyro at a constant rate would count."""

import math

import numpy as np

from allanite.extending import FloatArray, UsageError, say, spelled

from .linear import parabola
from .row import Interval, RateEstimator, RateMeasurement, Task

MAX_WORK = 7e6  # samples that the search may look at before it gives its best so far: some 40 ms
GRID = (0.4, 0.01)  # steps of the descent that comes first, from and to, pulses
NEIGHBOURHOOD = 0.1  # half the side of the box that is searched about the end of the descent, pulses
DITHERED = 0.3  # angle noise, quanta, from which the staircase's error can be predicted

TOUCHING, MAX_STEPS = 1e-12, 100
"""Gap, pulses, within which a line only touches the corners of steps: rounding; and most steps to find it."""

CUBE_ROOT = 2.2
"""Standard deviation of (staircase - regression) at the end of n samples, over (angle noise)^(2/3) n^(-1/3) in quanta:
1.98 to 2.37 for noise of 0.4 to 4 quanta and n of 1000 to 48000."""


def _staircase(interval: Interval, _: FloatArray, task: Task) -> RateMeasurement:
    y, line = _steps_and_line(interval)
    p, q, least, bound, slopes = _search(y, line, math.inf if task.options.certified else MAX_WORK)
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


def recognized(interval: Interval, *, certified: bool = False) -> tuple[FloatArray, FloatArray]:
    """The angle in quanta, and the line whose floor is the staircase nearest to it."""
    y, line = _steps_and_line(interval)
    p, q, *_ = _search(y, line, math.inf if certified else MAX_WORK)
    return y, line + p + (q - p) * np.linspace(0.0, 1.0, y.size)


def _search(
    y: FloatArray, line: FloatArray, work: float
) -> tuple[float, float, float, float, tuple[float, float] | None]:
    """Heights p, q over the ends of `line` at which the staircase is nearest, its misfit, the least possible one."""
    # Of an ideal staircase also the limits of its slope, and no search; else a descent on a grid, the whole
    # neighbourhood of where it ends, then whatever could be better.
    slopes = _ideal(y - line)
    if slopes is not None:
        steep, reach = sum(slopes) / 2, (y.size - 1) / 2
        free = y - line - steep * np.linspace(-reach, reach, y.size)
        middle = float(free.max() + free.min() + 1) / 2
        slope = float(line[-1] - line[0]) / (y.size - 1)
        return middle - steep * reach, middle + steep * reach, 0.0, 0.0, (slope + slopes[0], slope + slopes[1])
    from allanite.kernels.staircase import compass, misfit, nearest_staircase

    right = np.linspace(0.0, 1.0, y.size)
    samples = _about(y, line, right)
    whole = math.sqrt(misfit(*samples, (0.0, 0.0)))
    p, q, least = compass(samples, *GRID)
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
    if not math.isfinite(interval.pulse):
        raise UsageError(
            "the staircase needs counts, or samples and the step of their angle: pass "
            + spelled("--quantum", "quantum=...")
            + (" in the record's unit (for a rate: times s)")
        )
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
    if not noise >= DITHERED:
        return math.nan
    ends = CUBE_ROOT * noise ** (2 / 3) * (task.size + 1) ** (-1 / 3)
    return float((ends * task.pulse / task.duration) ** 2)


STAIRCASE = RateEstimator(
    name="staircase", title=say("recognition of the staircase of counts"),
    formula=r"\min_{U, \varphi} \sum (y_i - \lfloor U t_i + \varphi \rfloor)^2",
    reference=say("Enin, Saneev, Science and Education of the Bauman MSTU 2017(2) 52, formula (2)"),
    assumes=say(
        "counts without noise, for which its limits are certain; with noise above a fraction of a pulse it is "
        "slightly worse than regression"
    ),
    weights=lambda task: parabola(task.size), measure=_staircase, excess=_excess, needs_quantum=True, color="#AA4499",
)  # fmt: skip
