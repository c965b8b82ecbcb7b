"""Small files that claim or cost much: memory, time and words of the program that reads them."""

import contextlib
import sqlite3
import struct
import subprocess
import sys
import zipfile

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import parquet
from tests.rows import rows

import allanite as al

h5py = pytest.importorskip("h5py")

NUMBERS = np.random.default_rng(1).normal(size=(3000, 2))
TEXT = "gx [deg/s],gy [rad/s]\n" + "\n".join(f"{x:.3f},{y:.3f}" for x, y in NUMBERS)


def archive_of_64_bits(path):
    """A legitimate .zip whose end names no numbers: those stand in a record of 64 bits before it."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a.csv", TEXT)
    raw = path.read_bytes()
    at = raw.rfind(b"PK\5\6")
    count, size, offset = struct.unpack("<HLL", raw[at + 10 : at + 20])
    record = struct.pack("<4sQHHLLQQQQ", b"PK\6\6", 44, 45, 45, 0, 0, count, count, size, offset)
    where = struct.pack("<4sLQL", b"PK\6\7", 0, at, 1)
    end = struct.pack("<4sHHHHLLH", b"PK\5\6", 0, 0, *[0xFFFF] * 2, *[0xFFFFFFFF] * 2, 0)
    path.write_bytes(raw[:at] + record + where + end)


def archive_of_many(path):
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("a.csv", TEXT)
        for k in range(100_000):
            archive.writestr(zipfile.ZipInfo(f"{k}" + "x" * 400), b"")


def page_of_text(path):
    table = pa.table({"t": ["x" * 1_000_000] * 100, "gx": NUMBERS[:100, 0]})
    parquet.write_table(table, path, compression="zstd", use_dictionary=False, data_page_size=1 << 31)


def chunks_of_one_sample(path):
    with h5py.File(path, "w") as file:
        samples = file.create_dataset("gx", shape=(60_000,), chunks=(1,), dtype="<f8")
        samples.attrs["units"] = "deg/s"
        samples[:] = np.resize(NUMBERS, 60_000)


def cells_of_text(path):
    words = "w" * 40
    path.write_text("gx [deg/s],a,b\n" + "".join(f"{k % 7}.5,{words}{k},{words}{k}z\n" for k in range(900_000)))


def bag_of_topics(path):
    with contextlib.closing(sqlite3.connect(path)) as file:
        file.execute("CREATE TABLE topics(id INTEGER, name, type, serialization_format, offered_qos_profiles)")
        file.execute("CREATE TABLE messages(id INTEGER, topic_id INTEGER, timestamp INTEGER, data BLOB)")
        rows = [(k, f"/imu{k}", "sensor_msgs/msg/Imu", "cdr", "") for k in range(59_000)]
        file.executemany("INSERT INTO topics VALUES(?, ?, ?, ?, ?)", rows)
        file.executemany("INSERT INTO messages VALUES(?, ?, ?, x'00')", [(k, k, k) for k in range(59_000)])
        file.commit()


def workbook_of_rows(path):
    book = pytest.importorskip("openpyxl").Workbook()
    book.active.append([1.0])
    book.save(path.with_suffix(".old"))
    rows = b"<row><c><v>1</v></c></row>" * 6_000_000
    with zipfile.ZipFile(path.with_suffix(".old")) as old, zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in old.namelist():
            data = old.read(name)
            archive.writestr(name, data.replace(b"</sheetData>", rows + b"</sheetData>"))


CASES = {
    "legitimate.zip": (archive_of_64_bits, None),
    "many.zip": (archive_of_many, "the directory of the archive claims"),
    "page.parquet": (page_of_text, "the table claims"), "chunks.h5": (chunks_of_one_sample, None),
    "cells.csv": (cells_of_text, None),
    "arrays.npz": (
        lambda path: np.savez(path, **{f"c{k} [deg/s]": NUMBERS[:32, 0] for k in range(9000)}),
        "the archive has 9000 arrays",
    ),
    "topics.db3": (bag_of_topics, "topics.db3: too many topics: 59000, and at most 1000 are read; copy those"),
    "rows.xlsx": (workbook_of_rows, "the workbook claims 156"),
    "name.csv": (lambda path: path.write_text(TEXT.replace("gx", "n" * 50_000)), None),
    "unit.csv": (lambda path: path.write_text(f"x [{'s*' * 25_000}],y [furlong]\n" + TEXT.partition("\n")[2]), "unit"),
    "name.npz": (lambda path: np.savez(path, **{"n" * 50_000 + " [furlong]": NUMBERS[:, 0]}), "unit"),
}  # fmt: skip
PROGRAM = """
import resource, sys
import allanite as al
from allanite.cli import main
def peak():  # ru_maxrss is also that of the program that started this one
    with open("/proc/self/status") as status:
        return next(int(line.split()[1]) for line in status if line.startswith("VmHWM"))
al.prepare.inspect(al.read("small.csv")[0])
before = peak()
print("INFO", flush=True)
try:
    main(["info", sys.argv[1], "--rate", "100", "--threads", "1"])
finally:
    child = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    print("USED", peak() - before + max(0, child - before))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="memory is in kB on Linux only")
@rows("name", CASES)
@pytest.mark.slow("memory of processes of their own")
def test_what_it_takes_and_what_is_said(name, tmp_path):
    make, refused = CASES[name]
    make(tmp_path / name)
    times = "".join(f"{k / 100:.2f},{x:.3f}\n" for k, x in enumerate(NUMBERS[:, 0]))
    (tmp_path / "small.csv").write_text(f"time [s],gx [deg/s]\n{times}")
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, name], cwd=tmp_path, capture_output=True, text=True, check=False, timeout=300
    )
    shown, _, used = done.stdout.partition("INFO")[2].partition("USED ")
    assert int(used) * 1024 < 300e6
    assert done.returncode == (0 if refused is None else 2 if "unit" in refused else 3), done.stderr
    assert refused is None or refused in done.stderr
    assert len(shown) + len(done.stderr) < 5000
    assert max(len(line) for line in (shown + done.stderr).splitlines()) < 700


@pytest.mark.slow("takes more than half a second")
def test_the_samples_are_those_of_the_file(tmp_path):
    archive_of_64_bits(tmp_path / "a.zip")
    chunks_of_one_sample(tmp_path / "a.h5")
    assert np.array_equal(al.read(tmp_path / "a.zip", rate=100)["gx"].values, NUMBERS[:, 0].round(3))
    assert np.array_equal(al.read(tmp_path / "a.h5", rate=100)["gx"].values, np.resize(NUMBERS, 60_000))
