"""The verbs compensate and budget: what is printed, written, refused."""

import csv
import io
import json

import numpy as np
import pytest
from tests.commands import ends, run
from tests.rows import rows

import allanite as al
from allanite.applications.compensation.settings import CompensationSettings, FitSettings
from allanite.applications.signals.budgeting import PathSettings
from allanite.core.syntax import toml
from allanite.reporting import table
from allanite.study.channels import open_recording

MODEL = al.N(0.1, "deg/sqrt(h)") + al.K(2.0, "deg/h/sqrt(h)")
STAGE = "ADC 12 5V"
TORQUER = "turns=100,field=0.4,span=0.05,radius=0.05,inertia=2e-3,spin=1000,sides=4"


def write(path, columns, header):
    np.savetxt(path, columns, delimiter=",", fmt="%.9g", header=header, comments="")
    return path


DAY = "time [s],gx [deg/h],gy [deg/h],temp [degC],hum"


def day(path, seed, n=2400):
    rng = np.random.default_rng(seed)
    t = np.arange(n)
    temp = 25 + 5 * np.sin(2 * np.pi * t / 900 + seed) + 0.02 * rng.standard_normal(n)
    gx, gy = (np.degrees(al.simulate(MODEL, n, 1.0, rng=rng).values) * 3600 for _ in "xy")
    columns = np.column_stack([t, gx + 20 * temp, gy, temp, 40 + 0.1 * rng.standard_normal(n)])
    return write(path, columns, DAY)


@pytest.fixture(scope="module")
def days(tmp_path_factory):
    folder = tmp_path_factory.mktemp("days")
    return [day(folder / f"day{seed}.csv", seed) for seed in (1, 2)]


@pytest.fixture(scope="module")
def current(tmp_path_factory):
    path = tmp_path_factory.mktemp("current") / "current.csv"
    volts = 5 * al.simulate(al.N(2.5, "deg/sqrt(h)"), 20_000, 1000.0, rng=1).values / 0.2
    step = 10 / 2**12
    columns = np.column_stack([np.arange(20_000) / 1000, np.round(volts / step) * step])
    return write(path, columns, "time [s],ux [V]")


@pytest.mark.slow("takes more than half a second")
def test_everything_of_a_compensation_is_written(days, tmp_path):
    suffixes = {"report": "html", "plot": "svg", "json": "json", "csv": "t.csv", "save": "r.json", "corrected": "csv"}
    paths = {name: tmp_path / f"a.{suffix}" for name, suffix in suffixes.items()}
    asked = [part for name, path in paths.items() for part in (f"--{name}", path)]
    done = run("compensate", days[0], "--regressors", "temp", "--channels", "gx", "--apply", days[1], *asked)
    ends(done, 0, "gx depends on temp", "could be expected")
    assert done.stdout.splitlines()[-1] == f"corrected: {paths['corrected']}"
    data = json.loads(paths["json"].read_text(encoding="utf-8"), parse_constant=pytest.fail)
    assert [c["regression"]["name"] for c in data["channels"]] == ["gx"]
    effect = data["channels"][0]["regression"]["effects"][0]
    assert effect["low"] < np.radians(20 / 3600) < effect["high"]
    assert (data["channels"][0]["explained"], data["channels"][0]["alerts"]) == (True, [])
    assert data["applied"][0]["gain"]["explained"] > 0.5
    rows = list(csv.DictReader(io.StringIO(paths["csv"].read_text(encoding="utf-8"))))
    assert {row["of"] for row in rows} == {"fitted", "applied"}
    page = paths["report"].read_text(encoding="utf-8")
    assert page.startswith("<!DOCTYPE html>")
    assert page.count("<svg") == 2
    assert paths["plot"].read_text(encoding="utf-8").count("<path") > 10
    corrected = al.read(paths["corrected"])
    assert corrected.channels == ("gx",)
    assert corrected["gx"].history[-1].startswith("corrected: regression on temp")
    whole = al.read(days[1], along=["temp"])
    again = al.compensation.load(paths["save"])[0].apply(whole["gx"], whole)
    np.testing.assert_allclose(corrected["gx"].values, again.values, rtol=1e-9)


