"""Rows of targets, and what users of other programs asked for, in their own words."""

import re
from types import SimpleNamespace

import numpy as np
import pytest
from tests.commands import run
from tests.rows import rows
from tests.unit.exporting.test_covariance import noise

import allanite as al
from allanite.exporting.content import Entry, number
from allanite.exporting.imported import noise_in
from allanite.exporting.target import LONG
from allanite.reporting.views.export import _size
from allanite.testing import check_target


@rows("name", list(al.exporting.EXPORTS))
def test_fields_and_the_way_back(name):
    row = al.exporting.EXPORTS[name]
    assert row.name == name
    check_target(row)


def test_flicker_is_read_back_too():
    models = [one + al.B(size, unit) for one, size, unit in zip(noise(), (1e-5, 2e-4), ("rad/s", "m/s^2"), strict=True)]
    found = noise_in(al.export(models, "matlab").text, al.exporting.EXPORTS["matlab"], None)
    assert found.gyro["B"].value == pytest.approx(1e-5, rel=1e-12)


EXAMPLES = {
    "kalibr": (
        "#Accelerometers\naccelerometer_noise_density: 1.86e-03 #Noise density\naccelerometer_random_walk: 4.33e-04\n"
        "#Gyroscopes\ngyroscope_noise_density:     1.87e-04\ngyroscope_random_walk:       2.66e-05\n\n"
        "rostopic:                    /imu0      #the IMU ROS topic\nupdate_rate:                 200.0      #Hz\n",
        1.87e-4, 4.33e-4,
    ),
    "vins-mono": ("%YAML:1.0\n#imu\nacc_n: 0.08          # acc\nacc_w: 0.00004\ngyr_n: 0.004\ngyr_w: 2.0e-6\n",
                  0.004 / 20, 0.00004 / 200**0.5),
    "kf-gins": ("imunoise:\n  arw: [0.24, 0.24, 0.24] # [deg/sqrt(hr)]\n  vrw: [0.24, 0.24, 0.24]\n"
                "  gbstd: [50.0, 50.0, 50.0]\n  abstd: [250.0, 250.0, 250.0]\n  corrtime: 1.0 # [hr]\n",
                0.24 * 3.14159265358979 / 180 / 60, 250e-5 * (2 / 3600) ** 0.5),
    "px4": ("# Onboard parameters\n1\t1\tEKF2_ACC_B_NOISE\t0.003\t9\n1\t1\tEKF2_GYR_NOISE\t0.015\t9\n", 0.0015, 0.0003),
}  # fmt: skip
"""Files as users have them: gyro N and accelerometer K in SI, at 200 Hz."""


@rows("name", list(EXAMPLES))
def test_files_of_others_are_read(name):
    text, n, k = EXAMPLES[name]
    found = noise_in(text, al.exporting.EXPORTS[name], 200.0)
    assert found.gyro["N"].value == pytest.approx(n, rel=1e-9)
    assert found.accelerometer["K"].value == pytest.approx(k, rel=1e-9)


def test_numbers_keep_a_point():
    for value in (1e-5, 1e-300, 3.0, 0.1, 123456789.0, 2.5e-7):
        assert float(number(value)) == value
        assert re.fullmatch(r"\d+\.\d+(e[-+]\d+)?", number(value))


def test_the_long_time_is_that_of_every_file():
    assert f"{LONG / 3600:g}" in " ".join(al.exporting.EXPORTS["kf-gins"].notes)
    text = al.export(noise(), "gazebo", rate=100.0).text
    assert f"<dynamic_bias_correlation_time>{number(LONG)}<" in text


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """An export of a recording with a random walk, one without, and of given noise."""
    rng, folder = np.random.default_rng(5), tmp_path_factory.mktemp("imu")
    walk = al.Model("N 0.3 deg/sqrt(h), K 60 deg/h/sqrt(h)")
    records = [al.simulate(m, 20_000, 20.0, rng=rng, unit="deg/h", name=n)
               for m, n in ((walk, "gx"), (al.N(0.3, "deg/sqrt(h)"), "gy"))]  # fmt: skip
    al.write(al.Recording(tuple(records)), folder / "gyro.csv")
    study = al.analyze(folder / "gyro.csv")
    return SimpleNamespace(study=study, quiet=study["gy"], acc=noise()[1])


@rows(("target", "field", "nature"), [
    ("gazebo", 1, ("density", "steady-state sigma", "sqrt(T/2)")),
    ("gtsam", 0, ("density squared", "variance per sample", "f")),
    ("ros-imu", 0, ("variance per sample", "density squared", "1/f")),
    ("vins-mono", 0, ("sigma per sample", "density", "sqrt(1/(2 f))")),
    ("kf-gins", 2, ("steady-state sigma", "density", "sqrt(2/T)")),
    ("matlab", 2, ("level of flicker", "minimum of the curve", "0.664")),
])  # fmt: skip
def test_what_a_field_is_and_by_how_much_the_usual_mistake_is_wrong(target, field, nature):
    assert al.exporting.EXPORTS[target].fields[field].nature == nature
    assert all(all(field.nature[:1]) for row in al.exporting.EXPORTS.values() for field in row.fields)


def said(*arguments):
    done = run(*arguments, code=0)
    return " ".join(done.stdout.split())


def test_the_first_screen_says_why_and_what_comes_next(tmp_path, monkeypatch):
    monkeypatch.delenv("ALLANITE_DETAILS", raising=False)
    models = "0.3 deg/sqrt(h)", "7.2 deg/h", "N 60 ug/sqrt(Hz), K 20 ug/sqrt(h)"
    convert = "convert", *models, "--to", "openvins", "--rate", "200", "--cover", "1,300"
    shown = said(*convert)
    for words in ("×2.11, cover", "gyro: covers B 7.2 °/h from 1 to 300 s", "next: --output FILE"):
        assert words in shown
    assert "--output FILE" not in said(*convert, "--output", str(tmp_path / "imu.yaml"))
    assert "gyroscope_noise_density has no value (given gyro: N is not stated)" in said(
        "convert", "8 deg/h", "--to", "kalibr"
    )


