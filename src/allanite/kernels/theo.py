"""Statistics over windows: Theo1 by its definition, parabolas, and sums of products of frames."""

import numpy as np

from .allan import dot
from .compiling import kernel, part, shared, swift, swift_part
from .summed import running_sum

_BLOCK = 2048


@swift_part
def _pair_squares(ends, near, far):  # type: ignore[no-untyped-def]
    total = 0.0
    for i in range(ends.size):
        difference = ends[i] - (near[i] + far[i])
        total += difference * difference
    return total


@kernel
def theo1(x, m):  # type: ignore[no-untyped-def]
    """Sum over i < x.size - m and v = 1 .. m/2 of (x[i] - x[i+v] + x[i+m] - x[i+m-v])^2 / v for every even m."""
    sums = np.zeros(m.size)
    for j in range(m.size):
        sums[j] = _one(x, m[j])
    return sums


@part
def _one(x, m):  # type: ignore[no-untyped-def]
    z, ends = np.empty(_BLOCK + m), np.empty(_BLOCK)
    total = 0.0
    for start in range(0, x.size - m, _BLOCK):
        count = min(_BLOCK, x.size - m - start)
        piece = x[start : start + count + m]
        slope = (piece[-1] - piece[0]) / (piece.size - 1)
        for i in range(piece.size):
            z[i] = (piece[i] - piece[0]) - slope * i
        for i in range(count):
            ends[i] = z[i] + z[m + i]
        for v in range(1, m // 2 + 1):
            total += _pair_squares(ends[:count], z[v : v + count], z[m - v : m - v + count]) / v
    return total


@swift_part
def _add_points(A, e, f, points):  # type: ignore[no-untyped-def]
    """A[i] += points[0] e[i] + points[1] e[i-1] + points[2] f[i] + points[3] f[i-1], e and f from i = -1 on."""
    e0, e1, f0, f1 = points
    ea, eb, fa, fb = e[1:], e[:-1], f[1:], f[:-1]
    for i in range(A.size):
        A[i] += (e0 * ea[i] + e1 * eb[i]) + (f0 * fa[i] + f1 * fb[i])


@swift_part
def _add_mirrored(D, e, f, weights):  # type: ignore[no-untyped-def]
    """D[u] += e[0][u] e[1][u] + f[0][u] f[1][u]; gives the sum of weights[u] D[u]."""
    (a, b), (c, d) = e, f
    total = 0.0
    for u in range(D.size):
        D[u] += a[u] * b[u] + c[u] * d[u]
        total += weights[u] * D[u]
    return total


@kernel
def every_theo1(A, D, edges, signs):  # type: ignore[no-untyped-def]
    """Sum over v of (A_m[v] + A_m[m-v]) / v and of D_m[k-v] / v, v = 1 .. k = m/2, for all m = 2, 4 ...: two arrays.

    A_m[l] is A[l] plus the products of the first m points of the edges that lie l apart; D_m[u] is D[u] plus those of
    points that lie u beside one of the first k, on both sides. From one m to the next two points are added to A, and
    one centre to D (B. Lewis, IEEE Trans. UFFC 67, 2020, is such a recursion). `edges`: (v, 2 K), v even, with `signs`.
    """
    most = edges.shape[1] // 2
    first, second = np.zeros(most + 1), np.zeros(most + 1)
    weights = 1.0 / np.arange(1, most + 1)
    falling = weights[::-1].copy()
    backward = edges[:, ::-1].copy()
    signed = backward * signs.reshape(-1, 1)
    end = 2 * most
    for k in range(1, most + 1):
        m = 2 * k
        for b in range(0, signs.size, 2):
            e, f, E, F = edges[b], edges[b + 1], backward[b], backward[b + 1]
            s, t = signs[b], signs[b + 1]
            # the points l = 1, 2 ... before point j lie in the backward edge from end - j on
            points = s * e[m - 2], s * e[m - 1], t * f[m - 2], t * f[m - 1]
            _add_points(A[1 : m - 1], E[end - m + 1 : end], F[end - m + 1 : end], points)
            A[m - 1] += s * e[m - 1] * e[0] + t * f[m - 1] * f[0]
            # beside the new centre, with its sign in the points on the left
            left, right = (signed[b, end - k :], signed[b + 1, end - k :]), (e[k - 1 : m - 1], f[k - 1 : m - 1])
            second[k] = _add_mirrored(D[:k], (left[0], right[0]), (left[1], right[1]), falling[most - k :])
        first[k] = dot(weights[:k], A[1 : k + 1]) + dot(falling[most - k :], A[k:m])
    return first, second


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
