"""Published bias factors against exact expectations, as docs/published_formulas.md states them for 256 intervals."""

from table import Page

import numpy as np
import pytest
from tests import ROOT
from tests.reference.dense import moments, quadratic_form
from tests.reference.laws import LAWS, STRUCTURES
from tests.rows import rows

import allanite as al
from allanite.statistics.confidence.bias import published_bias

PAGE = Page((ROOT / "docs" / "published_formulas.md").read_text(encoding="utf-8"))
SIZE = 256
PUBLISHED_BIAS = {name: row.published for name, row in al.STATISTICS.items() if row.published}
NAMES = {2: "WPM", 1: "FPM", 0: "WFM", -1: "FFM", -2: "RWFM", -3: "FWFM", -4: "RRFM"}
RANGES = {"m = 1": (1,), "2 to 8": (2, 4, 8), "10 to 64": (10, 16, 32, 64), "66 to 128": (66, 96, 128)}
RANGES["beyond n/2"] = (160, 192, 240)
ROWS = [
    (name, alpha) for name in ("totdev", "mtotdev", "htotdev", "theo1") for alpha in PUBLISHED_BIAS[name].coefficients
]


def exact(name, alpha, m):
    """E[estimate] / E[target]; the target of Theo1 and of the total deviation is the Allan variance at any tau."""
    row, law = al.STATISTICS[name], LAWS[alpha]
    expected = moments(quadratic_form(row, m, SIZE), [law])[0][0]
    if row.target != "oadev":
        return expected / moments(quadratic_form(al.STATISTICS[row.target], m, SIZE), [law])[0][0]
    t = np.array([1.0, 2.0]) * m * row.tau_factor
    D = STRUCTURES[alpha](t)
    return expected / ((4 * D[0] - D[1]) / (2 * t[0] ** 2))


def errors(name, alpha):
    """Smallest and largest published / exact - 1 in % for each range of m; None where none is defined."""
    row = al.STATISTICS[name]
    for factors in RANGES.values():
        m = [k for k in factors if k <= row.largest(SIZE) and (name != "theo1" or k >= 10)]
        found = [100 * (published_bias(row, alpha, np.array([k]), SIZE)[0] / exact(name, alpha, k) - 1) for k in m]
        yield (min(found), max(found)) if found else None


@pytest.mark.nightly("errors of formulas that are printed in books")
@rows("name, alpha", ROWS)
def test_the_page_states_the_error(name, alpha):
    (row,) = (row for row in PAGE.rows("Bias") if (row["statistic"], row["noise"]) == (name, NAMES[alpha]))
    for cell, found in zip(list(row.values())[2:], errors(name, alpha), strict=True):
        assert (cell == "-") == (found is None)
        if found:
            assert [float(number) for number in cell.split(" .. ")] == pytest.approx(found, abs=0.051)


def test_what_is_not_published():
    """As the page says: high by 1.34 tau/T and up to 1.38."""
    assert exact("totdev", 2, 128) == pytest.approx((1 + 1.34 / 2), abs=0.005)
    assert exact("htotdev", 2, 64) == pytest.approx(1.38, abs=0.005)
    for name, alpha in (("totdev", 2), ("htotdev", 1), ("theo1", -3)):
        with pytest.raises(al.UsageError):
            published_bias(al.STATISTICS[name], alpha, np.array([4, 8]), SIZE)


@rows("name", sorted(set(al.STATISTICS) - set(PUBLISHED_BIAS)))
def test_other_rows_have_no_bias(name):
    m = np.array([2, 4, 8])
    np.testing.assert_array_equal(published_bias(al.STATISTICS[name], np.array([2, 0, -2]), m, SIZE), 1.0)


def test_every_tau_may_have_its_own_noise():
    found = published_bias(al.STATISTICS["ttotdev"], np.array([2, 0, -2]), np.array([2, 4, 8]), SIZE)
    assert found.tolist() == [0.94, 0.73, 0.69]
    assert published_bias(al.STATISTICS["htotdev"], -1, np.array([1, 2]), SIZE).tolist() == [1.0, 0.851]


def test_the_argument_of_theo1_is_tau_and_not_m():
    """With m instead of 0.75 m the worst error from m = 10 on is what the page says."""
    row, wrong = PUBLISHED_BIAS["theo1"], {}
    for alpha, c in row.coefficients.items():
        for m in (10, 16, 64, 256):
            wrong[alpha, m] = row.factor(c, np.array([m / 0.75]), SIZE)[0] / exact("theo1", alpha, m) - 1
    assert max(map(abs, wrong.values())) == pytest.approx(0.15, abs=0.005)


def test_the_published_tables_follow():
    """SP 1065 quotes the 1000-point set with the factors of white noise taken out; within a unit of its last digit."""
    record = al.Record(lcg(), rate=1.0, unit="1", kind="rate")
    for name, printed in (("mtotdev", [0.06499161, 0.02287774]), ("htotdev", [0.09614787, 0.03058103])):
        curve = al.deviation(record, name, m=[10, 100])
        factor = published_bias(al.STATISTICS[name], 0, curve.m, record.size)
        assert np.sqrt(curve.variance / factor) == pytest.approx(printed, abs=1e-8)


def lcg():
    n, values = 1234567890, []
    for _ in range(1000):
        values.append(n / 2147483647)
        n = 16807 * n % 2147483647
    return np.array(values)
