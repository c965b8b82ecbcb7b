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


def test_rates_are_the_matrix_times_the_currents(currents):
    found = al.signals.budget_file(currents, al.Recipe(terms="QN"), PathSettings((STAGE,), 0.2, 5.0, AXES))
    i = np.array([record.rate_values for record in currents])
    rates = np.array([record.rate_values for record in found.rates])
    np.testing.assert_allclose(rates, 0.2 * np.array(AXES).reshape(2, 2) @ i, rtol=1e-12, atol=1e-15)
    assert found.rates.channels == ("wx", "wy")


def test_rounding_of_both_converters_adds(currents):
    """The noise of rounding that is found is that of white errors of both, by simulation."""
    rng = np.random.default_rng(2)
    exact = rng.standard_normal((2, 200_000)) * 20
    error = np.array(AXES).reshape(2, 2) @ (np.rint(exact) - exact)  # steps
    found = al.signals.budget_file(currents, al.Recipe(terms="QN"), PathSettings((STAGE,), 0.2, 5.0, AXES))
    for channel, deviation in zip(found, error.std(axis=1), strict=True):
        stage = channel.budget.stages[0]
        rate = stage.coefficient / np.sqrt(0.01)
        assert rate == pytest.approx(deviation * STAGE.step / 5 * 0.2, rel=0.01)


def test_the_command_line_and_the_recipe(currents, tmp_path):
    path = tmp_path / "currents.csv"
    al.write(currents, path)
    asked = ("--stage", "ADC 14 5V", "--scale-factor", 0.2, "--sense", 5, "--coupling", "0,-1,1,0", "--terms", "QN")
    done = run("budget", path, *asked, "--json", "-", code=0)
    data = json.loads(done.stdout)
    assert data["settings"]["axes"] == [0, -1, 1, 0]
    recipe = tmp_path / "recipe.toml"
    recipe.write_text(toml(data["recipe"]), encoding="utf-8")
    again = run("budget", path, "--recipe", recipe, "--json", "-")
    assert json.loads(again.stdout)["settings"] == data["settings"]
    assert al.from_dict(data).settings == PathSettings((STAGE,), 0.2, 5.0, (0, -1, 1, 0))


@rows(
    ("axes", "words"),
    [
        ("0,1", "four numbers"),
        ("1,2,2,4", "singular"),
        ("nan,1,1,0", "between -1e+30"),
        ("0,0,1,1", "singular"),
    ],
)
def test_impossible_axes_are_refused(axes, words, currents, tmp_path):
    path = tmp_path / "currents.csv"
    al.write(currents, path)
    ends(run("budget", path, "--stage", "ADC 14 5V", "--scale-factor", 0.2, "--sense", 5, "--coupling", axes), 2, words)


def test_what_is_no_pair_of_currents_is_refused(currents):
    refused(al.DataError, "need two currents, but there are 'ix'", lambda: mixed(Recording(currents.records[:1]), AXES))
    rate = al.Record(np.zeros(20_000), 100.0, "deg/h", name="gx")
    refused(al.DataError, "two currents of one kind", lambda: mixed(Recording((currents.records[0], rate)), AXES))
    clipped = al.Record(np.clip(currents.records[0].values, -10, 10), 100.0, "mA", name="ix")
    stage = al.signals.Stage("ADC", 12, 10.0, "mA")
    refused(al.DataError, r"'ix'.*clipped", lambda: mixed(Recording((clipped, currents.records[1])), AXES, (stage,)))


def test_the_sum_of_two_currents_may_exceed_the_range_of_each():
    """Each is within +-2.5 V, their sum over the square root of two is not; one sample of each is clipped."""
    x = np.random.default_rng(1).uniform(-2.4, 2.4, 5000)
    y = x + np.random.default_rng(2).uniform(-0.05, 0.05, 5000)
    x[10], y[20] = 2.5, -2.5
    both = Recording(tuple(al.Record(v, 100.0, "V", name=name) for v, name in ((x, "ix"), (y, "iy"))))
    found = al.signals.budget_file(
        both, al.Recipe(terms="QN"), PathSettings((al.signals.Stage("ADC", 12, 2.5, "V"),), 0.2, 5.0, (1, 1, -1, 1))
    )
    assert [channel.refusal for channel in found] == ["", ""]
    assert [channel.budget.stages[0].clipped for channel in found] == [2, 2]


def test_a_gain_before_the_converter_makes_steps_and_range_smaller(currents):
    plain, gained = al.signals.Stage.parse("ADC 14 5V"), al.signals.Stage.parse("ADC 14 5V gain=8")
    assert gained.step == plain.step / 8
    assert al.signals.Stage.parse(gained.text) == gained
    assert "gain of 8" in str(gained)
    found = [
        al.signals.budget(currents.records[0], [stage], scale=0.2, sense=5.0, recipe=al.Recipe(terms="QN")).stages[0]
        for stage in (plain, gained)
    ]
    assert found[1].coefficient == pytest.approx(found[0].coefficient / 8)
    for wrong in ("gain=0", "gain=-1", "gain=x"):
        with pytest.raises(al.UsageError, match="gain"):
            al.signals.Stage.parse(f"ADC 12 5V {wrong}")
    record = al.Record(np.linspace(-1, 1, 4001), 100.0, "V", name="ux")
    al.signals.budget(
        record, [al.signals.Stage.parse("ADC 14 5V gain=4")], scale=0.2, sense=5.0, recipe=al.Recipe(terms="QN")
    )
    with pytest.raises(al.DataError, match="clipped"):
        al.signals.budget(record, [al.signals.Stage.parse("ADC 14 5V gain=8")], scale=0.2, sense=5.0)
