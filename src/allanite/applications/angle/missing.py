"""Harmonics that were not asked for, in what the constants do not explain."""

import math
from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from allanite.extending import Finding, FloatArray, IntArray, chance, join, say

from .harmonics import waves
from .solve import FALSE_ALARM, MISSING, Solution

LARGEST_ORDER = 1024  # that is looked for, unless larger ones were asked for
GROUPS = 4096  # means of samples at neighboring angles that are searched, at most
MOST = 4  # missing harmonics that are named
FINENESS = 3  # orders that are tried within what the motion of an angle resolves
AROUND = 25  # orders on each side that tell how large the noise is there
MEDIAN = 2 * math.log(2.0)  # of the squares that one more harmonic explains of white noise of variance 1
ALIKE = 6.63  # squares, over the noise, by which orders that explain the samples as well differ: 99 %
AT_ONCE = 1 << 17  # numbers that are computed at a time
NEW = 0.1  # part of a harmonic that must not be explained by the other constants

Pair = tuple[FloatArray, FloatArray]


class Residuals(NamedTuple):
    """The residuals of samples by the angle of a sensor: means of neighbors, orthogonal to the constants."""

    angle: FloatArray
    slope: FloatArray
    known: FloatArray  # orthonormal columns of the constants
    rest: FloatArray

    def explained(self, orders: IntArray) -> Pair:
        """Squares that a harmonic of each order explains, and its amplitude; 0 where the constants explain it."""
        squares, sizes = np.zeros((2, orders.size))
        at_once = max(1, AT_ONCE // self.rest.size)
        for i in range(0, orders.size, at_once):
            part = slice(i, i + at_once)
            phase = np.outer(orders[part], self.angle)
            s, c = self.slope * np.sin(phase), self.slope * np.cos(phase)
            inside, beside, by, on = s @ self.known, c @ self.known, s @ self.rest, c @ self.rest
            total = (s * s).sum(axis=1) + (c * c).sum(axis=1)
            ss, sc, cc = ((u * v).sum(axis=1) - (p * q).sum(axis=1)
                          for u, v, p, q in ((s, s, inside, inside), (s, c, inside, beside),
                                             (c, c, beside, beside)))  # fmt: skip
            det = np.where((ss + cc) / 2 - np.hypot((ss - cc) / 2, sc) > NEW * NEW * total, ss * cc - sc * sc, np.inf)
            sine, cosine = (cc * by - sc * on) / det, (ss * on - sc * by) / det
            squares[part], sizes[part] = sine * by + cosine * on, np.hypot(sine, cosine)
        return squares, sizes


class Peak(NamedTuple):
    """The most likely missing harmonic of one sensor: its order, those as likely, its amplitude and p-value."""

    name: str
    order: int
    low: int
    high: int
    amplitude: float
    squares: float  # over the noise
    p: float


def missing(
    solution: Solution, rows: FloatArray, values: FloatArray, sensors: Mapping[str, Pair],
    asked: Mapping[str, tuple[int, ...]],
) -> Iterator[Finding]:  # fmt: skip
    """Findings about harmonics that were not asked for; `sensors` have an angle and the slope of the values by it."""
    kept = np.delete(np.arange(values.size), solution.omitted)
    rows, values = rows[kept], values[kept]
    known = dict(asked)
    for _ in range(MOST):
        peaks = [_peak(name, _residuals(rows, values, *(part[kept] for part in pair)), known[name])
                 for name, pair in sensors.items()]  # fmt: skip
        likely = sorted((peak for peak in peaks if peak is not None), key=lambda peak: -peak.squares)
        if not likely or likely[0].p * len(sensors) > FALSE_ALARM:
            return
        yield _finding(likely)
        name, order = likely[0][:2]
        angle, slope = (part[kept] for part in sensors[name])
        rows = np.column_stack([rows, slope[:, None] * waves(angle, (order,))])
        known[name] = (*known[name], order)


def _residuals(rows: FloatArray, values: FloatArray, angle: FloatArray, slope: FloatArray) -> Residuals:
    many = math.ceil(values.size / GROUPS)
    order = np.argsort(np.mod(angle, 2 * math.pi), kind="stable") if many > 1 else np.arange(values.size)
    order = order[: values.size // many * many].reshape(-1, many)
    rows, values, slope = (part[order].mean(axis=1) for part in (rows, values, slope))
    # neighbors are within a turn of each other, of whichever turn they are
    angle = np.angle(np.exp(1j * angle)[order].mean(axis=1)) if many > 1 else angle
    basis, _ = np.linalg.qr(rows)
    return Residuals(angle, slope, basis, values - basis @ (basis.T @ values))


def _peak(name: str, residuals: Residuals, asked: tuple[int, ...]) -> Peak | None:
    turned = np.unwrap(residuals.angle)
    resolved, step = 2 * math.pi / float(np.ptp(turned)), float(np.median(np.abs(np.diff(turned))))
    most = max(LARGEST_ORDER, 4 * max(asked))
    if step * max(asked) < math.pi:  # unless the angles are those of a table, in any order
        most = min(most, int(math.pi / max(step, 1e-12)))
    gap = max(1, int(resolved / FINENESS))
    orders = np.arange(max(1, math.ceil(resolved)), most + 1, gap)
    freedom = residuals.rest.size - residuals.known.shape[1] - 2
    variance = float((residuals.rest**2).sum()) / max(1, freedom + 2)
    if orders.size < 2 or freedom < 1 or not variance > 0:
        return None
    squares, _ = residuals.explained(orders)
    best = int(squares.argmax())
    variance = max(variance, float(np.median(squares[max(0, best - AROUND) : best + AROUND + 1])) / MEDIAN)
    p = orders.size * (1 - min(squares[best] / (variance * (freedom + 2)), 1.0)) ** (freedom / 2)
    fine = np.arange(max(orders[0], orders[best] - 2 * gap), min(most, orders[best] + 2 * gap) + 1)
    fine = fine[~np.isin(fine, asked)]
    if not fine.size:
        return None
    squares, sizes = residuals.explained(fine)
    alike = squares > squares.max() - ALIKE * variance
    usual = alike & (fine % min(asked) == 0)
    chosen = int(np.where(usual if usual.any() else alike, squares, -1.0).argmax())
    low, high = fine[alike][[0, -1]].tolist()
    return Peak(name, int(fine[chosen]), low, high, float(sizes[chosen]), float(squares.max() / variance), p)


def _finding(likely: list[Peak]) -> Finding:
    first = likely[0]
    which = [say("harmonic {order} of {angle}", order=peak.order, angle=peak.name or say("the angle"))
             for peak in likely if peak.squares > first.squares - ALIKE]  # fmt: skip
    what = say("{harmonics} is also present, with an amplitude of about {amplitude:.3g} arcsec ({chance})",
               harmonics=join(say(" or "), which), amplitude=math.degrees(first.amplitude) * 3600,
               chance=chance(first.p))  # fmt: skip
    if first.high > first.low:
        what = say("{harmonic}; orders from {low} to {high} explain the samples as well", harmonic=what, low=first.low,
                   high=first.high)  # fmt: skip
    return Finding(MISSING, what, say("it was not requested, and makes the standard errors of the others wrong"),
                   say("add {order} to the orders", order=first.order))  # fmt: skip
