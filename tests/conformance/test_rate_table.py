"""The committed table of rates holds what is claimed of it and what the documentation quotes; a part is made again."""

from table import Page, read

import re

import pytest
from tests import ROOT

import rate as bench

TABLE = read("rate.md")
PAGE = (ROOT / "docs" / "rate_paper.md").read_text(encoding="utf-8")


def test_speed_meets_its_demands():
    assert [row[""] for row in TABLE.rows("Speed")] == ["met", "-", "met", "met"]


def test_the_bound_is_reached():
    for row in TABLE.rows("The bound"):
        assert abs(float(row["over the bound, %"])) < 0.5


def test_predictions_hold():
    rows = TABLE.rows("Predictions")
    assert len(rows) == 6
    for row in rows:
        assert 0.89 < float(row["rms error over it"]) < 1.11
        assert 92 <= float(row["cover of 95 %"]) <= 98


def test_the_search_meets_its_demands():
    for row in TABLE.rows("The search for the staircase"):
        least = float(row["least misfit"])
        assert float(row["default above, most"]) <= 0.001 * least
        assert float(row["default, ms"]) < 50


def test_the_order_of_the_methods():
    exact = {row["method"]: float(row["exact covariance"]) for row in TABLE.rows("The paper's experiment")}
    assert exact["mean"] > exact["hamming"] > exact["regression"] >= exact["optimal"]


def test_the_page_quotes_the_table():
    measured = {row["method"]: row for row in TABLE.rows("The paper's experiment")}
    names = {"Hamming": "hamming", "conditional lines": "conditional", "optimal, the Cramér-Rao bound": "optimal"}
    for row in Page(PAGE).rows("Comparison"):
        found = measured[names.get(row["method"], row["method"])]
        assert row["paper"] == found["paper"]
        assert row["exact covariance"] == found["exact covariance"]
        assert found["6 runs"].startswith(row["six simulated runs"])
    models = TABLE.rows("Noise that fits the paper")
    for row, found in zip(Page(PAGE).rows("Why the staircase cannot be better"), models, strict=False):
        assert list(row.values())[1:] == list(found.values())[1:]
        if row["noise"] != "the paper":
            assert float(found["Cramer-Rao bound"]) > 0.0013
    searches = {row["noise, pulses"]: row for row in TABLE.rows("The search for the staircase")}
    for row in Page(PAGE).rows("Searching for the minimum"):
        found = searches[row["noise, pulses"]]
        assert row["default above the minimum, most"] == f"{found['default above, most']} of {found['least misfit']}"
        assert row["descent above it, mean"] == found["descent above, mean"]
        assert [row[k] for k in ("default, ms", "certified, ms")] == [
            found[k] for k in ("default, ms", "certified, ms")
        ]


@pytest.mark.slow("a part of a committed table made again")
def test_a_part_made_again_agrees():
    """The exact rows, the models that fit, when to average, and the run with seed 1: to the last printed digit."""
    made = [dict(zip(bench.efficiency()[0], row, strict=True)) for row in bench.efficiency()[1]]
    assert made == TABLE.rows("When to average")
    once = bench.deviations(bench.gl1_run(1))
    for row, deviation in zip(TABLE.rows("The paper's experiment"), once, strict=True):
        assert row["exact covariance"] == f"{bench.exact(row['method']):.5f}"
        assert float(row["seed 1"]) == pytest.approx(deviation, abs=2e-5)


def test_the_example_of_the_page_runs():
    (code,) = re.findall(r"^```python\n(.*?)^```", PAGE, re.DOTALL | re.MULTILINE)
    said = []
    exec(code, {"print": said.append})  # noqa: S102 - our own page
    wanted = [line.strip().split("# ")[1] for line in code.splitlines() if "# " in line]
    assert said == wanted
