"""The main job on real recordings: figures computed independently, and the words that must stand above the numbers."""

import csv
import json
import lzma

import numpy as np
import pytest
from tests import all_but
from tests.commands import run
from tests.rows import rows

import allanite as al
from allanite.prepare import trim


def reference(folder, file, channel):
    """Octave overlapped deviations computed by others: m, deviation, unit."""
    with (folder / "reference_oadev.csv").open() as table:
        rows = [row for row in csv.DictReader(table) if (row["file"], row["channel"]) == (file, channel)]
    return [int(r["m"]) for r in rows], np.array([float(r["oadev"]) for r in rows]), rows[0]["unit"]


@pytest.fixture(scope="module")
def laser(recordings):
    return al.read(recordings / "psins_lasergyro.imu")


FIRST = {"gx": 0.1, "gy": 0.1, "gz": 0.1, "ax": 125.0, "ay": 125.0, "az": 125.0}
"""The row of scale factors: the reference took it for the first reading."""


@rows("channel", list(FIRST))
def test_laser_gyro_deviations(recordings, laser, channel):
    m, deviation, unit = reference(recordings, "psins_lasergyro.imu", channel)
    found = al.deviation(laser[channel], m=m).to(unit).deviation
    # one reading more at the start of 184 718: a part in a thousand of a vibrating accelerometer at the longest times
    np.testing.assert_allclose(found, deviation, rtol=2e-4 if channel[0] == "g" else 2e-2)
    record = laser[channel]
    theirs = np.concatenate(([FIRST[channel]], record.values)) * record.scale
    same = al.Record(theirs, record.rate, record.unit, kind="increment")
    np.testing.assert_allclose(al.deviation(same, m=m).to(unit).deviation, deviation, rtol=2e-8)


@rows("channel", ["gx", "gy", "gz"])
def test_laser_gyro_quiet_window(recordings, laser, channel):
    m, deviation, unit = reference(recordings, "psins_lasergyro.imu[600-900s]", channel)
    window = trim(laser, 600, 900)[channel]
    assert window.size == 30_000
    # their window begins one reading earlier, for the same reason
    np.testing.assert_allclose(al.deviation(window, m=m).to(unit).deviation, deviation, rtol=3e-4)
    values = laser[channel].values[59_999:89_999]
    same = al.Record(values, 100.0, "arcsec", kind="count", scale=0.1)
    np.testing.assert_allclose(al.deviation(same, m=m).to(unit).deviation, deviation, rtol=2e-8)


@pytest.mark.slow("takes more than half a second")
@rows("window", all_but([[], ["--from", "600", "--until", "900"]], [[]], "the page of two hours"))
def test_from_the_file_to_the_page(recordings, tmp_path, window):
    page, figure, data = (tmp_path / name for name in ("page.html", "curve.svg", "study.json"))
    command = ["analyze", str(recordings / "psins_lasergyro.imu"), "--channels", "gx,gy,gz", *window]
    command += ["--report", str(page), "--plot", str(figure), "--json", str(data)]
    result = run(*command, code=0)
    said = " ".join(result.stdout.split())
    assert said.index("no model of these terms explains the record") < said.index("angle random walk")
    html = page.read_text()
    assert html.index("no model of these terms explains the record") < html.index("angle random walk")
    assert "<svg" in figure.read_text()
    channels = json.loads(data.read_text())["channels"]
    assert [channel["name"] for channel in channels] == ["gx", "gy", "gz"]
    assert [[t["symbol"] for t in channel["fit"]["terms"]] for channel in channels] == [list("QNBKR")] * 3
    for channel in channels:  # the carrier sways: what stands in a band of little power is no answer
        assert channel["validity"] == "unexplained"
        assert [t["symbol"] for t in channel["fit"]["terms"] if t["status"] == "not valid"] == list("QNBKR")


def matrix(path):
    """The one matrix of numbers in an R data file, shape (1000000, 6): big-endian, after its length."""
    raw = lzma.decompress(path.read_bytes())
    start = raw.index((6_000_000).to_bytes(4, "big")) + 4
    return np.frombuffer(raw, ">f8", 6_000_000, start).reshape(6, -1).T.astype(float)


@pytest.mark.slow("takes more than half a second")
def test_a_filter_is_found_or_left_out(recordings, tmp_path):
    np.save(tmp_path / "adis.npy", matrix(recordings / "adis_16405_imu1.rda")[:, :3])
    recording = al.read(tmp_path / "adis.npy", rate=100.0, unit="deg/s", kind="rate")
    for record, channel in zip(recording, ("gx", "gy", "gz"), strict=True):
        m, deviation, _ = reference(recordings, "adis_16405_imu1.rda", channel)
        np.testing.assert_allclose(al.deviation(record, m=m).to("deg/s").deviation, deviation, rtol=2e-8)
        plain = al.identify(record, band="all")
        assert plain.validity == "unexplained"
        assert "the spectrum rolls off" in plain.goodness.verdict
        behind = al.identify(record)
        assert behind.validity == "explained"
        if channel == "gz":  # a resonance at 20 Hz hides how the filter begins
            assert any(c.name == "resonance" and c.claimed for c in behind.components)
            assert 29 < behind.scope.filter.cutoff < 38
        else:
            assert 35 < behind.scope.filter.cutoff < 38
        below = al.identify(record, band=(0, 5))
        at_one_second = al.deviation(record, m=[100]).deviation[0]
        assert below["N"].value == pytest.approx(at_one_second, rel=0.10)
        assert behind["N"].value == pytest.approx(at_one_second, rel=0.03)
        assert below["N"].status == "identified"
