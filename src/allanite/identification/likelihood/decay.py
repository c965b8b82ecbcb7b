"""The cosine transform of an exponential decay."""

import math

import numpy as np

from allanite.core.arrays import FloatArray


def decay_coefficients(k: FloatArray, n: int, tau: float) -> FloatArray:
    """DCT-II coefficients (orthonormal) of exp(-j / tau), j = 0..n-1, except for a factor 1 - (-1)^k exp(-n / tau).

    Examples
    --------
    >>> from scipy.fft import dct
    >>> literal = dct(np.exp(-np.arange(50) / 8), norm="ortho")
    >>> k = np.arange(1.0, 50)
    >>> bool(np.allclose(literal[1:], decay_coefficients(k, 50, 8.0) * (1 - (-1) ** k * np.exp(-50 / 8))))
    True
    """
    half, lost = (0.5 * math.pi / n) * k, -math.expm1(-1 / tau)
    return np.asarray(math.sqrt(2 / n) * np.cos(half) * lost / (lost**2 + 4 * (1 - lost) * np.sin(half) ** 2))