def test_a_limit_is_rounded_up():
    for value, shown in ((0.00191596, "< 0.0020"), (0.0012, "< 0.0012"), (8.41e-4, "< 8.5e-4"), (9.91, "< 10")):
        entry = Entry("", "gyro", "", "rad/s", "K", (value,), (), "", measured=False)
        assert _size(entry, limit=True) == shown


FLICKER = al.Model("N 1 deg/sqrt(h), B 9 deg/h")
REQUESTS = {
    "allan_variance_ros: confusion about the units":
        lambda m: "# rad/s/sqrt(Hz), N" in al.export([m.study, m.acc], "kalibr").text,
    "imu_utils: noise density or standard deviation, should it be divided by sqrt(Hz)":
        lambda m: "continuous time (densities)" in al.export([m.study, m.acc], "kalibr").text,
    "kalibr, VINS-Mono, uzh_fpv_open: continuous or discrete time":
        lambda m: "discrete time, f = 20 Hz" in al.export([m.study, m.acc], "vins-mono").text,
    "imu_utils, kalibr_allan: bias instability was exported as random walk":
        lambda m: all(f.term == "K" for row in al.exporting.EXPORTS.values() for f in row.fields
                      if re.search(r"walk|_w$|Walk|BiasN|B_NOISE|BIAS_P|psd", f.name)),
    "LIO-SAM, LINS: which value of a data sheet goes into which field":
        lambda m: "imuGyrBiasN K density steady-state sigma sqrt(T/2) rad/s²/√Hz gyro" in said("explain", "lio-sam"),
    "kalibr: a data sheet's ADIS16448 in kalibr's numbers":
        lambda m: "0.000191986 rad/s/√Hz" in said("convert", "0.66 deg/sqrt(h)", "--to", "kalibr"),
    "kalibr: no procedure for the random walk where only bias instability is known":
        lambda m: "K not identified, this is its 95 % upper limit" in al.export([m.quiet, m.acc], "kalibr").text,
    "kalibr: flicker is ignored, by what is the model to be replaced":
        lambda m: "Gauss-Markov" in al.export(FLICKER, "statespace", rate=9.0, form=".m").text,
    "kalibr, librealsense, OpenVINS: inflate the noise by 10 to 20, and say so":
        lambda m: "inflation: 10" in al.export([m.study, m.acc], "openvins", inflate=10.0).text,
    "VINS-Mono: measured values make the estimator drift":
        lambda m: al.export([m.study, m.acc], "vins-mono")["gyr_n"]
        == pytest.approx(al.export([m.study, m.acc], "kalibr")["gyroscope_noise_density"] * 40**0.5),
    "ORB_SLAM3, OpenImuCameraCalibrator: what do IMU.* mean, how to fill them in":
        lambda m: "IMU.GyroWalk" in al.export([m.study, m.acc], "orb-slam3").text,
    "kalibr: the readme does not say what to do with the parameters next":
        lambda m: len(al.exporting.EXPORTS) >= 20,
    "MATLAB: noise density, angle random walk or random walk; one- or two-sided":
        lambda m: '"NoiseType": "single-sided"' in al.export([m.study, m.acc], "matlab").text,
    "imu_utils, allan_variance_ros: published numbers cannot be reproduced":
        lambda m: re.search(r"# source: .*gyro.csv, sha256 [0-9a-f]{64}", al.export([m.study, m.acc], "kalibr").text),
    "kalibr_allan: the random walk is NaN":
        lambda m: "nan" not in al.export([m.quiet, m.acc], "kalibr").text.lower()
        and al.export([m.quiet, m.acc], "kalibr")["gyroscope_random_walk"] > 0,
    "allan-variance: a linear model of the bias for a Kalman filter":
        lambda m: "gx.Phi = [" in al.export(m.study, "statespace", form=".m").text,
    "NaveGo: units of the angle random walk of a STIM300":
        lambda m: "| 0.15 | | | deg/sqrt(h)" in said("convert", "0.0025 deg/s/sqrt(Hz)"),
    "NaveGo: how gb_psd is computed":
        lambda m: "gb_psd K density steady-state sigma sqrt(T/2) rad/s²/√Hz gyro" in said("explain", "navego"),
    "gnss-ins-sim: the drift of the bias depends on the sampling rate":
        lambda m: al.export([m.study, m.acc], "gnss-ins-sim")["gyro_b_stability"]
        == al.export([m.study, m.acc], "gnss-ins-sim", filter_rate=777.0)["gyro_b_stability"],
    "KF-GINS: a script for the error model":
        lambda m: "imunoise:" in al.export([m.study, m.acc], "kf-gins").text,
    "open_vins: the curves of x, y and z disagree, which value is to be taken":
        lambda m: al.export([m.study, m.acc], "kalibr").entries[2].channels == ("gx",)
        and "axis: worst" in al.export([m.study, m.acc], "kalibr").text,
    "IMUSensorModels: the accelerometer too, without a toolbox":
        lambda m: "accelerometer" in al.exporting.EXPORTS["kalibr"].sensors,
    "PX4-SITL_gazebo-classic: densities of the simulator are unrealistic":
        lambda m: "<gyroscopeNoiseDensity>" in al.export([m.study, m.acc], "gazebo-classic").text,
}  # fmt: skip
"""Project and request: what shows that it is met."""


@rows("request_", list(REQUESTS))
def test_a_request_is_met(request_, made):
    assert REQUESTS[request_](made)
