"""The verbs compensate and budget: what is printed, written, refused."""

import csv
import io
import json

import numpy as np
import pytest
from tests.commands import ends, run
from tests.rows import rows
from tests.unit.exporting import parsers

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
    np.savetxt(path, columns, delimiter=",", fmt=["%.3f", "%.10g"], header="time [s],ux [V]", comments="")
    return path


@pytest.mark.slow("takes more than half a second")
def test_everything_of_a_compensation_is_written(days, tmp_path):
    names = {"report": "p.html", "plot": "f.svg", "json": "a.json", "csv": "t.csv"}
    names |= {"save": "r.json", "corrected": "c.csv"}
    paths = {name: tmp_path / file for name, file in names.items()}
    asked = [part for name, path in paths.items() for part in (f"--{name}", path)]
    done = run("compensate", days[0], "--regressors", "temp", "--channels", "gx", "--apply", days[1], *asked, code=0)
    assert "gx depends on temp" in done.stdout
    assert "could be expected" in done.stdout
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


@pytest.fixture(scope="module")
def soak(tmp_path_factory):
    """Three gyros and an accelerometer in a chamber; gz has a fifth power, gy follows nothing."""
    rng, t = np.random.default_rng(3), np.arange(3600)
    x = np.sin(2 * np.pi * t / 2400)
    noise = [np.degrees(al.simulate(MODEL, t.size, 1.0, rng=rng).values) * 3600 for _ in "xyz"]
    follows = (300 * x + 100 * x**2 + 80 * x**3, 0 * x, 200 * x**5)
    az = 1000 + 2 * x + 0.1 * rng.standard_normal(t.size)
    columns = np.column_stack([t, *map(np.add, noise, follows), az, 42 + 22 * x])
    header = "time [s],gx [deg/h],gy [deg/h],gz [deg/h],az [mg],temp [degC]"
    return write(tmp_path_factory.mktemp("soak") / "soak.csv", columns, header)


@pytest.mark.slow("takes more than half a second")
@rows("autopilot", ["px4", "ardupilot"])
def test_an_autopilot_corrects_as_the_corrected_record(soak, autopilot, tmp_path):
    path, corrected = tmp_path / "tc.params", tmp_path / "c.csv"
    asked = ("--regressors", "temp", "--corrected", corrected)
    run("compensate", soak, *asked, "--to", autopilot, "-o", path, code=0)
    text = path.read_text(encoding="utf-8")
    assert "gy: no effect is shown" in text
    rows = parsers.parameters(text, "\t" if autopilot == "px4" else ",")
    v = {row[-3] if len(row) > 2 else row[0]: float(row[-2] if len(row) > 2 else row[1]) for row in rows}
    before, after = al.read(soak, along=["temp"]), al.read(corrected)
    seen, centre = before["temp"].values, 42 + 22 * np.sin(2 * np.pi * np.arange(3600) / 2400).mean()
    for name, sensor, axis in (("gx", "gyro", 0), ("gz", "gyro", 2), ("az", "accelerometer", 2)):
        removed = before[name].rate_values - after[name].rate_values
        some = range(0, 3600, 37)
        if autopilot == "px4":
            found = [parsers.px4_thermal_offset(v, sensor, axis, seen[i]) for i in some]
        else:
            found = [parsers.ardupilot_thermal_offset(v, sensor, axis, seen[i], centre) for i in some]
        np.testing.assert_allclose(found, removed[::37], rtol=0, atol=2e-4 * np.ptp(removed))


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
    done = run("compensate", days[1], "--use", saved, "--channels", "gx,gy", "--json", "-")
    data = json.loads(done.stdout)
    assert data["channels"][0]["gain"]["met"] is True
    assert data["channels"][1]["refusal"].startswith("no regression of this name")
    assert run("compensate", days[1], "--use", saved, "--regressors", "temp").exit_code == 2
    assert run("compensate", days[1], "--use", days[0]).exit_code == 3
    # what is read is never overwritten
    assert run("compensate", days[1], "--use", saved, "--json", saved, "--force").exit_code == 2


