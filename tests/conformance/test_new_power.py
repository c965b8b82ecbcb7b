"""A noise term whose coefficient has a power of time that no other has: its units follow from the power."""

import sys

import numpy as np
import pytest
from click.testing import CliRunner
from tests import ROOT

import allanite as al
from allanite.cli import main
from allanite.core.syntax import written
from allanite.core.units import SIGNALS, unit_of
from allanite.reporting import page
from allanite.terms import TERMS
from allanite.testing import check_term

sys.path.append(str(ROOT / "tests" / "plugin"))
from allanite_sample.relaxation import relaxation


@pytest.fixture(autouse=True)
def row(monkeypatch):
    """One line of the table."""
    monkeypatch.setitem(TERMS, "RR", relaxation(1.0))


def model():
    return al.N(0.1, "deg/sqrt(h)") + al.RR(2e-6, "rad/s^2.5", time_constant=20.0)


def record(n=2**13):
    return al.simulate(model(), n, 1.0, rng=np.random.default_rng(1), name="z")


def test_its_columns_agree():
    check_term(relaxation(6.0))


def test_its_units_follow_from_the_power():
    for signal in SIGNALS:
        expected = unit_of(signal.unit) * unit_of("s") ** -1.5
        assert unit_of(signal.si[-1.5]) == expected, signal.name
        assert unit_of(signal.sheet[-1.5]).dimension == expected.dimension, signal.name


def test_it_is_written_and_read():
    again = al.Model(str(model()))
    assert str(again) == str(model())
    assert al.Model(written(model())) == model() == al.Model.from_dict(model().to_dict())
    assert model()["RR"].unit == "rad/s^2.5"
    with pytest.raises(al.UnitError, match=r"usual units: deg/h\^2.5, ug/h\^1.5"):
        al.RR(1.0, "rad/s", time_constant=1.0)


def test_it_is_expected_and_simulated():
    curves = [al.deviation(al.simulate(model(), 2048, 1.0, rng=np.random.default_rng(i)), m=[1, 8, 64], noise=model())
              for i in range(40)]  # fmt: skip
    expected = al.expected(model(), "oadev", curves[0].tau)
    error = expected * np.sqrt(2 / curves[0].edf / len(curves))
    assert np.all(np.abs(np.mean([c.variance for c in curves], axis=0) - expected) < 5 * error)


def test_it_is_identified():
    fit = al.identify(record(), terms="N,RR")
    assert fit["RR"].status == "identified"
    assert fit["RR"].shape[0] == pytest.approx(20.0, rel=0.3)
    assert fit["RR"].value == pytest.approx(2e-6, rel=0.3)
    with pytest.raises(al.UsageError, match="RR"):  # a fit of a curve knows no terms with a shape
        al.identify(record(), "gls", terms="N,RR", statistic="oadev")


@pytest.mark.slow("takes more than half a second")
def test_everything_that_takes_a_model_takes_it(tmp_path):
    assert al.bound(model(), 2**13, 1.0)["RR"] < 0.2
    space = al.state_space(model(), 1.0)
    assert space.P0[0, 0] == pytest.approx((2e-6 * 20**1.5) ** 2)
    study = al.analyze(record(), al.Recipe(terms="N,RR", to=("rad/s^2.5",)))
    assert "driven relaxation" in page(study)
    assert "rad/s^2.5" in study.channels[0].fit["RR"].to_dict()["shown"]["unit"]
    al.plot(study, path=tmp_path / "z.svg")
    assert al.from_dict(study.to_dict()).channels[0].fit["RR"].shape == study.channels[0].fit["RR"].shape


@pytest.mark.slow("takes more than half a second")
def test_it_is_known_at_the_command_line(tmp_path):
    path = str(tmp_path / "z.csv")
    for line in (
        ["simulate", path, "--model", str(model()), "--rate", "1", "--samples", "8192"],
        ["analyze", path, "--terms", "N,RR"],
        ["analyze", path, "--terms", "N,RR", "--to", "rad/s^2.5"],
        ["plan", "--model", str(model()), "--rate", "1"],
        ["statespace", "--model", str(model()), "--rate", "1"],
        ["selfcheck", "--model", str(model()), "--rate", "1", "--samples", "2000", "--records", "2"],
        ["export", "--model", str(model()), "--to", "datasheet", "--rate", "1"],
    ):
        run = CliRunner().invoke(main, line)
        assert run.exit_code == 0, (line, run.output)
        assert "RR" in run.output or line[0] in ("simulate", "export")
