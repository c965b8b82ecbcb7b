"""MDF files: groups and their clocks, conversions, and what is damaged."""

import struct
import tempfile
import warnings

import numpy as np
import pytest
from tests.commands import run
from tests.rows import refused

import allanite as al
from allanite.core.errors import DataError, UsageError

pytestmark = pytest.mark.slow("files that a library of a second start time reads")

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    asammdf = pytest.importorskip("asammdf")

GYRO, TIMES = np.random.default_rng(2).normal(size=(500, 2)), np.arange(500) * 0.01
COUNTS = np.arange(500, dtype="i2") % 97


@pytest.fixture(params=["4.10 packed", "3.30"])
def mdf(request, tmp_path):
    version, _, packed = request.param.partition(" ")
    with asammdf.MDF(version=version) as file:
        counts = asammdf.Signal(COUNTS, TIMES, "deg/s", "gy", conversion={"a": 0.5, "b": 1.0})
        file.append([asammdf.Signal(GYRO[:, 0], TIMES, "deg/s", "gx"), counts])
        file.append([asammdf.Signal(GYRO[:, 1], TIMES, "deg/s", "gz")])
        file.append([asammdf.Signal(GYRO[:300, 0], TIMES[:300] * 5, "m/s^2", "acc")])
        file.append([asammdf.Signal(GYRO[:, 0], TIMES + 7, "km/h", "speed", conversion={"formula": "X1 * 2"})])
        file.append([asammdf.Signal(np.array([b"on"] * 500), TIMES, "", "word", encoding="utf-8")])
        return file.save(tmp_path / ("a.mf4" if version > "4" else "a.mdf"), compression=2 if packed else 0)


def test_groups_with_common_times_are_one_and_others_are_listed(mdf):
    words = r"2 tables.*\(group 0 \(500 rows at 100 Hz\), group 2 \(300 rows at 20 Hz\)\).*channels='group 0'"
    refused(UsageError, words, lambda: al.read(mdf))
    recording = al.read(mdf, channels=["group 0"])
    assert (recording.channels, recording[0].rate) == (("gx", "gy", "gz"), pytest.approx(100.0))
    assert (recording[0].unit, recording[0].size) == ("deg/s", 500)
    assert np.array_equal(recording["gz"].values, GYRO[:, 1])
    assert np.array_equal(recording["gy"].values, COUNTS * 0.5 + 1)
    assert any("no numbers, or numbers converted by a formula: " in note for note in recording.notes)
    assert al.read(mdf, channels=["group 0/gz"]).channels == ("gz",)


def test_the_samples_are_those_of_asammdf(mdf):
    found = al.read(mdf, channels=["acc"])
    assert found[0].rate == pytest.approx(20.0)
    with asammdf.MDF(mdf) as file:
        assert np.array_equal(found[0].values, file.get("acc").samples)
        assert np.array_equal(COUNTS * 0.5 + 1, file.get("gy").samples)


def test_damaged_files(tmp_path):
    (tmp_path / "b.mf4").write_bytes(bytes(100))
    refused(DataError, "does not begin like an MDF file", lambda: al.read(tmp_path / "b.mf4"))
    (tmp_path / "b.mf4").write_bytes(b"MDF     4.10    " + bytes(200))
    refused(DataError, r"damaged or incomplete: asammdf failed|no rows of numbers", lambda: al.read(tmp_path / "b.mf4"))
    run("info", tmp_path / "b.mf4", code=3)


@pytest.mark.parametrize("mdf", ["4.10 packed"], indirect=True)
def test_an_ended_reader_leaves_no_file(mdf, tmp_path, monkeypatch):
    raw = bytearray(mdf.read_bytes())
    (group,) = struct.unpack_from("<Q", raw, 88)
    assert raw[group : group + 4] == b"##DG"
    struct.pack_into("<Q", raw, group + 24, group)  # the list of groups never ends
    mdf.write_bytes(raw)
    (tmp_path / "temporary").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))
    monkeypatch.setenv("TMPDIR", str(tmp_path / "temporary"))
    refused(DataError, "or this computer is busy: .* it took too long", lambda: al.read(mdf))
    assert not list((tmp_path / "temporary").iterdir())
