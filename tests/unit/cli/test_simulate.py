"""``allanite simulate``: every format, every fault, what is refused."""

import contextlib
import json

import numpy as np
from tests.commands import ends, of_verb
from tests.rows import rows

import allanite as al
from allanite.readers.formats.registry import WRITERS

run = of_verb("simulate")


@rows("suffix", list(WRITERS))
def test_every_format_is_written_and_read_again(tmp_path, suffix):
    path = tmp_path / f"out{suffix}"
    done = run(path, "--sensor", "fog", "--rate", 100, "--duration", "10 s", "--channels", 2, "--seed", 3)
    ends(done, 0, f"out: {path}")
    recording = al.read(path)
    assert recording.channels == ("gx", "gy")
    rng = np.random.default_rng(3)
    for record in recording:
        again = al.simulate(al.sensor("fog"), 1000, 100.0, rng=rng, unit="deg/h")
        np.testing.assert_allclose(record.values, again.values, rtol=1e-12, atol=1e-12)
        assert (record.unit, record.rate, record.kind) == ("deg/h", 100.0, "rate")


def test_quantization_is_made_by_rounding_on_request(tmp_path):
    path, model = tmp_path / "out.npz", "Q 20 arcsec, N 2 deg/sqrt(h)"
    asked = ("--rate", 10, "--samples", 500, "--seed", 4, "--unit", "rad/s", "--rounding")
    run(path, "--model", model, *asked, code=0)
    again = al.simulate(al.Model(model), 500, 10.0, rng=4, rounding=True)
    np.testing.assert_allclose(al.read(path)[0].values, again.values, rtol=1e-12)
    run(tmp_path / "b.npz", "--model", "N 2 deg/sqrt(h)", *asked, code=2)


def test_an_effect_is_that_of_its_column(tmp_path):
    path, plain = tmp_path / "out.npz", tmp_path / "plain.npz"
    line = ("--model", "N 1 deg/sqrt(h)", "--rate", 10, "--samples", 500, "--channels", 2)
    run(plain, *line, code=0)
    run(path, *line, "--effect", "temp 2 degC 40 s 3 deg/h", "--effect", "disp 1 um 7 s 1 deg/h", code=0)
    recording = al.read(path)
    assert [(record.name, record.unit) for record in recording][2:] == [("temp", "degC"), ("disp", "um")]
    *gyros, temp, disp = (record.values for record in recording)
    np.testing.assert_allclose(temp, 2 * np.sin(2 * np.pi * np.arange(500) / 400), atol=1e-12)
    for gyro, alone in zip(gyros, al.read(plain), strict=True):
        np.testing.assert_allclose(gyro - alone.values, 1.5 * temp + disp, atol=1e-9)
    for wrong in ("temp 2 degC", "temp 2 40 s 3 deg/h", ""):
        assert "--effect has the form" in run(path, *line, "--force", "--effect", wrong).stderr, wrong


def test_all_faults_at_once(tmp_path):
    path = tmp_path / "out.npz"
    result = run(
        path, "--model", "N 0.01 deg/sqrt(h), GM 0.1 deg/h 20 s", "--rate", 100, "--samples", 5000, "--constant",
        "10 deg/h", "--low-pass", "20 Hz 2", "--noise-profile", "0:1, 25:1, 25:2", "--outliers", "0.1% 20",
        "--clip", "300 deg/h", "--quantize", "angle 0.1 arcsec", "--dither", "9 Hz 20", "--gaps", "1% 0.2s",
        "--json", "-", code=0,
    )  # fmt: skip
    truth = json.loads(result.stdout)
    steps = truth["channels"][0]["history"]
    begins = ["simulated", "constant", "low-pass", "noise", "", "0 samples clipped", "angle rounded", ""]
    assert all(step.startswith(begin) for step, begin in zip(steps, begins, strict=True))
    assert truth["model"]["terms"][1]["time_constant"] == 20.0
    assert (truth["seed"], truth["size"], truth["rate"]) == (1, 5000, 100.0)
    assert list(al.read(path)[0].history) == steps


