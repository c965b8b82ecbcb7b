"""Theo1 from the autocorrelation, one m and every m, against its definition."""

import numpy as np
import pytest
from tests import thinned
from tests.rows import rows

import allanite as al
from allanite.kernels.theo import theo1
from allanite.statistics.fast.theofft import theo1_sums

KINDS = {"white": lambda white: white, "random walk": np.cumsum, "ramp": lambda white: 1.0 * np.arange(white.size),
         "ramp and white": lambda white: 1e-3 * np.arange(white.size) + white,
         "quantization": lambda white: np.diff(white, prepend=0.0)}  # fmt: skip


def angle(kind, n, seed=1):
    y = KINDS[kind](np.random.default_rng(seed).standard_normal(n))
    return np.concatenate(([0.0], np.cumsum(y - y[0])))


@pytest.mark.slow("takes more than half a second")
@rows("kind", thinned(KINDS, 2))
def test_every_even_averaging_factor_equals_its_definition(kind):
    x = angle(kind, 4500)
    m = 2 * np.arange(1, 2251)
    np.testing.assert_allclose(theo1_sums(x, m), theo1(x, m), rtol=1e-9)


@pytest.mark.slow("takes more than half a second")
@rows("kind", list(KINDS))
def test_a_few_large_factors_equal_their_definition(kind):
    """With many frames, two and one; the seams count."""
    x = angle(kind, 60_000, 2)
    for low in (64, 512, 4096):
        m = 2 * np.unique(np.geomspace(low // 2, 4 * low - 1, 9).astype(int))
        np.testing.assert_allclose(theo1_sums(x, m), theo1(x, m), rtol=1e-9)


@rows("n", [2, 63, 64, 65, 511, 513, 1025, 2047, 16_385])
def test_every_length_of_a_record(n):
    x = angle("random walk", n, 3)
    m = 2 * np.arange(1, n // 2 + 1)
    some = np.unique(np.geomspace(1, m.size, 30).astype(int)) - 1
    np.testing.assert_allclose(theo1_sums(x, m)[some], theo1(x, m[some]), rtol=1e-9)


@pytest.mark.slow("the definition, at every lag")
def test_the_bias_ratio_is_that_of_its_definition():
    record = al.Record(np.cumsum(np.random.default_rng(4).standard_normal(30_000)), rate=1.0, unit="deg/h", name="z")
    i = np.arange(30_001 // 30 - 2)
    x = np.concatenate(([0.0], np.cumsum(record.values - record.values[0])))
    m = 12 + 4 * i
    theo = theo1(x, m) / (0.75 * (x.size - m) * m**2)
    m = 9 + 3 * i
    allan = [np.mean((x[2 * k :] - 2 * x[k:-k] + x[: -2 * k]) ** 2) / (2 * k**2) for k in m]
    found = al.deviation(record, "theobr", m=[100], noise=None).factor[0]
    assert found == pytest.approx(np.mean(allan / theo), rel=1e-9)
