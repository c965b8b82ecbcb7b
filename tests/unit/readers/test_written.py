"""Whatever is written is read back: every format that is written here, and those that others write."""

import bz2
import gzip
import lzma
import zipfile

import numpy as np
import pytest
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from pyarrow import parquet
from scipy.io import loadmat, savemat
from tests.rows import refused, rows
from tests.unit.readers.checks import noted, tried

import allanite as al
from allanite.core.errors import DataError, UsageError
from allanite.core.kinds import KINDS
from allanite.readers.formats.registry import WRITERS

h5py = pytest.importorskip("h5py")

UNITS = {
    "rate": ["deg/s", "rad/s", "deg/h", "g", "m/s^2", "ug", "1"],
    "increment": ["arcsec", "rad", "m/s", "s"], "angle": ["arcsec", "deg", "rad", "m/s", "s"],
    "count": ["arcsec", "urad", "ug*s"], "value": ["arcsec", "m/s", "V", "mbar", "Hz", "s", "1"],
}  # fmt: skip
ODD = ["time", "t", "rate", "allanite", "temperature", "gx", "gx [deg/s]", "1", "nan", "a,b", '"x"', "file", "Gx", "#"]
NAMES = st.text(st.characters(exclude_categories=("Cs",)), max_size=12) | st.sampled_from(ODD)
POSITIVE = st.floats(1e-6, 1e9)
FLOATS = st.floats(allow_nan=True, allow_infinity=True) | st.integers(-9, 9).map(float)


@st.composite
def recordings(draw):
    size, rate = draw(st.integers(3, 40)), draw(POSITIVE)
    start = draw(st.none() | st.floats(-1e9, 1e9).filter(lambda start: start == 0.0 or abs(start) > 1e-60))
    records = []
    for name in draw(st.lists(NAMES, min_size=1, max_size=5, unique=True)):
        kind = draw(st.sampled_from(list(KINDS)))
        integers = kind == "count" or draw(st.booleans())
        numbers = arrays.arrays(np.int64, size) if integers else arrays.arrays(np.float64, size, elements=FLOATS)
        scale = draw(POSITIVE) if kind == "count" or draw(st.booleans()) else None
        history = tuple(draw(st.lists(st.text(max_size=5), max_size=2)))
        unit = draw(st.sampled_from(UNITS[kind]))
        records.append(al.Record(draw(numbers), rate, unit, kind, scale, name=name, start=start, history=history))
    return al.Recording(tuple(records))


def assert_same(read, written):
    assert read.channels == written.channels
    for got, record in zip(read, written, strict=True):
        assert got.values.dtype == record.values.dtype
        assert np.array_equal(got.values, record.values, equal_nan=record.values.dtype.kind == "f")
        for what in ("rate", "unit", "kind", "scale", "start", "history"):
            assert getattr(got, what) == getattr(record, what), what


CONTAINED = (".hdf5", ".h5", ".mat")  # suffixes of formats that are read by a process for each file


@pytest.mark.slow("takes more than half a second")
@rows("suffix", [suffix for suffix in WRITERS if suffix != ".hdf5"])
def test_written_and_read_back(tmp_path, suffix):
    @tried(10 if suffix in CONTAINED else 150, recording=recordings())
    def check(recording):
        al.write(recording, tmp_path / f"a{suffix}", force=True)
        assert_same(al.read(tmp_path / f"a{suffix}"), recording)

    check()


@rows("suffix", WRITERS)
def test_a_long_recording_and_one_record(tmp_path, suffix):
    rng = np.random.default_rng(1)
    values = rng.normal(size=200_000)
    values[[5, 70_000]] = np.nan
    record = al.Record(values, 123.4567890123, "deg/s", name="gz", start=1.7e9 + 0.125)
    al.write(record, tmp_path / f"a{suffix}")
    assert_same(al.read(tmp_path / f"a{suffix}"), al.Recording((record,)))
    refused(UsageError, "already exists", lambda: al.write(record, tmp_path / f"a{suffix}"))
    assert [path.name for path in tmp_path.iterdir()] == [f"a{suffix}"]


@rows("suffix", WRITERS)
def test_what_the_user_says_wins_over_the_description(tmp_path, suffix):
    records = [al.Record(np.arange(50.0) % 7, 100.0, "deg/s", name=name, start=5.0) for name in ("gx", "gy")]
    al.write(al.Recording(tuple(records)), tmp_path / f"a{suffix}")
    recording = al.read(tmp_path / f"a{suffix}", rate=50.0, unit="deg/h", channels=["gy"])
    assert [(r.name, r.rate, r.unit) for r in recording] == [("gy", 50.0, "deg/h")]


