"""Samples far off their neighbours are those of sorted windows."""

import numpy as np
from tests.rows import paired, rows

from allanite.kernels.passing import HALF, off


@rows("size, part", paired([31, 32, 1023, 1024, 1025, 5000], [700, 1024, 10**9]))
def test_far_off_is_that_of_sorted_windows(size, part):
    y = np.random.default_rng(size).normal(size=size)
    y[[0, size // 2, size - 1]] += 5.0
    limit = 2.0 + np.arange(-(-size // part)) % 2
    padded = np.concatenate((y[1:2], y, y[-2:-1]))
    bend = np.abs((y - padded[:-2]) + (y - padded[2:]))
    expected = []
    for i in range(size):
        start = min(max(i - HALF, 0), size - 31)
        median = np.sort(y[start : start + 31])[HALF]
        most = limit[i // part]
        expected += [i] if bend[i] > most and abs(y[i] - median) > most else []
    assert len(expected) > 2
    np.testing.assert_array_equal(off(y, limit, part), expected)
