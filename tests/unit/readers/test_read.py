"""The door of the readers: what is refused, in which words, and what the table of formats promises."""

import hashlib
import os
from pathlib import Path

import numpy as np
import pytest
from tests.rows import paired, refused, rows

from allanite.core.errors import AllaniteError, DataError, UnitError, UsageError
from allanite.readers import read
from allanite.readers.formats.registry import READERS, reader_named

GOOD = "time [s],gx [deg/s]\n0.00,1.5\n0.01,1.25\n0.02,1.75\n"


@pytest.fixture
def write(tmp_path):
    def write(content, name="gyro.csv"):
        path = tmp_path / name
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        return path

    return write


def test_source_and_digest(write, monkeypatch):
    path = write(GOOD)
    recording = read(path)
    assert recording.source == str(path)
    assert recording.digest == hashlib.sha256(GOOD.encode()).hexdigest()
    assert read(str(path)).source == str(path)
    monkeypatch.chdir(path.parent)
    assert read("gyro.csv").source == "gyro.csv"


@rows("name", READERS)
def test_table_of_formats(name):
    assert reader_named(name).TITLE
    assert not READERS[name].sniff(b"", "")
    assert not READERS[name].sniff(b"\x00\x01\x02" * 100, ".bin")


def test_what_is_not_a_file_is_refused(tmp_path):
    refused(DataError, "no such file", lambda: read(tmp_path / "absent.csv"))
    refused(DataError, "directory", lambda: read(tmp_path))
    with pytest.raises(DataError):
        read("nul\0l")
    refused(UsageError, "path", lambda: read(7))


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_a_pipe_is_refused_and_does_not_hang(tmp_path):
    os.mkfifo(tmp_path / "pipe.csv")
    refused(DataError, "pipe", lambda: read(tmp_path / "pipe.csv"))


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="this system has no /dev/zero")
def test_a_device_is_refused():
    refused(DataError, "not a regular file", lambda: read("/dev/zero"))


def test_no_permission(write, monkeypatch):
    path = write(GOOD)

    def refuse(*_, **__):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "open", refuse)
    refused(DataError, "Permission denied", lambda: read(path))


@rows(
    "name, content",
    paired(
        ["a.csv", "a.npy", "a.npz", "a.txt", "a.imu", "a.bin", "a"],
        [
            b"", b"\n\n", np.random.default_rng(1).bytes(5000), b"\x00" * 3000, b"time,gx\n",
            b"# nothing\n# at all\n",
            b"1.0\n",
        ],
    ),
)  # fmt: skip
def test_useless_content_is_refused_in_words(write, name, content):
    with pytest.raises(AllaniteError) as caught:
        read(write(content, name), rate=100, unit="deg/s")
    assert name in str(caught.value)
    assert len(str(caught.value)) > 40


@pytest.mark.slow("takes more than half a second")
def test_rows_of_thousands_of_numbers_are_refused(write):
    row = b"1.5," * 1500
    refused(DataError, "one row per sample", lambda: read(write((row + b"\n") * 2000), rate=100, unit="deg/s"))


@rows("options, error, words", [
    *(({"rate": rate}, UsageError, "rate") for rate in (0, -1.0, float("nan"), float("inf"), "100", True, [100])),
    *(({"scale": scale}, UsageError, "scale") for scale in (0, -1.0, float("nan"), "one", "-1", "deg/s")),
    ({"unit": "furlong"}, UnitError, "deg/s, deg/h, rad/s"),
    ({"kind": "speed"}, UsageError, "known kinds: rate, increment"),
    ({"kind": "increment"}, UsageError, "does not match kind 'increment'"),
    ({"channels": ["gq"]}, UsageError, r"no column 'gq'.*1: time \[s\].*2: gx \[deg/s\]"),
    ({"channels": []}, UsageError, "no channel"), ({"channels": ["gx", "2"]}, UsageError, "twice"),
    ({"channels": ["time"], "time": "time", "unit": "deg/s"}, UsageError, "time and as a channel"),
])  # fmt: skip
def test_impossible_options_are_refused_in_words(write, options, error, words):
    refused(error, words, lambda: read(write(GOOD), **options))


def test_missing_rate_and_unit_are_asked_for_together(write):
    with pytest.raises(UsageError) as caught:
        read(write("gx,gy\n" + "1.5,2.5\n" * 20))
    for words in ("rate=100", "unit=", "'gx', 'gy'"):
        assert words in str(caught.value)


def test_counts_need_a_scale(write):
    with pytest.raises(UsageError, match=r"scale=0\.1"):
        read(write("gx\n" + "1\n2\n" * 20), rate=100, unit="arcsec", kind="count")