def test_motion_is_refused_and_outliers_of_regressors_are_kept(days, tmp_path):
    rows = np.loadtxt(days[0], delimiter=",", skiprows=1)
    rows[1200:1400, 1] += 3e5
    path = write(tmp_path / "moved.csv", rows, DAY)
    done = run("compensate", path, "--regressors", "temp", code=3)
    assert "the body moved" in " ".join(done.stderr.split())
    assert run("compensate", path, "--regressors", "temp", "--channels", "gx").exit_code == 3
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
    assert "gy shows no dependence on temp, d temp/dt" in done.stdout
    assert "absent" in done.stdout


@pytest.mark.slow("takes more than half a second")
def test_a_warm_up_is_no_motion(tmp_path):
    """Its slope is large beside the noise, but it has no sudden step."""
    path = day(tmp_path / "warm.csv", 5)
    rows = np.loadtxt(path, delimiter=",", skiprows=1)
    warm = 10 * (1 - np.exp(-rows[:, 0] / 600))
    rows[:, 1] += 60 * warm - 20 * rows[:, 3]
    rows[:, 3] = warm
    write(path, rows, DAY)
    assert run("info", path, "--channels", "gx").exit_code == 0
    ends(run("compensate", path, "--channels", "gx", "--regressors", "temp"), 0, "gx depends on temp")


@pytest.mark.slow("takes more than half a second")
def test_regressors_of_another_file(days, tmp_path):
    rows = np.loadtxt(days[0], delimiter=",", skiprows=1)[:, [0, 3]]
    beside = write(tmp_path / "beside.csv", rows, "time [s],temp [degC]")
    asked = ("compensate", days[0], "--channels", "gx", "--regressors", "temp", "--from", 300, "--until", 2100)
    effects = [
        json.loads(run(*asked, *more, "--json", "-").stdout)["channels"][0]["regression"]["effects"]
        for more in ((), ("--beside", beside))
    ]
    assert effects[0] == effects[1]
    # regressors of another file are interpolated only if asked
    slow = write(tmp_path / "slow.csv", rows[::10], "time [s],temp [degC]")
    asked = ("compensate", days[0], "--channels", "gx", "--regressors", "temp", "--beside", slow)
    ends(run(*asked), 3, "does not have the sample times of 'gx'", "--interpolate")
    # the last readings lie behind the last temperature
    ends(run(*asked, "--interpolate", "--split-gaps"), 0, "gx depends on temp")


@pytest.mark.slow("seconds of analyses")
def test_progress_of_a_correction_of_another_file_ends_once(days):
    told = []
    settings = CompensationSettings(("temp",), fit=FitSettings(terms="N"))
    al.compensation.compensate_file(
        days[0], al.Recipe(channels=("gx",)), settings, apply_to=days[1],
        progress=lambda what, fraction: told.append(fraction),
    )  # fmt: skip
    assert told == sorted(told)
    assert (told[0], told[-1], told.count(1.0)) == (0.0, 1.0, 1)


REFUSED = [
    (("--regressors", "flux"), 2, "no column 'flux'; columns:"),
    (("--regressors", "temp", "--lags", "a"), 2, "expected seconds"),
    (("--regressors", "temp", "--least", "1e6"), 3, "effective samples"),
    (("--regressors", "temp", "--corrected", "c.xyz"), 2, ".xyz"),
]


@rows(("options", "code", "words"), REFUSED)
def test_wrong_usage_of_compensate(days, options, code, words):
    ends(run("compensate", days[0], *options), code, words)


@pytest.mark.slow("takes more than half a second")
def test_everything_of_a_budget_is_written(current, tmp_path):
    names = {"rates": "rates.csv", "report": "p.html", "plot": "f.png", "json": "a.json", "csv": "t.csv"}
    paths = {name: tmp_path / file for name, file in names.items()}
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


