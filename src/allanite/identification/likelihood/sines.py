"""A piece of L samples under white rate and angle noise: its sine transform, its rate, its response."""

import numpy as np

from allanite.core.arrays import FloatArray


def rate_weights(L: int, ratio: float) -> tuple[FloatArray, float]:
    """Weights w of the rate of L samples by generalized least squares, and its variance over that of one sample's N.

    (I + rho T) x = 1 has the solution 1 - cosh(a (i - c)) / cosh(a c), c = (L + 1) / 2 and 2 cosh(a) = 2 + 1 / rho.
    """
    i = np.arange(1.0, L + 1)
    a = 2 * np.arcsinh(0.5 / np.sqrt(ratio))
    x = np.expm1(-a * i) * np.expm1(-a * (L + 1 - i)) / (1 + np.exp(-a * (L + 1)))  # the same without cancellation
    return np.asarray(x / x.sum()), float(1 / x.sum())


def angle_power(L: int) -> FloatArray:
    """Variance of the coefficients of the sine transform under angle noise, the eigenvalues of T."""
    return np.asarray(4 * np.sin(np.pi / (2 * (L + 1)) * np.arange(1, L + 1)) ** 2)


def low_powers(L: int, ratio: float, split: float, omega: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Power at frequencies of what a piece gives the joined record below the split, under white noise and under T."""
    w, _ = rate_weights(L, ratio)
    wave = np.exp(1j * np.outer(omega, np.arange(L)))
    coefficients = sine(wave)
    coefficients[:, np.pi / (L + 1) * np.arange(1, L + 1) >= split] = 0.0
    r = sine(coefficients)
    q = r + np.outer((wave - r).sum(axis=1), w)
    step = np.diff(np.pad(q, ((0, 0), (1, 1))), axis=1)
    return (np.abs(q) ** 2).sum(axis=1), (np.abs(step) ** 2).sum(axis=1)


def sine(x: FloatArray) -> FloatArray:
    """The orthonormal DST-I of the last axis, its own inverse."""
    from scipy.fft import dst

    return np.asarray(dst(x, type=1, norm="ortho"))


def sine_variances(c: FloatArray) -> FloatArray:
    """Diagonal of S'CS of the Toeplitz matrix with the first row c.

    Sum over lags h of both signs of c(h) ((L - h) cos(omega h) + sin(omega (h + 1)) / sin(omega)) / (L + 1).
    """
    from scipy.fft import dct, dst

    L = c.size
    cosines = dct(np.append(c * (L - np.arange(L)), [0.0, 0.0]), type=1)[1:-1]
    sines = dst(c, type=1) / np.sin(np.pi / (L + 1) * np.arange(1, L + 1))
    return np.asarray((cosines + sines - c[0]) / (L + 1))


def toeplitz(c: FloatArray, v: FloatArray) -> FloatArray:
    """Product of the symmetric Toeplitz matrix with first row c with v."""
    from scipy.fft import irfft, next_fast_len, rfft

    size = next_fast_len(2 * v.size, real=True)  # a circle of more than twice the lags: none is met from both sides
    circle = np.concatenate((c, np.zeros(size - 2 * c.size + 1), c[:0:-1]))
    return np.asarray(irfft(rfft(circle) * rfft(v, size), size)[: v.size])
