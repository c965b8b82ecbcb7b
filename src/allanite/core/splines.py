"""Splines, as those of scipy.interpolate, whose import takes a tenth of a small analysis."""

import numpy as np

from .arrays import FloatArray


def cubic(x: FloatArray, y: FloatArray) -> FloatArray:
    """Cubics between points, the highest power first, shape (4, ..., points - 1); the outer two of each end are one."""
    from scipy.linalg import solve_banded

    h, rise = np.diff(x), np.diff(y) / np.diff(x)
    if x.size < 4:  # a line, or a parabola
        bend = np.diff(rise) / (x[-1] - x[0]) if x.size == 3 else np.zeros_like(rise)
        s = np.concatenate((rise[..., :1] - h[0] * bend, rise + h * bend), axis=-1)
    else:
        bands, b = np.zeros((3, x.size)), np.empty(y.shape)
        bands[0, 2:], bands[1, 1:-1], bands[2, :-2] = h[:-1], 2 * (h[:-1] + h[1:]), h[1:]
        b[..., 1:-1] = 3 * (h[1:] * rise[..., :-1] + h[:-1] * rise[..., 1:])
        for end, g, r in ((0, h, rise), (-1, h[::-1], rise[..., ::-1])):
            wide = g[0] + g[1]
            bands[1, end], bands[end, (1, -2)[end]] = g[1], wide
            b[..., end] = ((g[0] + 2 * wide) * g[1] * r[..., 0] + g[0] ** 2 * r[..., 1]) / wide
        s = solve_banded((1, 1), bands, b.reshape(-1, x.size).T).T.reshape(y.shape)
    t = (s[..., :-1] + s[..., 1:] - 2 * rise) / h
    return np.array([t / h, (rise - s[..., :-1]) / h - t, s[..., :-1], y[..., :-1]])


def linear(x: FloatArray, y: FloatArray) -> FloatArray:
    """The same of straight lines."""
    rise = np.diff(y) / np.diff(x)
    return np.array([0 * rise, 0 * rise, rise, y[..., :-1]])


def valued(x: FloatArray, cubics: FloatArray, at: FloatArray) -> FloatArray:
    """The cubics between points x at places, those of the ends also beyond."""
    i = np.clip(np.searchsorted(x, at, side="right") - 1, 0, x.size - 2)
    a, b, c, d = cubics[..., i]
    u = at - x[i]
    return np.asarray(((a * u + b) * u + c) * u + d)


def basis(knots: FloatArray, x: FloatArray) -> FloatArray:
    """Cubic B-splines of knots at places between the first and the last, shape (places, splines)."""
    x = x[:, None]
    made = ((knots[:-1] <= x) & (x < knots[1:])).astype(np.float64)
    for k in (1, 2, 3):
        wide = knots[k:] - knots[:-k]
        wide = np.where(wide > 0, wide, 1.0)  # of none where it is zero
        made = (x - knots[: -k - 1]) / wide[:-1] * made[:, :-1] + (knots[k + 1 :] - x) / wide[1:] * made[:, 1:]
    return np.asarray(made)
