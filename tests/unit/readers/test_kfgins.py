"""Rows of seven doubles are read as KF-GINS if asked for, and advised of by what they hold; nothing else is."""

import numpy as np
import pytest
from tests.commands import ends, run
from tests.rows import refused, rows

import allanite as al
from allanite.readers.formats import kfgins

RNG = np.random.default_rng(12)


def samples(count=400, rate=200.0):
    made = np.empty((count, 7))
    made[:, 0] = 456_300 + np.arange(count) / rate
    made[:, 1:] = RNG.normal(0, 1e-5, (count, 6))
    made[:, 6] -= 9.8 / rate
    return made


def test_increments_and_their_clock(tmp_path):
    made = np.delete(samples(), 100, axis=0)
    (tmp_path / "imu.bin").write_bytes(made.tobytes() + bytes(9))
    recording = al.read(tmp_path / "imu.bin", dtype="kfgins")
    assert recording.channels == ("gx", "gy", "gz", "ax", "ay", "az")
    assert {record.kind for record in recording} == {"increment"}
    assert [record.unit for record in recording] == ["rad"] * 3 + ["m/s"] * 3
    assert recording[0].rate == pytest.approx(200.0)
    assert np.flatnonzero(np.isnan(recording[0].values)).tolist() == [100]
    assert np.array_equal(np.delete(recording["az"].values, 100), made[:, 6])
    assert "the last 9 bytes are no whole row and are left out" in recording.notes
    assert run("info", tmp_path / "imu.bin", "--dtype", "kfgins").exit_code == 0


def in_g_at_10_hz():
    made = samples(rate=10.0)
    made[:, 4:] = [0.0, 0.0, -1.0]
    return made


@rows("data", [
    samples(), samples() * [1, 50, 50, 50, 1, 1, 1], in_g_at_10_hz(),
], ids=["its own", "degrees", "rates and g"])  # fmt: skip
def test_what_looks_like_it_is_not_read_unless_asked_for(tmp_path, data):
    (tmp_path / "imu.bin").write_bytes(np.ascontiguousarray(data).tobytes())
    with pytest.raises(al.UsageError, match=r"may be KF-GINS binary.*use dtype='kfgins'; if not, dtype='7f8'"):
        al.read(tmp_path / "imu.bin")
    assert al.read(tmp_path / "imu.bin", dtype="kfgins")[0].kind == "increment"
    ends(run("info", tmp_path / "imu.bin"), 2, "--dtype kfgins")
    plain = al.read(tmp_path / "imu.bin", dtype="7f8", time="1", unit="rad", kind="increment", channels="2,3,4")
    assert np.array_equal(plain[1].values, data[:, 2])


def test_rows_of_another_width_are_refused(tmp_path):
    (tmp_path / "imu.bin").write_bytes(samples().tobytes())
    refused(al.UsageError, "omit columns and offset", lambda: al.read(tmp_path / "imu.bin", dtype="kfgins", columns=7))
    (tmp_path / "imu.bin").write_bytes(bytes(40))
    refused(al.DataError, "fewer than 2 rows", lambda: al.read(tmp_path / "imu.bin", dtype="kfgins"))


@rows("change", [
    lambda r: r[:, :6], lambda r: r[:5], lambda r: r * np.array([1, 1, 1, 1, 3, 3, 3]), lambda r: r[::-1],
    lambda r: np.where(np.arange(7) == 1, np.nan, r), lambda r: r.astype("f4"), lambda r: RNG.bytes(9000),
], ids=["six columns", "few rows", "no gravity", "backwards", "not a number", "floats", "anything"])  # fmt: skip
def test_nothing_else_is_taken_for_it(tmp_path, change):
    changed = change(samples())
    data = changed if isinstance(changed, bytes) else np.ascontiguousarray(changed).tobytes()
    assert not kfgins.sniff(data, ".bin")
    (tmp_path / "a.bin").write_bytes(data)
    refused(al.DataError, "unknown file format", lambda: al.read(tmp_path / "a.bin"))
