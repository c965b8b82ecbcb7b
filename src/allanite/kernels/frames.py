"""Frames of a record, each less its own polynomial, and sums of products of their transforms."""

import numpy as np

from .allan import dot
from .compiling import kernel, part, shared, swift_part
from .summed import running_sum

STRETCH = 1024
"""Floats of a spectrum that are multiplied before going on to the next block."""


@swift_part
def _moments(z):  # type: ignore[no-untyped-def]
    """Sums of z, t z and t^2 z, t from -1 to 1."""
    zero = first = second = 0.0
    step = 2.0 / (z.size - 1)
    for i in range(z.size):
        t = step * i - 1.0
        zero += z[i]
        first += t * z[i]
        second += t * t * z[i]
    return zero, first, second


@swift_part
def _less(z, a, b, c):  # type: ignore[no-untyped-def]
    """Take a + b t + c t^2 from z, in place, t from -1 to 1."""
    step = 2.0 / (z.size - 1)
    for i in range(z.size):
        t = step * i - 1.0
        z[i] -= a + t * (b + t * c)


@part
def flatten(z, degree):  # type: ignore[no-untyped-def]
    """Remove the least-squares polynomial of degree 1 or 2 from z, in place."""
    n = float(z.size)
    t2 = n * (n + 1) / (3 * (n - 1))
    t4 = n * (n + 1) * (3 * n * n - 7) / (15 * (n - 1) ** 3)
    zero, first, second = _moments(z)
    bend = (second - zero * t2 / n) / (t4 - t2 * t2 / n) if degree == 2 else 0.0
    _less(z, zero / n - bend * t2 / n, first / t2, bend)


@shared
def cut(x, start, degree, summed, out):  # type: ignore[no-untyped-def]
    """The points of a frame into out: x, or its running sum, from `start` on, less their polynomial."""
    if summed:
        running_sum(x[start : start + out.size - 1], out)
    else:
        for i in range(out.size):
            out[i] = x[start + i] - x[start]
    flatten(out, degree)


@swift_part
def _add_product(total, a, b):  # type: ignore[no-untyped-def]
    """Add conj(a) b, complex numbers as pairs of floats."""
    for i in range(total.size // 2):
        total[2 * i] += a[2 * i] * b[2 * i] + a[2 * i + 1] * b[2 * i + 1]
        total[2 * i + 1] += a[2 * i] * b[2 * i + 1] - a[2 * i + 1] * b[2 * i]


@kernel
def add_products(total, spectra, left):  # type: ignore[no-untyped-def]
    """total[o] += sum over frames and blocks k < left of conj(spectra[k]) spectra[k + o].

    `spectra` has shape (frames, blocks, 2 f), `total` (offsets, 2 f): complex numbers as pairs of floats.

    A stretch of frequencies at a time, so that all blocks of it stay in the cache.
    """
    blocks, size = spectra.shape[1], spectra.shape[2]
    for f in range(0, size, STRETCH):
        stop = min(f + STRETCH, size)
        for s in range(spectra.shape[0]):
            for k in range(left):
                for o in range(min(total.shape[0], blocks - k)):
                    _add_product(total[o, f:stop], spectra[s, k, f:stop], spectra[s, k + o, f:stop])


@kernel
def add_rectangles(total, near, far, place, steps):  # type: ignore[no-untyped-def]
    """total[:, J] += conj(near[:, I]) far for all I < J with a I + d J = place, steps = a, d.

    `total` and `near` have shape (parents, blocks, 2 f), `far` (parents, 2 f).
    """
    a, d = steps
    for high in range(1, total.shape[1]):
        rest = place - d * high
        low = rest // a
        if rest >= 0 and low * a == rest and low < high:
            for p in range(total.shape[0]):
                _add_product(total[p, high], near[p, low], far[p])


@kernel
def running_squares(z):  # type: ignore[no-untyped-def]
    """Running sums of z^2, shape (z.size + 1,), by blocks: rounding does not grow with the length."""
    out = np.empty(z.size + 1)
    out[0] = base = 0.0
    for start in range(0, z.size, 256):
        part = 0.0
        for i in range(start, min(start + 256, z.size)):
            part += z[i] * z[i]
            out[i + 1] = base + part
        base += part
    return out


@kernel
def add_leaves(out, e, sign, steps, leaf):  # type: ignore[no-untyped-def]
    """out[m] += sign times the sum of e[i] e[i + d m + offset] over a m0 <= i < a m, steps = a, d, offset.

    m0 is where the block of `leaf` that holds m begins.
    """
    a, d, offset = steps
    for m0 in range(0, out.size, leaf):
        for m in range(m0 + 1, min(m0 + leaf, out.size)):
            far = d * m + offset
            out[m] += sign * dot(e[a * m0 : a * m], e[a * m0 + far : a * m + far])
