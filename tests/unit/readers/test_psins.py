"""PSINS text made here; the real file has its own test."""

import pytest
from tests.rows import refused, rows

from allanite.core.errors import DataError
from allanite.readers import read
from allanite.readers.formats.registry import reader_named

HEADER = "0 0 -90.6 0 0 0\n34.2 108.9 380 0 8.0 9.7803\n0.1 0.1 0.1 125 125 125 \n"
COUNTS = [[0, 0, 2, 0, 0, 80], [-4, 0, 7, 0, 0, 79], [2, 1, -3, 0, 10**12, 80]]
ROWS = "".join(" ".join(map(str, row)) + "\n" for row in COUNTS)
WHOLE = "% PSINS-format SIMU log file.\n% 6 words of prose in here\n\n" + HEADER + ROWS


@rows("content", [WHOLE, HEADER + ROWS])
def test_with_and_without_comments(write, content):
    recording = read(write(content, "simu.imu"))
    assert recording.channels == ("gx", "gy", "gz", "ax", "ay", "az")
    assert (recording["gz"].kind, recording["gz"].scale, recording["gz"].rate) == ("count", 0.1, 125.0)
    assert [list(row) for row in zip(*(record.values.tolist() for record in recording), strict=True)] == COUNTS
    assert recording["az"].factor == pytest.approx(125e-6 * 9.80665)


def test_ordinary_tables_are_not_taken_for_it():
    for data, suffix in ((b"1 2 3 4 5 6\n" * 9, ".txt"), (b"gx gy\n1 2\n", ".imu")):
        assert not reader_named("psins").sniff(data, suffix)


@rows("old, new, words", [
    ("-4 0 7", "-4 x 7", "line 8, column 'gy': 'x'"), ("-4 0 7", "-4 7", "line 8 has 5 columns"),
    ("0.1 0.1 0.1 ", "0.1 0.1 ", "line 6 is a header row"), (" 8.0 ", " 0.0 ", "must be positive"),
    (ROWS, "", "three header rows"),
])  # fmt: skip
def test_damage_is_named(write, old, new, words):
    refused(DataError, words, lambda: read(write(WHOLE.replace(old, new), "simu.imu")))
