"""Sound files of every format, for tests and for what damages them."""

import binascii
import bz2
import gzip
import io
import lzma
import struct
import tempfile
import zipfile
from pathlib import Path
from typing import NamedTuple

import numpy as np

import allanite as al


def _numbers(rows: int) -> np.ndarray:
    return np.random.default_rng(11).normal(size=(rows, 3))


NUMBERS = _numbers(40)  # what all files hold

ASKED = {"rate": 100.0, "unit": "deg/s"}
RAW = {"dtype": "<i2", "columns": 3, "scale": "0.01deg/s", "rate": 100.0}
IMPORTED = {".h5": "h5py", ".mat": "scipy.io", ".rda": "rdata.parser", ".rds": "rdata.parser", ".ulg": "pyulog"}
IMPORTED |= {".xlsx": "openpyxl", ".tdms": "nptdms", ".mf4": "asammdf"}
IMPORTED |= dict.fromkeys((".bag", ".db3", ".mcap"), "rosbags.typesys.stores.ros2_humble")
"""What the process of their own imports that reads the formats of fragile libraries."""


def lengthen(rows: int) -> None:
    """Let the files be of so many rows from now on."""
    globals()["NUMBERS"] = _numbers(rows)


def _text(delimiter: str) -> bytes:
    rows = (delimiter.join((f"{k * 0.01:.2f}", *(f"{x:.5f}" for x in row))) for k, row in enumerate(NUMBERS))
    head = delimiter.join(("time[s]", "gx[deg/s]", "gy[deg/s]", "T[degC]"))
    return "\n".join(("# a logger", head, *rows, "# end")).encode()


def _saved(save, *given, **named) -> bytes:
    file = io.BytesIO()
    save(file, *given, **named)
    return file.getvalue()


def _written(suffix: str) -> bytes:
    records = [al.Record(NUMBERS[:, i], 100.0, "deg/s", name=name) for i, name in enumerate(("gx", "gy", "gz"))]
    with tempfile.TemporaryDirectory() as folder:
        al.write(al.Recording(tuple(records)), Path(folder, f"a{suffix}"))
        return Path(folder, f"a{suffix}").read_bytes()


def _parquet() -> bytes:
    import pyarrow as pa
    from pyarrow import parquet

    stamps = pa.array(np.arange(len(NUMBERS)) * 10_000, pa.timestamp("us"))
    table = pa.table(
        {
            "time": stamps, "gx_dps": NUMBERS[:, 0], "n": np.arange(len(NUMBERS)) % 3,
            "tag": ["a", "b"] * (len(NUMBERS) // 2),
        }
    )  # fmt: skip
    return _saved(lambda file: parquet.write_table(table, file, compression="none"))


def _hdf5(**how) -> bytes:
    import h5py

    def save(file):
        with h5py.File(file, "w", libver=how.pop("libver", None)) as f:
            f.create_dataset("imu/gyro", data=NUMBERS, **how).attrs["units"] = "deg/s"
            f["imu"].attrs["rate"] = 100.0
            f["imu/time"], f["note"] = np.arange(len(NUMBERS)) * 0.01, "on the table"

    return _saved(save)


def _matlab(**how) -> bytes:
    from scipy.io import savemat

    content = {
        "imu": {"gyro": NUMBERS, "t": np.arange(len(NUMBERS)) * 0.01, "cells": np.array([1, "a"], object)},
        "fs": 100.0,
    }
    return _saved(savemat, content | {"note": "on the table"}, **how)


def _matlab_73() -> bytes:
    import h5py

    def save(file):
        with h5py.File(file, "w", userblock_size=512) as f:
            f.create_dataset("gyro", data=NUMBERS.T).attrs["MATLAB_class"] = np.bytes_("double")

    data = bytearray(_saved(save))
    data[:128] = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\0\2IM"
    return bytes(data)


def _r(suffix: str) -> bytes:
    import pandas as pd
    import rdata

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, f"a{suffix}")
        if suffix == ".rda":
            rdata.write_rda(path, {"gyro": NUMBERS, "freq": 100.0})
        else:
            rdata.write_rds(path, pd.DataFrame(NUMBERS, columns=["gx", "gy", "gz"]))
        return gzip.decompress(path.read_bytes())  # what is in it is the target, not its packing


def _ulog() -> bytes:
    def message(kind: bytes, payload: bytes) -> bytes:
        return len(payload).to_bytes(2, "little") + kind + payload

    kind = np.dtype([("timestamp", "<u8"), ("xyz", "<f4", 3)])
    rows = np.zeros(len(NUMBERS), kind)
    rows["timestamp"], rows["xyz"] = np.arange(len(NUMBERS)) * 5000, NUMBERS
    head = message(b"F", b"sensor_gyro:uint64_t timestamp;float x;float y;float z;")
    data = (message(b"D", bytes(2) + row.tobytes()) for row in rows)
    return b"ULog\1\x12\x35\1" + bytes(8) + head + message(b"A", bytes(3) + b"sensor_gyro") + b"".join(data)


