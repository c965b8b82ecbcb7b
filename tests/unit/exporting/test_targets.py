"""The table of targets: dimensions, formulas, and every file back to the coefficients that it was made of."""

import re

import pytest
from tests.rows import rows
from tests.unit.exporting.test_covariance import noise

import allanite as al
from allanite.exporting.content import number
from allanite.exporting.imported import noise_in
from allanite.exporting.target import LONG
from allanite.testing import check_target


@rows("name", list(al.EXPORTS))
def test_fields_and_the_way_back(name):
    row = al.EXPORTS[name]
    assert row.name == name
    check_target(row)


def test_flicker_is_read_back_too():
    models = [one + al.B(size, unit) for one, size, unit in zip(noise(), (1e-5, 2e-4), ("rad/s", "m/s^2"), strict=True)]
    found = noise_in(al.export(models, "matlab").text, al.EXPORTS["matlab"], None)
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
    found = noise_in(text, al.EXPORTS[name], 200.0)
    assert found.gyro["N"].value == pytest.approx(n, rel=1e-9)
    assert found.accelerometer["K"].value == pytest.approx(k, rel=1e-9)


def test_numbers_keep_a_point():
    for value in (1e-5, 1e-300, 3.0, 0.1, 123456789.0, 2.5e-7):
        assert float(number(value)) == value
        assert re.fullmatch(r"\d+\.\d+(e[-+]\d+)?", number(value))


def test_the_long_time_is_that_of_every_file():
    assert f"{LONG / 3600:g}" in " ".join(al.EXPORTS["kf-gins"].notes)
    text = al.export(noise(), "gazebo", rate=100.0).text
    assert f"<dynamic_bias_correlation_time>{number(LONG)}<" in text
