"""Integration, and squared differences of the angle at every averaging factor."""

import numpy as np

from .compiling import kernel, swift_part

BLOCK = 8192
"""Samples per block: what one averaging factor has loaded the next finds in the cache."""


@kernel
def integrate(values, constant):  # type: ignore[no-untyped-def]
    """x[0] = 0, x[k+1] = x[k] + (values[k] - constant), shape (n + 1,), float64.

    Integers stay exact as long as the sum is below 2^53 steps.
    """
    x = np.empty(values.size + 1)
    x[0] = 0.0
    total = 0.0
    for k in range(values.size):
        total += values[k] - constant
        x[k + 1] = total
    return x


@swift_part
def squares(x, m, order, start, stop):  # type: ignore[no-untyped-def]
    """Sum over i = start .. stop - 1 of the squared difference of order 1, 2 or 3 of x[i], x[i+m], x[i+2m], x[i+3m]."""
    a, b = x[start:stop], x[start + m : stop + m]
    total = 0.0
    if order == 1:
        for i in range(a.size):
            difference = b[i] - a[i]
            total += difference * difference
        return total
    c = x[start + 2 * m : stop + 2 * m]
    if order == 2:
        for i in range(a.size):
            difference = (c[i] - b[i]) - (b[i] - a[i])
            total += difference * difference
        return total
    d = x[start + 3 * m : stop + 3 * m]
    for i in range(a.size):
        difference = (d[i] - a[i]) - 3.0 * (c[i] - b[i])
        total += difference * difference
    return total


@kernel
def strided(x, m, order):  # type: ignore[no-untyped-def]
    """Sum of the squared differences at every m[j]-th i, shape of m."""
    sums = np.zeros(m.size)
    for k in range(m.size):
        points = x[:: m[k]].copy()
        if points.size > order:
            sums[k] = squares(points, 1, order, 0, points.size - order)
    return sums


@swift_part
def dot(a, b):  # type: ignore[no-untyped-def]
    """Sum of a b, over the length of a."""
    total = 0.0
    for i in range(a.size):
        total += a[i] * b[i]
    return total


@swift_part
def _folded_squares(a, b, c, signs, shift):  # type: ignore[no-untyped-def]
    """Sum of (shift + signs[0] a - 2 b + signs[1] c)^2."""
    left, right = signs
    total = 0.0
    for i in range(b.size):
        difference = (shift + right * c[i] - b[i]) + (left * a[i] - b[i])
        total += difference * difference
    return total


@kernel
def folded(x, m):  # type: ignore[no-untyped-def]
    """Sum over i = 1 .. x.size - 2 of x'[i-m] - 2 x[i] + x'[i+m] squared, x' folded back at the first and last point.

    x'[-j] = 2 x[0] - x[j] and x'[last+j] = 2 x[last] - x[last-j] are read off the reversed record.
    """
    last = x.size - 1
    back = x[::-1].copy()
    sums = np.zeros(m.size)
    for start in range(1, last, BLOCK):
        stop = min(start + BLOCK, last)
        for j in range(m.size):
            k = m[j]
            if k >= last:
                continue
            inner, outer = min(k, last - k), max(k, last - k)
            for first, after in (
                (start, min(stop, inner)),
                (max(start, inner), min(stop, outer)),
                (max(start, outer), stop),
            ):
                if after <= first:
                    continue
                a, left, shift = x[max(first - k, 0) :], 1.0, 0.0
                if first < k:
                    a, left, shift = back[last - k + first :], -1.0, 2 * x[0]
                c, right = x[first + k :], 1.0
                if after - 1 > last - k:
                    c, right, shift = back[first + k - last :], -1.0, shift + 2 * x[last]
                sums[j] += _folded_squares(a[: after - first], x[first:after], c, (left, right), shift)
    return sums
