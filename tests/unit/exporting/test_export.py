"""Which coefficient is written, what stands for one that was not identified, and what is refused."""

import io
import json
import pickle
import re
import shlex
import shutil
import subprocess
from dataclasses import replace
from html import unescape

import numpy as np
import pytest
from tests.commands import ends, run
from tests.rows import refused, rows
from tests.unit.exporting.test_covariance import noise

import allanite as al
from allanite.core.estimate import Estimate
from allanite.core.fit import Fit
from allanite.core.plain import from_dict
from allanite.core.units import SIGNALS
from allanite.exporting.choice import axes_of, coefficients
from allanite.reporting import page, table

GYRO, ACCELEROMETER = SIGNALS[:2]


def fit(name, signal=GYRO, *, n=1e-4, k=1e-6, k_status="identified", upper=None, **more):
    """A fit with N and K of one axis."""
    limits = lambda level: (0.9 * n, 1.1 * n)  # noqa: E731 - short
    walk = Estimate("K", signal, k, None, k_status, upper, "whittle", **more)
    white = Estimate("N", signal, n, 0.05 * n, "identified", None, "whittle", limits=limits)
    return Fit((white, walk), "whittle", signal, al.Model((al.Term("N", n, signal),)), name=name)


def six(**more):
    """Gyros with N of 1, 3 and 2 e-4 and accelerometers; `more` is about K of the gyros."""
    gyros = [fit(f"g{axis}", n=n, k=n / 100, **more) for axis, n in zip("xyz", (1e-4, 3e-4, 2e-4), strict=True)]
    return gyros + [fit(f"a{axis}", ACCELEROMETER, n=1e-3, k=1e-5) for axis in "xyz"]


@rows(
    ("axis", "channel", "value"), [("worst", "gy", 3e-4), ("median", "gz", 2e-4), ("x", "gx", 1e-4), ("z", "gz", 2e-4)]
)
def test_axis_policies(axis, channel, value):
    found = al.export(six(), "kalibr", axis=axis, rate=100.0)
    assert (found.entries[0].channels, found["gyroscope_noise_density"]) == ((channel,), value)
    assert f"# axis: {axis}\n" in found.text
    assert f"N of {channel}: 95 %: {0.9 * value:.4g} to {1.1 * value:.4g}" in found.text


def test_each_axis_its_own():
    found = al.export(six(), "matlab", axis="each")
    assert json.loads(found.text)["IMU"]["Gyroscope"]["NoiseDensity"] == [1e-4, 3e-4, 2e-4]
    covariance = al.export(six(), "ros-imu", axis="each", rate=100.0).entries[0].values
    assert covariance == pytest.approx([1e-6, 9e-6, 4e-6])
    with pytest.raises(al.UsageError, match="kalibr takes one value for all axes"):
        al.export(six(), "kalibr", axis="each", rate=100.0)


def test_inflation_is_written():
    plain, inflated = (al.export(six(), "kalibr", rate=100.0, inflate=factor) for factor in (1.0, 10.0))
    assert inflated["gyroscope_random_walk"] == pytest.approx(10 * plain["gyroscope_random_walk"])
    assert "inflation: 10" in inflated.text
    assert "value inflated by 10" in inflated.entries[0].remark
    refused(al.UsageError, "not inflated", lambda: al.export(six(), "datasheet", inflate=2.0))


def test_an_upper_limit_stands_for_what_was_not_identified_and_says_so():
    source = six()
    source[:3] = [fit(f"g{axis}", k=None, k_status="absent", upper=2e-7 * i) for i, axis in enumerate("xyz", 1)]
    found = al.export(source, "kalibr", rate=100.0)
    assert found["gyroscope_random_walk"] == pytest.approx(6e-7)
    assert not found.entries[2].measured
    assert "K not identified, this is its 95 % upper limit" in found.text
    # of axes some of which have a value, the largest value
    source[1] = fit("gy", k=1e-7)
    assert al.export(source, "kalibr", rate=100.0)["gyroscope_random_walk"] == 1e-7


@rows("status", ["not observable", "not valid", "absent"])
def test_nothing_is_never_written_as_zero(status):
    value = 1e-6 if status == "not valid" else None
    source = [replace(one, estimates=(one["N"], replace(one["K"], value=value, status=status, reason="too short")))
              for one in six()[:3]]  # fmt: skip
    with pytest.raises(al.DataError, match="kalibr cannot be written: gyroscope_random_walk has no value") as refused:
        al.export([*source, *six()[3:]], "kalibr", rate=100.0)
    assert f"gx, gy, gz: K is {status if status != 'absent' else 'not identified'}" in str(refused.value)
    # where no field needs it, it is not written
    assert "random" not in al.export([*source, *six()[3:]], "ros-imu", rate=100.0).text.replace("random walk)", "")


