"""The committed table of the gyro-vertical says what the documentation says of it."""

from table import read

import pytest

PAGE = read("vertical.md")


def test_predicted_errors_are_the_simulated_ones():
    rows = PAGE.rows("Predicted against simulated")
    assert len(rows) == 60
    assert max(abs(float(row["difference"].removesuffix(" %"))) for row in rows) < 5
    for row in PAGE.rows("Flicker and random walk"):
        assert float(row["simulated [arcsec]"]) == pytest.approx(float(row["predicted [arcsec]"]), rel=0.05)


def test_no_filter_is_better_than_the_bound():
    rows = PAGE.rows("Loss")
    assert all(float(row["bound"]) <= float(row["first order"]) for row in rows)
    assert max(float(row["loss"].removesuffix(" %")) for row in rows) > 40


def test_scenarios_and_coning_are_those_of_the_prototype():
    for row in PAGE.rows("Scenarios"):
        for name in ("fixed base", "acceleration", "oscillation"):
            if row[f"{name} expected"] != "-":
                assert float(row[f"{name} instant"]) == pytest.approx(float(row[f"{name} expected"]), rel=0.2)
    for row in PAGE.rows("Coning"):
        assert float(row["here"]) == pytest.approx(float(row["expected"]), rel=0.2)


def test_the_oscillation_is_that_of_the_closed_form():
    rows = PAGE.rows("Oscillation in closed form")
    assert len(rows) == 3
    for row in rows:
        for how in ("mean", "instant"):
            assert float(row[f"{how} simulated"]) == pytest.approx(float(row[f"{how} derived"]), rel=0.05)
        assert float(row["instant derived"]) == pytest.approx(float(row["expected"]), rel=0.2)


def test_a_million_samples_take_less_than_three_seconds():
    assert max(float(row["s for 1e6 samples"]) for row in PAGE.rows("Speed")) < 3
