"""The cosine transform in rows and columns against the library's."""

import numpy as np
from scipy.fft import dct
from tests import all_but
from tests.rows import rows

from allanite.identification.likelihood import spectrum
from allanite.identification.likelihood.spectrum import cosine_transform

FACTORED = [4, 8, 12, 16, 30, 36, 60, 100, 128, 1000, 1024, 7200, 30_030, 131_072, 360_000]
OTHER = [5, 1001, 1002, 2_000_006]


@rows("n", all_but([*FACTORED, *OTHER], [131_072, 360_000, 2_000_006]))
def test_rows_and_columns_or_no_matrix(n, monkeypatch):
    monkeypatch.setattr(spectrum, "LONG_RECORD", 4)
    assert (spectrum._rows(n) > 0) == (n in FACTORED)
    y = np.random.default_rng(n).standard_normal(n)
    np.testing.assert_allclose(cosine_transform(y.copy()), dct(y, norm="ortho"), rtol=0, atol=1e-14)
    if n in (1000, 1001):
        expected = dct(y - 0.25 * (np.arange(n) - (n - 1) / 2), norm="ortho")
        np.testing.assert_allclose(cosine_transform(y.copy(), 0.25), expected, rtol=0, atol=1e-10)


def test_a_random_walk_keeps_its_high_frequencies(monkeypatch):
    monkeypatch.setattr(spectrum, "LONG_RECORD", 4)
    y = np.cumsum(np.random.default_rng(1).standard_normal(360_000))
    high = slice(180_000, None)
    np.testing.assert_allclose(cosine_transform(y.copy())[high], dct(y, norm="ortho")[high], rtol=0, atol=1e-10)
