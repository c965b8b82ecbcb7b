"""TheoH to its end: the options of a curve, what they change, and what is refused."""

import csv
import io
import json

import numpy as np
import pytest
from click.testing import CliRunner
from tests.rows import rows

import allanite as al
from allanite.cli import main

MIXTURE = "Q 0.5 arcsec, N 0.02 deg/sqrt(h), B 0.3 deg/h, K 1 deg/h/sqrt(h), R 5 deg/h^2"


def run(*arguments):
    return CliRunner().invoke(main, [str(a) for a in arguments])


def cells(*arguments):
    result = run(*arguments, "--csv", "-")
    assert result.exit_code == 0, result.output
    return list(csv.DictReader(io.StringIO(result.stdout)))


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("data") / "fog.csv"
    made = run("simulate", path, "--model", MIXTURE, "--duration", "7200", "--rate", "1")
    assert made.exit_code == 0, made.output
    return path


@pytest.mark.slow("takes more than half a second")
@pytest.mark.usefixtures("details")
def test_a_jump_is_told_and_its_cure_works(file):
    plain = run("deviation", file, "--statistic", "theoh", "--bias", "plain")
    said = " ".join(plain.stdout.split())
    assert "the bias ratio of theoh assumes one kind of noise" in said
    assert "times the Allan deviation at 1536 s" in said
    assert "(--bias model corrects it)" in said
    assert "theoh jumps there, where it passes from oadev to TheoBR" in said
    cured = run("deviation", file, "--statistic", "theoh", "--bias", "model")
    assert cured.exit_code == 0
    assert "jumps" not in cured.stdout
    assert "jumps" not in run("deviation", file, "--statistic", "theoh").stdout  # it is the default
    late = [float(r["deviation"]) for r in cells("deviation", file, "--statistic", "theoh", "--bias", "plain")][-2:]
    right = [float(r["deviation"]) for r in cells("deviation", file, "--statistic", "theoh", "--bias", "model")][-2:]
    assert all(b > 1.1 * a for a, b in zip(late, right, strict=True))


@pytest.mark.usefixtures("details")
def test_one_kind_of_noise_has_no_jump(tmp_path):
    path = tmp_path / "white.csv"
    run("simulate", path, "--model", "N 0.1 deg/sqrt(h)", "--duration", "3600", "--rate", "1")
    shown = run("deviation", path, "--statistic", "theobr,theoh", "--bias", "plain", "--terms", "N").stdout
    assert "TheoH" in shown
    assert "assumes one kind" not in shown


def test_options_are_those_of_the_library(file):
    record = al.read(file)["gx"]
    for option, choice in (
        (("--join", "0.05"), {"join": 0.05, "bias": "plain"}),
        (("--divisor", "6"), {"divisor": 6, "bias": "plain"}),
    ):
        found = cells("deviation", file, "--statistic", "theoh", "--no-intervals", "--bias", "plain", *option)
        curve = al.deviation(record, "theoh", noise=None, **choice).to("deg/h")
        np.testing.assert_allclose([float(r["deviation"]) for r in found], curve.deviation, rtol=1e-12)
        assert [int(r["m"]) for r in found] == curve.m.tolist()


def test_a_published_bias_and_the_exact_one_differ_a_little(file):
    exact, published, plain = (
        np.array([float(r["deviation"]) for r in cells("deviation", file, "--statistic", "theo1", "--bias", bias)])
        for bias in ("exact", "published", "plain")
    )
    assert np.abs(published / plain - 1).max() > 0.2
    assert np.abs(exact / plain - 1).max() > 0.2
    assert np.abs(published / exact - 1)[-3:].max() < 0.3


def test_a_bias_is_for_the_statistics_that_have_it(file):
    both = cells("deviation", file, "--statistic", "oadev,theoh", "--bias", "model", "--no-intervals")
    assert {r["statistic"] for r in both} == {"oadev", "theoh"}
    assert {r["low"] for r in both} == {""}


