"""Rows of targets, and what users of other programs asked for, in their own words."""

import re

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


REQUESTS = [
    # kalibr, imu_utils: continuous or discrete time; densities or standard deviations
    ("kalibr", {}, "continuous time (densities)"), ("kalibr", {}, "# rad/s/sqrt(Hz), N"),
    ("vins-mono", {}, "discrete time, f = 20 Hz"),
    # kalibr: flicker is ignored, by what is the model to be replaced
    ("statespace", {"form": ".m"}, "Gauss-Markov"),
    # MATLAB: one- or two-sided
    ("matlab", {}, '"NoiseType": "single-sided"'),
]  # fmt: skip


@rows("target, options, words", REQUESTS)
def test_what_users_of_other_programs_asked_for_stands_in_the_file(target, options, words):
    models = [noise()[0] + al.B(1e-5, "rad/s"), noise()[1]]
    assert words in al.export(models, target, rate=20.0, **options).text


def test_a_bias_instability_is_no_random_walk_and_a_drift_does_not_depend_on_the_rate():
    """imu_utils and kalibr_allan wrote the one for the other; that of gnss-ins-sim was a matter of its rate."""
    fields = [field for row in al.exporting.EXPORTS.values() for field in row.fields]
    walks = [field for field in fields if re.search(r"walk|_w$|Walk|BiasN|B_NOISE|BIAS_P|psd", field.name)]
    assert {field.term for field in walks} == {"K"}
    slow, fast = (al.export(noise(), "gnss-ins-sim", rate=20.0, filter_rate=rate) for rate in (None, 777.0))
    assert slow["gyro_b_stability"] == fast["gyro_b_stability"]


@rows("words, answer", [
    (("explain", "lio-sam"), "imuGyrBiasN K density steady-state sigma sqrt(T/2) rad/s²/√Hz gyro"),
    (("explain", "navego"), "gb_psd K density steady-state sigma sqrt(T/2) rad/s²/√Hz gyro"),
    (("convert", "0.0025 deg/s/sqrt(Hz)"), "| 0.15 | | | deg/sqrt(h)"),  # that of a STIM300
])  # fmt: skip
def test_what_the_commands_answer(words, answer):
    assert answer in said(*words)
