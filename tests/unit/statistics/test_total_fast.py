"""The modified total statistics by running sums against every window by itself."""

import numpy as np
from numba import njit
from tests.rows import paired, rows

from allanite.kernels.total import SHORT, modified_total, one_by_one as part

N = 3000


@njit
def one_by_one(x, m):
    """The part of that name, which has no wrapper for Python."""
    return part(x, m)


def angle(kind, seed=1):
    white = np.random.default_rng(seed).standard_normal(N)
    y = {
        "white": white, "random walk": np.cumsum(white), "ramp": 1.0 * np.arange(N),
        "ramp and white": 1e-3 * np.arange(N) + white, "quantization": np.diff(white, prepend=0.0),
    }[kind]  # fmt: skip
    return np.concatenate(([0.0], np.cumsum(y - y[0])))


@rows("rates, kind", paired([False, True], ["white", "random walk", "ramp", "ramp and white", "quantization"]))
def test_windows_together_equal_every_window_by_itself(kind, rates):
    x = np.diff(angle(kind)) if rates else angle(kind)
    m = np.array([*range(1, 40), 97, 98, 250, 251, 600, 777, 998, 999, x.size // 3])
    expected = np.array([one_by_one(x, k) for k in m])
    np.testing.assert_allclose(modified_total(x, m), expected, rtol=1e-9, atol=1e-14)


def test_a_strong_vibration_leaves_the_noise():
    x = angle("white") + 1e7 * np.sin(2 * np.pi * np.arange(N + 1) / 50)
    m = np.arange(SHORT, 110)
    expected = np.array([one_by_one(x, k) for k in m])
    np.testing.assert_allclose(modified_total(x, m), expected, rtol=1e-9)


@rows("points", [30, 31, 32, 90, 155])
def test_a_single_window_and_few(points):
    x = angle("random walk")[:points]
    m = np.arange(1, (points + 1) // 3 + 1)
    np.testing.assert_allclose(modified_total(x, m), [one_by_one(x, k) for k in m], rtol=1e-9)
