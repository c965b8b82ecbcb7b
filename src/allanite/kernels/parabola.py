"""A parabola under a stretch of samples: its sums, and the samples less it. u is a line over the stretch."""

import numpy as np

from .compiling import kernel, swift


@swift
def parabola_sums(x, start, step):  # type: ignore[no-untyped-def]
    """Sums of x, u, u^2, u^3, u^4, x u, x u^2 with x less its first value, u = start + step i, shape (7,)."""
    a = b = c = d = e = f = g = 0.0
    x0 = x[0]
    for i in range(x.size):
        u = start + step * i
        y = x[i] - x0
        square = u * u
        a += y
        b += u
        c += square
        d += square * u
        e += square * square
        f += y * u
        g += y * square
    return np.array((a, b, c, d, e, f, g))


@kernel
def less_parabola(x, m, start, step, factors):  # type: ignore[no-untyped-def]
    """Every m-th sample less constant + line u + square u^2, with these three factors, u = start + step i."""
    constant, line, square = factors
    z = np.empty((x.size + m - 1) // m)
    for i in range(z.size):
        u = start + step * (i * m)
        z[i] = x[i * m] - (constant + u * (line + u * square))
    return z
