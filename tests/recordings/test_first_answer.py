"""The first answer on real recordings, by the default recipe, and beside a data sheet: parts of committed tables."""

from table import read

import math

import pytest
from tests.rows import rows

import allanite as al
import recordings as script

pytestmark = pytest.mark.slow("analyses of long recordings")

GYROS = ("adis_16405_imu1.rda", "adis_16405_imu2.rda")
OTHERS = (
    ("mpu6050_static10min/mpu6050_gyroscope.mat", {"rate": 100.0, "unit": "deg/s"}),
    ("mpu6050_static10min/mpu6050_accelerometer.mat", {"rate": 100.0, "unit": "g"}),
    ("phone_gyro4.txt", {"unit": "rad/s"}),
)


def second(record):
    """Allan deviation at 1 s, SI."""
    curve = al.deviation(record, "oadev", m=[round(record.rate)])
    return float(curve.to(record.signal.unit).deviation[0])


def below_the_curve(channel):
    """Whether 0.664 B, where it is a result, is at most the least upper limit of the measured curve."""
    flicker = channel.fit["B"]
    if not flicker.claimed:
        return True
    curve = al.deviation(channel.record, "oadev", taus="octave", noise=channel.fit.model)
    return 0.664 * flicker.value <= float(curve.to(channel.record.signal.unit).upper(0.95).min())


@rows("name", GYROS)
def test_gyroscopes_with_a_filter_are_explained_and_N_is_what_the_curve_shows(recordings, name):
    recipe = al.Recipe(unit="deg/s", channels=("1", "2", "3"))
    for channel in al.analyze(recordings / name, recipe).channels:
        assert channel.noise.validity in ("explained", "approximate")  # the bias of some steps
        assert not channel.fit.scope.whole
        assert abs(channel.fit["N"].value / second(channel.record) - 1) < 0.03
        assert below_the_curve(channel)


@rows("name, choices", OTHERS, ids=lambda x: x.split("/")[-1] if isinstance(x, str) else "")
def test_other_sensors_at_rest_have_a_graded_answer(recordings, name, choices):
    for channel in al.analyze(recordings / name, al.Recipe(**choices)).channels:
        assert channel.noise.validity in ("explained", "approximate")
        assert math.isclose(channel.fit["N"].value, second(channel.record), rel_tol=0.1)
        assert below_the_curve(channel)


def test_a_swaying_gyroscope_has_no_result(recordings):
    for channel in al.analyze(recordings / "psins_lasergyro.imu").channels:
        assert channel.noise.validity == "unexplained"
        assert not any(e.claimed for e in channel.fit)
        if channel.record.name.startswith("g"):
            assert sum(c.name == "resonance" and c.claimed for c in channel.fit.components) > 5


@rows("name, choices", [row[:2] for row in script.RECORDINGS if row[2] == "adis16405"][:1])
def test_a_channel_beside_its_data_sheet_is_as_in_the_table(recordings, name, choices):
    channel, every = "Gyro. X", read("recordings.md").rows("Data sheets")
    rows = [row for row in every if (row["file"], row["channel"]) == (name, channel)]
    found = al.comparison.compare_with_sheet(recordings / name, "adis16405", channels=(channel,), **choices)
    measured = {m.claim.printed: m.ratio[0] for m in found.measured(found[channel])}
    assert {row["quantity"]: pytest.approx(float(row["ratio"]), rel=0.01) for row in rows} == measured


DISPUTED = {
    ("cubeorange_sample_log_small.ulg", "accelerometer_m_s2[1]"),  # 6.5 s; the flat part is one octave beyond a line
    ("cubeorange_sample_log_small.ulg", "gyro_rad[1]"),  # the flat part is behind the filter; N is the level below
    ("imu_tk_xsens_gyro.mat", "column 2"),  # the flat part is behind the filter; N is the deviation at 1 s within 2 %
}
"""Channels whose N contradicts the white level, and why."""


def test_claims_are_what_an_expert_reads_off_the_record():
    wrong = [row for row in read("recordings.md").rows("Channels") if row["verdict"].startswith("wrong")]
    assert {(row["file"], row["channel"]) for row in wrong} == DISPUTED
