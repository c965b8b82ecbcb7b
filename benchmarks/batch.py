"""Many records: one process, two, and a Dask cluster of two; and what is lost or done twice when something fails.

    python benchmarks/batch.py [--records 2000] [--samples 1000000] [--failing 1000] [--short 20000] [--write PATH]

Each record is white noise and a random walk of its own seed, as .npy. A ratio is that of the times on the clock; beside
it, for a machine that others use as well, the ratio of processor times: that of one process over that of the parent
and of one worker of several. For failures there are --failing records of --short samples, one of which is no recording.
"""

from table import begin, markdown

import multiprocessing
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import psutil
from distributed import Client, LocalCluster

import allanite as al
from allanite.batch.cluster import Dask
from allanite.batch.executor import Executor, Processes, Serial
from allanite.batch.job import run_batch
from allanite.batch.status import Resumed

RECIPE = al.Recipe(rate=100.0, unit="deg/h")
WORKERS = 2
COMMAND = [sys.executable, "-m", "allanite.cli", "batch", "--rate", "100", "--unit", "deg/h", "--quiet"]


class Taken(NamedTuple):
    """Seconds on the clock, and of processor time of this process and of its workers."""

    wall: float
    own: float
    workers: float

    @property
    def longest(self) -> float:
        """Processor time of this process and of one of the workers."""
        return self.own + self.workers / WORKERS


def records(folder: Path, count: int, samples: int) -> Path:
    """Make the files."""
    folder.mkdir()
    for seed in range(count):
        rng = np.random.default_rng(seed)
        values = rng.normal(0.0, 5.0, samples) + np.cumsum(rng.normal(0.0, 5e-3, samples))
        np.save(folder / f"u{seed:05d}.npy", values)
    return folder


def timed(job: Callable[[], object], workers: Callable[[], float]) -> Taken:
    """The times of a job; `workers` tells the processor time of the workers so far."""
    begun = time.perf_counter(), time.process_time(), workers()
    job()
    ended = time.perf_counter(), time.process_time(), workers()
    return Taken(*(after - before for before, after in zip(begun, ended, strict=True)))


def children() -> float:
    """Processor time of the processes that this one has started, and of those that they had started and that ended."""
    return sum(sum(child.cpu_times()[:4]) for child in psutil.Process().children())


def same(one: Path, other: Path) -> str:
    """Whether two folders of results have the same bytes."""
    both = [{p.relative_to(at): p.read_bytes() for p in at.rglob("*") if p.is_file()} for at in (one, other)]
    return "yes" if both[0] == both[1] else "NO"


