"""The tables of records with gaps hold what is asked: limits that hold the truth in 92 to 98 %, or no result."""

from table import read

import math
import re
from statistics import mean

import pytest

import gaps

COEFFICIENTS, CURVES = read("gaps.md"), read("gaps_curves.md")
SENSORS = tuple(gaps.SENSORS)


def least(page):
    """92 % less 2.6 standard errors of a share of the page's records."""
    records = int(re.search(r"--records (\d+)", page.head)[1])
    return 92 - 260 * math.sqrt(0.92 * 0.08 / records)


def covered(rows):
    return [float(row["95"].split()[0]) for row in rows if row["95"]]


@pytest.mark.parametrize("page", [COEFFICIENTS, CURVES])
def test_every_cell_is_there(page):
    assert re.search(r"commit [0-9a-f]{7}, \d{4}-\d\d-\d\d", page.head)
    assert {(row["sensor"], row["lost"]) for row in page.rows()} == {(s, lost) for s in SENSORS for lost in gaps.LOSSES}


def test_limits_of_coefficients_hold():
    rows = COEFFICIENTS.rows()
    assert min(covered(rows)) >= least(COEFFICIENTS)
    for symbol in "QNBK":
        assert 92 <= mean(covered(row for row in rows if row["term"] == symbol)) <= 99


def test_what_is_explained_stays_so():
    assert min(float(row["explained"]) for row in COEFFICIENTS.rows() if row["explained"]) >= 95


@pytest.mark.parametrize(
    "sensor",
    [
        "MEMS",
        "FOG",
        pytest.param(
            "RLG",
            marks=pytest.mark.xfail(
                reason="where N is claimed too large, in 3 of 60 records at 30 %, the joints pass for N: the curve is "
                "up to 9 times too large instead of refused; at 1 % limits hold in 85 to 95 %",
                strict=True,
            ),
        ),
    ],
)
def test_limits_of_curves_hold_or_the_curve_is_refused(sensor):
    found = covered(row for row in CURVES.rows() if row["sensor"] == sensor)
    assert min(found) >= least(CURVES)
    assert 92 <= mean(found) <= 98


@pytest.mark.parametrize("sensor", ["MEMS", "FOG"])
def test_curves_reach_four_tenths_of_the_record_where_one_reading_in_a_hundred_is_lost(sensor):
    row, = (r for r in CURVES.rows() if (r["sensor"], r["lost"], r["statistic"], r["tau / T"])
            == (sensor, "1 %", "oadev", "0.4"))  # fmt: skip
    assert row["there"] == "100"
