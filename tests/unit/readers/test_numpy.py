"""NumPy files: shapes, names, damage, and objects that are never loaded."""

import pickle

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st
from hypothesis.extra import numpy as arrays
from tests import examples
from tests.rows import refused, rows

from allanite.core.errors import DataError, UsageError
from allanite.readers import read

DATA = np.random.default_rng(5).normal(size=(50, 3))


@pytest.fixture
def save(tmp_path):
    def save(array, name="gyro.npy"):
        np.save(tmp_path / name, array, allow_pickle=True)
        return tmp_path / name

    return save


@pytest.fixture
def savez(tmp_path):
    def savez(**content):
        np.savez_compressed(tmp_path / "gyro.npz", **content)
        return tmp_path / "gyro.npz"

    return savez


@settings(max_examples=examples(60), deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
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
    for options, asked in (({"unit": "deg/s"}, "rate=100"), ({"rate": 10}, "unit=")):
        with pytest.raises(UsageError, match=asked):
            read(save(DATA), **options)
    # structured fields are headers
    array = np.zeros(50, dtype=[("time_us", "i8"), ("gyro_dps", "f4", 3), ("temp", "f4")])
    array["time_us"], array["gyro_dps"] = np.arange(50) * 10_000, DATA
    recording = read(save(array))
    assert recording.channels == ("gyro_dps 1", "gyro_dps 2", "gyro_dps 3")
    assert ({record.unit for record in recording}, recording[0].rate) == ({"deg/s"}, pytest.approx(100.0))


def test_archive(savez):
    recording = read(savez(t=np.arange(50) * 0.01 + 0.005, gx_dps=DATA[:, 0], acc_mps2=DATA, temperature=np.ones(7)))
    assert recording.channels == ("gx_dps", "acc_mps2 1", "acc_mps2 2", "acc_mps2 3")
    assert ([r.unit for r in recording], recording[0].rate) == (["deg/s"] + ["m/s^2"] * 3, pytest.approx(100.0))
    recording = read(savez(gyro=DATA, rate=200.0, note=np.array("room 3")), unit="deg/s")
    assert recording[0].rate == 200.0
    assert any("rate 200.0 Hz from the number stored" in note for note in recording.notes)


def test_stamps_of_numpy(save):
    array = np.zeros(50, dtype=[("when", "M8[us]"), ("gx_dps", "f8")])
    array["when"] = np.datetime64("2024-02-01") + np.arange(50) * np.timedelta64(5000, "us")
    array["gx_dps"] = DATA[:, 0]
    assert read(save(array))["gx_dps"].rate == pytest.approx(200.0)


def test_arrays_of_different_length(savez):
    path = savez(gx=DATA[:, 0], gy=DATA[:-1, 1])
    with pytest.raises(DataError, match=r"different lengths.*'gx' has 50.*'gy' has 49.*channels"):
        read(path, rate=10, unit="deg/s")
    assert read(path, rate=10, unit="deg/s", channels=["gy"])["gy"].size == 49


@rows("array", [np.zeros((5, 5, 5)), np.zeros(50, complex), np.zeros((50, 2), "U3"), np.zeros(0), np.zeros(1)])
def test_what_is_no_table_of_numbers(save, array):
    with pytest.raises(DataError):
        read(save(array), rate=10, unit="deg/s")


def test_cut_off_and_wrong_magic(save):
    path = save(DATA)
    whole = path.read_bytes()
    for broken in (
        whole[:-8],
        whole[:100],
        whole[:7],
        b"\x93NUMPX" + whole[7:],
        whole.replace(b"(50, 3)", b"(5000000000, 3)"),
    ):
        path.write_bytes(broken)
        with pytest.raises(DataError, match=r"damaged|does not begin"):
            read(path, rate=10, unit="deg/s")


class Trap:
    def __reduce__(self):
        return (exec, ("import builtins; builtins.allanite_was_fooled = True",))


@rows("name", ["gyro.npy", "gyro.csv", "gyro"])
def test_pickled_objects_are_never_loaded(tmp_path, name):
    import builtins

    path = tmp_path / name
    np.savez(tmp_path / "a.npz", gx=np.array([Trap(), 1.0], dtype=object))
    with path.open("wb") as file:
        np.save(file, np.array([Trap(), Trap()], dtype=object), allow_pickle=True)
    (tmp_path / "b.npy").write_bytes(pickle.dumps([Trap()]))
    with (tmp_path / "c.npy").open("wb") as file:
        np.save(file, np.zeros(9, dtype=[("gx", "f8"), ("what", "O")]), allow_pickle=True)
    for file in (path, tmp_path / "a.npz", tmp_path / "b.npy", tmp_path / "c.npy"):
        with pytest.raises(DataError, match="pickled Python objects, which are never loaded"):
            read(file, rate=10, unit="deg/s")
    assert not hasattr(builtins, "allanite_was_fooled")


@rows("kind", ["V0", "S0", "U0"])
def test_elements_without_width_are_not_counted_out(tmp_path, kind):
    header = f"{{'descr': '|{kind}', 'fortran_order': False, 'shape': (100000000000,), }}\n".encode()
    (tmp_path / "a.npy").write_bytes(b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header)
    refused(DataError, "the array claims 100000 MB", lambda: read(tmp_path / "a.npy", rate=1, unit="deg/s"))
