"""HDF5, MATLAB, R and Parquet: what is found in them, what is chosen, what is asked."""

import bz2
import gzip
import lzma
import struct
import subprocess
import sys
import zipfile

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import parquet
from scipy.io import savemat as save
from tests.rows import refused, rows

import allanite as al

h5py = pytest.importorskip("h5py")

RNG = np.random.default_rng(3)
GYRO, ACC = RNG.normal(size=(60, 3)), RNG.normal(size=(40, 3))
USUAL = {"rate": 1.0, "unit": "deg/s"}


@pytest.fixture
def two_sensors(tmp_path):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        gyro = file.create_dataset("imu0/gyro", data=GYRO, compression="gzip", shuffle=True)
        gyro.attrs["units"], gyro.attrs["columns"] = "deg/s", ["x", "y", "z"]
        file["imu0"].attrs["rate"] = 200.0
        file["imu1/acc"] = ACC
        file["imu1/acc"].attrs["unit"] = "m/s^2"
        file["imu1/time"] = np.arange(40) * 0.02 + 7
        file["imu1/temperature"] = np.arange(5.0)
        file["note"] = "on the table"
    return tmp_path / "a.h5"


@pytest.mark.slow("takes more than half a second")
def test_several_sensors_are_listed_and_chosen(two_sensors, monkeypatch):
    monkeypatch.chdir(two_sensors.parent)
    words = r"2 recordings.*imu0/gyro \(60 x 3\); imu1/acc \(40 x 3\), imu1/time \(40\).*channels="
    refused(al.UsageError, words, lambda: al.read(two_sensors))
    for path, choice in ((str(two_sensors), "imu0/gyro"), ("a.h5", "/imu0/gyro")):
        gyro = al.read(path, channels=[choice])
        assert (gyro.source, gyro.channels, gyro["y"].rate) == (path, ("x", "y", "z"), 200.0)
        assert np.array_equal(gyro["y"].values, GYRO[:, 1])
    assert gyro["y"].unit == "deg/s"
    assert any("rate 200.0 Hz from 'imu0/rate'" in note for note in gyro.notes)
    for choice in (["acc"], ["acc 2"], ["6"]):
        acc = al.read(two_sensors, channels=choice)
        assert (acc[0].unit, acc[0].start, acc[0].rate) == ("m/s^2", 7.0, pytest.approx(50.0))
    assert np.array_equal(acc[0].values, ACC[:, 2])
    assert any("imu0/gyro (60 x 3)" in note for note in acc.notes)
    refused(al.UsageError, "2 recordings", lambda: al.read(two_sensors, channels=["nothing"]))


def test_sensors_of_one_length_with_rates_of_their_own_are_not_mixed(tmp_path):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        for name, rate in (("a", 100.0), ("b", 400.0)):
            file[f"{name}/gyro"] = GYRO
            file[f"{name}/gyro"].attrs["fs"] = rate
    refused(al.UsageError, "2 recordings", lambda: al.read(tmp_path / "a.h5", unit="deg/s"))
    assert al.read(tmp_path / "a.h5", unit="deg/s", channels=["b/gyro"])[0].rate == 400.0


def test_units_of_columns_and_compounds(tmp_path):
    table = np.zeros(50, [("time", "f8"), ("gyro_dps", "<f4", 3), ("tag", "S3"), ("ok", "?")])
    table["time"], table["gyro_dps"] = np.arange(50) * 0.25, GYRO[:50]
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["table"] = table
    recording = al.read(tmp_path / "a.h5")
    assert recording.channels == ("gyro_dps 1", "gyro_dps 2", "gyro_dps 3")
    assert (recording[0].rate, recording[0].unit) == (4.0, "deg/s")
    assert np.array_equal(recording[1].values, table["gyro_dps"][:, 1])
    with h5py.File(tmp_path / "b.h5", "w") as file:
        file["block0_values"], file["block0_items"] = GYRO, [b"gx", b"gy", b"T"]
        file["block0_values"].attrs["units"] = ["deg/s", "deg/s", "degC"]
    assert al.read(tmp_path / "b.h5", rate=1.0).channels == ("gx", "gy")


