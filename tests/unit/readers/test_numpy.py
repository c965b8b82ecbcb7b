"""NumPy files: shapes, names, damage, and objects that are never loaded."""

import builtins
import pickle

import numpy as np
import pytest
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from tests.rows import refused, rows
from tests.unit.readers.checks import tried

from allanite.core.errors import DataError, UsageError
from allanite.readers import read

DATA = np.random.default_rng(5).normal(size=(50, 3))


@pytest.fixture
def save(tmp_path):
    """Write an array, or several by their names."""

    def save(*array, **arrays):
        path = tmp_path / ("gyro.npz" if arrays else "gyro.npy")
        (np.savez_compressed if arrays else np.save)(path, *array, **arrays)
        return path

    return save


@tried(
    60,
    array=arrays.arrays(
        st.sampled_from(["<f8", ">f8", "<f4", "<i2", ">i4", "<i8", "u1", "<u4"]),
        st.tuples(st.integers(4, 20), st.integers(1, 4)),
        elements={"allow_nan": False, "allow_infinity": False},
    ),
    order=st.sampled_from("CF"),
)
def test_whatever_the_type_the_numbers_come_back(save, array, order):
    path = save(np.asarray(array, order=order))
    recording = read(path, rate=10, unit="deg/s", channels=[str(i + 1) for i in range(array.shape[1])])
    assert recording.channels == tuple(f"column {i + 1}" for i in range(array.shape[1]))
    for i, record in enumerate(recording):
        assert record.values.dtype == (np.int64 if array.dtype.kind in "iu" else np.float64)
        assert np.array_equal(record.values, array[:, i])


def test_one_channel_and_rows_that_are_channels_where_they_are_fewer(save):
    assert read(save(DATA[:, 0]), rate=100, unit="deg/s").channels == ("column 1",)
    recording = read(save(DATA.T), rate=100, unit="deg/s")
    assert np.array_equal(recording[2].values, DATA[:, 2])
    assert any("3 rows of 50 values are used as channels" in note for note in recording.notes)
    refused(UsageError, "rate=100", lambda: read(save(DATA), unit="deg/s"))
    refused(UsageError, "unit=", lambda: read(save(DATA), rate=10))
    # structured fields are headers
    array = np.zeros(50, dtype=[("time_us", "i8"), ("gyro_dps", "f4", 3), ("temp", "f4")])
    array["time_us"], array["gyro_dps"] = np.arange(50) * 10_000, DATA
    recording = read(save(array))
    assert recording.channels == ("gyro_dps 1", "gyro_dps 2", "gyro_dps 3")
    assert ({record.unit for record in recording}, recording[0].rate) == ({"deg/s"}, pytest.approx(100.0))
    # so are those of stamps of numpy
    array = np.zeros(50, dtype=[("when", "M8[us]"), ("gx_dps", "f8")])
    array["when"] = np.datetime64("2024-02-01") + np.arange(50) * np.timedelta64(5000, "us")
    array["gx_dps"] = DATA[:, 0]
    assert read(save(array))["gx_dps"].rate == pytest.approx(200.0)


def test_archive(save):
    recording = read(save(t=np.arange(50) * 0.01 + 0.005, gx_dps=DATA[:, 0], acc_mps2=DATA, temperature=np.ones(7)))
    assert recording.channels == ("gx_dps", "acc_mps2 1", "acc_mps2 2", "acc_mps2 3")
    assert ([r.unit for r in recording], recording[0].rate) == (["deg/s"] + ["m/s^2"] * 3, pytest.approx(100.0))
    recording = read(save(gyro=DATA, rate=200.0, note=np.array("room 3")), unit="deg/s")
    assert recording[0].rate == 200.0
    assert any("rate 200.0 Hz from the number stored" in note for note in recording.notes)
    # arrays of different length
    path = save(gx=DATA[:, 0], gy=DATA[:-1, 1])
    words = r"different lengths.*'gx' has 50.*'gy' has 49.*channels"
    refused(DataError, words, lambda: read(path, rate=10, unit="deg/s"))
    assert read(path, rate=10, unit="deg/s", channels=["gy"])["gy"].size == 49


@rows("array", [np.zeros((5, 5, 5)), np.zeros(50, complex), np.zeros((50, 2), "U3"), np.zeros(0), np.zeros(1)])
def test_what_is_no_table_of_numbers(save, array):
    refused(DataError, "gyro.npy", lambda: read(save(array), rate=10, unit="deg/s"))


@rows("change", [
    lambda data: data[:-8], lambda data: data[:100], lambda data: data[:7], lambda data: b"\x93NUMPX" + data[7:],
    lambda data: data.replace(b"(50, 3)", b"(5000000000, 3)"),
], ids=["without the end", "in the header", "in the magic", "wrong magic", "claims more"])  # fmt: skip
def test_cut_off_and_wrong_magic(save, change):
    path = save(DATA)
    path.write_bytes(change(path.read_bytes()))
    refused(DataError, "damaged|does not begin", lambda: read(path, rate=10, unit="deg/s"))


class Trap:
    def __reduce__(self):
        return (exec, ("import builtins; builtins.allanite_was_fooled = True",))


@rows("name", ["gyro.npy", "gyro.csv", "gyro"])
def test_pickled_objects_are_never_loaded(tmp_path, name):
    np.savez(tmp_path / "a.npz", gx=np.array([Trap(), 1.0], dtype=object))
    with (tmp_path / name).open("wb") as file:
        np.save(file, np.array([Trap(), Trap()], dtype=object))
    (tmp_path / "b.npy").write_bytes(pickle.dumps([Trap()]))
    np.save(tmp_path / "c.npy", np.zeros(9, dtype=[("gx", "f8"), ("what", "O")]))
    for file in (name, "a.npz", "b.npy", "c.npy"):
        with pytest.raises(DataError, match="pickled Python objects, which are never loaded"):
            read(tmp_path / file, rate=10, unit="deg/s")
    assert not hasattr(builtins, "allanite_was_fooled")


@rows("kind", ["V0", "S0", "U0"])
def test_elements_without_width_are_not_counted_out(tmp_path, kind):
    header = f"{{'descr': '|{kind}', 'fortran_order': False, 'shape': (100000000000,), }}\n".encode()
    (tmp_path / "a.npy").write_bytes(b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header)
    refused(DataError, "the array claims 100000 MB", lambda: read(tmp_path / "a.npy", rate=1, unit="deg/s"))
