"""Files that do not fit into memory: peak memory and throughput of `allanite analyze`, over reading alone.

Each file is made, read alone, analyzed and deleted. Its pages are dropped from memory before it is read, alone or by
the analysis: `cold`; and it is read alone once more, from memory: `warm`. Reading alone is readinto of 8 MB at a time,
or of Parquet iter_batches of pyarrow in one thread. Processor time is of user and system, of all threads.
"""

from table import begin, markdown

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

CHUNK = 5_000_000  # samples that are made at a time
MEMORY = "500MB"  # what the analysis is given, so that it reads in parts


class File(NamedTuple):
    """A kind of file: its suffix, bytes per sample, options, how it is made and how it is read alone."""

    suffix: str
    width: int
    options: tuple[str, ...]
    make: Callable[[Path, int, int], None]
    alone: str


def samples(count: int, seed: int, dtype: str) -> np.ndarray:
    """White noise with a random walk, as integers of a tenth of its deviation where they are asked for."""
    rng = np.random.default_rng(seed)
    values = rng.standard_normal(count, dtype=np.float32)
    values += np.float32(1e-4) * np.cumsum(rng.standard_normal(count, dtype=np.float32))
    return np.rint(10 * values).astype(dtype) if dtype[0] == "i" else values.astype(dtype)


def binary(dtype: str, *, npy: bool) -> Callable[[Path, int, int], None]:
    """What makes a file of numbers, with the header of NumPy or without."""

    def make(path: Path, count: int, seed: int) -> None:
        with path.open("wb") as file:
            if npy:
                np.lib.format.write_array_header_1_0(
                    file, {"descr": np.dtype(dtype).str, "fortran_order": False, "shape": (count,)}
                )
            for begin in range(0, count, CHUNK):
                samples(min(CHUNK, count - begin), seed + begin, dtype).tofile(file)
            os.fsync(file.fileno())

    return make


def parquet(path: Path, count: int, seed: int) -> None:
    """A column of float32, in row groups of a million."""
    import pyarrow as pa
    from pyarrow import parquet as pq

    schema = pa.schema([pa.field("gz", pa.float32(), metadata={"unit": "deg/h"})], {"rate": "1000"})
    with pq.ParquetWriter(path, schema, use_dictionary=False) as writer:
        for begin in range(0, count, CHUNK):
            values = samples(min(CHUNK, count - begin), seed + begin, "f4")
            writer.write_table(pa.table([pa.array(values)], schema), row_group_size=1_000_000)
    with path.open("rb") as file:
        os.fsync(file.fileno())


BYTES = "buffer = bytearray(8 << 20)\nwith open(path, 'rb', buffering=0) as f:\n    while f.readinto(buffer): pass"
BATCHES = (
    "from pyarrow import parquet\n"
    "for batch in parquet.ParquetFile(path, pre_buffer=False, buffer_size=1 << 20).iter_batches(1 << 20, "
    "use_threads=False): pass"
)
UNIT = ("--rate", "1000", "--unit", "deg/h")
FILES = {
    "npy-f8": File(".npy", 8, UNIT, binary("f8", npy=True), BYTES),
    "npy-f4": File(".npy", 4, UNIT, binary("f4", npy=True), BYTES),
    "raw-i2": File(".bin", 2, (*UNIT, "--dtype", "i2"), binary("i2", npy=False), BYTES),
    "parquet-f4": File(".parquet", 4, (), parquet, BATCHES),
}


class Cost(NamedTuple):
    """Wall time, processor time and peak resident memory of a process, s and bytes."""

    wall: float
    busy: float
    peak: float


def cost(command: list[str]) -> Cost:
    """What a command costs."""
    begun = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    _, status, used = os.wait4(process.pid, 0)
    wall = time.perf_counter() - begun
    if status:
        raise RuntimeError(f"{command} ended with status {status}")
    return Cost(wall, used.ru_utime + used.ru_stime, used.ru_maxrss * 1024)


def drop(path: Path) -> None:
    """Drop the pages of a file from memory."""
    with path.open("rb") as file:
        os.posix_fadvise(file.fileno(), 0, 0, os.POSIX_FADV_DONTNEED)


def measured(name: str, folder: Path, count: int, seed: int) -> list[str]:
    """A row of the table."""
    kind = FILES[name]
    path = folder / f"{name}{kind.suffix}"
    kind.make(path, count, seed)
    alone = [sys.executable, "-c", f"path = {str(path)!r}\n{kind.alone}"]
    drop(path)
    cold = cost(alone)
    warm = cost(alone)
    drop(path)
    analyze = [sys.executable, "-m", "allanite.cli", "analyze", str(path), *kind.options, "--memory", MEMORY]
    job = cost([*analyze, "--json", os.devnull, "--force", "--quiet"])
    size = path.stat().st_size
    path.unlink()
    return [
        name, f"{count / 1e6:g}", f"{size / 1e9:.2f}", f"{size / 1e6 / cold.wall:.0f}", f"{size / 1e6 / warm.wall:.0f}",
        f"{size / 1e6 / job.wall:.0f}", f"{100 * cold.wall / job.wall:.0f}", f"{100 * warm.wall / job.wall:.0f}",
        f"{job.busy / count * 1e9:.0f}", f"{job.wall / count * 1e9:.0f}", f"{job.peak / 1e6:.0f}",
    ]  # fmt: skip


def main() -> None:
    """Print the table."""
    run = begin(__doc__, millions=1000, files=list(FILES), folder=tempfile.gettempdir())
    count = run.asked.millions * 1_000_000
    with tempfile.TemporaryDirectory(dir=run.asked.folder, prefix="allanite-") as folder:
        rows = [measured(name, Path(folder), count, 10**10 * i) for i, name in enumerate(run.asked.files, 1)]
    heads = (
        "file", "million samples", "GB", "alone, cold, MB/s", "alone, warm, MB/s", "analyze, cold, MB/s",
        "over alone, cold, %", "over alone, warm, %", "processor ns/sample", "wall ns/sample", "peak MB",
    )  # fmt: skip
    loads = ", ".join(f"{load:.1f}" for load in os.getloadavg())
    notes = (
        "seeds: those of the parts of each file, 10^10 times its number plus their first sample",
        f"{os.cpu_count()} processors, load {loads} at the end: where the machine is shared, processor time is the "
        "figure to read",
        f"analyze is given --memory {MEMORY} and writes --json; peak is its resident memory, the interpreter included",
    )
    run.publish("Files that do not fit into memory", notes, markdown(heads, rows))


if __name__ == "__main__":
    main()
