"""Files read in parts: the samples, rate, names, notes and findings of the same file read as a whole."""

import hashlib
import os
from itertools import count

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import strategies as st
from pyarrow import parquet
from tests.rows import refused, rows
from tests.unit.readers.checks import assert_as_whole, gathered, tried

import allanite as al
from allanite.parallel.processes import ahead
from allanite.readers.columns import lines as head
from allanite.readers.formats.registry import READERS, reader_named
from allanite.readers.parts import bytes_of, demand_memory, opened
from allanite.readers.sandbox.source import digest_of

h5py = pytest.importorskip("h5py")

N = 30_000
RATE = 100.0
UNIT = {"rate": RATE, "unit": "deg/s"}
TIMED = {"unit": "deg/s", "time": "time_s"}


def noise():
    return np.random.default_rng(1).normal(size=(N, 3))


def stamped(lost=((1000, 1010), (20_000, 20_300))):
    """Time stamps and two channels, without some rows."""
    table = np.column_stack([np.arange(N) / RATE, noise()[:, :2]])
    return np.delete(table, np.concatenate([np.arange(0), *(np.arange(*rows) for rows in lost)]), axis=0)


def npy(folder, array):
    np.save(folder / "a.npy", array)
    return folder / "a.npy"


def fields(folder, lost=((1000, 1010), (20_000, 20_300))):
    return npy(folder, np.rec.fromarrays(stamped(lost).T, names=["time_s", "gx", "gy"]))


def shifted(folder, seconds, where):
    """A channel whose stamps are later there."""
    time = np.arange(N) / RATE
    time[where] += seconds
    return npy(folder, np.rec.fromarrays([time, noise()[:, 0]], names=["time_s", "gx"]))


def table(folder):
    columns = stamped().T
    nanoseconds = np.rint(columns[0] * 1e9).astype("M8[ns]")
    gy = pa.array(columns[2], mask=np.arange(len(columns[2])) % 997 == 5)
    named = {"stamp": nanoseconds, "gx [deg/s]": columns[1].astype("f4"), "word": ["a"] * len(gy), "gy [deg/s]": gy}
    parquet.write_table(pa.table(named), folder / "a.parquet", row_group_size=7000)
    return folder / "a.parquet"


