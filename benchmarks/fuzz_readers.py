"""Damaged files: whatever is done to a file of any format, it is read or refused in words, soon and in little memory.

    python benchmarks/fuzz_readers.py [--share 1] [--only gyro.npy,r.rds] [--jobs 2] [--write PATH]

Mutation k of a seed file is always the same: its generator is seeded by the name of the file and k, and one that fails
is printed with both. Each file is read in a process that is watched: a crash and a hang are failures as well as an
error of another type than AllaniteError, more than 2 s of processor time, and more than 3 times the file and 100 MB.
Formats of fragile libraries are read as always by a process of their own, here forked from one that has imported the
library, which saves 0.1 s to 2 s.
Ends with exit code 1 if there is a failure.
"""

from table import Page, Row, begin, commit, markdown, processor

import binascii
import bz2
import contextlib
import ctypes
import gzip
import importlib.util
import io
import lzma
import multiprocessing
import os
import resource
import struct
import subprocess
import sys
import tempfile
import time
import traceback
import zipfile
import zlib
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from datetime import date
from pathlib import Path
from typing import NamedTuple

import numpy as np

import allanite as al
from allanite.kernels.clock import followed

IMPORTED = {".h5": "h5py", ".mat": "scipy.io", ".rda": "rdata.parser", ".rds": "rdata.parser", ".ulg": "pyulog"}
IMPORTED |= {".xlsx": "openpyxl", ".tdms": "nptdms", ".mf4": "asammdf"}
IMPORTED |= dict.fromkeys((".bag", ".db3", ".mcap"), "rosbags.typesys.stores.ros2_humble")
"""What the process of their own imports that reads these formats."""

CONTAINED = tuple(IMPORTED)

WORKER = []
"""The program of that process, once it is imported."""

SLOW, WATCH = 2.0, 20.0
"""Seconds that a file may take, and after which the process is stopped."""

MEMORY = next((folder for folder in ("/dev/shm",) if os.path.isdir(folder)), None)  # noqa: S108  a disk is slow

ROOM, TIMES = 100 << 20, 3
NUMBERS = np.random.default_rng(11).normal(size=(40, 3))
ASKED = {"rate": 100.0, "unit": "deg/s"}
RAW = {"dtype": "<i2", "columns": 3, "scale": "0.01deg/s", "rate": 100.0}
SNIPPETS = [
    b"\n",
    b"\r",
    b",",
    b";",
    b'"',
    b"#",
    b"nan",
    b"-",
    b"\0",
    b"\xff",
    b"1e999",
    b"[",
    b"O",
    b"%",
    b"\t",
    b"  ",
]
EXTREMES = [
    0,
    1,
    0x7F,
    0xFF,
    0x7FFF,
    0xFFFF,
    0x7FFFFFFF,
    0xFFFFFFFF,
    0x80000000,
    0x7FFFFFFFFFFFFFFF,
    0xFFFFFFFFFFFFFFFF,
]


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

    stamps = pa.array(np.arange(40) * 10_000, pa.timestamp("us"))
    table = pa.table({"time": stamps, "gx_dps": NUMBERS[:, 0], "n": np.arange(40) % 3, "tag": ["a", "b"] * 20})
    return _saved(lambda file: parquet.write_table(table, file, compression="none"))


def _hdf5(**how) -> bytes:
    import h5py

    def save(file):
        with h5py.File(file, "w", libver=how.pop("libver", None)) as f:
            f.create_dataset("imu/gyro", data=NUMBERS, **how).attrs["units"] = "deg/s"
            f["imu"].attrs["rate"] = 100.0
            f["imu/time"], f["note"] = np.arange(40) * 0.01, "on the table"

    return _saved(save)


def _matlab(**how) -> bytes:
    from scipy.io import savemat

    content = {"imu": {"gyro": NUMBERS, "t": np.arange(40) * 0.01, "cells": np.array([1, "a"], object)}, "fs": 100.0}
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
    rows = np.zeros(40, kind)
    rows["timestamp"], rows["xyz"] = np.arange(40) * 5000, NUMBERS
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
    return (head + about.format(5, 5) + rows + "\n" + about.format(6, 6) + rows).encode()


def _sentences() -> bytes:
    bodies = (",".join(("VNGYR", *(f"{x:+.6f}" for x in row))).encode() for row in NUMBERS)
    return b"".join(b"$%s*%04X\r\n" % (body, binascii.crc_hqx(body, 0)) for body in bodies)