def test_a_budget_takes_the_unit_of_the_header(current, tmp_path):
    asked = ("--stage", STAGE, "--torquer", TORQUER, "--sense", 5, "--terms", "QN", "--json", "-")
    by_header, by_option = (
        json.loads(run("budget", current, *unit, *asked).stdout)["channels"] for unit in ((), ("--unit", "V"))
    )
    assert len(by_header) == 1
    assert by_header == by_option
    rows = np.random.default_rng(1).standard_normal((4000, 3))
    path = write(tmp_path / "beside.csv", rows, "ix [mA],battery [V],humidity [%]")
    found = al.signals.budget_file(
        path, al.Recipe(rate=100.0), PathSettings((al.signals.Stage("ADC", 12, 10.0, "mA"),), 0.2)
    )
    assert [channel.record.name for channel in found] == ["ix"]
    ends(run("analyze", path, "--rate", 100), 2, "'mA' is not a unit of a gyroscope")


def test_the_recipe_of_a_budget_repeats_it(current, tmp_path):
    asked = ("--unit", "V", "--stage", STAGE, "--stage", "output 16 500deg/s", "--sense", 5, "--from", 1)
    for scale in (("--torquer", TORQUER), ("--scale-factor", 0.2)):
        data = json.loads(run("budget", current, *asked, *scale, "--terms", "QN", "--json", "-").stdout)
        recipe = tmp_path / f"recipe{scale[0]}.toml"
        recipe.write_text(toml(data["recipe"]), encoding="utf-8")
        assert json.loads(run("budget", current, "--recipe", recipe, "--json", "-").stdout) == data


@pytest.mark.slow("takes more than half a second")
def test_a_model_that_does_not_explain_the_record_is_said_in_its_budget(tmp_path):
    rng = np.random.default_rng(1)
    t = np.arange(20_000) / 100
    values = rng.standard_normal(t.size) + 3 * np.sin(2 * np.pi * t * (1 + 0.01 * t))
    record = al.Record(values, 100.0, "deg/h", name="z")
    found = al.signals.budget_file(record, None, PathSettings((al.signals.Stage("output", 16, 100.0, "deg/s"),)))
    assert not found["z"].budget.noise.explained
    assert found["z"].alerts[0].startswith("not explained")
    assert found.to_dict()["channels"][0]["budget"]["explained"] is False
    assert "not explained" in table(found)


WRONG = [
    (("--stage", STAGE, "--scale-factor", 0.2), 2, "gain"),
    (("--stage", STAGE, "--scale-factor", -1, "--sense", 1), 2, "between 1e-30"),
    (("--stage", STAGE, "--torquer", "turns=1"), 2, "missing field"),
    (("--stage", STAGE, "--torquer", "turns=x"), 2, "a name and a number"),
    (("--stage", STAGE, "--torquer", TORQUER, "--scale-factor", 1), 2, "given twice"),
    (("--stage", "ADC"), 2, "a stage is a name"),
    (("--stage", "ADC 12 0.5V", "--scale-factor", 0.2, "--sense", 5), 3, "clipped"),
]


@rows(("options", "code", "words"), WRONG)
def test_wrong_usage_of_budget(current, options, code, words):
    ends(run("budget", current, "--unit", "V", *options), code, words)


def test_a_current_is_read_by_its_unit(tmp_path):
    path = tmp_path / "i.csv"
    path.write_text("time [s],i [mA],temp [degC]\n" + "".join(f"{i / 10},{i % 7},{20 + i % 3}\n" for i in range(300)))
    assert al.read(path, unit="mA").channels == ("i",)
    assert al.read(path, channels=["i"])["i"].unit == "mA"
    both = al.read(path, unit="mA", along=["temp"])
    assert [record.unit for record in both] == ["mA", "degC"]
    with pytest.raises(al.UsageError, match="not a unit of a gyroscope"):
        al.read(path)
