"""The first answer on real recordings, by the default recipe, and beside a data sheet: parts of committed tables."""

from table import read

import math

import pytest
from tests import all_but
from tests.recordings.test_every_recording import FILES, MPU
from tests.rows import rows

import allanite as al

pytestmark = [pytest.mark.slow("analyses of long recordings"), pytest.mark.usefixtures("analyzed_once")]

OPTIONS = {file.name: file.options for file in FILES}


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


@rows("name", all_but(["adis_16405_imu1.rda", "adis_16405_imu2.rda"], ["adis_16405_imu2.rda"]))
def test_gyroscopes_with_a_filter_are_explained_and_N_is_what_the_curve_shows(recordings, name):
    for channel in al.analyze(recordings / name, **OPTIONS[name]).channels[:3]:
        assert channel.noise.validity in ("explained", "approximate")  # the bias of some steps
        assert not channel.fit.scope.whole
        assert abs(channel.fit["N"].value / second(channel.record) - 1) < 0.03
        assert below_the_curve(channel)


@rows("name", [f"{MPU}mpu6050_gyroscope.mat", f"{MPU}mpu6050_accelerometer.mat", "phone_gyro4.txt"])
def test_other_sensors_at_rest_have_a_graded_answer(recordings, name):
    for channel in al.analyze(recordings / name, **OPTIONS[name]):
        assert channel.noise.validity in ("explained", "approximate")
        assert math.isclose(channel.fit["N"].value, second(channel.record), rel_tol=0.1)
        assert below_the_curve(channel)


def test_a_swaying_gyroscope_has_no_result(recordings):
    for channel in al.analyze(recordings / "psins_lasergyro.imu").channels:
        assert channel.noise.validity == "unexplained"
        assert not any(e.claimed for e in channel.fit)
        if channel.record.name.startswith("g"):
            assert sum(c.name == "resonance" and c.claimed for c in channel.fit.components) > 5


def test_a_channel_beside_its_data_sheet_is_as_in_the_table(recordings):
    name, channel = "adis_16405_imu1.rda", "Gyro. X"
    table = [row for row in read("recordings.md").rows("Data sheets") if row["file"] == name]
    printed = {row["quantity"]: float(row["ratio"]) for row in table if row["channel"] == channel}
    beside = al.comparison.compare_with_sheet(recordings / name, "adis16405", **OPTIONS[name])
    measured = {m.claim.printed: m.ratio[0] for m in beside.measured(beside[channel])}
    assert measured == pytest.approx(printed, rel=0.01)


DISPUTED = {
    ("cubeorange_sample_log_small.ulg", "accelerometer_m_s2[1]"),  # 6.5 s; the flat part is one octave beyond a line
    ("cubeorange_sample_log_small.ulg", "gyro_rad[1]"),  # the flat part is behind the filter; N is the level below
    ("imu_tk_xsens_gyro.mat", "column 2"),  # the flat part is behind the filter; N is the deviation at 1 s within 2 %
}
"""Channels whose N contradicts the white level, and why."""


def test_claims_are_what_an_expert_reads_off_the_record():
    wrong = [row for row in read("recordings.md").rows("Channels") if row["verdict"].startswith("wrong")]
    assert {(row["file"], row["channel"]) for row in wrong} == DISPUTED
