"""Rows of seven doubles are read as KF-GINS if asked for, and advised of by what they hold; nothing else is."""

import numpy as np
import pytest
from tests.commands import ends, run
from tests.rows import refused, rows

import allanite as al

RNG = np.random.default_rng(12)


def samples(rate=200.0):
    made = np.column_stack((456_300 + np.arange(400) / rate, RNG.normal(0, 1e-5, (400, 6))))
    made[:, 6] -= 9.8 / rate
    return made


def test_increments_and_their_clock(write):
    made = np.delete(samples(), 100, axis=0)
    path = write(made.tobytes() + bytes(9), "imu.bin")
    recording = al.read(path, dtype="kfgins")
    assert recording.channels == ("gx", "gy", "gz", "ax", "ay", "az")
    assert [(r.kind, r.unit) for r in recording] == [("increment", "rad")] * 3 + [("increment", "m/s")] * 3
    assert recording[0].rate == pytest.approx(200.0)
    assert np.flatnonzero(np.isnan(recording[0].values)).tolist() == [100]
    assert np.array_equal(np.delete(recording["az"].values, 100), made[:, 6])
    assert "the last 9 bytes are no whole row and are left out" in recording.notes
    run("info", path, "--dtype", "kfgins", code=0)


IN_G = np.hstack((samples(10.0)[:, :4], np.tile([0.0, 0.0, -1.0], (400, 1))))


@rows("data", [samples(), samples() * [1, 50, 50, 50, 1, 1, 1], IN_G], ids=["its own", "degrees", "rates and g"])
def test_what_looks_like_it_is_not_read_unless_asked_for(write, data):
    path = write(data.tobytes(), "imu.bin")
    words = r"may be KF-GINS binary.*use dtype='kfgins'; if not, dtype='7f8'"
    refused(al.UsageError, words, lambda: al.read(path))
    assert al.read(path, dtype="kfgins")[0].kind == "increment"
    ends(run("info", path), 2, "--dtype kfgins")
    plain = al.read(path, dtype="7f8", time="1", unit="rad", kind="increment", channels="2,3,4")
    assert np.array_equal(plain[1].values, data[:, 2])


def test_rows_of_another_width_are_refused(write):
    path = write(samples().tobytes(), "imu.bin")
    refused(al.UsageError, "omit columns and offset", lambda: al.read(path, dtype="kfgins", columns=7))
    refused(al.DataError, "fewer than 2 rows", lambda: al.read(write(bytes(40), "imu.bin"), dtype="kfgins"))


@rows("change", [
    lambda r: r[:, :6].copy(), lambda r: r[:5], lambda r: r * [1, 1, 1, 1, 3, 3, 3], lambda r: r[::-1].copy(),
    lambda r: np.where(np.arange(7) == 1, np.nan, r), lambda r: r.astype("f4"), lambda r: RNG.bytes(9000),
], ids=["six columns", "few rows", "no gravity", "backwards", "not a number", "floats", "anything"])  # fmt: skip
def test_nothing_else_is_taken_for_it(write, change):
    refused(al.DataError, "unknown file format", lambda: al.read(write(bytes(change(samples())), "a.bin")))
