"""The cosine transform in rows and columns against the library's."""

import numpy as np
import pytest
from scipy.fft import dct
from tests import all_but
from tests.rows import rows

from allanite.identification.likelihood import spectrum
from allanite.identification.likelihood.spectrum import cosine_transform


@rows(
    "n", all_but([4, 8, 12, 16, 30, 36, 60, 100, 128, 1000, 1024, 7200, 30_030, 131_072, 360_000], [131_072, 360_000])
)
def test_rows_and_columns(n: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(spectrum, "LONG_RECORD", 4)
    assert spectrum._rows(n) > 0
    y = np.random.default_rng(n).standard_normal(n)
    np.testing.assert_allclose(cosine_transform(y.copy()), dct(y, norm="ortho"), rtol=0, atol=1e-14)


@rows("n", all_but([5, 1001, 1002, 2_000_006], [2_000_006]))
def test_sizes_that_make_no_matrix(n: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(spectrum, "LONG_RECORD", 4)
    assert spectrum._rows(n) == 0
    y = np.random.default_rng(n).standard_normal(n)
    np.testing.assert_allclose(cosine_transform(y.copy()), dct(y, norm="ortho"), rtol=0, atol=1e-14)


@rows("n", [1000, 1001])
def test_less_a_ramp(n: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(spectrum, "LONG_RECORD", 4)
    y = np.random.default_rng(n).standard_normal(n)
    expected = dct(y - 0.25 * (np.arange(n) - (n - 1) / 2), norm="ortho")
    np.testing.assert_allclose(cosine_transform(y.copy(), 0.25), expected, rtol=0, atol=1e-10)


def test_a_random_walk_keeps_its_high_frequencies(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(spectrum, "LONG_RECORD", 4)
    y = np.cumsum(np.random.default_rng(1).standard_normal(360_000))
    high = slice(180_000, None)
    np.testing.assert_allclose(cosine_transform(y.copy())[high], dct(y, norm="ortho")[high], rtol=0, atol=1e-10)