@pytest.mark.slow("thousands of datasets")
def test_many_datasets_are_read_or_refused_by_their_number(tmp_path):
    for count, path in ((3000, tmp_path / "many.h5"), (10_001, tmp_path / "over.h5")):
        with h5py.File(path, "w") as file:
            for i in range(count):
                file[f"g{i}"] = np.arange(3.0)
    assert len(al.read(tmp_path / "many.h5", **USUAL)) == 3000
    refused(al.DataError, "more than 10000", lambda: al.read(tmp_path / "over.h5", **USUAL))


def test_links_out_of_a_file_are_not_followed(tmp_path, two_sensors):
    with h5py.File(tmp_path / "b.h5", "w") as file:
        file["outer"] = h5py.ExternalLink(str(two_sensors), "imu0/gyro")
        file["loop"] = h5py.SoftLink("/")
        file["self"] = file["/"]
    refused(al.DataError, "no array of samples.*which is not followed", lambda: al.read(tmp_path / "b.h5", **USUAL))
    with h5py.File(tmp_path / "c.h5", "w") as file:
        layout = h5py.VirtualLayout((60, 3), "f8")
        layout[:] = h5py.VirtualSource(str(two_sensors), "imu0/gyro", (60, 3))
        file.create_virtual_dataset("virtual", layout)
        file.create_dataset("external", (60,), "f8", external=[(str(two_sensors), 0, 480)])
    refused(al.DataError, "no array", lambda: al.read(tmp_path / "c.h5", **USUAL))


@rows("precision, offset", [(12, 2), (8, 0), (16, 0)])
def test_integers_of_fewer_bits_than_their_width(tmp_path, precision, offset):
    """The stored bits were once taken for the number: 15424 for -240."""
    path, values = tmp_path / "bits.h5", np.arange(-100, 100, dtype="i2")
    kind = h5py.h5t.STD_I16LE.copy()
    kind.set_precision(precision)
    kind.set_offset(offset)
    with h5py.File(path, "w") as file:
        dataset = h5py.h5d.create(file.id, b"gx", kind, h5py.h5s.create_simple(values.shape))
        dataset.write(h5py.h5s.ALL, h5py.h5s.ALL, values)
    (record,) = al.read(path, rate=1.0, unit="1", kind="value")
    assert np.array_equal(record.values, values)


def test_a_dataset_that_claims_more_than_its_file(tmp_path):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file.create_dataset("gyro", (10**9, 3), "f8", chunks=(1000, 3))
    refused(al.DataError, "'gyro' claims 24000 MB", lambda: al.read(tmp_path / "a.h5", **USUAL))
    with h5py.File(tmp_path / "b.h5", "w") as file:
        file.create_dataset("gyro", (10**8,), "f8", chunks=(10**8,))
    refused(al.DataError, "larger than the file can hold", lambda: al.read(tmp_path / "b.h5", **USUAL))


@pytest.mark.slow("takes more than half a second")
def test_a_crash_or_a_stop_of_the_library_is_a_sentence(two_sensors, monkeypatch, tmp_path):
    from allanite.readers.sandbox import process

    monkeypatch.setattr(process, "WORKER", tmp_path / "worker.py")
    for code, wait, words in (
        ("import os; os.abort()", 120.0, "signal 6"),
        ("import signal; signal.pause()", 0.1, "too long"),
        ("import sys; sys.exit('no such thing')", 120.0, "no such thing"),
        ("print('{}')", 120.0, "damaged"),
    ):
        monkeypatch.setattr(process, "ANSWER_TIME", wait)
        (tmp_path / "worker.py").write_text(code)
        with pytest.raises(al.DataError, match=words):
            al.read(two_sensors)


