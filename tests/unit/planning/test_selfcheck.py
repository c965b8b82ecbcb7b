"""The check of the identification on simulated records: its counts, its limits, the verb."""

import json
import math
import re

import numpy as np
import pytest
from tests.commands import of_verb
from tests.rows import refused

import allanite as al
from allanite.planning.selfcheck import SelfCheck, TermCheck

MODEL = al.N(0.1, "deg/sqrt(h)") + al.K(60.0, "deg/h/sqrt(h)")


@pytest.mark.slow("takes more than half a second")
def test_the_bound_is_reached():
    """40 records: spread within 5 standard errors, the mean error too (false alarms below 1e-5)."""
    check = al.selfcheck(MODEL, 4000, 10.0, records=40, rng=np.random.default_rng(1), terms="NBK")
    assert [c.symbol for c in check.terms] == ["N", "B", "K"]
    N = check["N"]
    assert N.bound == al.bound(MODEL, 4000, 10.0)["N"]
    assert abs(N.spread[0] - N.bound) < 5 * N.spread[1]
    assert abs(N.bias[0]) < 5 * N.bias[1]
    assert (N.found[0], check["B"].truth) == (1.0, 0)
    assert math.isnan(check["B"].bound)
    assert check["B"].found[0] <= 0.25


def test_the_same_seed_gives_the_same_and_a_fit_stands_for_its_model():
    noises = MODEL, al.Fit((), "", MODEL.signal, MODEL)
    of_model, of_fit = (al.selfcheck(n, 2000, 10.0, records=3, rng=np.random.default_rng(1), terms="N") for n in noises)
    assert str(of_model.to_dict()) == str(of_fit.to_dict())  # NaN is not equal to itself


def made(symbol="N", truth=2.0, *, value=(2.0, 2.2), low=(1.0, 2.1), high=(3.0, 3.0), claimed=(True, True), many=2):
    arrays = (np.resize(np.array(part, dtype=float), many) for part in (value, low, high))
    return TermCheck(symbol, MODEL.signal, truth, 0.1, *arrays, np.resize(np.array(claimed), many))


def test_the_counts_are_those_of_the_definition():
    check = made()
    assert (check.bias, check.spread) == (pytest.approx((0.05, 0.05)), pytest.approx((0.0707107, 0.05), rel=1e-5))
    assert check.coverage == pytest.approx((0.5, math.sqrt(0.25 / 2)))
    assert check.found == pytest.approx((1.0, math.sqrt(0.75 * 0.25 / 2)))
    assert np.isnan(made(truth=0.0).bias).all()


def test_limits_are_exceeded_beyond_chance_only():
    def checked(*terms):
        return SelfCheck(MODEL, 100, 1.0, 400, 0.95, terms, (0.0, 0.0))

    wrong = made(value=np.linspace(2.19, 2.21, 400), low=1.0, high=2.1, claimed=True, many=400)
    absent = made("B", 0.0, value=0.0, low=0.0, high=1.0, claimed=np.arange(400) < 40, many=400)
    check = checked(wrong, absent)
    assert (check.exceeded(), check.exceeded(bias=0.11, coverage=0.9, missed=0.0, false=0.09)) == ([], [])
    sentences = check.exceeded(bias=0.09, coverage=0.9, false=0.05)
    assert sentences == [
        "N: bias of the estimate 10 +- 0.014 %, limit 9 %", "B: falsely found in 10 +- 1.5 %, limit 5 %"
    ]  # fmt: skip
    broken = checked(made(low=2.05, high=3.0, value=2.1, claimed=False, many=400)).exceeded(coverage=0.9, missed=0.1)
    assert [words.split(":")[1].split()[0] for words in broken] == ["coverage", "missed"]


def test_terms_that_cannot_be_compared_are_named():
    pair = al.Model("N 1 deg/sqrt(h), GM 1 deg/h 3 s, GM 1 deg/h 30 s")
    check = al.selfcheck(pair, 400, 10.0, records=2, rng=1, terms="NB")
    assert check.notes == ("Gauss-Markov noise (GM) is in the model, but was not identified in any record",)
    refused(al.UsageError, "unknown term 'GM' of this check", lambda: check["GM"])
    few = "the number of records must be between 2"
    refused(al.UsageError, few, lambda: al.selfcheck(pair, 400, 10.0, records=1, rng=1))


@pytest.mark.nightly("seconds of processor time for what shorter tests look at, too")
def test_time_constants_and_sinusoids():
    """Ten records of a strong process and a strong line: both are always found, within 5 standard errors."""
    model = al.Model("N 0.1 deg/sqrt(h), GM 30 deg/h 5 s, Sine 30 deg/h 1.3 Hz")
    check = al.selfcheck(model, 12_000, 10.0, records=10, rng=np.random.default_rng(1))
    for symbol in ("N", "GM", "Sine", "GM time constant"):
        found = check[symbol]
        assert found.found[0] == 1.0
        assert abs(found.bias[0]) < 5 * found.bias[1] + 0.2 * found.bound
        assert found.bound == al.bound(model, 12_000, 10.0)[symbol]
    assert check["Sine"].spread[0] == pytest.approx(check["Sine"].bound, rel=1)


run = of_verb("selfcheck")
FEW = ("--model", "N 0.1 deg/sqrt(h)", "--rate", 10, "--samples", 1000, "--records", 10)


def test_the_verb_prints_the_table_and_ends_well():
    result = run(*FEW, "--min-coverage", 50, "--max-missed", 1, "--max-bias", 20, code=0)
    assert "check  10 records of 1000 samples at 10 Hz (100 s), intervals at 95 %" in result.stdout
    assert re.search(r"^  Q +absent ", result.stdout, re.MULTILINE)


def test_the_verb_ends_with_4_where_a_limit_is_exceeded():
    result = run(*FEW, "--terms", "QB", "--band", "all", "--max-false", 1, "--json", "-", code=4)
    assert "falsely found in" in result.stderr
    (channel,) = json.loads(result.stdout)["channels"]
    assert (channel["records"], [t["term"] for t in channel["terms"]]) == (10, ["Q", "B"])
    assert channel["terms"][1]["found"] > 0.5
    assert 0.5 > channel["terms"][0]["found_error"] > 0


@pytest.mark.nightly("seconds of processor time for what shorter tests look at, too")
def test_another_method_can_be_checked():
    """It reads no evidence off the curve, so that no term counts as found, and no record as unexplained."""
    check = al.selfcheck(MODEL, 2000, 10.0, records=4, rng=np.random.default_rng(1), method="nnls")
    assert abs(check["N"].bias[0]) < 0.2
    assert check["N"].found[0] == 0.0
    assert math.isnan(check.unexplained[0])
    assert "method 'nnls' gives no evidence for a term: none is counted as identified" in check.notes
    result = run(*FEW, "--method", "gls", "--json", "-", code=0)
    assert json.loads(result.stdout)["recipe"]["method"] == "gls"


def test_the_verb_needs_a_length():
    assert run("--sensor", "fog", "--rate", 10).exit_code == 2
