"""Roll and pitch of recordings: identified time constant, predicted limits, bad input, the command."""

import json
import math
import re
from dataclasses import replace
from itertools import permutations, product

import numpy as np
import pytest
from tests.commands import ends, of_verb
from tests.rows import refused, rows

import allanite as al
from allanite.applications.attitude import SCENARIOS, Trial, VerticalSettings, optimal_time_constant, vertical
from allanite.applications.attitude.inertial import Axes
from allanite.applications.attitude.tuning import _doubts
from allanite.reporting import table

GYRO, TILT = al.N(0.3, "deg/sqrt(h)"), al.N(100, "ug/sqrt(Hz)")
NAMES = ("gx", "gy", "gz", "ax", "ay", "az")


@pytest.fixture(scope="module")
def still():
    rng, up = np.random.default_rng(1), {"az": 9.80665}
    made = [al.simulate(GYRO if name[0] == "g" else TILT, 20_000, 50.0, rng=rng, name=name) for name in NAMES]
    return al.Recording(tuple(replace(r, values=r.values + up.get(r.name, 0.0)) for r in made))


def changed(recording, names, values):
    return al.Recording(tuple(replace(r, values=values(r.values)) if r.name in names else r for r in recording))


def test_time_constant_follows_from_the_identified_noise(still):
    study = vertical(still)
    assert study.loop.time_constant == pytest.approx(optimal_time_constant(GYRO, TILT).time_constant, rel=0.05)
    for angle in study.angles:
        assert angle.deviation == pytest.approx(angle.prediction.rms, rel=0.1)
        assert angle.optimum.first.rms <= angle.prediction.rms * (1 + 1e-9)
    assert (study.angles[0].gyro, study.angles[0].accelerometer) == ("gx", "ay")
    assert len(study.roll) == len(study.pitch) == 20_000


def test_a_given_time_constant_needs_no_noise_and_no_best_one(still, swaying):
    short, moved = al.Recording(tuple(replace(r, values=r.values[:150]) for r in still)), recorded(swaying)
    got = vertical(short, "mahony", 2.0)
    assert (got.loop.time_constant, [angle.prediction for angle in got.angles]) == (2.0, [None, None])
    refused(al.DataError, "no time constant follows from the noise: .*give it with time_co", lambda: vertical(short))
    silent = replace(KNOWN, accelerometer="N 1e-6 ug/sqrt(Hz)")
    for angle in vertical(moved, settings=silent).angles:
        assert (angle.optimum, angle.prediction.loop.time_constant) == (None, 2.0)
        assert "no best filter for this angle: no time constant is best" in angle.doubts[0]
    silent = replace(silent, time_constant=None)
    refused(al.UsageError, "no time constant is best", lambda: vertical(moved, settings=silent))


def test_given_noise_is_not_identified(still):
    settings = VerticalSettings("second-order", gyro="N 0.3 deg/sqrt(h), K 500 deg/h/sqrt(h)",
                                accelerometer="N 100 ug/sqrt(Hz)")  # fmt: skip
    got = vertical(still, settings=settings)
    assert all(channel.noise is None for channel in got)
    assert got.loop.order == 2
    white = replace(settings, method="kalman", gyro="N 0.3 deg/sqrt(h), K 20 deg/h/sqrt(h)")
    kalman = vertical(still, settings=white)
    assert (kalman.loop.k1, kalman.loop.k2) == (pytest.approx(0.89099, rel=1e-4), pytest.approx(0.016160, rel=1e-4))


def test_z_may_point_down(still):
    up, down = (vertical(r, settings=KNOWN) for r in (still, changed(still, ("gy", "gz", "ay", "az"), np.negative)))
    assert (up.downward, down.downward) == (False, True)
    assert down.roll == pytest.approx(up.roll, abs=1e-9)


@pytest.fixture(scope="module")
def swaying():
    trial = Trial(GYRO, TILT, (1e-5, -2e-5, 3e-5), duration=20.0)
    data, _ = al.attitude.simulate_motion(SCENARIOS["oscillation"], trial, rng=np.random.default_rng(1))
    return np.hstack((data.gyro, data.force))


