"""The door of the readers: what is refused, in which words, and what the table of formats promises."""

import hashlib
import os
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest
from tests.rows import paired, refused, rows

from allanite.core.errors import AllaniteError, DataError, UnitError, UsageError
from allanite.readers import read
from allanite.readers.formats.registry import READERS, reader_named

GOOD = "time [s],gx [deg/s]\n0.00,1.5\n0.01,1.25\n0.02,1.75\n"


def test_source_and_digest(write, monkeypatch):
    path = write(GOOD)
    assert read(path).digest == hashlib.sha256(GOOD.encode()).hexdigest()
    assert read(path).source == read(str(path)).source == str(path)
    monkeypatch.chdir(path.parent)
    assert read("gyro.csv").source == "gyro.csv"


@rows("name", READERS)
def test_table_of_formats(name):
    assert reader_named(name).TITLE
    assert not READERS[name].sniff(b"", "")
    assert not READERS[name].sniff(b"\x00\x01\x02" * 100, ".bin")


def test_what_is_no_path_is_refused():
    refused(DataError, "nul", lambda: read("nul\0l"))
    refused(UsageError, "path", lambda: read(7))


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="this system has no named pipes and devices")
def test_a_pipe_or_a_device_is_refused_and_does_not_hang(tmp_path):
    os.mkfifo(tmp_path / "pipe.csv")
    refused(DataError, "pipe", lambda: read(tmp_path / "pipe.csv"))
    refused(DataError, "not a regular file", lambda: read("/dev/zero"))


def test_no_permission(write, monkeypatch):
    path = write(GOOD)
    monkeypatch.setattr(Path, "open", Mock(side_effect=PermissionError(13, "Permission denied")))
    refused(DataError, "Permission denied", lambda: read(path))


NAMES = ["a.csv", "a.npy", "a.npz", "a.txt", "a.imu", "a.bin", "a"]
NOISE = np.random.default_rng(1).bytes(5000)
USELESS = [b"", b"\n\n", NOISE, b"\x00" * 3000, b"time,gx\n", b"# nothing\n# at all\n", b"1.0\n"]


@rows("name, content", paired(NAMES, USELESS))
def test_useless_content_is_refused_in_words(write, name, content):
    refused(AllaniteError, f"/{name}: .{{20}}", lambda: read(write(content, name), rate=100, unit="deg/s"))


@pytest.mark.slow("takes more than half a second")
def test_rows_of_thousands_of_numbers_are_refused(write):
    row = b"1.5," * 1500
    refused(DataError, "one row per sample", lambda: read(write((row + b"\n") * 2000), rate=100, unit="deg/s"))


@rows("options, error, words", [
    *(({"rate": rate}, UsageError, "rate") for rate in (0, -1.0, float("nan"), float("inf"), "100", True, [100])),
    *(({"scale": scale}, UsageError, "scale") for scale in (0, -1.0, float("nan"), "one", "-1", "deg/s")),
    ({"unit": "furlong"}, UnitError, "deg/s, deg/h, rad/s"),
    ({"kind": "increment"}, UsageError, "does not match kind 'increment'"),
    ({"channels": ["gq"]}, UsageError, r"no column 'gq'.*1: time \[s\].*2: gx \[deg/s\]"),
    ({"channels": []}, UsageError, "no channel"), ({"channels": ["gx", "2"]}, UsageError, "twice"),
    ({"channels": ["time"], "time": "time", "unit": "deg/s"}, UsageError, "time and as a channel"),
])  # fmt: skip
def test_impossible_options_are_refused_in_words(write, options, error, words):
    refused(error, words, lambda: read(write(GOOD), **options))


def test_what_is_missing_is_asked_for(write):
    refused(UsageError, "rate=100.*'gx', 'gy'.*unit=", lambda: read(write("gx,gy\n" + "1.5,2.5\n" * 20)))
    path = write("gx\n" + "1\n2\n" * 20)
    refused(UsageError, r"scale=0\.1", lambda: read(path, rate=100, unit="arcsec", kind="count"))
