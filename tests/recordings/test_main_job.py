"""The main job on real recordings: figures computed independently, and the words that must stand above the numbers."""

import json
import lzma

import numpy as np
import pytest
from tests import all_but
from tests.commands import run
from tests.rows import rows

import allanite as al

pytestmark = pytest.mark.usefixtures("analyzed_once")


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
    for channel in channels:  # the carrier sways: what stands in a band of little power is no answer
        assert channel["validity"] == "unexplained"
        terms = channel["fit"]["terms"]
        assert [t["symbol"] for t in terms][:5] == list("QNBKR")
        assert {t["status"] for t in terms} == {"not valid"}


def matrix(path):
    """The one matrix of numbers in an R data file, shape (1000000, 6): big-endian, after its length."""
    raw = lzma.decompress(path.read_bytes())
    start = raw.index((6_000_000).to_bytes(4, "big")) + 4
    return np.frombuffer(raw, ">f8", 6_000_000, start).reshape(6, -1).T.astype(float)


@pytest.mark.slow("takes more than half a second")
def test_every_number_of_a_matrix_of_r_is_read(recordings):
    path = recordings / "adis_16405_imu1.rda"
    read = np.column_stack([channel.record.values for channel in al.analyze(path, unit="gyro=deg/s,accel=g")])
    np.testing.assert_array_equal(read, matrix(path))
    assert al.read(path, unit="g").channels == ("Accel. X", "Accel. Y", "Accel. Z")


@pytest.mark.slow("takes more than half a second")
@rows("name", all_but(["Gyro. X", "Gyro. Y", "Gyro. Z"], ["Gyro. X", "Gyro. Y"], "long records"))
def test_a_filter_is_found_or_left_out(recordings, name):
    channel = al.analyze(recordings / "adis_16405_imu1.rda", unit="gyro=deg/s,accel=g")[name]
    plain = al.identify(channel.record, band="all")
    assert plain.validity == "unexplained"
    assert "the spectrum rolls off" in plain.goodness.verdict
    behind, below = channel.fit, al.identify(channel.record, band=(0, 5))
    assert behind.validity == "explained"
    if name == "Gyro. Z":  # a resonance at 20 Hz hides how the filter begins
        assert any(c.name == "resonance" and c.claimed for c in behind.components)
        assert 29 < behind.scope.filter.cutoff < 38
    else:
        assert 35 < behind.scope.filter.cutoff < 38
    at_one_second = al.deviation(channel.record, m=[100]).deviation[0]
    assert below["N"].value == pytest.approx(at_one_second, rel=0.10)
    assert behind["N"].value == pytest.approx(at_one_second, rel=0.03)
    assert below["N"].status == "identified"