def _dataflash() -> bytes:
    kinds = {128: ("FMT", "BBnNZ", "Type,Length,Name,Format,Columns"), 130: ("IMU", "QBfff", "TimeUS,I,GyrX,GyrY,GyrZ")}
    kinds |= {133: ("ISBH", "QHBBHHQf", "TimeUS,N,type,instance,mul,smp_cnt,SampleUS,smp_rate")}
    kinds |= {134: ("ISBD", "QHHaaa", "TimeUS,N,seqno,x,y,z")}
    mark, sizes = b"\xa3\x95", {128: 89, 130: 24, 133: 31, 134: 207}
    data = b"".join(
        mark + bytes([128, kind, sizes[kind]]) + struct.pack("4s16s64s", *(word.encode() for word in said))
        for kind, said in kinds.items()
    )
    head = struct.pack("<QHBBHHQf", 0, 0, 1, 0, 100, 64, 0, 1000.0)
    part = np.arange(96, dtype="<i2").tobytes()
    data += (
        mark + bytes([133]) + head + b"".join(mark + bytes([134]) + struct.pack("<QHH", 0, 0, k) + part for k in (0, 1))
    )
    return data + b"".join(mark + bytes([130]) + struct.pack("<QB3f", 5000 * i, 0, *v) for i, v in enumerate(NUMBERS))


def _workbook() -> bytes:
    import openpyxl

    book = openpyxl.Workbook()
    for row in (
        ["time [s]", "gx [deg/s]", "gy [deg/s]"],
        *([k * 0.01, *x[:2].tolist()] for k, x in enumerate(NUMBERS)),
    ):
        book.active.append(row)
    packed = _saved(book.save)
    # what is in it is the target, not its packing
    with zipfile.ZipFile(io.BytesIO(packed)) as old:
        parts = [(name, old.read(name)) for name in old.namelist()]

    def save(file):
        with zipfile.ZipFile(file, "w", zipfile.ZIP_STORED) as new:
            for name, part in parts:
                new.writestr(name, part)

    return _saved(save)


def _tdms() -> bytes:
    from nptdms import ChannelObject, TdmsWriter

    about = {"wf_increment": 0.01, "unit_string": "deg/s"}

    def save(file):
        with TdmsWriter(file) as writer:
            for rows in np.split(NUMBERS, 2):
                writer.write_segment([ChannelObject("Run", f"g{a}", rows[:, i], about) for i, a in enumerate("xyz")])

    return _saved(save)


def _labview() -> bytes:
    head = "LabVIEW Measurement\nSeparator\tTab\nDecimal_Separator\t.\nX_Columns\tOne\n***End_of_Header***\n"
    about = "Channels\t2\nDate\t2026/01/02\t2026/01/02\nTime\t03:04:0{}.5\t03:04:0{}.5\nDelta_X\t0.01\t0.01\n"
    about += "Y_Unit_Label\tdeg/s\tdeg/s\n***End_of_Header***\nX_Value\tgx\tgy\tComment\n"
    rows = "".join(f"{k * 0.01:.6f}\t{x[0]:.6f}\t{x[1]:.6f}\n" for k, x in enumerate(NUMBERS))
    return (head + about.format(5, 5) + rows + "\n" + about.format(9, 9) + rows).encode()  # 400 rows take 4 s


def _sentences() -> bytes:
    bodies = (",".join(("VNGYR", *(f"{x:+.6f}" for x in row))).encode() for row in NUMBERS)
    return b"".join(b"$%s*%04X\r\n" % (body, binascii.crc_hqx(body, 0)) for body in bodies)


def _mdf() -> bytes:
    import asammdf

    signals = [
        asammdf.Signal(NUMBERS[:, i], np.arange(len(NUMBERS)) * 0.01, name=f"g{a}", unit="deg/s")
        for i, a in enumerate("xyz")
    ]
    with tempfile.TemporaryDirectory() as folder, asammdf.MDF() as file:
        file.append(signals)
        return file.save(Path(folder, "a.mf4")).read_bytes()


def _kfgins() -> bytes:
    rows = np.column_stack((np.arange(len(NUMBERS)) * 0.005, NUMBERS * 1e-5, NUMBERS * 1e-4 + np.array([0, 0, 0.049])))
    return rows.astype("<f8").tobytes()


