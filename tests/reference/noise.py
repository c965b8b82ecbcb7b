"""Noise by the structure function D of its angle: the covariance of mean rates, and records drawn by plain numpy.

Sizes are {"Q": ..., "N": ..., "B": ..., "K": ...} of one sample interval as the unit of time.
"""

import numpy as np

STRUCTURE = {"Q": lambda t: 2.0 * (t > 0), "N": lambda t: t,
             "B": lambda t: -(t**2) * np.log(np.where(t > 0, t, 1.0)) / np.pi, "K": lambda t: -(t**3) / 6}  # fmt: skip
"""IEEE Std 952: D(t) = E (x(s + t) - x(s))^2 of a coefficient of 1; of B and K less a polynomial."""


def autocovariance(sizes, n):
    """Of the mean rates at the lags 0 .. n - 1: [D(l + 1) + D(|l - 1|) - 2 D(l)] / 2; of B and K up to a constant."""
    lag = np.arange(float(n))
    parts = ((STRUCTURE[symbol], size) for symbol, size in sizes.items())
    return sum((v**2 * (D(lag + 1) + D(abs(lag - 1)) - 2 * D(lag)) / 2 for D, v in parts), np.zeros(n))


def covariance(sizes, n):
    """Covariance of n mean rates, shape (n, n)."""
    return autocovariance(sizes, n)[abs(np.subtract.outer(np.arange(n), np.arange(n)))]


def draw(rng, sizes, n):
    """(mean rates, the part of them that wanders: B and K), shape (n,) each."""
    drift = sizes.get("K", 0.0) * rng.standard_normal(n)
    slow = np.cumsum(drift) - drift / 2 + sizes.get("K", 0.0) / np.sqrt(12) * rng.standard_normal(n)
    if "B" in sizes:  # its differences are stationary, and drawn on a circle
        c = autocovariance({"B": sizes["B"]}, n + 1)
        r = 2 * c[:n] - c[1:] - c[abs(np.arange(n) - 1)]
        power = np.fft.rfft(np.concatenate((r, r[-2:0:-1]))).real
        slow = slow + np.cumsum(np.fft.irfft(np.fft.rfft(rng.standard_normal(2 * n - 2)) * np.sqrt(power))[:n])
    fast = sizes.get("N", 0.0) * rng.standard_normal(n) + sizes.get("Q", 0.0) * np.diff(rng.standard_normal(n + 1))
    return fast + slow, slow
