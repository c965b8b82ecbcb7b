"""Raw total, parabolic and Theo1 deviations of two records as allantools computes them, to eleven digits."""

import numpy as np
import pytest
from tests.anchors.values import WHO, Data, flicker, lcg, printed, value
from tests.reference.theo import kf, theobr
from tests.rows import rows

WHITE = lcg(512) - 0.5
RECORDS = {"white": Data.of_rate(np.longdouble(1e-9) * WHITE), "flicker": Data.of_rate(flicker(WHITE), 42.0)}
TABLES = dict(printed("allantools.txt"))


@rows("record, statistic", [words for words in TABLES if "kf" not in words])
def test_eleven_digits(record, statistic):
    factors, expected = zip(*TABLES[record, statistic], strict=True)
    for who in WHO:
        found = value(who, statistic, RECORDS[record], factors)
        np.testing.assert_allclose(found, np.array(expected, float), rtol=1e-11, err_msg=who)


@rows("record", RECORDS)
def test_bias_factor_with_divisor_six(record):
    data, ((divisor, expected),) = RECORDS[record], TABLES[record, "kf"]
    assert float(kf(data.x, data.tau0, divisor)) == pytest.approx(float(expected), rel=1e-11)
    m, theo1 = TABLES[record, "theo1"][-1]
    assert float(theobr(data.x, m, data.tau0, divisor)) == pytest.approx(float(expected) * float(theo1) ** 2, rel=1e-11)


@rows("record", RECORDS)
def test_bias_factor_is_one_number_for_the_record(record):
    data, factors = RECORDS[record], [10, 12, 100, 512]
    for who in WHO:
        ratio = (value(who, "theobr", data, factors) / value(who, "theo1", data, factors)) ** 2
        np.testing.assert_allclose(ratio, float(kf(data.x, data.tau0)), rtol=1e-10, err_msg=who)