KNOWN = VerticalSettings(time_constant=2.0, gyro="N 0.3 deg/sqrt(h)", accelerometer="N 100 ug/sqrt(Hz)", keep_bias=True)
"""Nothing is identified."""


def recorded(values):
    units = 3 * ["rad/s"] + 3 * ["m/s^2"]
    each = zip(values.T, units, NAMES, strict=True)
    return al.Recording(tuple(al.Record(column, 100.0, unit, name=name) for column, unit, name in each))


def mounted(values, axes):
    """What sensors read whose axes are forward, sideways and vertical in this way."""
    return recorded(np.hstack((values[:, :3] @ axes.matrix, values[:, 3:] @ axes.matrix)))


def handed(text):
    return np.linalg.det([(-1 if part[0] == "-" else 1) * np.eye(3)["xyz".index(part[-1])] for part in text.split(",")])


@rows("names, signs", product(permutations("xyz"), product(("", "-"), repeat=3)))
def test_axes_are_right_handed_or_refused_with_others(names, signs):
    text = ",".join(map("".join, zip(signs, names, strict=True)))
    if handed(text) > 0:
        assert str(Axes.of(text)) == text
        assert Axes.of(text).turned(np.array([[1.0, 2.0, 3.0]]))[0] == pytest.approx(Axes.of(text).matrix @ [1, 2, 3])
        return
    with pytest.raises(al.UsageError, match=f"the axes {text} are left-handed") as refusal:
        Axes.of(text)
    suggested = str(refusal.value).split("axes='")[1].split("'")[0]
    assert handed(suggested) == pytest.approx(1)
    assert suggested.replace("-", "") == text.replace("-", "")


@rows("text", ["y,-x,z", "-z,y,x", "-x,-z,-y"])
def test_a_recording_turned_about_has_the_names_of_its_file(swaying, text):
    turned = vertical(mounted(swaying, Axes.of(text)), settings=replace(KNOWN, axes=text))
    names = {angle.name: (angle.gyro, angle.accelerometer) for angle in turned.angles}
    forward, side, _ = (part[-1] for part in text.split(","))
    assert names == {"roll": ("g" + forward, "a" + side), "pitch": ("g" + side, "a" + forward)}
    assert text in table(turned)


@pytest.mark.slow("seconds of analyses")
@rows("text, gravity, suggested", [
    ("y,z,x", "x", "y,z,x"), ("-z,y,x", "x", "y,z,x"), ("y,-z,-x", "-x", "y,-z,-x"), ("x,-z,y", "y", "x,-z,y"),
    ("x,z,-y", "-y", "x,z,-y"),
])  # fmt: skip
def test_gravity_along_another_axis_is_refused_with_axes_that_hold(swaying, text, gravity, suggested):
    recording = mounted(swaying, Axes.of(text))
    said = rf"gravity is along {gravity}, not z: \d+% of the mean specific force; give axes='{suggested}'"
    refused(al.DataError, said, lambda: vertical(recording, time_constant=2.0))
    found = vertical(recording, settings=replace(KNOWN, axes=suggested))
    assert not found.downward
    assert np.abs(np.degrees([angle.mean for angle in found.angles])).max() < 5
    lying = vertical(recording, settings=replace(KNOWN, method="mahony", axes="x,y,z"))
    assert np.hypot(*(angle.mean for angle in lying.angles)) > 1.3


@rows("wrong", ["x,y", "x,y,y", "x,y,w", "x,y,--z", "", "x,,z", "1,2,3"])
def test_wrong_axes(wrong):
    with pytest.raises(al.UsageError, match=r"are x, y and z in some order.*such as axes='y,-x,z', not"):
        VerticalSettings(axes=wrong)