def test_an_axis_without_a_coefficient_is_named():
    source = six()
    source[1] = fit("gy", k=1e-3, k_status="not valid", reason="the curve contradicts it")
    found = al.export(source, "kalibr", rate=100.0)
    assert found["gyroscope_random_walk"] == 2e-6
    said = "gyroscope_random_walk is taken from the other axes (gy: K is not valid"
    assert any(note.startswith(said) for note in found.notes)
    assert said in found.text


def test_models_that_explain_nothing_are_refused_unless_asked_for():
    goodness = al.identify(al.simulate(al.N(1.0, "rad/sqrt(s)"), 4000, 10.0, rng=np.random.default_rng(1))).goodness
    bad = [replace(one, goodness=replace(goodness, p=1e-20)) for one in six()]
    for source, target, names in ((bad[:3], "datasheet", "gx, gy, gz"), (six()[:3] + bad[3:], "kalibr", "ax, ay, az")):
        with pytest.raises(al.DataError, match=f"^{names}: the model does not explain the record.*unexplained=True"):
            al.export(source, target, rate=100.0)
    mixed = [bad[1], six()[0], *six()[3:]]
    found = al.export(mixed, "kalibr", rate=100.0)
    assert (found.entries[0].channels, found.rejected) == (("gx",), ("gy",))
    assert "gy is left out: the model does not explain the record" in found.alerts
    forced = al.export(mixed, "kalibr", rate=100.0, unexplained=True)
    assert forced.entries[0].channels == ("gy",)
    assert "(the model does not explain the record)" in forced.text


@rows("source, target, options, words", [
    (six()[:3], "lio-sam", {}, "lio-sam needs an accelerometer"), (six()[3:], "px4", {}, "px4 needs a gyro"),
    (six(), "vins-mono", {}, "vins-mono needs the sampling rate: rate="),
    (six(), "kalibrr", {}, "unknown target 'kalibrr'; did you mean kalibr"),
    (six(), "kalibr", {"axis": "best"}, "'best'; choose worst"),
    ([*six()[:2], *six()[3:]], "kalibr", {"axis": "z", "rate": 100.0}, "no axis z"),
    *((six(), "kalibr", {name: value}, "must be between") for name, value in (
        ("inflate", 0.0), ("inflate", float("nan")), ("rate", -1.0), ("filter_rate", 0.0))),
    (1.0, "kalibr", {}, "source must be a Study, a Channel, a Fit"),
    (six(), "statespace", {"form": ".txt", "rate": 1.0}, "statespace is written as .npz, .m, .h, not as '.txt'"),
])  # fmt: skip
def test_wrong_choices(source, target, options, words):
    error = al.DataError if "needs a" in words else al.UsageError
    refused(error, words, lambda: al.export(source, target, **options))


def test_the_rate_is_asked_for_only_where_it_is_needed():
    assert al.export(six(), "lio-sam").text
    assert al.export(six(), "px4").text  # the filter has its own step


def test_values_outside_of_the_range_of_a_parameter_are_clipped_and_said():
    found = al.export([al.Model("N 1e-6 rad/s/sqrt(Hz), K 1e-9 rad/s^2/sqrt(Hz)"), noise()[1]], "px4")
    assert found["EKF2_GYR_NOISE"] == 1e-4
    assert "1e-05 is outside of what is accepted, 0.0001 to 0.1" in found.entries[0].remark


def test_what_the_target_has_no_field_for_is_listed():
    models = [one + al.B(size, unit) for one, size, unit in zip(noise(), (1e-5, 2e-4), ("rad/s", "m/s^2"), strict=True)]
    found = al.export(models, "kalibr", rate=100.0)
    assert any(note.startswith("given gyro: no field for B (bias instability), 2.063 deg/h") for note in found.notes)
    assert "no field for B" in found.text


def test_a_process_replaces_a_walk_only_where_a_correlation_time_is_written():
    axes = list(axes_of(al.N(1e-4, "rad/s/sqrt(Hz)") + al.GM(1e-5, "rad/s", time_constant=50.0)))
    assert coefficients(axes, "K", markov=False, unexplained=False)[0] == ()
    (one,), _ = coefficients(axes, "K", markov=True, unexplained=False)
    assert (one.value, one.time) == (pytest.approx(1e-5 * (2 / 50) ** 0.5), 50.0)