@pytest.mark.slow("takes more than half a second")
def test_what_was_saved_and_what_a_recipe_says_is_used(days, tmp_path):
    asked = ("--regressors", "temp", "--channels", "gx", "--degree", 2, "--lags", 60, "--from", 200, "--apply", days[1])
    first = run("compensate", days[0], *asked, "--outliers", "mark", "--split-gaps", "--level", 0.9, "--json", "-")
    data = json.loads(first.stdout)
    recipe = tmp_path / "recipe.toml"
    recipe.write_text(toml(data["recipe"]), encoding="utf-8")
    assert json.loads(run("compensate", days[0], "--recipe", recipe, "--json", "-").stdout) == data
    # what was saved is used
    saved = tmp_path / "r.json"
    run("compensate", days[0], "--regressors", "temp", "--channels", "gx", "--save", saved, "--quiet")
    used = json.loads(run("compensate", days[1], "--use", saved, "--channels", "gx,gy", "--json", "-").stdout)
    assert used["channels"][0]["gain"]["met"] is True
    assert used["channels"][1]["refusal"].startswith("no regression of this name")
    run("compensate", days[1], "--use", saved, "--regressors", "temp", code=2)
    run("compensate", days[1], "--use", days[0], code=3)
    # what is read is never overwritten
    run("compensate", days[1], "--use", saved, "--json", saved, "--force", code=2)


def test_motion_is_refused_and_outliers_of_regressors_are_kept(days, tmp_path):
    rows = np.loadtxt(days[0], delimiter=",", skiprows=1)
    rows[1200:1400, 1] += 3e5
    path = write(tmp_path / "moved.csv", rows, DAY)
    ends(run("compensate", path, "--regressors", "temp"), 3, "the body moved")
    ends(run("compensate", path, "--regressors", "temp", "--channels", "gx"), 3, "gx: moves from 1184 s")
    # outliers of regressors are not marked
    rows = np.loadtxt(days[0], delimiter=",", skiprows=1)[:, [0, 1, 3]]
    rows[500, 1] += 1e6
    rows[700, 2] += 500
    path = write(tmp_path / "spikes.csv", rows, "time [s],gx [deg/h],temp [degC]")
    both = open_recording(path, al.Recipe(outliers="mark"), along=("temp",))
    assert np.flatnonzero(np.isnan(both["gx"].values)).tolist() == [500]
    assert np.isfinite(both["temp"].values).all()
    # a channel that does not follow is said to
    done = run("compensate", days[0], "--regressors", "temp", "--derivative-of", "temp", "--channels", "gy")
    ends(done, 0, "gy shows no dependence on temp, d temp/dt", "absent")


@pytest.mark.slow("takes more than half a second")
def test_a_warm_up_is_no_motion(tmp_path):
    """Its slope is large beside the noise, but it has no sudden step."""
    path = day(tmp_path / "warm.csv", 5)
    rows = np.loadtxt(path, delimiter=",", skiprows=1)
    warm = 10 * (1 - np.exp(-rows[:, 0] / 600))
    rows[:, 1] += 60 * warm - 20 * rows[:, 3]
    rows[:, 3] = warm
    write(path, rows, DAY)
    run("info", path, "--channels", "gx", code=0)
    ends(run("compensate", path, "--channels", "gx", "--regressors", "temp"), 0, "gx depends on temp")


@pytest.mark.slow("takes more than half a second")
def test_regressors_of_another_file(days, tmp_path):
    rows = np.loadtxt(days[0], delimiter=",", skiprows=1)[:, [0, 3]]
    beside = write(tmp_path / "beside.csv", rows, "time [s],temp [degC]")
    asked = ("compensate", days[0], "--channels", "gx", "--regressors", "temp", "--from", 300, "--until", 2100)
    within, outside = (run(*asked, *more, "--json", "-", code=0).stdout for more in ((), ("--beside", beside)))
    effects = [json.loads(text)["channels"][0]["regression"]["effects"] for text in (within, outside)]
    assert effects[0] == effects[1]
    # regressors of another file are interpolated only if asked
    slow = write(tmp_path / "slow.csv", rows[::10], "time [s],temp [degC]")
    asked = ("compensate", days[0], "--channels", "gx", "--regressors", "temp", "--beside", slow)
    ends(run(*asked), 3, "does not have the sample times of 'gx'", "--interpolate")
    # the last readings lie behind the last temperature
    ends(run(*asked, "--interpolate", "--split-gaps"), 0, "gx depends on temp")


@pytest.mark.slow("seconds of analyses")
def test_progress_of_a_correction_of_another_file_ends_once(days):
    told, recipe = [], al.Recipe(channels=("gx",))
    settings = CompensationSettings(("temp",), fit=FitSettings(terms="N"))
    progress = lambda what, fraction: told.append(fraction)  # noqa: E731
    al.compensation.compensate_file(days[0], recipe, settings, apply_to=days[1], progress=progress)
    assert told == sorted(told)
    assert (told[0], told[-1], told.count(1.0)) == (0.0, 1.0, 1)


