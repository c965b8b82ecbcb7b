"""Programs that are ended at random moments: the target is the old file or the whole new one, nothing else is left.

    python benchmarks/signals.py [--runs 200] [--write PATH]

A signal of SIGINT, SIGTERM and SIGHUP is sent at a moment that is drawn from the time the whole job takes, after the
time the interpreter needs to begin. Run k of a job on a disk has the seed (crc32 of both names, k). Each job runs on a
usual disk and, by the superuser, on one of 5 MB in memory, which is too small for some of them. Ends with exit code 1
if something is left, the target is neither the old nor a whole new file, the words are those of a defect, or the
program needs more than 1 s to end.
"""

from table import begin, markdown

import contextlib
import gzip
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import zlib
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

import allanite as al

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
STARTED, LIMIT = 0.25, 1.0
"""Seconds until the program has taken the signals over, and in which it has to end."""

SMALL = "5m"
OLD = b"what was there before\n"
ENDED = {-2, 129, 130, 143}
"""Exit codes of a program that a signal has ended; -2 is how Python itself ends at Ctrl-C, 130 in a shell."""


class Job(NamedTuple):
    """A command, and how its target begins and ends when it is whole."""

    words: tuple[str, ...]
    target: str
    whole: tuple[bytes, bytes]


JOBS = {
    "analyze --report": Job(
        ("analyze", "{in}/a.npz", "--quiet", "--force", "--report", "{out}/a.html"),
        "a.html",
        (b"<!DOCTYPE html>", b"</html>"),
    ),
    "simulate .npz": Job(
        ("simulate", "{out}/s.npz", "--sensor", "mems", "--rate", "100", "--samples", "300000", "--force"),
        "s.npz",
        (b"PK", b""),
    ),
    "simulate .npz, too large": Job(
        ("simulate", "{out}/s.npz", "--sensor", "mems", "--rate", "100", "--samples", "3000000", "--force"),
        "s.npz",
        (b"PK", b""),
    ),
    "info of a .csv.gz": Job(
        ("info", "{in}/a.csv.gz", "--quiet", "--force", "--json", "{out}/i.json"), "i.json", (b"{", b"}")
    ),
}


def recordings(folder: Path) -> None:
    """The files that are read: one as it is, one packed."""
    record = al.simulate(al.sensor("mems"), 400_000, 100.0, rng=np.random.default_rng(1))
    al.write(record, folder / "a.npz")
    lines = "".join(f"{value:.9f}\n" for value in record.values.tolist())
    (folder / "a.csv.gz").write_bytes(gzip.compress(("# rate: 100\ngx [rad/s]\n" + lines).encode()))


@contextlib.contextmanager
def disks(root: Path) -> Iterator[dict[str, Path]]:
    """Folders on the disks where jobs run."""
    usual, small = root / "usual", root / "small"
    usual.mkdir()
    small.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", f"size={SMALL}", "tmpfs", str(small)]
    mounted = os.name == "posix" and not subprocess.run(mount, capture_output=True, check=False).returncode
    try:
        yield {"usual": usual} | ({"5 MB": small} if mounted else {})
    finally:
        if mounted:
            subprocess.run(["umount", str(small)], check=True)


class Place(NamedTuple):
    """Where a job reads and writes."""

    source: Path
    disk: Path

    def begin(self, job: Job) -> subprocess.Popen[bytes]:
        """Start it, with an old file in the place of its target."""
        out, copies = self.disk / "out", self.disk / "copies"
        for folder in (out, copies):
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir()
        (out / job.target).write_bytes(OLD)
        words = [word.replace("{in}", str(self.source)).replace("{out}", str(out)) for word in job.words]
        command = [sys.executable, "-m", "allanite.cli", *words]
        environment = {**os.environ, "TMPDIR": str(copies)}
        return subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)

    def wrong(self, job: Job, words: bytes) -> str:
        """What is not as it should be once the program has ended."""
        target = self.disk / "out" / job.target
        data = target.read_bytes()
        begins, ends = job.whole
        left = [p.name for folder in ("out", "copies") for p in (self.disk / folder).iterdir() if p != target]
        if left:
            return f"left: {', '.join(left)}"
        if data != OLD and not (data.startswith(begins) and data.rstrip().endswith(ends) and _read(target)):
            return f"a target of {len(data)} bytes that is not whole"
        return "a defect" if b"Traceback" in words or b"internal error" in words else ""


def _read(target: Path) -> bool:
    if target.suffix != ".npz":
        return True
    try:
        return al.read(target)[0].size > 0
    except al.AllaniteError:
        return False


def moments(name: str, disk: str, place: Place, runs: int) -> tuple[list[str], list[str]]:
    """The line of a job on a disk, and what went wrong."""
    job, counts, slowest, wrong = JOBS[name], Counter(), 0.0, []
    start = time.perf_counter()
    usual = place.begin(job)
    usual.communicate()
    whole = time.perf_counter() - start
    for k in range(runs):
        rng = np.random.default_rng((zlib.crc32(f"{name} {disk}".encode()), k))
        at, number = rng.uniform(STARTED, max(whole, 2 * STARTED)), SIGNALS[k % len(SIGNALS)]
        running = place.begin(job)
        time.sleep(at)
        running.send_signal(number)
        start = time.perf_counter()
        words = running.communicate()[1]
        took = time.perf_counter() - start
        code = running.returncode
        counts["ended" if code in ENDED else "finished" if code == usual.returncode else "other"] += 1
        slowest = max(slowest, took)
        why = place.wrong(job, words) or (f"{took:.1f} s" if took > LIMIT else "")
        if why:
            wrong.append(f"{name}, {disk}, run {k}, {number.name} at {at:.3f} s: {why}")
    cells = (name, disk, runs, counts["ended"], counts["finished"], counts["other"], f"{slowest:.2f}", len(wrong))
    return list(map(str, cells)), wrong


HEADINGS = ("job", "disk", "runs", "ended by the signal", "finished before", "ended otherwise", "slowest s", "failures")


def main() -> None:
    run = begin(__doc__, runs=200)
    for number in SIGNALS:  # which a shell or nohup may have let programs ignore
        signal.signal(number, signal.SIG_DFL)
    rows, wrong = [], []
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        (root / "in").mkdir()
        recordings(root / "in")
        with disks(root) as found:
            for name in JOBS:
                for disk, path in found.items():
                    row, why = moments(name, disk, Place(root / "in", path), run.asked.runs)
                    rows.append(row)
                    wrong += why
                    print(*row, *why, sep=" | ", flush=True)
    notes = (
        "run k of a job on a disk has the seed (crc32 of both names, k)",
        "a failure is a file that is left, a target that is neither the old file nor a whole new one, the words of a "
        f"defect, or more than {LIMIT:g} s from the signal to the end; the slowest is that of all runs",
        *(f"failed: {one}" for one in wrong),
    )
    run.publish("Programs ended at random moments", notes, markdown(HEADINGS, rows))
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