@pytest.mark.nightly("seconds of processor time for what shorter tests look at, too")
@rows("name", list(al.exporting.EXPORTS))
def test_the_same_input_gives_the_same_bytes_and_every_form(name):
    for form in al.exporting.EXPORTS[name].forms:
        made = [al.export(noise(), name, rate=100.0, form=form) for _ in range(2)]
        assert made[0].data == made[1].data
        assert not re.search(r"20\d\d-\d\d", made[0].text)
    assert from_dict(json.loads(json.dumps(made[0].to_dict()))).data == made[0].data
    assert pickle.loads(pickle.dumps(made[0])).text == made[0].text
    assert al.exporting.EXPORTS[name].title in unescape(page(made[0]))
    shown = table(made[0])
    assert all(entry.full in shown for entry in made[0].entries)


def test_forms_of_a_state_space():
    from allanite.statespace import state_space

    model = al.Model("N 0.01 deg/sqrt(h), B 0.5 deg/h")
    space = state_space(model, 100.0)
    held = np.load(io.BytesIO(al.export([model, noise()[1]], "statespace", rate=100.0).data))
    for name, own in (("axis1", space), ("axis2", state_space(noise()[1], 100.0))):
        for label in ("Phi", "Qd", "H", "R", "P0"):
            np.testing.assert_array_equal(held[f"{name}_{label}"], getattr(own, label))
    script = al.export(model, "statespace", rate=100.0, form=".m").text
    rows = re.search(r"axis1\.Phi = \[(.*)\];", script)[1].split("; ")
    np.testing.assert_array_equal([[float(v) for v in row.split()] for row in rows], space.Phi)
    header = al.export(model, "statespace", rate=100.0, form=".h").text
    assert f"static const double axis1_Qd[{len(space.Qd)}][{len(space.Qd)}]" in header
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler:
        check = [compiler, "-Wall", "-Wno-unused-variable", "-Werror", "-fsyntax-only", "-x", "c", "-"]
        done = subprocess.run(check, input=header, text=True, capture_output=True, check=False)
        assert done.returncode == 0, done.stderr
    white = np.load(io.BytesIO(al.export(al.N(0.1, "rad/sqrt(s)"), "statespace", rate=100.0).data))
    assert sorted(white) == ["axis1_R", "comment"]
    np.testing.assert_allclose(white["axis1_R"], 1.0)


def test_forms_of_a_data_sheet():
    csv = al.export(six()[:1], "datasheet", form=".csv").text.splitlines()
    assert "gx,angle random walk N,0.343775,0.309397,0.378152,deg/sqrt(h),," in csv
    latex = al.export(six()[:1], "datasheet", form=".tex").text
    assert r"gx & angle random walk N & 0.343775 & 0.309397 & 0.378152 & deg/sqrt(h) &  &  \\" in latex


# the command line


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """A gyro with three axes, and its accelerometers in a file of their own."""
    folder, rng = tmp_path_factory.mktemp("imu"), np.random.default_rng(11)
    for name, model, unit in (("gyro", "N 0.3 deg/sqrt(h), K 60 deg/h/sqrt(h)", "deg/h"),
                              ("acc", "N 100 ug/sqrt(Hz), K 3000 ug/sqrt(h)", "ug")):  # fmt: skip
        axes = (al.simulate(al.Model(model), 30_000, 20.0, rng=rng, unit=unit, name=name[0] + x) for x in "xyz")
        al.write(al.Recording(tuple(axes)), folder / f"{name}.csv")
    return folder


@pytest.mark.slow("takes more than half a second")
def test_a_file_for_kalibr_from_two_recordings(files):
    import yaml

    out = files / "imu.yaml"
    done = run("export", files / "gyro.csv", files / "acc.csv", "--to", "kalibr", "-o", out, code=0)
    held = yaml.safe_load(out.read_text())
    assert held["update_rate"] == 20.0
    assert held["gyroscope_noise_density"] == pytest.approx(0.3 * np.pi / 180 / 60, rel=0.03)
    assert held["accelerometer_random_walk"] == pytest.approx(3000e-6 * 9.80665 / 60, rel=0.4)
    assert "gyroscope_noise_density" in done.stdout
    ends(run("export", files / "gyro.csv", files / "acc.csv", "--to", "kalibr", "-o", out), 2, "already exists")


@pytest.mark.slow("takes more than half a second")
def test_results_of_analyze_are_taken_as_they_are(files):
    for name in ("gyro", "acc"):
        run("analyze", files / f"{name}.csv", "--json", files / f"{name}.json", "--quiet", code=0)
    stored, direct = (
        run("export", *sorted(files.glob(f"*.{suffix}")), "--to", "vins-fusion", "-o", "-", code=0).stdout
        for suffix in ("json", "csv")
    )
    assert stored == direct
    assert re.search(r"# source: .*gyro.csv, sha256 [0-9a-f]{64}", stored)


