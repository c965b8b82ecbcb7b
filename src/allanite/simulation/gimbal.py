"""Random errors of a measured cosine between two gyros' momentum vectors."""

import numpy as np
from numpy.typing import NDArray

from allanite.core.errors import UsageError

FloatArray = NDArray[np.float64]


def readout_noise(n: int, *, sigma: float, walk: float = 0.0, rng: "np.random.Generator") -> FloatArray:
    """White noise of each reading, and a random walk under it.

    Parameters
    ----------
    n : int
        Number of readings.
    sigma : float
        Standard deviation of the white noise, in any unit.
    walk : float, optional
        Standard deviation of the random walk's step from reading to reading; the walk begins at 0.
    rng : numpy.random.Generator
        The source of randomness, for example ``numpy.random.default_rng(1)``.

    Returns
    -------
    array, shape (n,)

    Examples
    --------
    >>> noise = readout_noise(10_000, sigma=2.0, rng=np.random.default_rng(1))
    >>> bool(1.95 < noise.std() < 2.05)
    True
    """
    if n < 1 or not (np.isfinite([sigma, walk]).all() and min(sigma, walk) >= 0):
        raise UsageError(
            f"noise needs at least one reading and deviations that are not negative: n={n}, {sigma=}, {walk=}"
        )
    noise = sigma * rng.standard_normal(n)
    if walk:
        noise[1:] += walk * np.cumsum(rng.standard_normal(n - 1))
    return noise
