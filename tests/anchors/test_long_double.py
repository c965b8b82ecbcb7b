"""Brute-force values in long double of 513-point excerpts, on which two other programs agree to 5e-12.

The file's TheoBR has Stable32's divisor 6, which the referee takes as an option.
"""

import json

import numpy as np
import pytest
from tests.anchors.values import WHO, Data, value
from tests.reference.theo import kf, theobr

FILES = ["cs5071a_513", "pink_513"]

COLUMNS = [
    # statistic, column, its averaging factors
    ("mtotdev", "mtot_raw", "m_total"),
    ("ttotdev", "ttot_raw", "m_total"),
    ("htotdev", "htot_raw", "m_total"),
    ("pdev", "pdev", "m_total"),
    ("theo1", "theo1_raw", "m_theo1_even (tau=0.75 m tau0)"),
]


def load(reference, name, dtype):
    table = json.loads((reference / "derived" / f"{name}.json").read_text())
    return table, Data(table["tau0_s"], np.array(table["phase"], dtype=dtype))


@pytest.mark.parametrize("who", WHO)
@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("row", COLUMNS, ids=lambda row: row[0])
def test_eleven_digits(reference, who, name, row):
    statistic, column, factors = row
    table, data = load(reference, name, np.longdouble)
    np.testing.assert_allclose(value(who, statistic, data, table[factors]), table["expected"][column], rtol=1e-11)


@pytest.mark.parametrize("name", FILES)
def test_bias_factor_with_divisor_six(reference, name):
    table, data = load(reference, name, np.longdouble)
    expected = table["expected"]
    assert float(kf(data.x, data.tau0, 6)) == pytest.approx(expected["theoBR_kf"], rel=1e-11)
    factors = table["m_theo1_even (tau=0.75 m tau0)"]
    found = [float(theobr(data.x, m, data.tau0, 6)) ** 0.5 for m in factors]
    np.testing.assert_allclose(found, expected["theoBR"], rtol=1e-11)


@pytest.mark.parametrize("who", WHO)
@pytest.mark.parametrize("name", FILES)
def test_bias_factor_is_one_number_for_the_record(reference, who, name):
    _, data = load(reference, name, np.longdouble)
    factors = [10, 12, 100, 512]
    ratio = (value(who, "theobr", data, factors) / value(who, "theo1", data, factors)) ** 2
    np.testing.assert_allclose(ratio, float(kf(data.x, data.tau0)), rtol=1e-10)