def speed(at: Path, count: int, samples: int) -> list[list[str]]:
    """Rows: executor, times, ratios, and whether the bytes are those of one process."""
    source = records(at / "speed", count, samples)
    run_batch(str(source / "u0000[01].npy"), at / "warm", RECIPE)  # compiled, imported

    def job(name: str, executor: Executor) -> Callable[[], Resumed]:
        return lambda: run_batch(source, at / name, RECIPE, executor=executor)

    found = {"serial": timed(job("serial", Serial()), children)}
    found[f"{WORKERS} processes"] = timed(job(f"{WORKERS} processes", Processes(WORKERS)), children)
    with LocalCluster(WORKERS, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        run = job("Dask", Dask(cluster.scheduler_address))
        found["Dask"] = timed(run, lambda: sum(client.run(time.process_time).values()))
    one = found["serial"]
    return [
        [name, f"{t.wall:.1f}", f"{t.own:.1f}", f"{t.workers:.1f}", f"{one.wall / t.wall:.2f}",
         f"{one.own / t.longest:.2f}", same(at / "serial", at / name)]
        for name, t in found.items()
    ]  # fmt: skip


def failures(at: Path, count: int, samples: int) -> list[list[str]]:
    """Rows: what happened, files analyzed before and after, failed files, and whether the bytes are the same."""
    source = records(at / "failing", count, samples)
    (source / "u00007.npy").write_bytes(b"\x93NUMPY no more")
    plain = run_batch(source, at / "plain", RECIPE, executor=Processes(WORKERS))
    rows = [["one file is no recording", "0", str(plain.analyzed), _failed(plain), "-"]]
    killed: list[int] = []

    def kill_one(what: str, fraction: float) -> None:
        if fraction > 0.3 and not killed:
            child = multiprocessing.active_children()[0]
            killed.append(child.pid or 0)
            child.kill()

    found = run_batch(source, at / "worker", RECIPE, executor=Processes(WORKERS), progress=kill_one)
    demand(bool(killed), "no worker was killed")
    rows.append(
        ["a worker is killed with -9", "0", str(found.analyzed), _failed(found), same(at / "plain", at / "worker")]
    )

    command = [*COMMAND, "--workers", str(WORKERS), str(source), "--out"]
    process = subprocess.Popen([*command, str(at / "killed")])
    while _parts(at / "killed") < count // 3:
        time.sleep(0.05)
    process.kill()
    process.wait()
    rows.append(_resumed("the batch is killed with -9", source, at, "killed"))

    return [*rows, *_full_disk(command, source, at)]


def _full_disk(command: list[str], source: Path, at: Path) -> list[list[str]]:
    """A row; the file system with half the room that is needed can be made by root only."""
    if not hasattr(os, "geteuid") or os.geteuid():
        return []
    room = sum(p.stat().st_size for p in (at / "plain" / "parts").iterdir()) // 2
    disk = at / "disk"
    disk.mkdir()
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={room}", "tmpfs", disk], check=True)
    try:
        done = subprocess.run([*command, str(disk / "full")], capture_output=True, text=True, check=False)
        demand("No space left on device" in done.stderr, done.stderr)
        shutil.copytree(disk / "full", at / "full")
    finally:
        subprocess.run(["umount", disk], check=True)
    return [_resumed("the disk is full", source, at, "full")]


def demand(holds: bool, what: object) -> None:
    """End the run if something else happened than what its row says."""
    if not holds:
        raise RuntimeError(what)


def _resumed(what: str, source: Path, at: Path, name: str) -> list[str]:
    before = _parts(at / name)
    found = run_batch(source, at / name, RECIPE, executor=Processes(WORKERS))
    demand(found.analyzed + before == len(found.files), (found.analyzed, before))  # nothing lost, nothing twice
    return [what, str(before), str(found.analyzed), _failed(found), same(at / "plain", at / name)]


def _failed(found: Resumed) -> str:
    return ", ".join(Path(file.file).name for file in found.failed)


def _parts(folder: Path) -> int:
    return len(list(folder.glob("parts/*.parquet")))


def main() -> None:
    run = begin(__doc__, records=2000, samples=1_000_000, failing=1000, short=20_000, folder="")
    asked = run.asked
    at = Path(tempfile.mkdtemp(dir=asked.folder or None))
    load = os.getloadavg()[1]
    try:
        fast = speed(at, asked.records, asked.samples)
        table = failures(at, asked.failing, asked.short)
    finally:
        shutil.rmtree(at)
    heads = ["executor", "clock, s", "this process, s", "workers, s", "ratio", "ratio of processor times", "same bytes"]
    notes = [
        f"seeds: 0..{asked.records - 1} and 0..{asked.failing - 1}",
        f"{os.cpu_count()} cores; load of the machine {load:.1f} before, {os.getloadavg()[1]:.1f} at the end: above "
        f"{os.cpu_count()} others share the cores, and the clock says less than the processor times",
    ]
    body = [
        f"## {asked.records} records of {asked.samples} samples", "", *markdown(heads, fast),
        f"## Failures, {asked.failing} records of {asked.short} samples", "",
        *markdown(["what", "there before", "analyzed then", "failed", "same bytes"], table),
    ]  # fmt: skip
    run.publish("Batch", notes, body)


if __name__ == "__main__":
    main()