@rows("suffix", [".h5", ".parquet", ".rda", ".mat", ".npz", ".zip", ".gz"])
def test_foreign_files_of_every_suffix(write, suffix):
    refused(al.DataError, "begin|format|damaged", lambda: al.read(write(RNG.bytes(3000), f"b{suffix}"), **USUAL))


def test_heavy_libraries_are_imported_by_none_but_their_readers(tmp_path):
    al.write(al.Record([1.5, 2.5, 1.5], 100.0, "deg/s", name="gz"), tmp_path / "a.npz")
    code = "import sys, allanite; allanite.read(sys.argv[1]); print([m for m in sys.argv[2:] if m in sys.modules])"
    assert printed(code, tmp_path / "a.npz", "h5py", "pyarrow", "scipy.io", "rdata") == "[]"


def printed(code, *words):
    """What a program prints in a process of its own."""
    command = [sys.executable, "-c", code, *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()


def savemat(path, content, **options):
    save(path, content, **options)
    return path


@rows("compress", [False, True])
def test_structures_and_what_is_no_number(tmp_path, compress):
    content = {
        "run": {"gyro": GYRO, "t": np.arange(60) * 0.01, "sensor": "ADIS", "cells": np.array([1, "a"], object)},
        "many": np.array([(1.5,), (2.5,)], [("v", "f8")]), "flags": GYRO[:, 0] > 0, "z": GYRO * 1j,
        "small": np.arange(60, dtype=np.int8),
    }  # fmt: skip
    recording = al.read(savemat(tmp_path / "a.mat", content, do_compression=compress), unit="deg/s", channels=["gyro"])
    assert (recording.channels, recording[0].rate) == (("gyro 1", "gyro 2", "gyro 3"), pytest.approx(100.0))
    assert any("run/cells" in note and "flags" in note and "z" in note for note in recording.notes)
    assert al.read(tmp_path / "a.mat", **USUAL, channels=["small"])[0].values.dtype == np.int64


def test_an_ascii_mat_is_text(tmp_path):
    np.savetxt(tmp_path / "a.mat", np.column_stack((np.arange(60) * 0.01 + 3, GYRO)))
    refused(al.UsageError, r"rate=100.*'column 2'.*unit=", lambda: al.read(tmp_path / "a.mat"))
    assert al.read(tmp_path / "a.mat", rate=100, unit="deg/s").channels == ("column 2", "column 3", "column 4")


@rows("old, new", [
    (struct.pack("<4i", 5, 8, 60, 3), struct.pack("<4i", 5, 8, 2**31 - 1, 2**31 - 1)),
    (b"\x09\0\0\0\xa0\x05\0\0", b"\x09\0\0\0\xa0\x05\0\x70"), (b"\x0e\0\0\0", b"\x0e\0\0\xff"),
], ids=["dimensions", "size of the numbers", "kind"])  # fmt: skip
def test_sizes_that_a_mat_file_claims_are_not_believed(tmp_path, old, new):
    data = savemat(tmp_path / "a.mat", {"gyro": GYRO}).read_bytes()
    assert data.count(old) == 1
    (tmp_path / "a.mat").write_bytes(data.replace(old, new))
    words = "claims|could not read|Expecting miMATRIX|scipy failed"
    refused(al.DataError, words, lambda: al.read(tmp_path / "a.mat", **USUAL))


@pytest.mark.slow("takes more than half a second")
def test_of_a_bomb_in_a_mat_file_no_more_is_unpacked_than_it_may(tmp_path):
    path = savemat(tmp_path / "a.mat", {"gyro": np.zeros(30_000_000)}, do_compression=True)
    words = r"claims more than the \S+ MB that a file of this size may unpack to"
    refused(al.DataError, words, lambda: al.read(path, **USUAL))


def r_file(path, body, version=2):
    encoding = struct.pack(">i", 5) + b"UTF-8" if version == 3 else b""
    path.write_bytes(b"X\n" + struct.pack(">iii", version, 0x40000, 0x20300) + encoding + body)
    return path


def test_a_time_series_of_r(tmp_path):
    values = struct.pack(">ii", 0x20E, 50) + np.arange(50.0).astype(">f8").tobytes()
    tsp = struct.pack(">ii", 14, 3) + struct.pack(">ddd", 0.0, 4.9, 10.0)
    attribute = struct.pack(">iiii", 0x402, 1, 9, 3) + b"tsp" + tsp + struct.pack(">i", 254)
    recording = al.read(r_file(tmp_path / "a.rds", values + attribute, 3), unit="deg/s")
    assert recording[0].rate == 10.0
    assert np.array_equal(recording[0].values, np.arange(50.0))


def sequence(count):
    """So many numbers, of which three are in the file."""
    name, numbers = b"compact_realseq".hex(), struct.pack(">ddd", count, 0.0, 1.0).hex()
    return f"000000ee 00000002 00000001 00000009 0000000f {name} 000000fe 0000000e 00000003 {numbers} 000000fe"


@pytest.mark.slow("takes more than half a second")
@rows(("hex_body", "words"), [
    ("0000000e 7fffffff", "claimed"),  # numbers
    ("0000000e 00000064" + "00" * 480, "only 480"),  # 100 numbers, cut off
    ("0000000e ffffffff 00000001 00000000", "claimed"),  # of a long vector
    ("00000013 0fffffff", "more than the file can hold"),  # a list
    ("00000009 7fffffff", "claimed"),  # a text
    ("00000015", "claimed"),  # byte code
    ("000000ff", "rdata failed"),  # a reference
    ("00000203" * 4000, "rdata failed"),
    (sequence(1e15), "claims more than the 33.6 MB"),
    ("00000013 0000012c" + 300 * sequence(3e6), r"claims more than the \S+ MB"),  # gigabytes together
    ("00000013 000f4240" + 10**6 * "000000fe", "too many lists: more than 100000; save only the numbers"),
])  # fmt: skip
def test_what_r_files_claim_is_not_believed(tmp_path, hex_body, words):
    path = r_file(tmp_path / "a.rds", bytes.fromhex(hex_body.replace(" ", "")))
    refused(al.DataError, words, lambda: al.read(path, **USUAL))


def test_parquet_of_others(tmp_path):
    table = pa.table(
        {
            "time": pa.array(np.arange(60) * 5000, pa.timestamp("us")),
            "gyro_x_dps": pa.array([None, *GYRO[1:, 0]]), "acc": pa.array(GYRO[:, 1]), "tag": ["a"] * 60,
            "list": [[1]] * 60, "__index_level_0__": pa.array(range(60)),
        }
    )  # fmt: skip
    fields = [f.with_metadata({"unit": "m/s^2"}) if f.name == "acc" else f for f in table.schema]
    said = {b"pandas": b'{"index_columns": ["__index_level_0__"]}'}
    parquet.write_table(table.cast(pa.schema(fields, said)), tmp_path / "a.parquet")
    recording = al.read(tmp_path / "a.parquet")
    assert (recording.channels, [record.unit for record in recording]) == (("gyro_x_dps", "acc"), ["deg/s", "m/s^2"])
    assert recording[0].rate == pytest.approx(200.0)
    assert np.isnan(recording[0].values[0])
    assert any("list" in note for note in recording.notes)


def test_parquet_that_claims_too_much(tmp_path):
    parquet.write_table(pa.table({"gx": np.zeros(2 * 10**7)}), tmp_path / "a.parquet")
    refused(al.DataError, "claims 160 MB", lambda: al.read(tmp_path / "a.parquet", **USUAL))
    parquet.write_table(pa.table({str(i): [1.0, 2.0] for i in range(1001)}), tmp_path / "a.parquet")
    refused(al.DataError, "1001 columns", lambda: al.read(tmp_path / "a.parquet", **USUAL))


def test_a_dictionary_of_long_words_is_not_spelled_out(tmp_path):
    """A column of 20 GB in a file of a few kB: not read, since words are no readings."""
    words = pa.DictionaryArray.from_arrays(pa.array(np.zeros(20_000, np.int32)), ["x" * 10**6])
    parquet.write_table(pa.table({"gx_dps": np.arange(20_000) % 7, "tag": words}), tmp_path / "a.parquet")
    code = (
        "import sys, resource, pyarrow, allanite\n"
        "now = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_maxrss\n"
        "before = now()\n"
        "print(allanite.read(sys.argv[1], rate=1).channels, (now() - before) // 1024)"
    )
    channels, taken = printed(code, tmp_path / "a.parquet").rsplit(" ", 1)
    assert channels == "('gx_dps',)"
    assert int(taken) < 100


def test_an_archive_with_several_asks(tmp_path):
    with zipfile.ZipFile(tmp_path / "a.zip", "w") as archive:
        for name in ("run/a.csv", "run/b.csv"):
            archive.writestr(name, "gx [deg/s]\n" + "1.5\n2.5\n" * 9)
    path = str(tmp_path / "a.zip")
    words = r"2 readable files.*run/a\.csv, run/b\.csv.*::run/a\.csv"
    refused(al.UsageError, words, lambda: al.read(path, rate=1))
    refused(al.UsageError, r"no member 'c\.csv'; it contains run/a\.csv", lambda: al.read(f"{path}::c.csv", rate=1))
    assert al.read(f"{path}::run/b.csv", rate=1).source == f"{path}::run/b.csv"
    (tmp_path / "a.csv").write_text("gx [deg/s]\n1.5\n2.5\n")
    refused(al.UsageError, r"::a names a member of a \.zip", lambda: al.read(f"{tmp_path / 'a.csv'}::a", rate=1))


@pytest.mark.slow("takes more than half a second")
def test_bombs_are_refused(tmp_path):
    zeros = bytes(60 << 20)
    with zipfile.ZipFile(tmp_path / "a.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a.csv", zeros)
    refused(al.DataError, "bomb", lambda: al.read(tmp_path / "a.zip", rate=1))
    for data in (gzip.compress(zeros, 1), bz2.compress(zeros), lzma.compress(zeros, preset=0)):
        (tmp_path / "a").write_bytes(data)
        refused(al.DataError, "bomb", lambda: al.read(tmp_path / "a", rate=1))


def test_bombs_in_bombs_do_not_multiply(tmp_path):
    """Each layer is within its own limit, the two together are not."""
    np.savez_compressed(tmp_path / "a.npz", gx=np.zeros(2_200_000), gy=np.zeros(2_200_000))
    al.read(tmp_path / "a.npz", **USUAL, channels=["gx"])
    with zipfile.ZipFile(tmp_path / "a.zip", "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        archive.write(tmp_path / "a.npz", "a.npz")
    refused(al.DataError, r"claims 35\.2", lambda: al.read(tmp_path / "a.zip", **USUAL))


@pytest.mark.slow("takes more than half a second")
def test_archives_that_hold_nothing_to_read(tmp_path):
    path = tmp_path / "a.zip"

    def archive_of(*names):
        with zipfile.ZipFile(path, "w") as archive:
            for name in names:
                archive.writestr(name, b"1 2 3\n")
        return path

    refused(al.DataError, r"contains readme\.txt", lambda: al.read(archive_of("readme.txt")))
    refused(al.DataError, "Excel", lambda: al.read(archive_of("xl/workbook.xml")))
    path.write_bytes(path.read_bytes()[:-30])
    refused(al.DataError, "is incomplete", lambda: al.read(path))
    many = archive_of(*(f"{i}.csv" for i in range(30_000)))
    refused(al.DataError, "directory of the archive claims", lambda: al.read(many))


@rows("options, words", [
    ({"dtype": "i2", "columns": 7}, r"120 bytes.*14 bytes of a row: 8 rows and 8 bytes remain"),
    ({"dtype": "i2", "columns": 3, "offset": 5}, r"115 bytes after the offset of 5"),
    ({"dtype": "i2", "columns": 3, "offset": 500}, r"120 bytes and ends before the offset of 500"),
    ({"dtype": "O"}, "unknown number type 'O'"), ({"dtype": "i3"}, "unknown number type"),
    ({"dtype": "S4"}, "unknown number type"), ({"dtype": "i2", "columns": 0}, "columns must be between 1"),
    ({"dtype": "i2", "columns": True}, "columns must be an integer"),
    ({"dtype": "i2", "offset": -1}, "offset must be between 0"), ({"dtype": "u4,i2", "columns": 2}, "whole row"),
    ({"dtype": "i2", "columns": 10**30}, r"columns must be below 2\^63"),
    ({"dtype": "9999f8", "columns": 10**6}, "more than a row"), ({"columns": 3}, "raw binary"),
    ({"dtype": 2}, "dtype must be a string"), ({"dtype": "i2", "scale": "0.01deg/s", "unit": "deg/h"}, "contradicts"),
    ({"dtype": "i2", "scale": "0.01furlong"}, "unknown unit 'furlong'"),
])  # fmt: skip
def test_impossible_layouts(tmp_path, options, words):
    (tmp_path / "a.bin").write_bytes(bytes(120))
    refused(al.AllaniteError, words, lambda: al.read(tmp_path / "a.bin", **({"rate": 100} | options)))


def test_raw_rows_of_mixed_types_and_packed_ones(tmp_path):
    rows = np.zeros(50, np.dtype("<u4,3<i2"))
    rows["f0"], rows["f1"] = np.arange(50) * 5000 + 3, RNG.integers(-99, 99, (50, 3))
    assert rows.tobytes()[:2] != b"\x1f\x8b"
    (tmp_path / "a.bin.gz").write_bytes(gzip.compress(rows.tobytes()))
    recording = al.read(tmp_path / "a.bin.gz", dtype="u4,3i2", time="1[us]", scale="0.1 arcsec", kind="count")
    assert recording.channels == ("column 2", "column 3", "column 4")
    assert (recording[0].scale, recording[0].unit, recording[0].kind) == (0.1, "arcsec", "count")
    assert recording[0].rate == pytest.approx(200.0)
    assert np.array_equal(recording[1].values, rows["f1"][:, 1])


def test_raw_numbers_that_begin_like_a_packed_file_are_numbers(tmp_path):
    (tmp_path / "a.bin").write_bytes(b"\x1f\x8b\x08\x00" + bytes(60))
    assert al.read(tmp_path / "a.bin", dtype="i2", **USUAL)[0].size == 32


@pytest.mark.slow("takes more than half a second")
def test_a_column_of_texts_in_r_is_passed_over(tmp_path):
    """300000 stamps as texts beside 300000 numbers, as a data frame has them."""
    count = 300_000
    texts = struct.pack(">ii", 16, count) + (struct.pack(">ii", 9, 5) + b"00:01") * count
    numbers = struct.pack(">ii", 14, count) + np.arange(float(count)).astype(">f8").tobytes()
    names = struct.pack(">ii", 16, 2) + b"".join(struct.pack(">ii", 9, 2) + name for name in (b"at", b"gx"))
    attribute = struct.pack(">iiii", 0x402, 1, 9, 5) + b"names" + names + struct.pack(">i", 254)
    path = r_file(tmp_path / "a.rds", struct.pack(">ii", 0x213, 2) + texts + numbers + attribute)
    recording = al.read(path, **USUAL)
    assert recording.channels == ("gx",)
    assert np.array_equal(recording[0].values, np.arange(count))


@rows("kind", [7, 0])
def test_a_mat_file_of_other_elements(tmp_path, kind):
    data = savemat(tmp_path / "a.mat", {"gyro": GYRO}).read_bytes()
    (tmp_path / "a.mat").write_bytes(data[:128] + np.array([kind, 0], "<u4").tobytes() * 10**6)
    words = "scipy failed while reading its structure"
    refused(al.DataError, words, lambda: al.read(tmp_path / "a.mat", **USUAL))