def _mdf() -> bytes:
    import asammdf

    signals = [
        asammdf.Signal(NUMBERS[:, i], np.arange(40) * 0.01, name=f"g{a}", unit="deg/s") for i, a in enumerate("xyz")
    ]
    with tempfile.TemporaryDirectory() as folder, asammdf.MDF() as file:
        file.append(signals)
        return file.save(Path(folder, "a.mf4")).read_bytes()


def _kfgins() -> bytes:
    rows = np.column_stack((np.arange(40) * 0.005, NUMBERS * 1e-5, NUMBERS * 1e-4 + np.array([0, 0, 0.049])))
    return rows.astype("<f8").tobytes()


def _bag(form: str, compression: str = "") -> bytes:
    import bag_files

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
    """How a sound file is made, the options with which it is read, and how many mutations of it are read."""

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
            + b"0 -4 2 0 0 80\n" * 40
        ),
        {},
    ),
    "plain.npy": Seed(lambda: _saved(np.save, NUMBERS)),
    "fields.npy": Seed(lambda: _saved(np.save, np.zeros(40, [("time_ms", "i8"), ("gx_dps", "f4")]))),
    "archive.npz": Seed(lambda: _saved(np.savez, gx=NUMBERS[:, 0], t=np.arange(40) * 0.01)),
    "squeezed.npz": Seed(lambda: _saved(np.savez_compressed, gx=NUMBERS[:, 0], rate=np.array(100.0))),
    "described.npz": Seed(lambda: _written(".npz"), {}),
    "raw.bin": Seed(lambda: (NUMBERS * 100).astype("<i2").tobytes(), RAW),
    "plain.parquet": Seed(_parquet, {}, 50_000),
    "described.parquet": Seed(lambda: _written(".parquet"), {}),
    "plain.h5": Seed(_hdf5, {}, 10_000),
    "squeezed.h5": Seed(lambda: _hdf5(compression="gzip", shuffle=True, fletcher32=True, chunks=(10, 3)), {}, 10_000),
    "newest.h5": Seed(lambda: _hdf5(libver="latest", chunks=(10, 3), maxshape=(None, 3)), {}, 10_000),
    "described.h5": Seed(lambda: _written(".h5"), {}, 10_000),
    "matlab73.mat": Seed(_matlab_73),
    "matlab5.mat": Seed(_matlab, ASKED, 50_000),
    "squeezed.mat": Seed(lambda: _matlab(do_compression=True)),
    "matrix.rda": Seed(lambda: _r(".rda"), ASKED, 50_000),
    "frame.rds": Seed(lambda: _r(".rds"), ASKED, 50_000),
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


def generator(name: str, k: int) -> np.random.Generator:
    """The generator of mutation `k` of a seed file."""
    return np.random.default_rng((zlib.crc32(name.encode()), k))


def mutated(rng: np.random.Generator, data: bytes) -> bytes:
    """`data` with one to five damages: bytes changed, zeroed, removed, inserted, repeated, extreme sizes, a cut."""
    changed = bytearray(data)
    for _ in range(rng.integers(1, 6)):
        at, way, size = int(rng.integers(0, max(1, len(changed)))), int(rng.integers(0, 8)), int(rng.integers(1, 60))
        if way == 0 and changed:
            changed[at % len(changed)] = int(rng.integers(0, 256))
        elif way == 1 and changed:
            changed[at % len(changed)] ^= 1 << int(rng.integers(0, 8))
        elif way == 2:
            changed[at : at + size] = bytes(len(changed[at : at + size]))
        elif way == 3:
            del changed[at : at + size]
        elif way == 4:
            changed[at:at] = SNIPPETS[int(rng.integers(0, len(SNIPPETS)))]
        elif way == 5:
            changed[at:at] = changed[max(0, at - size) : at]
        elif way == 6:
            width, order = int(rng.choice([1, 2, 4, 8])), str(rng.choice(["little", "big"]))
            number = EXTREMES[int(rng.integers(0, len(EXTREMES)))] % (1 << 8 * width)
            changed[at : at + width] = number.to_bytes(width, order)
        elif rng.random() < 0.2:
            del changed[at:]
    return bytes(changed)


def options_of(rng: np.random.Generator, usual: dict) -> dict:
    """The options of the seed, or fewer, or more: each way leads through other code."""
    return (usual, usual, usual | ASKED, {k: v for k, v in usual.items() if k == "dtype"})[rng.integers(0, 4)]