def _bag(form: str, compression: str = "") -> bytes:
    from tests import bag_files

    topic = bag_files.imu_topic(form, np.tile(NUMBERS, 2), frame="imu")
    with tempfile.TemporaryDirectory() as folder:
        path = bag_files.write(Path(folder), form, [topic], compression=compression)
        return bag_files.file_of(path).read_bytes()


def _zip(how: int) -> bytes:
    def save(file):
        with zipfile.ZipFile(file, "w", how) as archive:
            archive.writestr("run/gyro.csv", _text(","))
            archive.writestr("README.md", "nothing")

    return _saved(save)


class Seed(NamedTuple):
    """How a sound file is made, the options with which it is read, and how many mutations of it are read.

    Few of the formats that a process of its own reads, which takes up to 2 s to begin.
    """

    make: object
    options: dict = ASKED
    count: int = 20_000


SEEDS = {
    "comma.csv": Seed(lambda: _text(","), ASKED, 10_000),
    "blanks.txt": Seed(lambda: _text("  "), ASKED, 10_000),
    "described.csv": Seed(lambda: _written(".csv"), {}, 10_000),
    "simu.imu": Seed(
        lambda: (
            b"% PSINS\n0 0 -90.6 0 0 0\n34.2 108.9 380 0 8.0 9.7803\n0.1 0.1 0.1 125 125 125\n"
            + b"0 -4 2 0 0 80\n" * len(NUMBERS)
        ),
        {},
    ),
    "plain.npy": Seed(lambda: _saved(np.save, NUMBERS)),
    "fields.npy": Seed(lambda: _saved(np.save, np.zeros(len(NUMBERS), [("time_ms", "i8"), ("gx_dps", "f4")]))),
    "archive.npz": Seed(lambda: _saved(np.savez, gx=NUMBERS[:, 0], t=np.arange(len(NUMBERS)) * 0.01)),
    "squeezed.npz": Seed(lambda: _saved(np.savez_compressed, gx=NUMBERS[:, 0], rate=np.array(100.0))),
    "described.npz": Seed(lambda: _written(".npz"), {}),
    "raw.bin": Seed(lambda: (NUMBERS * 100).astype("<i2").tobytes(), RAW),
    "plain.parquet": Seed(_parquet, {}, 50_000),
    "described.parquet": Seed(lambda: _written(".parquet"), {}),
    "plain.h5": Seed(_hdf5, {}, 300),
    "squeezed.h5": Seed(lambda: _hdf5(compression="gzip", shuffle=True, fletcher32=True, chunks=(10, 3)), {}, 300),
    "newest.h5": Seed(lambda: _hdf5(libver="latest", chunks=(10, 3), maxshape=(None, 3)), {}, 300),
    "described.h5": Seed(lambda: _written(".h5"), {}, 300),
    "matlab73.mat": Seed(_matlab_73, ASKED, 300),
    "matlab5.mat": Seed(_matlab, ASKED, 300),
    "squeezed.mat": Seed(lambda: _matlab(do_compression=True), ASKED, 300),
    "matrix.rda": Seed(lambda: _r(".rda"), ASKED, 300),
    "frame.rds": Seed(lambda: _r(".rds"), ASKED, 300),
    "flight.ulg": Seed(_ulog, {}, 300),
    "flight.bin": Seed(_dataflash, {"channels": "IMU/0"}, 3_000),
    "sheet.xlsx": Seed(_workbook, {}, 300),
    "run.tdms": Seed(_tdms, {}, 500),
    "run.lvm": Seed(_labview, {}, 3_000),
    "vn100.txt": Seed(_sentences, ASKED, 3_000),
    "run.mf4": Seed(_mdf, {}, 100),
    "kfgins.bin": Seed(_kfgins, {"dtype": "kfgins"}, 3_000),
    "plain.bag": Seed(lambda: _bag("bag"), {}, 300),
    "squeezed.bag": Seed(lambda: _bag("bag", "lz4"), {}, 300),
    "plain.db3": Seed(lambda: _bag("db3"), {}, 300),
    "plain.mcap": Seed(lambda: _bag("mcap"), {}, 300),
    "squeezed.mcap": Seed(lambda: _bag("mcap", "storage"), {}, 300),
    "stored.zip": Seed(lambda: _zip(zipfile.ZIP_STORED), ASKED, 10_000),
    "squeezed.zip": Seed(lambda: _zip(zipfile.ZIP_DEFLATED), ASKED, 10_000),
    "gyro.csv.gz": Seed(lambda: gzip.compress(_text(","), mtime=0), ASKED, 8_000),
    "gyro.csv.bz2": Seed(lambda: bz2.compress(_text(",")), ASKED, 8_000),
    "gyro.csv.xz": Seed(lambda: lzma.compress(_text(",")), ASKED, 8_000),
}
