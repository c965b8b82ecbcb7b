"""The time derivative of a slow channel: the slope of a line fitted in a sliding window."""

import numpy as np
from numpy.typing import NDArray

from allanite.extending import UsageError

FloatArray = NDArray[np.float64]

SHORTEST = 60.0
"""Seconds of a window; in a shorter one the steps of a digital thermometer are what changes."""


def local_slope(x: FloatArray, rate: float, window: float) -> FloatArray:
    """Slope of the least-squares line in a Hann window around each sample, per second; shape of `x`.

    At the ends the window is cut off, and the line fitted to what is left. A reading that is NaN counts for nothing in
    its neighbours' windows, and has no slope of its own.

    Examples
    --------
    >>> x = 0.5 * np.arange(300.0)
    >>> x[100] = np.nan
    >>> slope = local_slope(x, 2.0, 60.0)
    >>> slope[[0, 50, 99, 299]].round(12).tolist(), bool(np.isnan(slope[100]))
    ([1.0, 1.0, 1.0, 1.0], True)
    """
    half = int(window * rate / 2)
    if not (np.isfinite(window) and window >= SHORTEST and half >= 1):
        raise UsageError(
            f"the window of a derivative must have at least {SHORTEST:g} s and 3 samples, not {window!r} s"
        )
    from scipy.signal import oaconvolve

    j = np.arange(-half, half + 1, dtype=np.float64)
    weight = 0.5 + 0.5 * np.cos(np.pi * j / (half + 1))
    there = np.isfinite(x)
    centre = float(np.mean(x[there])) if there.any() else 0.0
    values = np.where(there, x - centre, 0.0)

    def around(y: FloatArray, power: int) -> FloatArray:
        """Sum of weight * j^power * y[i + j]."""
        return np.asarray(oaconvolve(y, (weight * (j / half) ** power)[::-1], mode="full")[half : half + y.size])

    ones = there.astype(np.float64)
    w, t, tt = (around(ones, power) for power in (0, 1, 2))
    y, ty = around(values, 0), around(values, 1)
    spread = w * tt - t * t
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = (w * ty - t * y) / spread
    # fewer than two samples in the window: the spread is rounding
    return np.where(there & (spread > 1e-9 * np.sum(weight) ** 2), slope * rate / half, np.nan)
