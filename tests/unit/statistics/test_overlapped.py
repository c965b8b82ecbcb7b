"""Squared differences at many averaging factors: rows, shared first points and tiles against the plain formula."""

import numpy as np
import pytest
from tests.rows import paired, rows

from allanite.kernels.squared import BLOCK, ROWS, TILE, add_overlapped, overlapped


def literal(x, m, order):
    for _ in range(order):
        x = x[m:] - x[:-m]
    return float(np.sum(x**2))


@rows("order, size", paired([1, 2, 3], [40, BLOCK + 1, 4 * ROWS + 3, TILE - 1, TILE + 1, 3 * TILE + 777]))
def test_every_size_and_order(order, size):
    x = np.cumsum(np.random.default_rng(size + order).standard_normal(size))
    most = (size - 1) // order
    m = np.unique(np.concatenate((np.geomspace(1, most, 37), [ROWS, ROWS + 1, TILE // 4 - 1, TILE // 4, most])))
    m = np.unique(m[m <= most].astype(np.int64))
    assert overlapped(x, m, order) == pytest.approx([literal(x, k, order) for k in m.tolist()], rel=1e-12)


@rows("size", [5, BLOCK, TILE + 5])
def test_only_the_first_windows(size):
    x = np.cumsum(np.random.default_rng(1).standard_normal(2 * TILE))
    m = np.array([1, 2, 3, 5, 300, 5000, 40_000])
    sums = np.ones(m.size)
    add_overlapped(sums, x, m, 3, size)
    expected = [1 + literal(x[: min(size + 3 * k, x.size)], k, 3) for k in m.tolist()]
    assert sums == pytest.approx(expected, rel=1e-12)


@rows("order", [1, 2, 3])
def test_the_sum_of_a_factor_has_the_same_bits_beside_any_others(order):
    rng = np.random.default_rng(order)
    x = np.cumsum(rng.standard_normal(TILE + 4 * ROWS))
    for size in (0, 1, 3, 4, 6, 13):
        m = np.unique(rng.integers(1, 3 * ROWS, size))
        assert overlapped(x, m, order).tolist() == [overlapped(x, m[i : i + 1], order)[0] for i in range(m.size)]
