"""TDMS files: groups, units and time steps from properties, and what is damaged."""

import numpy as np
import pytest
from tests.commands import run
from tests.rows import refused, rows

import allanite as al

nptdms = pytest.importorskip("nptdms")
GYRO = np.random.default_rng(4).normal(size=(500, 3))


def tdms(path, *channels):
    with nptdms.TdmsWriter(path) as writer:
        writer.write_segment([nptdms.ChannelObject(*channel) for channel in channels])
    return path


def waveform(unit, step=0.01):
    return {"wf_increment": step, "wf_start_offset": 0.5, "unit_string": unit}


@pytest.fixture
def runs(tmp_path):
    channels = [("Run 1", f"gyro {axis}", GYRO[:, i], waveform("deg/s")) for i, axis in enumerate("xyz")]
    channels += [("Run 1", "temperature", np.full(5, 20.0), waveform("degC", 1.0)), ("Run 1", "note", ["a", "b"], {})]
    channels += [("Run 2", "gyro x", GYRO[:300, 0].astype("f4"), waveform("deg/s", 0.002))]
    return tdms(tmp_path / "a.tdms", *channels)


@pytest.mark.slow("takes more than half a second")
def test_groups_are_listed_and_chosen(runs):
    words = r"2 tables.*\(Run 1/1 \(500 rows at 100 Hz\), Run 2 \(300 rows at 500 Hz\)\).*channels='Run 1/1'"
    refused(al.UsageError, words, lambda: al.read(runs))
    recording = al.read(runs, channels=["Run 1/1"])
    assert recording.channels == ("gyro x", "gyro y", "gyro z")
    assert (recording[0].rate, recording[0].unit, recording[0].start) == (100.0, "deg/s", 0.5)
    assert "rate 100.0 Hz from the property wf_increment of the channels" in recording.notes
    assert al.read(runs, channels=["Run 2"])[0].size == 300
    assert al.read(runs, channels=["Run 2/gyro x"])[0].rate == 500.0


def test_the_samples_are_those_of_nptdms(runs):
    with nptdms.TdmsFile.open(runs) as file:
        for axis in "xyz":
            channel = file["Run 1"][f"gyro {axis}"]
            assert np.array_equal(al.read(runs, channels=[f"Run 1/1/gyro {axis}"])[0].values, channel[:])


def test_time_stamps_in_a_channel(tmp_path):
    stamps = np.datetime64("2026-01-02T03:04:05", "us") + np.arange(500) * np.timedelta64(20_000, "us")
    path = tdms(tmp_path / "a.tdms", ("Run", "time", stamps, {}), ("Run", "gyro_x_dps", GYRO[:, 0], {}))
    recording = al.read(path)
    assert recording[0].rate == pytest.approx(50.0)
    assert np.array_equal(recording[0].values, GYRO[:, 0])
    # several segments and an index of another file
    with nptdms.TdmsWriter(path) as writer:
        for part in np.split(GYRO[:, 0], 5):
            writer.write_segment([nptdms.ChannelObject("Run", "gx", part, waveform("deg/s"))])
    (tmp_path / "a.tdms_index").write_bytes(b"TDSh" + bytes(40))
    assert np.array_equal(al.read(path)[0].values, GYRO[:, 0])


@pytest.mark.slow("takes more than half a second")
@rows("change, words", [
    (lambda whole: whole[:100], "damaged or incomplete: nptdms failed|no rows of numbers"),
    (lambda _: bytes(100), "does not begin like a TDMS file"),
    (lambda whole: whole[:28] + b"\xff" * 40 + whole[68:], "damaged or incomplete: nptdms failed"),
])  # fmt: skip
def test_damaged_files(runs, write, change, words):
    path = write(change(runs.read_bytes()), "b.tdms")
    refused(al.DataError, words, lambda: al.read(path))
    run("info", path, code=3)
