"""The cosine transform of a whole record.

One long transform goes through memory once for each of its some twenty stages, and mostly waits for it. Cut into rows
and columns of a matrix, which the cache holds, it goes through memory five times.
"""

import math

import numpy as np

from allanite.core.arrays import FloatArray

LONG = 1 << 20
"""Points from which the cache does not hold a transform."""

SHORT = 1 << 16
"""Points up to which a transform of any size is fast enough."""

PRIME = 256
"""Largest prime factor of the size of a transform that is not cut, unless it is short."""

UNEVEN = 16
"""Longest row over the shortest column, or the other way round, for which cutting pays."""


def cosine_transform(y: FloatArray, slope: float = 0.0) -> FloatArray:
    """The orthonormal DCT-II of y less a ramp that is zero in its middle, shape of y, which is overwritten.

    Examples
    --------
    >>> cosine_transform(np.array([1.0, 1.0, 1.0, 1.0])).round(3).tolist()
    [2.0, 0.0, 0.0, 0.0]
    """
    from scipy.fft import dct, fft

    from allanite.kernels.binned import less_ramp
    from allanite.kernels.cosine import coefficients, even_then_odd, twiddle

    rows = _rows(y.size)
    if not rows:
        less_ramp(y, slope)
        return np.asarray(dct(y, norm="ortho", overwrite_x=True))
    v = np.empty(y.size)
    even_then_odd(y, slope, v)
    z = fft(v.view(np.complex128).reshape(rows, -1), axis=0, overwrite_x=True)
    twiddle(z.view(np.float64))
    z = fft(z, axis=1, overwrite_x=True)
    coefficients(z.view(np.float64), y)
    return y


def easy_size(n: int) -> int:
    """The largest size up to n whose transform is fast: a few points less than n, at most some dozens.

    A prime size takes more than ten times as long, and as much more memory.

    Examples
    --------
    >>> easy_size(65_521), easy_size(1_000_000), easy_size(999_983), easy_size(3_599_999)
    (65521, 1000000, 999975, 3599996)
    """

    def easy(size: int) -> bool:
        return bool(_rows(size)) if size >= LONG else pow(math.factorial(PRIME), size.bit_length(), size) == 0

    return n if n < SHORT else next(size for size in range(n, 0, -1) if easy(size))


def _rows(n: int) -> int:
    """Rows of the matrix of n / 2 complex numbers, about as many as columns; 0 where there is no such matrix."""
    half = n // 2
    if n % 2 or n < LONG:
        return 0
    least = math.isqrt(half // UNEVEN)
    return next((P for P in range(math.isqrt(half), least, -1) if half % P == 0), 0)