def epoch(folder):
    """Whole seconds and nanoseconds in two columns, which are one clock."""
    whole = np.rint(stamped()[:, 0] * 1e9).astype(np.int64) + 1_700_000_000 * 10**9
    named = {"stamp.sec": whole // 10**9, "stamp.nanosec": whole % 10**9, "gx [deg/s]": stamped()[:, 1]}
    parquet.write_table(pa.table(named), folder / "b.parquet")
    return folder / "b.parquet"


def written(suffix):
    def make(folder):
        records = (al.Record(column, RATE, "deg/s", name=name) for name, column in zip("xyz", noise().T, strict=True))
        al.write(al.Recording(tuple(records)), folder / f"w{suffix}")
        return folder / f"w{suffix}"

    return make


def datasets(folder):
    with h5py.File(folder / "d.h5", "w") as file:
        file.create_dataset("imu/gyro", data=noise(), chunks=(1000, 3), compression="gzip").attrs["units"] = "rad/s"
        file["imu/time"] = np.arange(N) / RATE
        file["imu/time"].attrs["units"] = "s"
        file["camera/time"] = np.arange(200) / 3
    return folder / "d.h5"


def raw(folder, values):
    values.tofile(folder / "a.bin")
    return folder / "a.bin"


MIXED = np.rec.fromarrays([np.zeros(N, "<u4"), np.rint(noise()[:, :2] * 100)], dtype=[("a", "<u4"), ("b", "<i2", (2,))])
CASES = {
    "one column": (lambda folder: npy(folder, noise()[:, 0]), UNIT),
    "integers": (lambda folder: npy(folder, np.rint(noise() * 50).astype("i2")), UNIT),
    "columns one after the other": (lambda folder: npy(folder, np.asfortranarray(noise())), UNIT),
    "channels are rows": (lambda folder: npy(folder, noise().T.copy()), UNIT),
    "fields with time": (fields, TIMED), "some channels": (fields, TIMED | {"channels": ["gy"]}),
    "the rate overrides time": (fields, {"unit": "deg/s", "time": "none", "rate": 50.0, "channels": ["gx"]}),
    "parquet": (table, {}), "two columns are the clock": (epoch, {}),
    "parquet of allanite": (written(".parquet"), {}), "hdf5 of allanite": (written(".h5"), {}),
    "hdf5 with time": (datasets, {}),
    "mixed rows": (lambda folder: raw(folder, MIXED), UNIT | {"dtype": "u4,2i2", "channels": ["2", "3"]}),
    "raw": (lambda folder: raw(folder, noise().astype(">f4")), UNIT | {"dtype": ">f4", "columns": 3}),
    "points of an angle": (lambda folder: npy(folder, noise()[:, 0]), {"rate": RATE, "unit": "deg", "kind": "angle"}),
}  # fmt: skip


@pytest.fixture(autouse=True)
def short_head(monkeypatch):
    """The meaning of a file is found in its first rows, not in all of these short files."""
    for name in ("numpy_file", "raw", "parquet", "contained", "bag"):
        monkeypatch.setattr(f"allanite.readers.formats.{name}.HEAD_ROWS", 5000)
    assert head.HEAD_ROWS > 5000


@rows("case", CASES)
def test_parts_are_the_whole(case, tmp_path):
    make, choices = CASES[case]
    assert_as_whole(make(tmp_path), 7777, choices)


@rows("case", ["one column", "columns one after the other", "raw"])
def test_a_file_that_becomes_shorter_while_it_is_read_is_refused(case, tmp_path):
    make, choices = CASES[case]
    path = make(tmp_path)
    reader = opened(path, "1kB", choices)
    os.truncate(path, os.stat(path).st_size - 100)
    refused(al.DataError, "ends in the middle of its numbers", lambda: list(reader.pieces(4096)))


HOLES = st.lists(st.tuples(st.integers(6000, N - 10), st.integers(1, 400)), max_size=5)


@tried(25, holes=HOLES, size=st.integers(1100, 12_000))
def test_losses_are_gaps_wherever_the_parts_end(tmp_path, holes, size):
    path = fields(tmp_path, [(begin, begin + length) for begin, length in holes])
    assert_as_whole(path, size, TIMED, closeness=1e-9)


@pytest.mark.slow("takes more than half a second")
@rows("form", ["bag", "db3", "mcap"])
def test_a_bag_is_read_in_parts(tmp_path, form):
    bag_files = pytest.importorskip("tests.bag_files", reason="pip install 'allanite[ros]'")
    topic = bag_files.imu_topic(form, np.random.default_rng(2).normal(size=(9000, 6)))
    path = bag_files.write(tmp_path, form, [topic._replace(messages=topic.messages[:6000] + topic.messages[6100:])])
    whole = al.read(path)
    samples, beat, _, findings = gathered(bag_files.file_of(path), 4096, {})
    for values, record in zip(samples, whole, strict=True):
        np.testing.assert_array_equal(values, record.values)
    assert beat.rate == pytest.approx(whole[0].rate, rel=1e-12)
    # the whole of ROS 1 is counted by its header.seq, a part by its stamps
    mine, known = ([f.what.partition(", according to")[0] for f in all_] for all_ in (findings, whole.findings))
    assert mine == known


def test_a_long_gap_takes_no_memory(tmp_path):
    reader = opened(shifted(tmp_path, 1500.0, slice(20_000, None)), "1kB", TIMED)
    pieces = [(lost, columns[0].size) for lost, columns in reader.pieces(N)]
    assert pieces == [(0, 20_000), (150_000, 10_000)]


def test_a_clock_that_is_set_back_is_refused_unless_the_rate_is_given(tmp_path):
    path = shifted(tmp_path, -150.0, slice(20_000, None))
    for size, row in ((7000, 14_001), (5000, 20_001)):
        with pytest.raises(al.DataError, match=f"from row {row} on: rows are out of order"):
            gathered(path, size, TIMED)
    samples, beat, notes, _ = gathered(path, 5000, TIMED | {"rate": RATE})
    np.testing.assert_array_equal(samples[0], noise()[:, 0])
    assert beat.rate == RATE
    assert any("the rows are assumed to be evenly spaced" in note for note in notes)


def test_a_damaged_stamp_is_mended_in_a_part_and_refused_at_its_end(tmp_path):
    samples, beat, _, (finding,) = gathered(shifted(tmp_path, 40.0, 9000), 7000, TIMED)
    np.testing.assert_array_equal(samples[0], noise()[:, 0])
    assert (beat.rate, finding.name) == (pytest.approx(RATE), "damaged time stamps")
    assert "in row 9001 of the data" in finding.what
    path = shifted(tmp_path, 40.0, 13_999)  # where the next stamps are not yet known
    words = r"from row 14001 on: 1 time stamp of .* is earlier"
    refused(al.DataError, words, lambda: gathered(path, 7000, TIMED))


def test_what_fits_is_read_as_a_whole(tmp_path):
    path = npy(tmp_path, noise())
    for memory in (None, "1TB", "2.7MB"):
        assert opened(path, memory, UNIT) is None
    reader = opened(path, "2.6MB", UNIT)
    assert reader.rows == N
    # a format that is not read in parts is refused with a cure that works
    path = tmp_path / "a.npz"
    np.savez(path, noise())
    with pytest.raises(al.UsageError, match=r"may take 5\.\d+ MB of memory, of which 1 MB may be used") as error:
        opened(path, "1MB", UNIT)
    cure = str(error.value).partition("allow more with memory=")[2].strip("'")
    assert opened(path, cure, UNIT) is None
    refused(al.UsageError, "not read in parts", lambda: demand_memory(path, "1MB", UNIT))
    demand_memory(path, cure, UNIT)
    # the analysis is that of one channel, of a file of which all columns are read
    path = npy(tmp_path, np.column_stack([noise()] * 20))
    some = UNIT | {"channels": ["1"]}
    demand_memory(path, "30MB", some)
    assert opened(path, "30MB", some) is None
    words = r"may take 29 MB of memory.* and this job is not read in parts"
    refused(al.UsageError, words, lambda: demand_memory(path, "2MB", some))


def test_every_format_with_parts_is_tried_here():
    having = {name for name in READERS if hasattr(reader_named(name), "parts")}
    assert having == {"numpy", "parquet", "hdf5", "bag", "raw", "text"}


@rows("text", ["much", "0", "-1GB", "GB", ""])
def test_a_size_is_a_number_of_bytes(text):
    refused(al.UsageError, "a size such as 1GB or 500MB", lambda: bytes_of(text))


def test_an_error_of_a_thread_comes_where_its_results_are_used():
    items = ahead(1 // k for k in (1, 0))
    assert next(items) == 1
    refused(ZeroDivisionError, "division", lambda: next(items))


def test_a_thread_ends_when_nobody_waits():
    source = (k for k in count())
    items = ahead(source)
    next(items)
    items.close()
    assert source.gi_frame is None  # closed


@rows("size", [0, 1, (1 << 20) - 1, 1 << 20, (1 << 21) + 5])
def test_digest_is_that_of_the_whole_file(size, tmp_path):
    content = np.random.default_rng(size).bytes(size)
    (tmp_path / "file").write_bytes(content)
    assert digest_of(str(tmp_path / "file")) == hashlib.sha256(content).hexdigest()
