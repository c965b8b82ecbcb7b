"""One look at a part: the same as one look at each sample."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from tests import examples
from tests.rows import paired, rows

from allanite.kernels.passing import BLOCK, HALF, looked, off


def literal(y):
    there = y[np.isfinite(y)]
    if not there.size:
        return 0, np.inf, -np.inf, 0, 0
    low, high = there.min(), there.max()
    longest = run = 0
    for one, before in zip(y[1:], y[:-1], strict=True):
        run = run + 1 if one == before else 0
        longest = max(longest, run)
    return there.size, low, high, max((there == low).sum(), (there == high).sum()), longest


@settings(max_examples=examples(60), deadline=None)
@given(
    seed=st.integers(0, 99), size=st.integers(1, 3 * BLOCK), step=st.sampled_from([0.0, 0.5, 2.0]),
    lost=st.lists(st.integers(0, 3 * BLOCK), max_size=4), stuck=st.integers(0, 2 * BLOCK),
)  # fmt: skip
@pytest.mark.slow("property of every sample")
def test_look_is_that_at_each_sample(seed, size, step, lost, stuck):
    y = np.random.default_rng(seed).normal(size=size)
    y = np.round(y / step) * step if step else y
    y[stuck : stuck + BLOCK // 2 + seed] = 0.25
    for at in lost:
        y[at : at + 1] = (np.nan, np.inf, -np.inf)[at % 3]
    assert looked(y) == literal(y)


def test_look_at_nothing_finite():
    assert looked(np.full(5, np.nan)) == literal(np.full(5, np.nan))


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