def test_the_order_of_a_low_pass_and_the_profile_of_a_noise_have_several_forms(tmp_path):
    usual = ("--model", "N 0.01 deg/sqrt(h)", "--rate", 100, "--samples", 5000)
    (tmp_path / "profile.csv").write_text("time,factor\n0,1\n10,3\n40,1\n", "utf-8")
    choices = {"--low-pass": ("20 Hz", "20 Hz 1", "20 Hz 2"),
               "--noise-profile": ("0:1, 10:3, 40:1", tmp_path / "profile.csv", "0:1, 10:2, 40:1")}  # fmt: skip
    for option, forms in choices.items():
        for k, form in enumerate(forms):
            run(tmp_path / f"{k}.npz", *usual, option, form, "--force", code=0)
        first, same, other = (al.read(tmp_path / f"{k}.npz")[0].values for k in range(3))
        np.testing.assert_array_equal(first, same)
        assert np.ptp(first - other) > 0
    assert first[800:1200].std() > 2 * first[-800:].std()
    ends(run(tmp_path / "c.npz", *usual, "--noise-profile", "0:1, x"), 2, "--noise-profile takes '0:1, 600:3, 1200:1'")
    (tmp_path / "empty.csv").write_text("time,factor\n", "utf-8")
    run(tmp_path / "c.npz", *usual, "--noise-profile", tmp_path / "empty.csv", code=3)


def test_names_units_and_progress_of_channels(tmp_path, monkeypatch):
    path = tmp_path / "out.parquet"
    run(path, "--sensor", "mems", "--rate", 50, "--samples", 500, "--quantize", "rate 0.0625 deg/s")
    record = al.read(path)[0]
    assert record.unit == "deg/s"
    np.testing.assert_array_equal(record.values / 0.0625, np.rint(record.values / 0.0625))
    # accelerometers have their names and units
    run(tmp_path / "out.npz", "--model", "N 60 ug/sqrt(Hz)", "--rate", 50, "--samples", 500, "--channels", 4)
    recording = al.read(tmp_path / "out.npz")
    assert recording.channels == ("a1", "a2", "a3", "a4")
    assert recording[0].unit == "ug"
    run(tmp_path / "named.npz", "--sensor", "fog", "--rate", 50, "--samples", 500, "--channels", "azimuth,tilt")
    assert al.read(tmp_path / "named.npz").channels == ("azimuth", "tilt")
    # progress is the share of the channels that are made
    told = []
    bar = contextlib.nullcontext(lambda _, share: told.append(share))
    monkeypatch.setattr("allanite.cli.simulate.progress", lambda _: bar)
    run(tmp_path / "a.npz", "--sensor", "mems", "--rate", 10, "--samples", 200, "--channels", 10, code=0)
    assert (len(told), told) == (10, sorted(told))
    assert 0 <= told[0] < 0.5 < told[-1] <= 1


USUAL = ("--sensor", "rlg", "--rate", "100")


@rows("arguments, words", [
    (("out.npz", *USUAL), "give either --duration or --samples"),
    (("out.npz", *USUAL, "--samples", "99", "--duration", "9"), "give either --duration or --samples"),
    (("out.npz", "--rate", "100", "--samples", "99"), "--model, --sensor or --datasheet"),
    (("out.npz", *USUAL, "--model", "N 1 deg/sqrt(h)", "--samples", "99"), "given twice"),
    (("there.csv", *USUAL, "--samples", "99"), "already exists"),
    (("out.npz", *USUAL, "--samples", "99", "--channels", "0"), "at least 1"),
    (("out.npz", *USUAL, "--samples", "99", "--dither", "random"), "give --quantize too"),
    (("out.npz", *USUAL, "--samples", "99", "--quantize", "0.1 arcsec"), "'rate 0.01 deg/s' or 'angle 0.2 arcsec'"),
    (("out.npz", *USUAL, "--samples", "99", "--gaps", "1%"), "--gaps has the form '1% 5 s', not '1%'"),
    (("out.npz", *USUAL, "--samples", "99", "--unit", "ug"), "not a unit of rates"),
    (("out.npz", *USUAL, "--samples", "99", "--low-pass", "9 Hz 2.5"), "must be an integer, not 2.5"),
    (("out.npz", *USUAL, "--samples", "99", "--seed", "-1"), "--seed"),
])  # fmt: skip
def test_what_is_refused(tmp_path, monkeypatch, arguments, words):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "there.csv").write_text("mine")
    ends(run(*arguments), 2, words)
    assert [path.name for path in tmp_path.iterdir()] == ["there.csv"]
    assert (tmp_path / "there.csv").read_text() == "mine"
