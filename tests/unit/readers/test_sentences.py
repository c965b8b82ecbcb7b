"""Sentences with checksums: those that are wrong are gaps, several kinds are told apart."""

import binascii
from functools import reduce
from operator import xor

import numpy as np
import pytest
from tests.commands import ends, run
from tests.rows import refused, rows

import allanite as al

VALUES = np.random.default_rng(8).normal(size=(300, 12)).round(6)
REAL = (  # of a VN-100 at rest, 40 Hz, recorded by the course EECE5554
    "$VNYMR,+002.301,+002.766,+003.725,+00.2712,+00.0238,+00.4986,+00.517,-00.683,-09.997,+00.001468,+00.003671,+00.000959*69\r\n"
    "$VNYMR,+002.301,+002.764,+003.725,+00.2740,+00.0391,+00.4942,+00.565,-00.726,-09.978,-00.003231,-00.003657,-00.001000*62\r\n"
    "$VNYMR,+002.300,+002.762,+003.724,+00.2769,+00.0294,+00.5053,+00.447,-00.519,-09.570,-00.002089,-00.002036,+00.000876*66\r\n"
)


def sentence(name, values, *, before="", crc=False):
    body = ",".join((name, *(f"{v:+.6f}" for v in values)))
    check = f"{binascii.crc_hqx(body.encode(), 0):04X}" if crc else f"{reduce(xor, body.encode()):02X}"
    return f"{before}${body}*{check}\n"


@pytest.fixture
def save(write):
    return lambda lines: write("".join(lines), "vn.txt")


def test_sentences_of_a_real_sensor(save):
    recording = al.read(save([REAL]), rate=40)
    assert recording.channels == ("acc_x", "acc_y", "acc_z", "gyro_x", "gyro_y", "gyro_z")
    assert [r.unit for r in recording] == ["m/s^2"] * 3 + ["rad/s"] * 3
    assert recording["gyro_y"].values.tolist() == [0.003671, -0.003657, -0.002036]
    assert recording["acc_z"].values.tolist() == [-9.997, -9.978, -9.570]


@rows("crc", [False, True])
def test_wrong_checksums_are_counted_and_are_gaps(save, crc):
    lines = [sentence("VNYMR", v, crc=crc) for v in VALUES]
    lines[7] = lines[7].replace("0", "1", 1)
    lines[20] = lines[20][:30] + "\n"
    lines[299] = lines[299][:40]
    recording = al.read(save(["# a logger\n", *lines]), rate=40)
    assert (np.flatnonzero(np.isnan(recording["gyro_x"].values)).tolist(), recording["gyro_x"].size) == ([7, 20], 299)
    assert "3 sentences have a wrong checksum or are incomplete, and are left out" in recording.notes
    assert np.array_equal(np.delete(recording["gyro_z"].values, [7, 20]), np.delete(VALUES[:299, 11], [7, 20]))
    refused(al.UsageError, "sampling rate", lambda: al.read(save(lines)))


@rows("stamp", [
    lambda k: f"{1e9 + k * 0.025:.3f},", lambda k: f"2026-01-02 03:04:{5 + k // 40:02d}.{k % 40 * 25:03d} ",
], ids=["seconds", "date and time"])  # fmt: skip
def test_time_stamps_before_the_sentences(save, stamp):
    lines = [sentence("VNGYR", v[:3], before=stamp(k)) for k, v in enumerate(VALUES)]
    lines[7] = lines[7].replace(".", "1", 1)[:-4] + "\n"
    recording = al.read(save(lines))
    assert (recording[0].rate, np.flatnonzero(np.isnan(recording[0].values)).tolist()) == (pytest.approx(40.0), [7])
    assert [finding.name for finding in recording.findings] == ["missing samples"]
    assert recording.channels == ("gyro_x", "gyro_y", "gyro_z")


def test_increments_and_several_kinds(save):
    lines = [sentence("VNDTV", v[:7]) + sentence("VNIMU", v[:11]) for v in VALUES]
    refused(al.UsageError, r"2 tables.*VNDTV \(300 rows\).*VNIMU", lambda: al.read(save(lines), rate=100))
    lines = [line.split("\n")[0] + "\n" for line in lines] + [sentence("GPGGA", [1.0])] * 300
    recording = al.read(save(lines), rate=100)
    assert ({r.kind for r in recording}, [r.unit for r in recording]) == ({"increment"}, ["deg"] * 3 + ["m/s"] * 3)
    assert np.array_equal(recording["delta_theta_y"].values, VALUES[:, 2])


def test_exit_codes_of_damaged_and_foreign_files(save):
    path = save([sentence("VNYMR", v) for v in VALUES])
    for options, code in (((), 2), (("--rate", "40"), 0), (("--rate", "40", "--channels", "VNIMU"), 2)):
        run("info", path, *options, code=code)
    path = save([sentence("VNYMR", v).replace("VN", "VM") for v in VALUES])
    ends(run("info", path), 3, "no sentence has a valid checksum; 300 are damaged")