def test_mean_rates_are_subtracted_or_kept(still):
    biased = changed(changed(still, "gx", lambda v: v + 1e-4), "gy", lambda v: v - 2e-4)
    free, kept = (vertical(biased, settings=replace(KNOWN, keep_bias=keep)) for keep in (False, True))
    assert kept.angles[0].mean - free.angles[0].mean == pytest.approx(2e-4, rel=0.05)
    turned = vertical(biased, settings=replace(KNOWN, axes="y,-x,z", keep_bias=False))
    for study in (free, turned):  # those of the file
        assert [study[name].bias for name in ("gx", "gy")] == pytest.approx([1e-4, -2e-4], rel=1e-3)


def test_a_turning_body_and_a_time_constant_beyond_the_recording_are_said(still):
    settings = replace(KNOWN, keep_bias=False)
    turning = changed(still, "gz", lambda v: v + math.radians(20))
    shown = " ".join(table(vertical(turning, settings=replace(settings, time_constant=500.0))).split())
    assert "a mean rate of 20 °/s is no bias" in shown
    assert "the time constant is 500 s, but the recording lasts 400 s only" in shown
    plain = table(vertical(still, settings=settings))
    assert "is no bias" not in plain
    assert "the recording lasts" not in plain


@pytest.mark.slow("takes more than half a second")
def test_noise_that_no_model_explains_is_never_used_without_a_warning(still):
    stepped = changed(still, "ay", lambda v: np.resize(1e-3 * np.array([0, 1, 2, 3, 4, 3, 2, 1]), v.size))
    settings = replace(KNOWN, accelerometer=None)
    study = vertical(stepped, settings=settings)
    roll, pitch = study.angles
    assert not study["ay"].noise.explained
    assert roll.doubts[0].startswith("no model explains the noise of ay")
    assert pitch.doubts == ()
    assert roll.prediction is None  # its number would be that of a rejected model
    free = replace(settings, time_constant=None)
    refused(al.DataError, "no time constant", lambda: vertical(stepped, settings=free))
    for shown in (table(study), al.reporting.page(study), json.dumps(study.to_dict())):
        assert re.search("[nN]o model explains the noise of ay", shown)


@pytest.mark.slow("takes more than half a second")
def test_terms_that_are_not_valid_are_left_out_and_what_they_would_do_is_said(still):
    slow = al.simulate(TILT + al.B(300, "ug"), 20_000, 50.0, rng=np.random.default_rng(5))
    plain = vertical(changed(still, "ay", lambda _: slow.values))
    channel = plain["ay"]
    noise = replace(channel.noise, fit=channel.fit.invalid("it falls like none of the terms", ("B",)))
    wrong = replace(channel, noise=noise)
    assert ([t.symbol for t in channel.model], [t.symbol for t in wrong.model]) == (["N", "B"], ["N"])
    assert [t.symbol for t in wrong.fitted] == ["N", "B"]
    p = plain.angles[0].prediction
    prediction = al.attitude.predicted_error(p.gyro, wrong.model, p.loop, duration=400.0, rate=50.0)
    (doubt,) = _doubts((plain["gx"], wrong), prediction)
    assert doubt.startswith("the prediction is a lower bound: it lacks terms whose coefficients are not valid (B ay)")
    stated = float(doubt.split("would be ")[1].split(" arcsec")[0])
    assert stated == pytest.approx(p.to("arcsec"), rel=0.05)


