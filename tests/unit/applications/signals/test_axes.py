"""Two torquers of one rotor, and a gain before a converter."""

import json

import numpy as np
import pytest
from tests.commands import ends, run
from tests.rows import refused, rows

import allanite as al
from allanite.applications.signals import mixed
from allanite.applications.signals.budgeting import PathSettings
from allanite.core.record import Recording
from allanite.core.syntax import toml

STAGE = al.signals.Stage("ADC", 14, 5.0, "V")
AXES = (0.03, -1.1, 0.9, -0.02)


@pytest.fixture(scope="module")
def currents():
    rng = np.random.default_rng(1)
    values = np.rint(rng.standard_normal((2, 20_000)) * 300) * STAGE.step / 5 * 1e3  # mA
    return Recording(tuple(al.Record(v, 100.0, "mA", name=name) for v, name in zip(values, ("ix", "iy"), strict=True)))


@pytest.fixture(scope="module")
def study(currents):
    return al.signals.budget_file(currents, al.Recipe(terms="QN"), PathSettings((STAGE,), 0.2, 5.0, AXES))


def test_rates_are_the_matrix_times_the_currents(currents, study):
    i, rates = (np.array([record.rate_values for record in recording]) for recording in (currents, study.rates))
    np.testing.assert_allclose(rates, 0.2 * np.array(AXES).reshape(2, 2) @ i, rtol=1e-12, atol=1e-15)
    assert study.rates.channels == ("wx", "wy")


def test_rounding_of_both_converters_adds(study):
    """The noise of rounding that is found is that of white errors of both, by simulation."""
    exact = np.random.default_rng(2).standard_normal((2, 200_000)) * 20
    error = np.array(AXES).reshape(2, 2) @ (np.rint(exact) - exact)  # steps
    rates = [channel.budget.stages[0].coefficient / np.sqrt(0.01) for channel in study]
    assert rates == pytest.approx(error.std(axis=1) * STAGE.step / 5 * 0.2, rel=0.01)


@pytest.fixture
def path(currents, tmp_path):
    al.write(currents, tmp_path / "currents.csv")
    return tmp_path / "currents.csv"


ASKED = ("--stage", "ADC 14 5V", "--scale-factor", 0.2, "--sense", 5, "--coupling")


def test_the_command_line_and_the_recipe(path, tmp_path):
    data = json.loads(run("budget", path, *ASKED, "0,-1,1,0", "--terms", "QN", "--json", "-", code=0).stdout)
    assert data["settings"]["axes"] == [0, -1, 1, 0]
    recipe = tmp_path / "recipe.toml"
    recipe.write_text(toml(data["recipe"]), encoding="utf-8")
    again = run("budget", path, "--recipe", recipe, "--json", "-")
    assert json.loads(again.stdout)["settings"] == data["settings"]
    assert al.from_dict(data).settings == PathSettings((STAGE,), 0.2, 5.0, (0, -1, 1, 0))


@rows("axes, words", [
    ("0,1", "four numbers"), ("1,2,2,4", "singular"), ("nan,1,1,0", "between -1e+30"), ("0,0,1,1", "singular")
])  # fmt: skip
def test_impossible_axes_are_refused(path, axes, words):
    ends(run("budget", path, *ASKED, axes), 2, words)


def test_what_is_no_pair_of_currents_is_refused(currents):
    first, second = currents
    rate = al.Record(np.zeros(20_000), 100.0, "deg/h", name="gx")
    clipped = al.Record(np.clip(first.values, -10, 10), 100.0, "mA", name="ix")
    stage = al.signals.Stage("ADC", 12, 10.0, "mA")
    refused(al.DataError, "need two currents, but there are 'ix'", lambda: mixed(Recording((first,)), AXES))
    refused(al.DataError, "two currents of one kind", lambda: mixed(Recording((first, rate)), AXES))
    refused(al.DataError, r"'ix'.*clipped", lambda: mixed(Recording((clipped, second)), AXES, (stage,)))


def test_the_sum_of_two_currents_may_exceed_the_range_of_each():
    """Each is within +-2.5 V, their sum over the square root of two is not; one sample of each is clipped."""
    x = np.random.default_rng(1).uniform(-2.4, 2.4, 5000)
    y = x + np.random.default_rng(2).uniform(-0.05, 0.05, 5000)
    x[10], y[20] = 2.5, -2.5
    both = Recording(tuple(al.Record(v, 100.0, "V", name=name) for v, name in ((x, "ix"), (y, "iy"))))
    settings = PathSettings((al.signals.Stage("ADC", 12, 2.5, "V"),), 0.2, 5.0, (1, 1, -1, 1))
    found = al.signals.budget_file(both, al.Recipe(terms="QN"), settings)
    assert [(channel.refusal, channel.budget.stages[0].clipped) for channel in found] == [("", 2), ("", 2)]


def test_a_gain_before_the_converter_makes_steps_and_range_smaller():
    plain, gained = al.signals.Stage.parse("ADC 14 5V"), al.signals.Stage.parse("ADC 14 5V gain=8")
    assert gained.step == plain.step / 8
    assert al.signals.Stage.parse(gained.text) == gained
    assert "gain of 8" in str(gained)
    for wrong in ("gain=0", "gain=-1", "gain=x"):
        refused(al.UsageError, "gain", lambda wrong=wrong: al.signals.Stage.parse(f"ADC 12 5V {wrong}"))

    def budget(gain):
        record, stage = al.Record(np.linspace(-1, 1, 4001), 100.0, "V"), al.signals.Stage("ADC", 14, 5.0, "V", gain)
        return al.signals.budget(record, [stage], scale=0.2, sense=5.0, recipe=al.Recipe(terms="QN"))

    assert budget(4.0).stages[0].clipped == 0
    refused(al.DataError, "clipped", lambda: budget(8.0))
