"""A real laser-gyro recording in PSINS text: figures found independently of this package."""

import math

import numpy as np
import pytest
from tests.rows import rows

from allanite.readers import read

DEG_PER_HOUR = 180 / math.pi * 3600


@pytest.fixture(scope="module")
def laser(recordings):
    return read(recordings / "psins_lasergyro.imu")


def test_needs_no_option(laser):
    assert laser.channels == ("gx", "gy", "gz", "ax", "ay", "az")
    assert {(r.kind, r.rate, r.values.dtype.name) for r in laser} == {("count", 100.0, "int64")}
    assert [(r.unit, r.scale) for r in laser] == [("arcsec", 0.1)] * 3 + [("ug*s", 125.0)] * 3


def test_every_row_is_there(laser):
    # 184732 lines: 10 comments, 1 blank, 3 header rows
    assert {r.size for r in laser} == {184718}
    assert laser["gx"].values[:7].tolist() == [0, 0, 0, 0, 2, 2, -4]
    assert [int(r.values[-1]) for r in laser] == [2, -4, 7, 0, 2, 80]


@rows("name, rate", [("gx", -12.271), ("gy", 0.438), ("gz", 8.357)])
def test_mean_rates(laser, name, rate):
    assert np.mean(laser[name].rate_values) * DEG_PER_HOUR == pytest.approx(rate, abs=6e-4)


def test_earth_rate_and_gravity_are_resolved(laser):
    horizontal = math.hypot(*(np.mean(laser[name].rate_values) * DEG_PER_HOUR for name in ("gx", "gy")))
    assert horizontal == pytest.approx(12.43, rel=0.02)  # Earth rate times the cosine of the latitude, 34.246 deg
    force = math.hypot(*(np.mean(laser[name].rate_values) for name in ("ax", "ay", "az")))
    assert force / 9.80665 == pytest.approx(1.00155, abs=1e-5)


def test_says_what_it_took_from_the_file(laser):
    assert any("9.78033" in note for note in laser.notes)
    assert any("rate 100.0 Hz" in note and "second header row" in note for note in laser.notes)
    assert any("kind count of 0.1 arcsec" in note for note in laser.notes)


def test_options_win(recordings):
    path = recordings / "psins_lasergyro.imu"
    gyro = read(path, rate=125, scale=0.05, channels=["gz"])["gz"]
    assert (gyro.rate, gyro.scale, gyro.unit, gyro.kind) == (125.0, 0.05, "arcsec", "count")
    asked = read(path, unit="deg", scale=1e-4, kind="increment")
    assert (asked["gx"].unit, asked["gx"].kind, asked["gx"].scale) == ("deg", "increment", 1e-4)
    assert (asked["ax"].unit, asked["ax"].kind, asked["ax"].scale) == ("ug*s", "count", 125.0)


def test_phone_text_with_dates(recordings):
    phone = read(recordings / "phone_gyro4.txt", rate=5, unit="rad/s")
    assert phone.channels == ("column 3", "column 4", "column 5")
    assert {r.size for r in phone} == {38577}
    assert [float(np.std(r.values)) for r in phone] == pytest.approx([0.00119, 0.00106, 0.00102], abs=6e-6)


def test_fog_text_with_a_time_column_and_dates_around(recordings):
    fog = read(recordings / "aegiverse_fog_0917.txt", unit="deg/h")
    assert fog.channels == ("fog",)
    assert fog["fog"].rate == pytest.approx(100.03, abs=0.01)
    assert len(np.unique(fog["fog"].values)) == 5
