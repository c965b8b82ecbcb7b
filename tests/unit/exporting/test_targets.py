"""The table of targets: dimensions, formulas, and every file back to the coefficients that it was made of."""

import re

import pytest
from tests.unit.exporting.test_covariance import COEFFICIENTS, noise, with_fields

import allanite as al
from allanite.core.units import signal_named, unit_of
from allanite.exporting.content import number
from allanite.exporting.imported import noise_in
from allanite.exporting.target import LONG
from allanite.terms import TERMS


@pytest.mark.parametrize("name", list(al.EXPORTS))
def test_a_row_is_complete(name):
    row = al.EXPORTS[name]
    assert row.name == name
    assert len(row.source) > 20
    assert all(suffix.startswith(".") for suffix in row.forms)
    names = [field.full for field in row.fields]
    assert len(set(names)) == len(names)


@pytest.mark.parametrize(("name", "field"), [(n, f) for n, row in al.EXPORTS.items() for f in row.fields],
                         ids=lambda v: getattr(v, "full", v))  # fmt: skip
def test_the_unit_of_a_field_is_that_of_its_formula(name, field):
    """The dimension of (coefficient sqrt(f^a T^b))^power."""
    time = unit_of("s").dimension
    own = (
        unit_of(signal_named(field.sensor).si[TERMS[field.term].power]).dimension if field.term else (0.0,) * len(time)
    )
    inner = [o + t * (field.time - field.rate) / 2 for o, t in zip(own, time, strict=True)]
    assert unit_of(field.unit).dimension == pytest.approx([field.power * v for v in inner])


@pytest.mark.parametrize("name", with_fields())
def test_back_to_the_coefficients(name, tmp_path):
    made = al.export(noise(), name, rate=123.0)
    path = tmp_path / f"file{made.suffix}"
    made.write(path)
    found = al.read_noise(path, name, rate=123.0)
    for sensor, (n, k) in COEFFICIENTS.items():
        model = getattr(found, sensor)
        assert model["N"].value == pytest.approx(n, rel=1e-12)
        if any(field.term == "K" for field in al.EXPORTS[name].fields):
            assert model["K"].value == pytest.approx(k, rel=1e-12)
        else:
            assert [t.symbol for t in model] == ["N"]


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


@pytest.mark.parametrize("name", list(EXAMPLES))
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