def in_reverse(path):
    """The same file with its columns in another order, as other programs leave it."""
    if path.suffix == ".csv":
        description, *lines = path.read_text().splitlines()
        path.write_text("\n".join([description, *(",".join(line.split(",")[::-1]) for line in lines)]))
    elif path.suffix == ".parquet":
        table = parquet.read_table(path)
        parquet.write_table(table.select(table.column_names[::-1]), path)
    elif path.suffix == ".npz":
        with np.load(path) as file:
            np.savez(path, **{name: file[name] for name in file.files[::-1]})
    elif path.suffix == ".mat":
        found = loadmat(path)
        savemat(path, {name: found[name] for name in list(found)[::-1] if not name.startswith("_")}, oned_as="column")
    else:
        with h5py.File(path) as old, h5py.File(path.with_name("new"), "w") as new:
            for name in [*old][::-1]:
                old.copy(name, new)
        path.with_name("new").replace(path)


@rows("suffix", WRITERS)
def test_columns_in_another_order_keep_their_units(tmp_path, suffix):
    units = {"wz": "deg/h", "wx": "rad/s", "az": "g"}
    values = np.random.default_rng(1).normal(size=(3, 99))
    records = (al.Record(y, 10.0, unit, name=name) for y, (name, unit) in zip(values, units.items(), strict=True))
    written, path = al.Recording(tuple(records)), tmp_path / f"a{suffix}"
    al.write(written, path)
    in_reverse(path)
    assert_same(al.read(path), written)


def test_a_column_that_is_another_does_not_get_the_description(tmp_path):
    written = [al.Record(np.arange(99.0) % 7, 10.0, "rad/s", name=name) for name in ("gx", "gy")]
    al.write(al.Recording(tuple(written)), tmp_path / "a.csv")
    text = (tmp_path / "a.csv").read_text().replace(",gy [rad/s]\n", ",gz [deg/h]\n")
    (tmp_path / "a.csv").write_text(text)
    recording = al.read(tmp_path / "a.csv", rate=10.0)
    assert [(record.name, record.unit) for record in recording] == [("gx", "rad/s"), ("gz", "deg/h")]
    assert noted(recording, "does not match its columns")


def test_channels_that_share_no_clock_are_refused(tmp_path):
    slow, fast = (al.Record(np.zeros(9), rate, "deg/s", name=f"{rate:g}") for rate in (1.0, 2.0))
    both = al.Recording((slow, fast))
    refused(DataError, "do not have the same sample times", lambda: al.write(both, tmp_path / "a.csv"))
    refused(UsageError, r"no format can be written .*'\.xyz'.*\.parquet", lambda: al.write(slow, tmp_path / "a.xyz"))
    refused(UsageError, "does not exist", lambda: al.write(slow, tmp_path / "none" / "a.csv"))
    assert not list(tmp_path.iterdir())


def test_a_description_that_does_not_fit_is_not_used(tmp_path, write):
    al.write(al.Record([1.5, 2.5, 1.5], 100.0, "deg/s", name="gz"), tmp_path / "a.csv")
    text = (tmp_path / "a.csv").read_text()
    wide = text.replace(".5\n", ".5,1.5\n").replace("gz [deg/s]\n", "gz [deg/s],gy [deg/s]\n")
    for changed in (wide, text.replace("100.0", "-1"), text.replace('"rate"', '"r"')):
        recording = al.read(write(changed), rate=10.0)
        assert (recording[0].rate, noted(recording, "does not match its columns")) == (10.0, True)


# formats that others write

VALUES = arrays.arrays(np.float64, (12, 3), elements=FLOATS)


def assert_columns(path, values, **options):
    recording = al.read(path, unit="deg/s", channels=[str(i + 1) for i in range(values.shape[1])], **options)
    for i, record in enumerate(recording):
        assert np.array_equal(record.values, values[:, i], equal_nan=True)
    return recording


def plain_csv(values):
    rows = ["gx [deg/s],gy [deg/s],gz [deg/s]", *(",".join(map(repr, row)) for row in values.tolist())]
    return "\n".join(rows).encode()


@pytest.mark.parametrize(("suffix", "pack"), [(".gz", gzip.compress), (".bz2", bz2.compress), (".xz", lzma.compress)])
@tried(20, values=VALUES)
def test_packed_alone(tmp_path, suffix, pack, values):
    for name in (f"a.csv{suffix}", "nameless"):
        (tmp_path / name).write_bytes(pack(plain_csv(values)))
        assert assert_columns(tmp_path / name, values, rate=10.0).channels == ("gx", "gy", "gz")


