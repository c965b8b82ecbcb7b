"""What is done to samples before, within and after their cosine transform.

With h = n/2 = P Q complex points z_j, j = Q r + q, of the reals y_0, y_2, y_4 .. and then .. y_5, y_3, y_1
(J. Makhoul, IEEE Trans. ASSP 28, 1980), Z_k, k = s + P t, is the transform over r, times exp(-2 pi i s q / h), and then
over q. All tables are of P or Q angles; their products are the others.
"""

import math

import numpy as np
from numpy.typing import NDArray

from .compiling import inner, kernel, part, swift, swift_part

BLOCK = 1024
"""Coefficients that are summed before they are added to the rest of their bin: rounding grows with neither."""


SIZE = np.int64(0x7FFF_FFFF_FFFF_FFFF)
"""The bits of a number without its sign: as integers they are ordered as the sizes are, and compared side by side."""


@swift_part
def _block(c):  # type: ignore[no-untyped-def]
    """Sum of squares, sums of the first, third .. and of the second, fourth .. of some coefficients."""
    squares = first = second = 0.0
    for i in range(c.size // 2):
        a, b = c[2 * i], c[2 * i + 1]
        first += a
        second += b
        squares += a * a + b * b
    if c.size % 2:
        a = c[-1]
        first += a
        squares += a * a
    return squares, first, second


@swift_part
def _largest(bits):  # type: ignore[no-untyped-def]
    """Bits of the largest of some numbers, without its sign."""
    found = np.int64(0)
    for i in range(bits.size):
        found = max(found, bits[i] & SIZE)
    return found


@swift
def _binned(c, bits, edges):  # type: ignore[no-untyped-def]
    """See `binned`; `bits` are those of c as integers."""
    result = np.zeros((5, edges.size - 1))
    for j in range(edges.size - 1):
        at, most = edges[j], np.int64(0)
        for start in range(edges[j], edges[j + 1], BLOCK):
            stop = min(start + BLOCK, edges[j + 1])
            squares, first, second = _block(c[start:stop])
            result[0, j] += squares
            result[3 + start % 2, j] += first
            result[4 - start % 2, j] += second
            largest = _largest(bits[start:stop])
            if largest > most:
                most, at = largest, start
        while (bits[at] & SIZE) < most:
            at += 1
        result[0, j] /= edges[j + 1] - edges[j]
        result[1, j] = c[at] * c[at]
        result[2, j] = at
    return result


def binned(c: NDArray[np.float64], edges: NDArray[np.int64]) -> NDArray[np.float64]:
    """Mean and largest square of c[a:b] between neighbouring edges, its index, sums of even and of odd indices.

    Shapes (edges - 1,), the indices as floats; no bin is empty.
    """
    return np.asarray(_binned(c, c.view(np.int64), edges))


@swift
def less_constant(values, constant):  # type: ignore[no-untyped-def]
    """Values less a constant, float64, and their sum, which is finite if all of them are."""
    y = np.empty(values.size)
    total = 0.0
    for i in range(values.size):
        y[i] = values[i] - constant
        total += y[i]
    return y, total


@swift
def less_ramp(y, slope):  # type: ignore[no-untyped-def]
    """Take a ramp that is zero in the middle out of y, in its place."""
    middle = (y.size - 1) / 2
    for i in range(y.size):
        y[i] -= slope * (i - middle)


PART = 256
"""Neighbouring coefficients that are made together."""


@kernel
def even_then_odd(y, slope, v):  # type: ignore[no-untyped-def]
    """The points of even index, and then those of odd index backward, less a ramp that is zero in the middle."""
    n, middle = y.size, (y.size - 1) / 2
    for i in range(n // 2):
        v[i] = y[2 * i] - slope * (2 * i - middle)
    back = v[n // 2 :][::-1]
    for i in range(n // 2):
        back[i] = y[2 * i + 1] - slope * (2 * i + 1 - middle)


@swift_part
def _turn(row, fine, coarse):  # type: ignore[no-untyped-def]
    """Multiply row[q], complex numbers as pairs of floats, with coarse[q / fine] fine[q % fine]."""
    width = fine.shape[1]
    for b in range(coarse.shape[1]):
        part = row[2 * b * width : 2 * (b + 1) * width]
        c, s = coarse[0, b], coarse[1, b]
        for i in range(part.size // 2):
            re, im = c * fine[0, i] - s * fine[1, i], c * fine[1, i] + s * fine[0, i]
            x, y = part[2 * i], part[2 * i + 1]
            part[2 * i], part[2 * i + 1] = x * re - y * im, x * im + y * re


@inner
def _angles(step, count):  # type: ignore[no-untyped-def]
    """Cosines and sines of -step i, shape (2, count)."""
    table = np.empty((2, count))
    for i in range(count):
        table[0, i], table[1, i] = math.cos(step * i), -math.sin(step * i)
    return table


@kernel
def twiddle(z):  # type: ignore[no-untyped-def]
    """Multiply z[s, q] with exp(-2 pi i s q / h) in place; shape (P, 2 Q), complex numbers as pairs of floats."""
    P, Q = z.shape[0], z.shape[1] // 2
    width = int(math.sqrt(Q))
    for s in range(1, P):
        step = 2 * math.pi * s / (P * Q)
        _turn(z[s], _angles(step, width), _angles(step * width, -(-Q // width)))


@swift_part
def _four(near, far, turn, base, out):  # type: ignore[no-untyped-def]
    """Coefficients k, n - k, h - k and h + k from Z_k and Z_(h-k), of ascending k.

    `near`, `far` and `turn` are real and imaginary parts, shape (2, k); turn times base is exp(-i pi k / 2n). The
    coefficients of index n - k and h - k stand in descending k.
    """
    (a, b), (c, d), (co, si) = near, far, turn
    up, top, down, over = out
    last, half = up.size - 1, math.sqrt(0.5)
    for i in range(up.size):
        ur, ui = base[0] * co[i] - base[1] * si[i], base[0] * si[i] + base[1] * co[i]
        wr, wi = ur * ur - ui * ui, 2 * ur * ui
        wr, wi = wr * wr - wi * wi, 2 * wr * wi
        er, ei, fr, fi = a[i] + c[i], b[i] - d[i], b[i] + d[i], c[i] - a[i]
        gr, gi = wr * fr - wi * fi, wr * fi + wi * fr
        vr, vi, xr, xi = er + gr, ei + gi, er - gr, gi - ei
        up[i], top[last - i] = ur * vr - ui * vi, -(ur * vi + ui * vr)
        # exp(-i pi (h - k) / 2n) is exp(-i pi / 4) over the other
        tr, ti = half * (ur - ui), -half * (ur + ui)
        down[last - i], over[i] = tr * xr - ti * xi, -(tr * xi + ti * xr)


@inner
def _gather(Z, step, t, scale, out):  # type: ignore[no-untyped-def]
    """Column t of every step-th row, real and imaginary parts."""
    column = Z[::step, 2 * t : 2 * t + 2]
    for i in range(out.shape[1]):
        out[0, i], out[1, i] = scale * column[i, 0], scale * column[i, 1]


@part
def _part(Z, c, k, count, tables):  # type: ignore[no-untyped-def]
    """What Z_k .. Z_(k+count-1), of one column, and their counterparts give."""
    P, Q = Z.shape[0], Z.shape[1] // 2
    n, h = c.size, c.size // 2
    short, long, near, far = tables
    s, t = k % P, k // P
    _gather(Z[s:], 1, t, math.sqrt(0.5 / n), near[:, :count])
    _gather(Z[: (P - s) % P + 1], -1, Q - 1 - t if s else Q - t, math.sqrt(0.5 / n), far[:, :count])
    down, top = c[h - k - count + 1 : h - k + 1], c[n - k - count + 1 : n - k + 1]
    out = (c[k : k + count], top, down, c[h + k : h + k + count])
    turn, base = short[:, s : s + count], (long[0, t], long[1, t])
    _four((near[0, :count], near[1, :count]), (far[0, :count], far[1, :count]), (turn[0], turn[1]), base, out)


@kernel
def coefficients(Z, c):  # type: ignore[no-untyped-def]
    """The orthonormal DCT-II from Z[s, t] = Z_k, shape (P, 2 Q), complex numbers as pairs of floats."""
    P, Q, n = Z.shape[0], Z.shape[1] // 2, c.size
    angle = math.pi / (2 * n)
    tables = (_angles(angle, P // 2 + 1), _angles(angle * P, Q), np.empty((2, PART)), np.empty((2, PART)))
    c[0], c[n // 2] = (Z[0, 0] + Z[0, 1]) / math.sqrt(n), (Z[0, 0] - Z[0, 1]) / math.sqrt(n)
    for t in range(1, Q // 2 + 1):
        _part(Z, c, P * t, 1, tables)
    for s in range(1, (P + 1) // 2, PART):
        for t in range(Q):
            _part(Z, c, s + P * t, min(PART, (P + 1) // 2 - s), tables)
    if P % 2 == 0:
        for t in range((Q + 1) // 2):
            _part(Z, c, P // 2 + P * t, 1, tables)
