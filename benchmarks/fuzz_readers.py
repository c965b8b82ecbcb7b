"""Damaged files: whatever is done to a file of any format, it is read or refused in words, soon and in little memory.

    python benchmarks/fuzz_readers.py [--share 1] [--only gyro.npy,r.rds] [--jobs 2] [--through] [--write PATH]

Mutation k of a seed file is always the same: its generator is seeded by the name of the file and k, and one that fails
is printed with both. Each file is read in a process that is watched: a crash and a hang are failures as well as an
error of another type than AllaniteError, more than 2 s of processor time, and more than 3 times the file and 100 MB.
With --through the files are ten times as long, and what can still be read is sent on through one of the jobs, which
may take 5 s and 200 MB.
Formats of fragile libraries are read as always by a process of their own, here forked from one that has imported the
library, which saves 0.1 s to 2 s.
Ends with exit code 1 if there is a failure.
"""

from table import Page, Row, begin, commit, markdown, processor

import contextlib
import ctypes
import importlib.util
import io
import json
import multiprocessing
import os
import resource
import subprocess
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from datetime import date
from pathlib import Path
from typing import NamedTuple

import numpy as np

import allanite as al
from allanite.kernels.clock import followed
from allanite.reporting import to_csv
from damaged import SEEDS, generator, lengthen, mutated, options_of

IMPORTED = {".h5": "h5py", ".mat": "scipy.io", ".rda": "rdata.parser", ".rds": "rdata.parser", ".ulg": "pyulog"}
IMPORTED |= {".xlsx": "openpyxl", ".tdms": "nptdms", ".mf4": "asammdf"}
IMPORTED |= dict.fromkeys((".bag", ".db3", ".mcap"), "rosbags.typesys.stores.ros2_humble")
"""What the process of their own imports that reads these formats."""

CONTAINED = tuple(IMPORTED)

WARM = 60
"""Runs after which every job has been imported and compiled."""

WARMING = -1
"""In the place of the number of a mutation, until then."""

WORKER = []
"""The program of that process, once it is imported."""

SLOW, WATCH = 2.0, 120.0
"""Seconds that a file may take to be read, and after which the process is stopped."""

MEMORY = next((folder for folder in ("/dev/shm",) if os.path.isdir(folder)), None)  # noqa: S108  a disk is slow

ROOM, TIMES = 100 << 20, 3

ROWS = 400
"""Rows of the files that are sent through a job: of fewer, no noise is identified."""


class Way(NamedTuple):
    """How far a file is taken, in how many seconds of processor time and how much memory beside 3 times its size."""

    name: str
    slow: float
    room: int
    jobs: tuple = ()


def _analyzed(recording, _):
    study = al.analyze(recording)
    json.dumps(study.to_dict(), allow_nan=False)
    str(study), to_csv(study)


def _reported(recording, _):
    with tempfile.TemporaryDirectory(dir=MEMORY) as folder:
        al.report(al.analyze(recording), Path(folder, "a.html"))


def _deviation(recording, rng):
    statistic = str(rng.choice(list(al.STATISTICS)))
    for record in recording:
        str(al.deviation(record, statistic))


def _each(job):
    """A job of one record, for each of a recording."""
    return lambda recording, _: [str(job(record)) for record in recording]


READ = Way("reading", SLOW, ROOM)
THROUGH = Way(
    "reading and one of the jobs: analyze, deviation, spectrum, dynamic, compare, a page",
    5.0,
    200 << 20,
    (
        *(_analyzed, _deviation, _each(al.spectrum), _each(al.dynamic)),
        *(lambda recording, _: str(al.compare(recording, recording)), _reported),
    ),
)


def outcome(path: Path, options: dict, way: Way = READ, rng: np.random.Generator | None = None) -> str:
    """What became of a file: read, the name of the refusal, or a traceback."""
    try:
        recording = al.read(path, **options)
    except al.AllaniteError as error:
        if "does not fit into memory" in str(error):
            return f"memory\n{error}"
        said = str(error).removeprefix(str(path))
        return "refused" if len(said) > 20 else f"too few words\n{error}"
    except Exception:
        return "traceback\n" + traceback.format_exc()
    try:
        if way.jobs:
            way.jobs[rng.integers(0, len(way.jobs))](recording, rng)
    except al.AllaniteError as error:
        return "read" if len(str(error)) > 20 else f"too few words\n{error}"
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


