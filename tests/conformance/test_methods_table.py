"""The committed table of methods holds what is claimed of them, and a part of it can be made again."""

from table import read

import re

import numpy as np
import pytest

import allanite as al
import methods

PAGE = read("methods.md")
ROWS = PAGE.rows()
OTHERS = read("curves.md")
CURVES = OTHERS.rows()
SEEN = [row for row in ROWS if float(row["bound %"]) <= 12]
"""Terms that are well determined."""


def test_it_says_how_it_was_made():
    head = PAGE.head
    assert re.search(r"commit [0-9a-f]{7}, \d{4}-\d\d-\d\d, \S+, Python", head)
    assert "command: `python benchmarks/methods.py --sensors MEMS FOG RLG --sizes 65536 262144 --records 100`" in head
    assert "seeds 1..100, the same records for every method" in head
    made = methods
    terms = [(s, str(n), t.symbol) for n in (2**16, 2**18) for s in made.SENSORS for t in made.SENSORS[s]]
    assert [(r["sensor"], r["n"], r["term"], r["method"]) for r in ROWS] == [(*t, w) for t in terms for w in made.WAYS]


def test_the_curves_of_other_statistics_are_all_there():
    head = OTHERS.head
    assert "`python benchmarks/methods.py --sensors MEMS FOG RLG --sizes 65536 --records 40 --ways curves`" in head
    assert re.search(r"commit [0-9a-f]{7}, \d{4}-\d\d-\d\d", head)
    terms = [(s, t.symbol) for s in methods.SENSORS for t in methods.SENSORS[s]]
    assert [(r["sensor"], r["term"], r["method"]) for r in CURVES] == [(*t, w) for t in terms for w in methods.CURVES]


@pytest.mark.parametrize("row", CURVES, ids=lambda row: "-".join((row["sensor"], row["term"], row["method"])))
def test_their_limits_cover(row):
    """40 records of 95 %: 80 % or more."""
    assert float(row["cover %"]) >= 80


@pytest.mark.parametrize(("sensor", "term"), [(s, t.symbol) for s in methods.SENSORS for t in methods.SENSORS[s]])
def test_theoh_is_as_good_as_oadev(sensor, term):
    """On the same records, within the standard error of 40: 11 %."""
    rmse = {r["method"]: float(r["rmse"]) for r in CURVES if (r["sensor"], r["term"]) == (sensor, term)}
    assert rmse["gls of theoh"] <= 1.11 * rmse["gls of oadev"]


@pytest.mark.parametrize("row", [r for r in CURVES if float(r["bound %"]) <= 12], ids=lambda r: "-".join(r.values()))
def test_they_come_near_the_bound(row):
    """Standard error of 40 records: 11 %. Theo1 begins at two samples, where N and Q are hard to tell apart."""
    beneath = row["method"] in ("gls of theo1", "gls of theobr") and (row["sensor"], row["term"]) == ("RLG", "N")
    assert float(row["rmse"]) <= (1.7 if beneath else 1.4)


def met(row):
    """The demand; what is known to miss it stays to be seen, and fails if it comes to meet it."""
    name = (row["sensor"], row["n"], row["term"])
    reason = "1.17 of 1.15, with a Monte-Carlo error of 0.08; the likelihood has 1.14 on the same records"
    marks = [pytest.mark.xfail(strict=True, reason=reason)] if name == ("RLG", "262144", "Q") else []
    return pytest.param(row, id="-".join(name), marks=marks)


@pytest.mark.parametrize("row", [met(r) for r in SEEN if r["method"] == "gls"])
def test_generalised_least_squares_comes_near_the_bound(row):
    beneath_quantization = (row["sensor"], row["term"]) == ("RLG", "N")
    assert float(row["rmse"]) <= (1.45 if beneath_quantization else 1.15)


@pytest.mark.parametrize("name", al.METHODS)
def test_the_efficiency_of_a_method_is_that_of_the_table(name):
    found = re.fullmatch(r"([\d.]+) to ([\d.]+) times the Cramer-Rao bound", al.METHODS[name].efficiency)
    rmse = [float(row["rmse"]) for row in SEEN if row["method"] == name]
    assert [float(v) for v in found.groups()] == pytest.approx([min(rmse), max(rmse)], rel=0.01)


@pytest.mark.parametrize("sensor", ["MEMS", "FOG", "RLG"])
def test_a_part_made_again_agrees(sensor):
    """The first 10 records of well determined terms.

    The mean square of 10 lies within 0.1 and 4.5 times that of all (chi-square, 5e-5 on each side if errors are
    normal), and the mean within 5 standard errors.
    """
    made, records = methods, 10
    found = [made.identified(made.Job("known", sensor, 2**16, seed)) for seed in range(1, records + 1)]
    again = [dict(zip(made.HEADINGS, row, strict=True)) for row in made.rows_of(sensor, 2**16, found)]
    table = [row for row in ROWS if (row["sensor"], row["n"]) == (sensor, "65536")]
    for new, row in zip(again, table, strict=True):
        assert list(new.values())[:5] == list(row.values())[:5]
        assert (new["cover %"] == "-") == (row["cover %"] == "-")
        if row not in SEEN or row["method"] == "slopes":  # which point a slope is read from is no normal error
            continue
        rmse, bias = float(row["rmse"]), float(row["bias"])
        assert 0.1 <= (float(new["rmse"]) / rmse) ** 2 <= 4.5
        scatter = np.sqrt(max(rmse**2 - bias**2, 0.0) + 0.02)
        assert abs(float(new["bias"]) - bias) <= 5 * scatter / np.sqrt(records)