def outcome(path: Path, options: dict) -> str:
    """What became of a file: read, the name of the refusal, or a traceback."""
    try:
        al.read(path, **options)
    except al.AllaniteError as error:
        if "does not fit into memory" in str(error):
            return f"memory\n{error}"
        said = str(error).removeprefix(str(path))
        return "refused" if len(said) > 20 else f"too few words\n{error}"
    except Exception:
        return "traceback\n" + traceback.format_exc()
    return "read"


class Forked:
    """What `subprocess.Popen` is for the process that reads a file of a fragile format, but forked."""

    def __init__(self, arguments, *, stderr, **_):
        (ask, asked), (answer, answered) = os.pipe(), os.pipe()
        self.pid = os.fork()
        if not self.pid:
            _work(arguments, (ask, answered, stderr.fileno()), (asked, answer))
        os.close(ask), os.close(answered)
        self.stdin, self.stdout, self.code = os.fdopen(asked, "wb"), os.fdopen(answer, "rb", 0), None
        self.stdout = io.BufferedReader(self.stdout)

    def kill(self):
        """Stop it."""
        if self.code is None:
            os.kill(self.pid, 9)

    def wait(self):
        """How it ended."""
        if self.code is None:
            self.code = os.waitstatus_to_exitcode(os.waitpid(self.pid, 0)[1])
        return self.code

    def communicate(self):
        """Wait until it has ended."""
        self.wait()
        with contextlib.suppress(OSError):
            self.stdin.close()
        self.stdout.close()


def _work(arguments, ours, theirs) -> None:
    """The forked process: its own program with its own standard streams, and then the end."""
    code = 1
    try:
        for fd in theirs:
            os.close(fd)
        for i, fd in enumerate(ours):
            os.dup2(fd, i)
        streams = (os.fdopen(0, closefd=False), os.fdopen(1, "w", closefd=False), os.fdopen(2, "w", closefd=False))
        sys.stdin, sys.stdout, sys.stderr = streams
        sys.argv = arguments[2:]
        WORKER[0].main()
        code = 0
    except SystemExit as error:
        code = 0 if error.code is None else 1
        print(error.code, file=sys.stderr, flush=True)
    except BaseException:
        traceback.print_exc()
        sys.stderr.flush()
    finally:
        os._exit(code)


def _fork_workers(name: str) -> None:
    # what is imported now need not be in each child
    importlib.import_module(IMPORTED[os.path.splitext(name)[1]])
    importlib.import_module("h5py")  # MATLAB 7.3
    from allanite.readers.sandbox import process

    spec = importlib.util.spec_from_file_location("worker", process.WORKER)
    WORKER.append(importlib.util.module_from_spec(spec))
    spec.loader.exec_module(WORKER[0])
    process.subprocess = type("Forking", (), {"Popen": Forked, "PIPE": subprocess.PIPE})


def _peak() -> int:
    kinds = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    return sum(resource.getrusage(kind).ru_maxrss for kind in kinds) * 1024


def _serve(name: str, data: bytes, span: tuple[int, int], place, *, pipe, fork: bool) -> None:
    """Read the mutations of a span; `place` holds the one at work, `pipe` takes what is found."""
    seed = SEEDS[name]
    if fork and name.endswith(CONTAINED):
        _fork_workers(name)
    with tempfile.TemporaryDirectory(dir=MEMORY) as folder:
        path = Path(folder, name)
        path.write_bytes(data)
        for _ in range(3):
            outcome(path, seed.options)  # what is imported and cached is there before the memory is watched
        followed(np.arange(4.0), np.arange(4), 16, 0.5)  # compiled, for time stamps that are damaged
        base, counts, slowest = _peak(), Counter(), 0.0
        for k in range(*span):
            place.value = k
            rng = generator(name, k)
            path.write_bytes(mutated(rng, data))
            options = options_of(rng, seed.options)
            took, said = _timed(path, options)
            peak, slowest = _peak() - base, max(slowest, took)
            counts[said.split("\n")[0]] += 1
            why = f"{took:.1f} s" if took > SLOW else f"{peak >> 20} MB" if peak > TIMES * len(data) + ROOM else ""
            if why or said not in ("read", "refused"):
                pipe.send(("failure", k, why or said))
                base = _peak()
        pipe.send(("done", counts, slowest, _peak() - base))


