"""Tasks that other processes import, and what the tests of batches share."""

import os
import signal
import time
from pathlib import Path

from pyarrow import parquet

import allanite as al


def doubled(item):
    if item["x"] == 3:
        raise RuntimeError("three")
    return {"y": 2 * item["x"]}


def deadly(item):
    """Kills its own process: always, or the first time."""
    if item["x"] == "always" or (item["x"] == "once" and not Path(item["mark"]).exists()):
        Path(item["mark"]).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return {"pid": os.getpid()}


def out_of_memory(item):
    raise MemoryError


def waiting(item):
    time.sleep(item["x"])
    return {"x": item["x"]}


def gyros(folder, sizes, length=2000):
    """Recordings of these angle random walks: u0.csv and so on."""
    for i, size in enumerate(sizes):
        al.write(al.simulate(al.N(size, "deg/sqrt(h)"), length, 10.0, rng=i, name="gz"), folder / f"u{i}.csv")


def with_bad(folder, sizes):
    """A new folder of such recordings, and of a file that is none."""
    folder.mkdir(exist_ok=True)
    gyros(folder, sizes)
    (folder / "bad.csv").write_text("hello\nworld\n")
    return folder


def contents(results):
    return {path.relative_to(results): path.read_bytes() for path in results.rglob("*") if path.is_file()}


def stored(results, name):
    return parquet.read_table(results / f"{name}.parquet").to_pylist()