def test_free_fall_is_counted(still):
    dropped = changed(still, ("ax", "ay", "az"), lambda v: np.where(np.arange(v.size) // 100 == 50, 0.0, v))
    got = vertical(dropped, settings=KNOWN)
    assert (got.held, got.falling) == (100, 100)
    assert "100 samples in free fall" in table(got)


@rows("settings, words", [
    ({"time_constant": 0.02}, "sample interval of 0.02 s"), ({"method": "best"}, "unknown filter 'best'; known filters")
])  # fmt: skip
def test_settings_are_checked(still, settings, words):
    refused(al.UsageError, words, lambda: vertical(still, **settings))


@rows("change, said", [
    (lambda r: al.Recording(r.records[:3]), "three gyros and three accelerometers, but there are 3 gyros and 0"),
    (lambda r: al.Recording(r.records[:4]), "3 gyros and 1 accelerometer: gx, gy, gz, ax; choose six channels"),
    (lambda r: changed(r, "gy", lambda v: np.where(np.arange(v.size) // 10 == 10, np.nan, v)),
     r"10 samples of 'gy' are missing.*gap: prepare.trim\(recording, 2.2, 400\)"),
    (lambda r: changed(r, "gx", lambda v: v + 80.0), "which no vehicle does: are they in deg/s"),
    (lambda r: changed(r, "az", lambda v: v / 9.80665), "are the accelerometers in g"),
    (lambda r: changed(r, "az", lambda v: v * 9.80665), r"are the accelerometers in m/s\^2"),
    (lambda r: changed(r, "az", lambda v: v * 1e-4), "free fall"),
    (lambda r: al.Recording((*r.records[:5], replace(r.records[5], rate=25.0))), "these differ: gx 20000 samples"),
])  # fmt: skip
def test_bad_recordings(still, change, said):
    refused(al.DataError, said, lambda: vertical(change(still), time_constant=1.0))


@pytest.fixture
def desk(tmp_path, monkeypatch, still):
    monkeypatch.chdir(tmp_path)
    al.write(still, "six.csv")
    return tmp_path


run = of_verb("vertical")


@pytest.mark.slow("takes more than half a second")
def test_a_file_without_units(desk, still):
    values = np.stack([record.values for record in still], axis=1)
    np.savetxt(desk / "bare.csv", values, "%.17g", ",", header=",".join(NAMES), comments="")
    units = f"gyro={still['gx'].unit},accel={still['ax'].unit}"
    short = [*NOISE, "--rate", "50", "--time-constant", "2", "--quiet", "--json", "-"]
    texts = run("bare.csv", "--unit", units, *short, code=0).output, run("six.csv", *short).output
    bare, six = ([angle["deviation"] for angle in json.loads(text)["angles"]] for text in texts)
    assert bare == pytest.approx(six, rel=1e-9)
    ends(run("bare.csv", "--unit", "deg/s", *short), 3, "--unit gyro=deg/s,accel=g")


def test_the_matrices_are_those_of_the_filter(desk):
    done = run("six.csv", *NOISE, "--time-constant", "2", "--json", "k.json")
    assert json.loads((desk / "k.json").read_text())["loop"]["k1"] == 0.5
    assert f"K = [[{-math.expm1(-0.5 / 50)!r}]]" in done.output


NOISE = ("--gyro", "N 0.3 deg/sqrt(h), B 10 deg/h, K 20 deg/h/sqrt(h)", "--accelerometer", "N 100 ug/sqrt(Hz), B 50 ug")


def test_the_command_without_a_recording():
    ends(run(*NOISE, "--duration", "10 min"), 0, "time constant 0.7587 s: RMS error 26.4 arcsec",
         "optimal causal (Wiener) filter", "floor: 13.7 arcsec", "accelerometer B = 50 µg")  # fmt: skip


@pytest.mark.slow("scenarios of ten minutes")
def test_scenarios_are_shown():
    done = run(*NOISE, "--scenarios", "--gyro-bias", "10 deg/h", "--rate", 20)
    ends(done, 0, "no filter is the best in all scenarios", "does not see 1 m/s²")


@rows("words, code, said", [
    ([], 2, "give a recording, or the noise of both sensors with --gyro and --accelerometer"),
    (NOISE[:2], 2, "the noise of both sensors"), ([*NOISE, "--gate", "3"], 2, "--gate applies to a recording"),
    (["six.csv", "--scenarios"], 2, "--scenarios applies without a recording only"),
    (["six.csv", "--time-constant", "0.01"], 2, "give a longer one with --time-constant"),
    (["none.csv"], 3, "none.csv"), (["six.csv", "--axes", "x,z,y"], 2, "--axes x,-z,y"),
    ([*NOISE, "--axes", "x,-z,y"], 2, "--axes applies to a recording"),
])  # fmt: skip
def test_wrong_commands(desk, words, code, said):
    ends(run(*words), code, said)