def _timed(path: Path, options: dict) -> tuple[float, str]:
    start = sum(os.times()[:4])  # of processes that have ended too; what waits for other jobs does not count
    said = outcome(path, options)
    return sum(os.times()[:4]) - start, said


class Result(NamedTuple):
    """What became of the mutations of a seed file."""

    name: str
    count: int
    counts: Counter
    failures: list
    slowest: float
    peak: int
    seconds: float


def run(name: str, count: int, *, first: int = 0, fork: bool = True) -> Result:
    """Read `count` mutations of a seed file in processes that are watched."""
    begin, counts, failures, slowest, peak = time.perf_counter(), Counter(), [], 0.0, 0
    context, data = multiprocessing.get_context("spawn"), SEEDS[name].make()
    _demand_sound(name, data)
    place, last = context.Value(ctypes.c_long, first), first + count
    while first < last:
        pipe, end = context.Pipe(duplex=False)
        process = context.Process(
            target=_serve,
            args=(name, data, (first, min(last, first + 5000)), place),
            kwargs={"pipe": end, "fork": fork},
        )
        process.start()
        end.close()
        said = _followed(process, pipe, place)
        failures += [(k, why) for what, k, why in (item for item in said if item[0] == "failure")]
        done = next((item for item in said if item[0] == "done"), None)
        if done:
            counts, slowest, peak = counts + done[1], max(slowest, done[2]), max(peak, done[3])
            first = min(last, first + 5000)
        else:
            counts["crash"] += 1
            failures.append((place.value, f"crash or hang, exit code {process.exitcode}"))
            first = place.value + 1
    return Result(name, count, counts, failures, slowest, peak, time.perf_counter() - begin)


def _demand_sound(name: str, data: bytes) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, name)
        path.write_bytes(data)
        if (said := outcome(path, SEEDS[name].options)) != "read":
            al.read(path, **SEEDS[name].options)
            raise RuntimeError(said)


def _followed(process, pipe, place) -> list:
    """What a process sends until it ends; one that stays at one file is stopped."""
    said, at, since = [], place.value, time.perf_counter()
    while True:
        if pipe.poll(0.2):
            try:
                said.append(pipe.recv())
            except EOFError:
                break
        if place.value != at:
            at, since = place.value, time.perf_counter()
        if time.perf_counter() - since > WATCH:
            process.kill()
    process.join()
    return said


ABOUT = f"""# Damaged files

- machine: {{machine}}
- command: `python benchmarks/fuzz_readers.py --write benchmarks/results/fuzz.md`, or with --only for single rows
- mutation k of a file has the seed (crc32 of its name, k), k from 0
- a failure is a traceback, a crash, a hang, over {SLOW:g} s of processor time, or over {TIMES} times the file and
  {ROOM >> 20} MB of memory

"""
HEADINGS = (
    "file", "bytes", "mutations", "read", "refused", "failures", "slowest ms", "memory MB", "commit", "date",
)  # fmt: skip


def row(r: Result, code: str) -> Row:
    """The line of a table for a result."""
    size = len(SEEDS[r.name].make())
    cells = (r.name, size, r.count, r.counts["read"], r.counts["refused"], len(r.failures))
    return (*map(str, cells), f"{r.slowest * 1e3:.0f}", f"{r.peak / 2**20:.0f}", code, str(date.today()))


def renewed(page: Page, line: Row) -> str:
    """The table with this line instead of that of the same file."""
    before = [tuple(old.values()) for table in page.tables() for old in table]
    rows = {one[0]: one for one in (*before, line)}
    return ABOUT.format(machine=processor()) + "\n".join(markdown(HEADINGS, [rows[n] for n in SEEDS if n in rows]))


def main() -> None:
    asked = begin(__doc__, share=1.0, only=",".join(SEEDS), jobs=2).asked
    code, failed = commit(), False
    with ThreadPoolExecutor(asked.jobs) as pool:
        for result in pool.map(lambda name: run(name, round(asked.share * SEEDS[name].count)), asked.only.split(",")):
            print(*row(result, code), sep=" | ", flush=True)
            for k, why in result.failures[:5]:
                print(f"  {result.name}, mutation {k}: {why}", flush=True)
            failed |= bool(result.failures)
            if path := asked.write:
                before = Page(path.read_text(encoding="utf-8") if path.exists() else "")
                path.write_text(renewed(before, row(result, code)), encoding="utf-8")
    sys.exit(failed)


if __name__ == "__main__":
    main()