@pytest.mark.slow("takes more than half a second")
def test_the_other_sensor_as_a_model_and_json(files):
    other = ("--model", "N 100 ug/sqrt(Hz), K 10 ug/sqrt(h)")
    done = run("export", files / "gyro.csv", *other, "--to", "px4", "--json", "-", code=0)
    found = from_dict(json.loads(done.stdout))
    assert found["EKF2_GYR_NOISE"] == pytest.approx(0.3 * np.pi / 180 / 60 * 10, rel=0.03)
    assert json.loads(done.stdout)["recipe"]["terms"] == "auto"


@rows("arguments, code, words", [
    (("export", "{gyro}", "--to", "kalibr"), 3, "kalibr needs an accelerometer, and there is only gx (gyro)"),
    (("export", "{gyro}", "--to", "kalibr"), 3, "N and K of its data sheet by --model"),
    (("export", "--to", "kalibr"), 2, "give a recording, a result of analyze in JSON, or the noise with --model"),
    (("export", "--model", "N 1 deg/sqrt(h)", "--to", "statespace"), 2, "needs the sampling rate: --rate HZ"),
    (("export", "absent.json", "--to", "kalibr"), 3, "absent.json: No such file or directory"),
    (("convert", "0.66 parsec", "--to", "kalibr"), 2, "unknown unit 'parsec'"),
    (("convert", "0.66 m", "--to", "kalibr"), 2, "'m' is not a unit of a noise coefficient"),
    (("convert", "0.66 deg/sqrt(h)", "--to", "vins-mono"), 2, "needs the sampling rate: --rate HZ"),
    (("convert", "--from", "kalibr", "{gyro}"), 3, "has none of the fields of kalibr: gyroscope_noise_density"),
    (("convert", "--from", "datasheet", "{gyro}"), 2, "datasheet cannot be read back"),
    (("convert", "8 deg/h", "N 60 ug/sqrt(Hz), B 9 ug", "--to", "lio-sam", "-o-"), 3, "N is not stated"),
])  # fmt: skip
def test_what_is_refused_says_so(files, arguments, code, words):
    ends(run(*(str(a).format(gyro=files / "gyro.csv") for a in arguments)), code, words)


def test_a_value_of_a_data_sheet_in_the_unit_of_a_field():
    done = run("convert", "0.66 deg/sqrt(h)", "--to", "kalibr", code=0)
    assert re.search(r"gyroscope_noise_density +0\.000191986 +rad/s/√Hz +given +N", done.stdout)
    discrete = run("convert", "0.66 deg/sqrt(h)", "100 ug/sqrt(Hz)", "--to", "vins-mono", "--rate", "200")
    assert re.search(r"gyr_n +0\.00383972", discrete.stdout)
    assert re.search(r"acc_n +0\.0196133", discrete.stdout)
    units = run("convert", "0.66 deg/sqrt(h)")
    assert "| noise density, two-sided | 39.6 |" in units.stdout


def test_from_one_target_to_another(tmp_path):
    for name in ("kalibr", "vins-mono"):
        al.export(noise(), name, rate=200.0).write(tmp_path / name)
    read = run("convert", "--from", "kalibr", tmp_path / "kalibr", code=0)
    assert re.search(r"N +angle random walk +0\.687549 +°/√h +0\.0002 +rad/√s", read.stdout)
    made = run("convert", "--from", "kalibr", tmp_path / "kalibr", "--to", "vins-mono", "-o", "-")
    (tmp_path / "again").write_text(made.stdout)
    held, again = (al.read_noise(tmp_path / name, "vins-mono", rate=200.0) for name in ("vins-mono", "again"))
    for one, other in ((held.gyro, again.gyro), (held.accelerometer, again.accelerometer)):
        assert [one[symbol].value for symbol in "NK"] == pytest.approx([other[symbol].value for symbol in "NK"], 1e-12)


@rows("name", list(al.exporting.EXPORTS))
def test_every_target_is_explained(name):
    row, said = al.exporting.EXPORTS[name], " ".join(run("explain", name, code=0).stdout.split())
    assert all(field.name in said for field in row.fields)
    assert " ".join(row.source.split())[:40] in said
    assert json.loads(run("explain", name, "--json", "-").stdout)["targets"][0]["name"] == name


def test_the_command_beside_the_values_is_complete(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("ALLANITE_DETAILS")
    y = np.random.default_rng(4).standard_normal((4000, 6)) * 1e-3 + [0, 0, 0, 0, 0, 1]
    np.savetxt("imu.csv", y, delimiter=",", header="gx,gy,gz,ax,ay,az", comments="")
    said = run("analyze", "imu.csv", "--rate", "100", "--unit", "gyro=deg/s,accel=g")
    line = " ".join(said.stdout.split()).split("(allanite ")[1].split(")")[0]
    run(*shlex.split(line.replace("FILE", "imu.csv")), "-o", "imu.yaml", code=0)
    assert (tmp_path / "imu.yaml").exists()
