"""Text read in parts: the samples, notes and refusals of the same text read as a whole."""

import bz2
import gzip
import lzma
import subprocess
import sys
import zipfile

import numpy as np
import pytest
from tests.rows import refused, rows
from tests.unit.readers.checks import assert_as_whole, gathered

import allanite as al
from allanite.readers.columns import layout, lines
from allanite.readers.formats import text
from allanite.readers.options import Options
from allanite.readers.parts import opened

N = 9000  # rows: more than the first part has, so that several follow

STAMPS = np.datetime64("2024-03-11T23:59:30.125", "ns") + np.arange(N) * np.timedelta64(10_000_000, "ns")
GX, GY = np.random.default_rng(3).normal(size=(2, N)).round(6)


def cells(*columns, sep=","):
    return "".join(sep.join(map(str, row)) + "\n" for row in zip(*columns, strict=True))


def dated(stamps, form):
    return [stamp.item().strftime(form) for stamp in stamps.astype("M8[us]")]


def broken(content, row, line):
    """The text with another line in the place of a row."""
    return "\n".join(line if i == row else old for i, old in enumerate(content.split("\n")))


TIME = [f"{i / 100:.2f}" for i in range(N)]
PLAIN = "time [s],gx [deg/s],gy [deg/s]\n" + cells(TIME, GX, GY)
DAYS = STAMPS[0] + np.arange(N) * np.timedelta64(100, "s")  # ten days: the thirteenth shows which number is the day
CLOCK = dated(STAMPS - np.timedelta64(60, "s"), "%H:%M:%S.%f")  # over midnight
UNIT = {"unit": "deg/s"}