def test_published_degrees_of_freedom(tmp_path):
    path = tmp_path / "white.csv"
    run("simulate", path, "--model", "N 0.1 deg/sqrt(h)", "--samples", "7200", "--rate", "1")
    found = cells(
        "deviation", path, "--statistic", "theo1", "--edf", "published", "--m", "10,100,720,3600", "--power-law"
    )
    white = {int(r["m"]): float(r["edf"]) for r in found if r["alpha"] == "0"}
    table = {10: 3139, 100: 387, 720: 51.6, 3600: 7.8}
    assert set(white) >= {10, 100, 720}
    for m, edf in white.items():
        assert edf == pytest.approx(table[m], rel=0.01)


@pytest.mark.usefixtures("details")
def test_the_power_law_is_a_column(file):
    found = cells("deviation", file, "--power-law")
    laws = [int(r["alpha"]) for r in found]
    assert laws[:3] == [0, 0, 0]
    assert laws[-1] == -2
    assert {r["alpha"] for r in cells("deviation", file)} == {""}
    text = run("deviation", file, "--power-law").stdout
    assert "power law, less a ramp" in text
    assert "f^-2" in text
    data = json.loads(run("deviation", file, "--power-law", "--json", "-").stdout)
    assert data["channels"][0]["values"][0]["alpha"] == laws


def test_means_come_before_anything_else(file):
    record = al.read(file)["gx"]
    found = cells("deviation", file, "--average", "10", "--from", "100", "--no-intervals", "--m", "1,2,4")
    means = record.values[:7200].reshape(-1, 10).mean(axis=1)[10:]
    wanted = al.deviation(al.Record(means, rate=0.1, unit="deg/h", kind="rate"), m=[1, 2, 4], noise=None).to("deg/h")
    np.testing.assert_allclose([float(r["deviation"]) for r in found], wanted.deviation, rtol=1e-9)
    assert [float(r["tau_s"]) for r in found] == [10.0, 20.0, 40.0]


@pytest.mark.slow("takes more than half a second")
def test_theoh_is_fitted_by_the_exact_expectation(file):
    data = json.loads(run("analyze", file, "--method", "gls", "--statistic", "theoh", "--json", "-").stdout)
    terms = {t["symbol"]: t for t in data["channels"][0]["fit"]["terms"]}
    assert terms["N"]["low"] < terms["N"]["value"] < terms["N"]["high"]
    assert terms["R"]["status"] == "identified"


@rows(
    "options, words",
    [
        (
            ("--bias", "banana"),
            "unknown bias correction 'banana'; known bias corrections: exact, published, model, plain",
        ),
        (("--bias", "model", "--statistic", "oadev,theo1"), "bias='model' is for theobr, theoh"),
        (("--bias", "exact", "--statistic", "theoh"), "theoh takes bias=model or None"),
        (("--edf", "foo"), "edf must be 'exact' or 'published', not 'foo'"),
        (("--edf", "published", "--no-intervals"), "they need intervals"),
        (("--edf", "published", "--statistic", "pdev"), "no degrees of freedom of pdev are published"),
        (("--join", "2", "--statistic", "theoh"), "join must be a share of the record between 0 and 1, not 2.0"),
        (("--divisor", "7", "--statistic", "theoh"), "must be 30 (as published) or 6 (as in Stable32), not 7"),
    ],
)
def test_wrong_options_are_refused(file, options, words):
    result = run("deviation", file, *options)
    assert result.exit_code == 2, result.output
    assert words in " ".join(result.stderr.split())


def test_published_degrees_of_freedom_are_for_one_power_law(file):
    record = al.read(file)["gx"]
    one = al.deviation(record, "oadev", m=[8], noise=al.N(1.0, "deg/sqrt(h)"), edf="published")
    assert one.edf[0] == pytest.approx(
        al.deviation(record, "oadev", m=[8], noise=al.N(1.0, "deg/sqrt(h)")).edf[0], rel=0.15
    )
    assert "with published degrees of freedom" in one.supposed
    mixed = al.N(1.0, "deg/sqrt(h)") + al.B(1.0, "deg/h")
    with pytest.raises(al.UsageError):
        al.deviation(record, "oadev", m=[8], noise=mixed, edf="published").interval()