@tried(20, values=VALUES)
def test_packed_in_an_archive(tmp_path, values):
    with zipfile.ZipFile(tmp_path / "a.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("run 1/gyro.csv", plain_csv(values))
        archive.writestr("README.md", "1 2 3\n4 5 6\n")
        archive.writestr("__MACOSX/run 1/._gyro.csv", "\0\0")
    for name in ("a.zip", "a.zip::run 1/gyro.csv"):
        assert assert_columns(f"{tmp_path}/{name}", values, rate=10.0).source.endswith(name)


@pytest.mark.slow("takes more than half a second")
@pytest.mark.parametrize("compress", [False, True])
@tried(4, values=VALUES, rate=POSITIVE)
def test_matlab_5(tmp_path, compress, values, rate):
    for order in (values, values.T.copy()):
        content = {"imu": {"gyro": order, "fs": rate}, "temperature": np.arange(5.0), "note": "on the table"}
        savemat(tmp_path / "a.mat", content, do_compression=compress)
        recording = al.read(tmp_path / "a.mat", unit="deg/s", channels=["gyro"])
        assert [(r.name, r.rate) for r in recording] == [(f"gyro {i}", rate) for i in (1, 2, 3)]
        np.testing.assert_array_equal([record.values for record in recording], values.T)


def matlab_73(path, content):
    """As MATLAB writes it: a block of 512 bytes, every array transposed, its class as attribute."""
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, (array, kind) in content.items():
            file.create_dataset(name, data=array.T).attrs["MATLAB_class"] = np.bytes_(kind)
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\0\2IM")


@tried(6, values=VALUES, rate=POSITIVE)
def test_matlab_73(tmp_path, values, rate):
    text = np.frombuffer("note".encode("utf-16-le"), np.uint16).reshape(1, 4)
    content = {"gyro": (values, "double"), "fs": (np.array([[rate]]), "double"), "note": (text, "char")}
    matlab_73(tmp_path / "a.mat", content)
    recording = assert_columns(tmp_path / "a.mat", values)
    assert (recording.channels, recording[0].rate) == (("gyro 1", "gyro 2", "gyro 3"), rate)


@pytest.mark.slow("takes more than half a second")
@tried(4, values=VALUES, rate=POSITIVE)
def test_r_matrices_and_frames(tmp_path, values, rate):
    rdata, pandas = pytest.importorskip("rdata"), pytest.importorskip("pandas")
    rdata.write_rda(tmp_path / "a.rda", {"gyro": values, "freq": rate})
    assert assert_columns(tmp_path / "a.rda", values)[0].rate == rate
    frame = pandas.DataFrame(values, columns=["gx", "gy", "gz"])
    rdata.write_rds(tmp_path / "a.rds", frame)
    assert assert_columns(tmp_path / "a.rds", values, rate=rate).channels == ("gx", "gy", "gz")


@pytest.mark.parametrize("dtype", ["i2", ">i2", "u1", "<u4", ">i4", "i8", "f4", ">f8"])
@tried(20, data=st.data())
def test_raw_binary(tmp_path, dtype, data):
    elements = {"allow_infinity": False} if "f" in dtype else {}
    values = data.draw(arrays.arrays(np.dtype(dtype), (9, 3), elements=elements))
    (tmp_path / "a.bin").write_bytes(b"header." + values.tobytes())
    how = {"rate": 10, "dtype": dtype, "columns": 3, "offset": 7, "scale": "0.01deg/s"}
    for i, record in enumerate(al.read(tmp_path / "a.bin", **how, channels=["1", "2", "3"])):
        assert np.array_equal(record.values, values[:, i].astype(record.values.dtype), equal_nan="f" in dtype)
        assert (record.scale, record.unit, record.kind) == (0.01, "deg/s", "rate")


@rows("scale", ["1e-40", "1e40"])
def test_a_description_with_an_impossible_scale_is_refused(tmp_path, scale):
    path = tmp_path / "a.csv"
    al.write(al.Record(np.arange(99.0) % 7, 100.0, "arcsec", "increment", scale=1.0, name="gz"), path)
    path.write_text(path.read_text().replace('"scale": 1.0', f'"scale": {scale}'))
    words = r"a.csv: the scale must be between 1e-30 and 1e\+30"
    refused(UsageError, words, lambda: al.read(path, rate=10.0, kind="increment"))
