"""Samples as they come: how fast a stream is, how good its coefficients, and what a file beyond memory costs.

Speed: processor time of the thread, the least of several, beside allantools.realtime and the whole record at once.
Coefficients: simulated records pushed in 16 chunks, and as a whole; root mean square errors over the Cramer-Rao bound.
Large files: each is made, analyzed and deleted; its pages are dropped from memory before it is read.
Processor time is of user and system, of all threads.
"""

from table import begin, least, section

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

import allantools.realtime
import numpy as np
import pyarrow as pa
from pyarrow import parquet

import allanite as al
from allanite.stream.accumulator import streamable

SAMPLES, PEER = 4_000_000, 3000  # of the stream, and of the peer, which is slow
SENSORS = (("mems", 100.0, 2**20, "NBK"), ("fog", 1.0, 2**18, "QNBKR"))


def factors(most: int) -> list[int]:
    """Averaging factors of a stream, up to one."""
    every = [*range(1, 16), *(q << k for k in range(1, 24) for q in range(8, 16))]
    return [m for m in every if m <= most]


def speed() -> list[list[str]]:
    """What, million samples per second, times allantools.realtime."""
    values, taken = np.random.default_rng(1).normal(size=SAMPLES), partial(least, clock=time.thread_time)
    record = al.Record(values, 1.0, "deg/h")

    def peer() -> None:
        stream = allantools.realtime.oadev_realtime(afs=np.array(factors(PEER // 2)))
        for value in values[:PEER].tolist():
            stream.add_frequency(value)

    paces = {"allantools.realtime, oadev": PEER / taken(peer, 2)}
    at_once = taken(lambda: al.deviation(replace(record), m=factors(SAMPLES // 2), noise=None), 2)
    paces["al.deviation, the same averaging times, every window"] = SAMPLES / at_once
    for chunk, count in ((SAMPLES, SAMPLES), (10_000, SAMPLES), (100, 800_000)):
        for statistic in streamable() if chunk == SAMPLES else ("oadev",):
            stream = al.Accumulator(1.0, "deg/h", statistic=statistic)
            parts = np.split(values[:count], range(chunk, count, chunk))
            push = partial(lambda stream, parts: [stream.push(part) for part in parts], stream, parts)
            push()
            paces[f"Accumulator, {statistic}, chunks of {chunk}"] = count / taken(push, 3)
    slow = next(iter(paces.values()))
    return [[what, f"{pace / 1e6:.3g}", f"{pace / slow:.0f}"] for what, pace in paces.items()]


def coefficients(records: int) -> list[list[str]]:
    """Sensor, samples, term, bound, and the errors of a stream and of the whole record over it."""
    rows = []
    for name, rate, n, terms in SENSORS:
        model, errors = al.sensor(name), []
        for seed in range(1, records + 1):
            record = al.simulate(model, n, rate, rng=np.random.default_rng(seed))
            stream = al.Accumulator(rate, record.unit, record.kind)
            for part in np.array_split(record.values, 16):
                stream.push(part)
            fits = stream.fit(terms, band="all"), al.identify(record, terms=terms, band="all", lines=False)
            errors.append([[abs((fit[s].value or 0.0) / model[s].value) - 1 for s in terms] for fit in fits])
        bound, rms = al.bound(model, n, rate), np.sqrt(np.mean(np.square(errors), axis=0))
        for symbol, *both in zip(terms, *rms, strict=True):
            ratios = (f"{error / bound[symbol]:.2f}" for error in both)
            rows.append([name, str(n), symbol, f"{100 * bound[symbol]:.2g}", *ratios])
    return rows


# --- large files -----------------------------------------------------------------------------------------------------

CHUNK = 5_000_000  # samples that are made at a time
subprocess._USE_VFORK = False  # else the peak memory of a command is at least that of this process
MEMORY = "500MB"  # what the analysis is given, so that it reads in parts


def chunks(count: int) -> Iterator[np.ndarray]:
    """White noise with a random walk, in parts."""
    for begin_at in range(0, count, CHUNK):
        rng, size = np.random.default_rng([1, begin_at]), min(CHUNK, count - begin_at)
        yield rng.standard_normal(size, dtype="f4") + 1e-4 * np.cumsum(rng.standard_normal(size, dtype="f4"))


def binary(path: Path, count: int) -> None:
    """A .npy of float64."""
    with path.open("wb") as file:
        about = {"descr": "<f8", "fortran_order": False, "shape": (count,)}
        np.lib.format.write_array_header_1_0(file, about)
        for part in chunks(count):
            part.astype("f8").tofile(file)
        os.fsync(file.fileno())


def columns(path: Path, count: int) -> None:
    """A Parquet of a column of float32, in row groups of a million."""
    schema = pa.schema([pa.field("gz", pa.float32(), metadata={"unit": "deg/h"})], {"rate": "1000"})
    with path.open("wb") as file, parquet.ParquetWriter(file, schema, use_dictionary=False) as writer:
        for part in chunks(count):
            writer.write_table(pa.table([pa.array(part)], schema), row_group_size=1_000_000)
        file.flush()
        os.fsync(file.fileno())


FILES = {".npy": (binary, ("--rate", "1000", "--unit", "deg/h")), ".parquet": (columns, ())}
"""By the suffix: what makes a file, and options with which it is analyzed."""


def large(suffix: str, folder: Path, count: int) -> list[str]:
    """The row of a file."""
    make, options = FILES[suffix]
    path = folder / f"a{suffix}"
    make(path, count)
    with path.open("rb") as file:
        os.posix_fadvise(file.fileno(), 0, 0, os.POSIX_FADV_DONTNEED)
    words = ("analyze", path, *options, "--memory", MEMORY, "--json", os.devnull, "--force", "--quiet")
    command = [sys.executable, "-m", "allanite.cli", *map(str, words)]
    begun, process = time.perf_counter(), subprocess.Popen(command, stdout=subprocess.DEVNULL)
    _, status, used = os.wait4(process.pid, 0)
    wall, size = time.perf_counter() - begun, path.stat().st_size / 1e6
    if status:
        raise RuntimeError(f"{command} ended with status {status}")
    path.unlink()
    numbers = (
        size / wall,
        (used.ru_utime + used.ru_stime) / count * 1e9,
        wall / count * 1e9,
        used.ru_maxrss * 1.024e-3,
    )
    return [suffix, f"{count / 1e6:g}", f"{size / 1e3:.2f}", *(f"{number:.0f}" for number in numbers)]


def main() -> None:
    run = begin(__doc__, records=200, millions=1000)
    fast, good = speed(), coefficients(run.asked.records)
    with tempfile.TemporaryDirectory() as folder:
        files = [large(suffix, Path(folder), run.asked.millions * 1_000_000) for suffix in FILES]
    notes = (
        f"seeds: 1..{run.asked.records} of records, (1, first sample) of each part of a file; errors over the "
        f"bound are known to {100 / np.sqrt(2 * run.asked.records):.0f} %",
        f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} processors at the end: beside other programs read the "
        "ratios and the processor time",
    )
    run.publish("Streams", notes, [
        *section("Speed", ("what", "million samples/s", "times allantools.realtime"), fast,
                 f"White noise; an Accumulator of oadev holds {al.Accumulator(1.0, 'deg/h').nbytes} bytes."),
        *section("Coefficients", ("sensor", "samples", "term", "bound %", "stream / bound", "whole / bound"), good),
        *section("Files that do not fit into memory",
                 ("file", "million samples", "GB", "MB/s", "processor ns/sample", "wall ns/sample", "peak MB"), files,
                 f"analyze is given --memory {MEMORY}; peak is its resident memory, the interpreter included."),
    ])  # fmt: skip


if __name__ == "__main__":
    main()