def _serve(name: str, data: bytes, span: tuple[int, int], place, *, pipe, fork: bool, through: bool) -> None:
    """Read the mutations of a span; `place` holds the one at work, `pipe` takes what is found."""
    seed, way = SEEDS[name], THROUGH if through else READ
    if fork and name.endswith(CONTAINED):
        _fork_workers(name)
    warnings.simplefilter("error", RuntimeWarning)  # a division by zero is a defect
    with tempfile.TemporaryDirectory(dir=MEMORY) as folder:
        path = Path(folder, name)
        path.write_bytes(data)
        for _ in range(3):
            outcome(path, seed.options)  # what is imported and cached is there before the memory is watched
        followed(np.arange(4.0), np.arange(4), 16, 0.5)  # compiled, for time stamps that are damaged
        place.value = WARMING
        for k in range(WARM if through else 0):
            outcome(path, seed.options, way, np.random.default_rng(k))
        base, counts, slowest = _peak(), Counter(), 0.0
        for k in range(*span):
            place.value = k
            rng = generator(name, k)
            path.write_bytes(mutated(rng, data))
            options = options_of(rng, seed.options)
            took, said = _timed(path, options, way, rng)
            peak, slowest = _peak() - base, max(slowest, took)
            counts[said.split("\n")[0]] += 1
            why = (
                f"{took:.1f} s"
                if took > way.slow
                else f"{peak >> 20} MB"
                if peak > TIMES * len(data) + way.room
                else ""
            )
            if why or said not in ("read", "refused"):
                pipe.send(("failure", k, why or said))
                base = _peak()
        pipe.send(("done", counts, slowest, _peak() - base))


def _timed(path: Path, options: dict, way: Way, rng: np.random.Generator) -> tuple[float, str]:
    start = sum(os.times()[:4])  # of processes that have ended too; what waits for other jobs does not count
    said = outcome(path, options, way, rng)
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


def run(name: str, count: int, *, first: int = 0, fork: bool = True, through: bool = False) -> Result:
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
            kwargs={"pipe": end, "fork": fork, "through": through},
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
        if place.value != WARMING and time.perf_counter() - since > WATCH:
            process.kill()
    process.join()
    return said


ABOUT = """# Damaged files

- machine: {machine}
- command: `python benchmarks/fuzz_readers.py{words} --write benchmarks/results/{table}`, or with --only for
  single rows; with --resume it goes on after the mutations of the table, if they are of the same commit
- what is done: {way.name}
- mutation k of a file has the seed (crc32 of its name, k), k from 0
- a failure is a traceback, a crash, a hang, over {way.slow:g} s of processor time, or over {times} times the file and
  {room} MB of memory

"""
HEADINGS = (
    "file", "bytes", "mutations", "read", "refused", "failures", "slowest ms", "memory MB", "commit", "date",
)  # fmt: skip


def row(r: Result, code: str, before: dict[str, str] | None = None) -> Row:
    """The line of a table for a result, which goes on after a line before."""
    was = {k: int(before[k]) if before else 0 for k in HEADINGS[2:8]}
    counts = {"mutations": r.count, "read": r.counts["read"], "refused": r.counts["refused"]}
    sums = (was[k] + n for k, n in (*counts.items(), ("failures", len(r.failures))))
    most = max(was["slowest ms"], round(r.slowest * 1e3)), max(was["memory MB"], round(r.peak / 2**20))
    return (*map(str, (r.name, len(SEEDS[r.name].make()), *sums, *most)), code, str(date.today()))


def renewed(page: Page, line: Row, way: Way) -> str:
    """The table with this line instead of that of the same file."""
    before = [tuple(old.values()) for table in page.tables() for old in table]
    rows = {one[0]: one for one in (*before, line)}
    words, table = (" --through", "fuzz_analysis.md") if way.jobs else ("", "fuzz.md")
    about = ABOUT.format(machine=processor(), words=words, table=table, way=way, times=TIMES, room=way.room >> 20)
    return about + "\n".join(markdown(HEADINGS, [rows[n] for n in SEEDS if n in rows]))


def main() -> None:
    asked = begin(__doc__, share=1.0, only=",".join(SEEDS), jobs=2, through=False, resume=False).asked
    code, failed = commit(), False
    page = Page(asked.write.read_text(encoding="utf-8") if asked.write and asked.write.exists() else "")
    lines = {line["file"]: line for table in page.tables() for line in table}
    held = {name: line for name, line in lines.items() if asked.resume and line["commit"] == code}

    if asked.through:
        lengthen(ROWS)

    def one(name: str) -> Result:
        first = int(held[name]["mutations"]) if name in held else 0
        return run(name, round(asked.share * SEEDS[name].count), first=first, through=asked.through)

    with ThreadPoolExecutor(asked.jobs) as pool:
        for result in pool.map(one, asked.only.split(",")):
            line = row(result, code, held.get(result.name))
            print(*line, sep=" | ", flush=True)
            for k, why in result.failures[:5]:
                print(f"  {result.name}, mutation {k}: {why}", flush=True)
            failed |= bool(result.failures)
            if path := asked.write:
                page = Page(renewed(page, line, THROUGH if asked.through else READ))
                path.write_text(page.text, encoding="utf-8")
    sys.exit(failed)


if __name__ == "__main__":
    main()
