"""What users of other programs asked for, in their own words, and where the answer is now."""

import re
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner
from tests.rows import rows
from tests.unit.exporting.test_covariance import noise

import allanite as al
from allanite.cli import main


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


def said(*arguments):
    done = CliRunner().invoke(main, list(arguments))
    assert done.exit_code == 0, done.output
    return " ".join(done.stdout.split())


FLICKER = al.Model("N 1 deg/sqrt(h), B 9 deg/h")
REQUESTS = {
    "allan_variance_ros: confusion about the units":
        lambda m: "# rad/s/sqrt(Hz), N" in al.export([m.study, m.acc], "kalibr").text,
    "imu_utils: noise density or standard deviation, should it be divided by sqrt(Hz)":
        lambda m: "continuous time (densities)" in al.export([m.study, m.acc], "kalibr").text,
    "kalibr, VINS-Mono, uzh_fpv_open: continuous or discrete time":
        lambda m: "discrete time, f = 20 Hz" in al.export([m.study, m.acc], "vins-mono").text,
    "imu_utils, kalibr_allan: bias instability was exported as random walk":
        lambda m: all(f.term == "K" for row in al.EXPORTS.values() for f in row.fields
                      if re.search(r"walk|_w$|Walk|BiasN|B_NOISE|BIAS_P|psd", f.name)),
    "LIO-SAM, LINS: which value of a data sheet goes into which field":
        lambda m: "imuGyrBiasN gyro rad/s²/√Hz K" in said("explain", "lio-sam"),
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
        lambda m: len(al.EXPORTS) >= 20,
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
        lambda m: "gb_psd gyro rad/s²/√Hz K" in said("explain", "navego"),
    "gnss-ins-sim: the drift of the bias depends on the sampling rate":
        lambda m: al.export([m.study, m.acc], "gnss-ins-sim")["gyro_b_stability"]
        == al.export([m.study, m.acc], "gnss-ins-sim", filter_rate=777.0)["gyro_b_stability"],
    "KF-GINS: a script for the error model":
        lambda m: "imunoise:" in al.export([m.study, m.acc], "kf-gins").text,
    "open_vins: the curves of x, y and z disagree, which value is to be taken":
        lambda m: al.export([m.study, m.acc], "kalibr").entries[2].channels == ("gx",)
        and "axis: worst" in al.export([m.study, m.acc], "kalibr").text,
    "IMUSensorModels: the accelerometer too, without a toolbox":
        lambda m: "accelerometer" in al.EXPORTS["kalibr"].sensors,
    "PX4-SITL_gazebo-classic: densities of the simulator are unrealistic":
        lambda m: "<gyroscopeNoiseDensity>" in al.export([m.study, m.acc], "gazebo-classic").text,
}  # fmt: skip
"""Project and request: what shows that it is met."""


@rows("request_", list(REQUESTS))
def test_a_request_is_met(request_, made):
    assert REQUESTS[request_](made)