CASES = {
    "a header": (PLAIN, {}),
    "no header": (cells(TIME, GX, GY), UNIT | {"rate": 100.0}),
    "semicolons and decimal commas": ("t [s];gx [deg/s]\n" + cells(TIME, GX, sep=";").replace(".", ","), {}),
    "blanks": (cells(TIME, GX, GY, sep="   "), UNIT | {"rate": 100.0}),
    "comments, and lines without cells": (PLAIN.replace("\n88.00,", "\n# here\n\n   \n88.00,"), {}),
    "carriage returns and newlines": (PLAIN.replace("\n", "\r\n"), {}),
    "carriage returns": (PLAIN.replace("\n", "\r"), {}),
    "missing cells": ("time [s],gx [deg/s]\n" + cells(TIME, ["" if i % 97 == 5 else x for i, x in enumerate(GX)]), {}),
    "a plus sign, late": (broken(PLAIN, 8500, "84.99,+1.5,  "), {}),
    "whole numbers at first": ("t [s],gx [deg/s]\n" + cells(TIME, [*range(8000), *GX[8000:]]), {}),
    "whole numbers": ("t [s],gx [deg/s]\n" + cells(TIME, (GX * 1000).astype(int)), {}),
    "words": ("time [s],state,gx [deg/s]\n" + cells(TIME, ["idle"] * 8000 + ["run"] * 1000, GX), {}),
    "dates": ("date,gx [deg/s]\n" + cells(dated(STAMPS, "%Y-%m-%d %H:%M:%S.%f"), GX), {}),
    "dates with the day first": ("date,gx [deg/s]\n" + cells(dated(DAYS, "%d.%m.%Y %H:%M:%S"), GX), {}),
    "dates with the month first, seen late": ("date,gx [deg/s]\n" + cells(dated(DAYS, "%m/%d/%Y %H:%M:%S"), GX), {}),
    "date and time apart": (
        "date,time,gx [deg/s]\n" + cells(dated(STAMPS, "%Y/%m/%d"), dated(STAMPS, "%H:%M:%S.%f"), GX), {},
    ),
    "times of day over midnight": ("time,gx [deg/s]\n" + cells(CLOCK, GX), {}),
    "midnight every hundred rows": ("time,gx [deg/s]\n" + cells(dated(DAYS, "%H:%M:%S"), GX), {}),
    "seconds and nanoseconds": (
        "sec,nanosec,gx [deg/s]\n" + cells(10**9 + np.arange(N) // 100, np.arange(N) % 100 * 10**7, GX), {},
    ),
    "a rate above the numbers": ("# Sample rate: 100 Hz\ngx [deg/s],gy [deg/s]\n" + cells(GX, GY), {}),
    "a last line that is cut off": (PLAIN + "90.00,1", {}),
    "a gap": (PLAIN.replace(cells(TIME[7000:7100], GX[7000:7100], GY[7000:7100]), ""), {}),
    "damaged stamps": (broken(broken(PLAIN, 5001, "0.00,1,2"), 7501, "974.99,3,4"), {}),
    "the last stamp": (broken(PLAIN, N, "9.99,1,2"), {}),
    "latin letters": (PLAIN.replace("deg/s", "°/s").encode("latin-1"), {}),
    "UTF-16": (PLAIN.encode("utf-16"), {}),
    "a byte order mark": (PLAIN.encode("utf-8-sig") + b"\x1a", {}),
    "sentences with checksums": (
        cells(["$IMU"] * N, TIME, GX, GY).replace("\n", "*5A\r\n"),
        UNIT | {"channels": ["3", "4"], "rate": 100.0, "time": "none"},
    ),
    "a word among the numbers": (broken(PLAIN, 8123, "81.22,oops,1"), {}),
    "a row that is too short": (broken(PLAIN, 8123, "81.22,1"), {}),
    "a time of another form": (broken("time,gx [deg/s]\n" + cells(CLOCK, GX), 8123, "noon,1"), {}),
    "a zero byte": (PLAIN[:200_000].encode() + b"\x00" + PLAIN[200_000:].encode(), {}),
}  # fmt: skip


REFUSED = ("a word among the numbers", "a row that is too short", "a time of another form", "a zero byte")


def refusal(work):
    with pytest.raises(al.AllaniteError) as error:
        work()
    return f"{error.type.__name__}: {error.value}".removeprefix("DataError: ")


@pytest.fixture(autouse=True)
def short_parts(monkeypatch):
    monkeypatch.setattr(layout, "HEAD", 20_000)
    monkeypatch.setattr(lines, "FIRST", 40_000)
    monkeypatch.setattr(lines, "BLOCK_BYTES", 20_000)


def file_of(folder, content):
    path = folder / "a.csv"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


@rows("case", CASES)
def test_records_in_parts_are_those_of_the_whole(case, tmp_path):
    content, choices = CASES[case]
    path = file_of(tmp_path, content)
    if case in REFUSED:
        said = refusal(lambda: al.read(path, **choices)).removeprefix(f"{path}: ")
        assert refusal(lambda: gathered(path, 4096, choices)).removeprefix(f"{path}: ") == said
    else:
        assert_as_whole(path, 4096, choices, strict=True)


@pytest.fixture(scope="module")
def packed(tmp_path_factory):
    """A folder of the text in each packing."""
    folder = tmp_path_factory.mktemp("packed")
    with zipfile.ZipFile(folder / "a.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("readme.md", "not this")
        archive.writestr("b.csv.gz", gzip.compress(PLAIN.encode()))
    for suffix, packing in ((".gz", gzip), (".bz2", bz2), (".xz", lzma)):
        (folder / f"a.csv{suffix}").write_bytes(packing.compress(PLAIN.encode()))
    return folder


@rows("name", ["a.csv.gz", "a.csv.bz2", "a.csv.xz", "a.zip", "a.zip::b.csv.gz"])
def test_a_packed_text_is_read_in_parts(name, packed):
    reader = opened(f"{packed}/{name}", "1kB", {})
    assert reader.rows == N
    assert np.array_equal(np.concatenate([columns[0] for _, columns in reader.pieces(1000)]), GX)


def test_a_damaged_or_too_large_packing_is_refused_in_parts(tmp_path):
    path, whole = tmp_path / "a.csv.gz", gzip.compress(PLAIN.encode())
    path.write_bytes(whole[: len(whole) // 2])
    refused(al.DataError, r"the \.gz packing is damaged or was cut off", lambda: opened(path, "1kB", {}))
    path.write_bytes(gzip.compress(b"0.0,1.0\n" * (5 << 20)))
    refused(al.DataError, "unpacks to more than the limit of", lambda: opened(path, "1kB", UNIT | {"rate": 100.0}))
    # lines that are not rows are not read in parts
    options = Options(rate=100.0, unit="deg/s")
    wide = "\n".join(",".join(map(str, row)) for row in (GX[:2000], GY[:2000])) + "\n"
    alternating = "".join(f"{a} {b}\n{a}\n" for a, b in zip(GX, GY, strict=True))
    sensors = cells(["GYRO", "ACC"] * (N // 2), TIME, GX)
    for content in (wide, alternating, sensors):
        assert text.parts(str(file_of(tmp_path, content)), options) is None


READ = """
import os, sys, tracemalloc
from allanite.readers.columns import layout, lines
from allanite.readers.parts import opened
layout.HEAD, lines.FIRST, lines.BLOCK_BYTES = 20_000, 40_000, 1 << 19
reader = opened(sys.argv[1], "1MB", {"rate": 100.0})
same = sum(1 for _ in reader.pieces())  # imports what it needs
tracemalloc.start()
reader = opened(sys.argv[1], "1MB", {"rate": 100.0})
same = sum(len(columns[0]) for _, columns in reader.pieces()) == reader.rows
print(same, reader.rows, tracemalloc.get_traced_memory()[1], flush=True)
os._exit(0)
"""
"""tracemalloc is not stopped safely while another thread gets memory: it ends with a process of its own."""


@pytest.mark.slow("takes more than half a second")
def test_memory_is_that_of_a_few_parts(tmp_path):
    path = tmp_path / "long.csv"
    with path.open("w") as file:
        file.write("gx [deg/s],gy [deg/s]\n")
        for _ in range(120):
            file.write(cells(GX, GY))
    assert path.stat().st_size > 20e6
    done = subprocess.run([sys.executable, "-c", READ, path], capture_output=True, text=True, check=True)
    same, count, peak = done.stdout.split()
    assert (same, int(count)) == ("True", 120 * N)
    assert int(peak) < 12e6
