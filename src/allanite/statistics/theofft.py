"""Theo1 of one large m by correlations, in O(N log N) instead of O(N m).

With k = m/2, a_i = x_i + x_{i+m} and w_v = 1/v the square of the definition splits into

    sum_i sum_v w_v (a_i - x_{i+v} - x_{i+m-v})^2
      = H sum_i a_i^2 - 2 sum_u W_u sum_i a_i x_{i+u} + sum_u W_u sum_i x_{i+u}^2 + 2 sum_v w_v sum_i x_{i+v} x_{i+m-v}

with W_u = w_u + w_{m-u}. The first correlation is plain. The last pairs points that lie symmetrically about a centre:
an autocorrelation at even lags less its two edges, which are triangles ``sum over p < v of x_p x_{p+2(k-v)}``, halved
until they are small: each half leaves a square, which is a correlation again. All of it in segments of the record,
each less the line through its ends: what cancels then is never more than a segment's own size.
"""

from functools import cache

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

LONG = 7
"""Windows that start in one segment, over m."""

LEAF = 128
"""Side of the triangles that are summed directly."""


def theo1_fft(x: FloatArray, m: int) -> float:
    """Sum over i < x.size - m and v = 1 .. m/2 of (x[i] - x[i+v] + x[i+m] - x[i+m-v])^2 / v."""
    windows, length = x.size - m, LONG * m
    whole = windows // length
    total = 0.0
    if whole:
        segments = np.lib.stride_tricks.sliding_window_view(x, length + m)[::length][:whole]
        # a batch stays within the cache's neighbourhood
        batch = max(1, (1 << 20) // (length + m))
        total += sum(_segments(segments[i : i + batch], m) for i in range(0, whole, batch))
    if windows > whole * length:
        total += _segments(x[None, whole * length :], m)
    return total


def _segments(x: FloatArray, m: int) -> float:
    """The sum over all windows of segments, shape (s, b + m)."""
    k, b = m // 2, x.shape[1] - m
    z = x - x[:, :1]
    z -= np.arange(x.shape[1]) * (z[:, -1:] / (x.shape[1] - 1))
    ends = z[:, :b] + z[:, m:]
    weights, harmonic = _weights(k)
    size = _fast(b + m)
    spectrum = np.fft.rfft(z, size)
    with_ends = np.fft.irfft(_cross(np.fft.rfft(ends, size), spectrum), size)[:m]
    paired = np.fft.irfft(_cross(np.fft.rfft(z[:, :b], size), spectrum), size)[:m:2]
    squares = np.concatenate(([0.0], np.cumsum((z * z).sum(0))))
    spread = np.concatenate(([0.0], weights[1:k], [2 * weights[k]], weights[1:k][::-1]))  # W_u, u < m
    edges = _triangles(z[:, b:], k) - _triangles(z[:, :m], k)  # by v = k - u
    pairs = paired[:k][::-1] + edges[1:]  # by v = 1 .. k
    return float(
        harmonic * (ends * ends).sum()
        - 2 * spread @ with_ends
        + spread @ (squares[b : b + m] - squares[:m])
        + 2 * weights[1:] @ pairs
    )


def _cross(a: NDArray[np.complex128], b: NDArray[np.complex128]) -> NDArray[np.complex128]:
    return np.asarray(np.einsum("ij,ij->j", a.conj(), b))


@cache
def _weights(k: int) -> tuple[FloatArray, float]:
    weights = np.concatenate(([0.0], 1 / np.arange(1, k + 1)))
    return weights, float(weights.sum())


def _fast(n: int) -> int:
    """The smallest length from n on that has only the factors 2, 3 and 5."""
    best = 1 << (n - 1).bit_length()
    for threes in (1, 3, 9, 27):
        for fives in (1, 5, 25):
            part = threes * fives
            best = min(best, part << max(0, -(-n // part) - 1).bit_length())
    return best


def _triangles(e: FloatArray, k: int) -> FloatArray:
    """Sum over segments and p < v of e[p] e[p + 2 (k - v)], v = 0 .. k, shape (k + 1,); e of shape (s, 2k)."""
    from allanite.kernels.theo import triangles

    side = LEAF
    while side < k + 1:
        side *= 2
    # zeros in front make the largest triangle a power of two: v and p are shifted along
    shift = side - 1 - k
    padded = np.zeros((e.shape[0], 2 * side))
    padded[:, shift : shift + 2 * k] = e
    out = np.zeros(side)
    half = side // 2
    while half >= LEAF:
        out.reshape(-1, 2 * half)[:, half:] += _squares(padded, half)
        half //= 2
    for row in padded:
        triangles(row, LEAF, out)
    return out[shift:]


def _squares(e: FloatArray, half: int) -> FloatArray:
    """What p of the first half of each block gives v of its second half, shape (blocks, half)."""
    side, count = e.shape[1] // 2, e.shape[1] // (4 * half)
    near = e[:, :side].reshape(-1, count, 2 * half)[:, :, :half]
    starts = 2 * side - 4 * half - 2 * half * np.arange(count)
    far = np.lib.stride_tricks.sliding_window_view(e, 3 * half, axis=1)[:, starts]
    product = np.einsum("sbj,sbj->bj", np.fft.rfft(near, 3 * half).conj(), np.fft.rfft(far))
    return np.asarray(np.fft.irfft(product, 3 * half)[:, : 2 * half : 2][:, ::-1])