@pytest.mark.slow("takes more than half a second")
def test_everything_of_a_budget_is_written(current, tmp_path):
    suffixes = {"rates": "csv", "report": "html", "plot": "png", "json": "json", "csv": "t.csv"}
    paths = {name: tmp_path / f"a.{suffix}" for name, suffix in suffixes.items()}
    asked = [part for name, path in paths.items() for part in (f"--{name}", path)]
    done = run("budget", current, "--unit", "V", "--stage", STAGE, "--torquer", TORQUER, "--sense", 5, *asked)
    ends(done, 0, "K_i = 0.2 rad/s per A, of 4 coil side(s)", "more bits would change nothing")
    data = json.loads(paths["json"].read_text(encoding="utf-8"), parse_constant=pytest.fail)
    assert data["channels"][0]["budget"]["stages"][0]["codes"]["missing"] == 0
    rate = al.read(paths["rates"])["ux"]
    assert rate.unit == "rad/s"
    assert rate.values.std() == pytest.approx(np.radians(2.5 / 60) * np.sqrt(1000), rel=0.02)
    assert next(csv.reader(io.StringIO(paths["csv"].read_text(encoding="utf-8"))))[:2] == ["channel", "stage"]
    assert "How this was computed" in paths["report"].read_text(encoding="utf-8")
    assert paths["plot"].read_bytes().startswith(b"\x89PNG")


def test_a_current_is_read_by_its_unit(current, tmp_path):
    asked = ("--stage", STAGE, "--torquer", TORQUER, "--sense", 5, "--terms", "QN", "--json", "-")
    texts = [run("budget", current, *unit, *asked, code=0).stdout for unit in ((), ("--unit", "V"))]
    (by_header,), (by_option,) = (json.loads(text)["channels"] for text in texts)
    assert by_header == by_option
    rows = np.random.default_rng(1).standard_normal((4000, 4))
    path = write(tmp_path / "beside.csv", rows, "ix [mA],battery [V],humidity [%],temp [degC]")
    settings = PathSettings((al.signals.Stage("ADC", 12, 10.0, "mA"),), 0.2)
    assert [channel.record.name for channel in al.signals.budget_file(path, al.Recipe(rate=100.0), settings)] == ["ix"]
    ends(run("analyze", path, "--rate", 100), 2, "'mA' is not a unit of a gyroscope")
    assert al.read(path, rate=100.0, unit="mA").channels == ("ix",)
    assert al.read(path, rate=100.0, channels=["ix"])["ix"].unit == "mA"
    assert [record.unit for record in al.read(path, rate=100.0, unit="mA", along=["temp"])] == ["mA", "degC"]


def test_the_recipe_of_a_budget_repeats_it(current, tmp_path):
    asked = ("--unit", "V", "--stage", STAGE, "--stage", "output 16 500deg/s", "--sense", 5, "--from", 1)
    for scale in (("--torquer", TORQUER), ("--scale-factor", 0.2)):
        data = json.loads(run("budget", current, *asked, *scale, "--terms", "QN", "--json", "-").stdout)
        recipe = tmp_path / f"recipe{scale[0]}.toml"
        recipe.write_text(toml(data["recipe"]), encoding="utf-8")
        assert json.loads(run("budget", current, "--recipe", recipe, "--json", "-").stdout) == data


@pytest.mark.slow("takes more than half a second")
def test_a_model_that_does_not_explain_the_record_is_said_in_its_budget(tmp_path):
    t = np.arange(20_000) / 100
    values = np.random.default_rng(1).standard_normal(t.size) + 3 * np.sin(2 * np.pi * t * (1 + 0.01 * t))
    record = al.Record(values, 100.0, "deg/h", name="z")
    found = al.signals.budget_file(record, None, PathSettings((al.signals.Stage("output", 16, 100.0, "deg/s"),)))
    assert found["z"].alerts[0].startswith("not explained")
    assert found.to_dict()["channels"][0]["budget"]["explained"] is found["z"].budget.noise.explained is False
    assert "not explained" in table(found)


@rows("asked, code, words", [
    (("compensate", "--lags", "a"), 2, "expected seconds"), (("compensate", "--least", 1e6), 3, "effective samples"),
    (("compensate", "--corrected", "c.xyz"), 2, ".xyz"), (("budget", "--torquer", "turns=1"), 2, "missing field"),
    (("budget", "--torquer", "turns=x"), 2, "a name and a number"),
    (("budget", "--torquer", TORQUER, "--scale-factor", 1), 2, "given twice"),
])  # fmt: skip
def test_wrong_usage(days, current, asked, code, words):
    verb, *options = asked
    usual = (days[0], "--regressors", "temp") if verb == "compensate" else (current, "--unit", "V", "--stage", STAGE)
    ends(run(verb, *usual, *options), code, words)
