"""Programs that are ended at random moments: soon, whole or not at all, and without anything that is left behind.

Files: SIGINT, SIGTERM and SIGHUP by turns, on a usual disk and, by the superuser, on one of 5 MB in memory, too small
for some jobs; the target has to be the old file or a whole new one, and nothing else may remain. Verbs: Ctrl-C in every
verb and every statistic.

The moment is drawn from the time that the job takes, at most the first 10 s, after the time that the interpreter needs
to begin. Ends with exit code 1 if a program needs more than 1 s to end, leaves a process or a file behind, or ends in
the words of a defect.
"""

from table import begin, section

import contextlib
import gzip
import json
import os
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import zlib
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path

import numpy as np

import allanite as al

STARTED, LONGEST, LIMIT, END = 0.25, 10.0, 1.0, 0.5
"""Seconds until signals are taken over, of a job that are looked at, to end in, and of Python's own end after a job."""

ENDED, FINISHED = {-2, 129, 130, 143}, {0, 4, 5}
"""Exit codes of a program that a signal has ended, -2 is how Python itself ends at Ctrl-C; of one that was done."""

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
OLD = b"what was there before\n"
MODEL = "--model 'N 0.01 deg/sqrt(h), B 0.1 deg/h, K 0.1 deg/h^1.5' --rate 100"

VERBS = (
    *(f"{verb} gyro.npz" for verb in ("info", "analyze", "spectrum", "dynamic", "rate", "statespace", "plan")),
    *(f"deviation gyro.npz --statistic {name}" for name in al.statistics.STATISTICS),
    "deviation gyro.npz --statistic mtotdev --threads 2",
    "deviation gyro.npz --taus all",
    "deviation gyro.npz --statistic mtie --taus all",
    "analyze gyro.npz --report page.html --force",
    "analyze gyro.npz --method gls",
    "analyze gyro.csv",
    "analyze gyro.csv.gz",
    "analyze gyro.npy --rate 100 --unit deg/s --memory 20MB",
    "spectrum gyro.npz --estimator multitaper",
    "dynamic gyro.npz --statistic theo1",
    "compare gyro.npz other.npz",
    "compare gyro.npz --part 10000",
    "compensate warm.npz --rate 100 --regressors temperature --degree 3",
    "vertical six.npz --rate 100",
    "export gyro.npz --to kalibr --model 'N 100 ug/sqrt(Hz), K 10 ug/sqrt(h)'",
    "batch folder --out results",
    f"simulate made.npz {MODEL} --samples SAMPLES --force",
    f"plan {MODEL} --durations 50000,500000",
    "selfcheck gyro.npz --records 50",
    f"selfcheck {MODEL} --samples SAMPLES --records 50",
    "example 000 papers --force",
)
"""Every verb and statistic; SAMPLES stands for the length of the record."""

JOBS = {
    "analyze --report": "analyze IN/gyro.npz --quiet --force --report OUT/a.html",
    "simulate .npz": "simulate OUT/s.npz --sensor mems --rate 100 --force --samples 300000",
    "simulate .npz, too large": "simulate OUT/s.npz --sensor mems --rate 100 --force --samples 3000000",
    "info of a .csv.gz": "info IN/gyro.csv.gz --quiet --force --json OUT/i.json",
}
"""Commands that write a file."""

Line = tuple[list[str], list[str]]
"""The cells of a job, and what went wrong."""


def started(line: str, folder: Path, **more: str) -> subprocess.Popen[bytes]:
    """A command in a folder, with variables besides."""
    command = [sys.executable, "-m", "allanite.cli", *shlex.split(line)]
    quiet = {"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE}
    return subprocess.Popen(command, cwd=folder, env=os.environ | more, start_new_session=True, **quiet)


def alone(group: int) -> bool:
    """Whether no process of the group runs on for half a second; one that has ended may wait to be asked how."""
    for _ in range(10):
        listed = subprocess.run(["ps", "-A", "-o", "pgid=,stat="], capture_output=True, text=True, check=True).stdout
        states = [state for of, state in map(str.split, listed.splitlines()) if int(of) == group]
        if all(state.startswith("Z") for state in states):
            return True
        time.sleep(0.05)
    os.killpg(group, signal.SIGKILL)
    return False


def undisturbed(start: Callable[[], subprocess.Popen[bytes]]) -> tuple[float, int]:
    """How long a job takes if nothing ends it, and its exit code."""
    begun, running = time.perf_counter(), start()
    try:
        running.communicate(timeout=LONGEST)
    except subprocess.TimeoutExpired:
        os.killpg(running.pid, signal.SIGKILL)
        running.communicate()
        return LONGEST, 0
    return time.perf_counter() - begun, running.returncode


def moments(
    name: str, start: Callable[[], subprocess.Popen[bytes]], look: Callable[[], str], signals: Sequence[int], runs: int
) -> Line:
    """The line of a job that is started anew for each run; `look` tells what is left."""
    takes, usual = undisturbed(start)
    wrong = [f"{name}: exit code {usual}"] if signals == SIGNALS[:1] and usual not in FINISHED else []
    ended, slowest = 0, 0.0
    for k in range(runs):
        rng = np.random.default_rng((zlib.crc32(name.encode()), k))
        at, number = rng.uniform(STARTED, max(takes, 2 * STARTED)), signals[k % len(signals)]
        running = start()
        time.sleep(at)
        sent = time.perf_counter()
        running.send_signal(number)
        printed, took = running.communicate()[1], time.perf_counter() - sent
        code, slowest = running.returncode, max(slowest, took)
        ended += code in ENDED
        why = [
            f"{took:.2f} s" if took > LIMIT else "",
            "" if code in {*ENDED, *FINISHED, usual, -number * (at > takes - END)} else f"exit {code}: {printed!r:.99}",
            "words of a defect" if b"Traceback" in printed or b"internal error" in printed else "",
            "" if alone(running.pid) else "a process is left",
            look(),
        ]
        wrong += [f"{name}, run {k}, {signal.Signals(number).name} at {at:.3f} s: {each}" for each in why if each]
    print(name, *wrong, sep="\n", file=sys.stderr, flush=True)
    seconds = f"{takes:.1f}" if takes < LONGEST else f"over {LONGEST:g}"
    return [name, seconds, str(runs), str(ended), f"{slowest:.2f}", str(len(wrong))], wrong


@contextlib.contextmanager
def disks(root: Path) -> Iterator[dict[str, Path]]:
    """Folders on the disks where jobs run."""
    usual, small = root / "usual", root / "small"
    usual.mkdir()
    small.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=5m", "tmpfs", str(small)]
    mounted = not subprocess.run(mount, capture_output=True, check=False).returncode
    try:
        yield {"usual disk": usual} | ({"disk of 5 MB": small} if mounted else {})
    finally:
        if mounted:
            subprocess.run(["umount", str(small)], check=True)


def job(line: str, disk: Path) -> subprocess.Popen[bytes]:
    """Start a job, with an old file in the place of its target."""
    for folder in (disk / "out", disk / "copies"):
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
    target_of(line).write_bytes(OLD)
    return started(line, disk, TMPDIR=str(disk / "copies"))


def target_of(line: str) -> Path:
    """What a job writes."""
    return Path(next(word for word in line.split() if "/out/" in word))


def left(line: str, disk: Path) -> str:
    """What is not as it should be once a job has ended."""
    target = target_of(line)
    others = [path.name for name in ("out", "copies") for path in (disk / name).iterdir() if path != target]
    if others:
        return f"left: {', '.join(others)}"
    good = target.read_bytes() == OLD or whole(target)
    return "" if good else f"a target of {target.stat().st_size} bytes that is not whole"


def whole(target: Path) -> bool:
    """Whether a target is a page, a record or a result from its beginning to its end."""
    if target.suffix == ".html":
        data = target.read_bytes()
        return data.startswith(b"<!DOCTYPE html>") and data.rstrip().endswith(b"</html>")
    try:
        return bool(json.loads(target.read_text("utf-8")) if target.suffix == ".json" else al.read(target)[0].size)
    except (al.AllaniteError, ValueError):
        return False


def files(folder: Path, samples: int, runs: int) -> Iterator[Line]:
    """The lines of jobs that write a file."""
    recordings(folder, samples)
    with disks(folder) as places:
        for name, command in JOBS.items():
            for disk, path in places.items():
                line = command.replace("IN", str(folder)).replace("OUT", str(path / "out"))
                yield moments(f"{name}, {disk}", partial(job, line, path), partial(left, line, path), SIGNALS, runs)


def recordings(folder: Path, samples: int) -> None:
    """The files that the verbs read."""
    rng = np.random.default_rng(1)
    gyro, other = (al.simulate(al.sensor("mems"), samples, 100.0, rng=rng) for _ in range(2))
    al.write(gyro, folder / "gyro.npz")
    al.write(other, folder / "other.npz")
    al.write(gyro, folder / "gyro.csv")
    (folder / "gyro.csv.gz").write_bytes(gzip.compress((folder / "gyro.csv").read_bytes(), 1))
    np.save(folder / "gyro.npy", gyro.values)
    names = ("gx [deg/s]", "gy [deg/s]", "gz [deg/s]", "ax [g]", "ay [g]", "az [g]")
    still = gyro.values[: samples // 6]
    np.savez(folder / "six.npz", **{name: still + (name == "az [g]") for name in names})
    slow = np.cumsum(rng.standard_normal(samples)) / np.sqrt(samples)
    np.savez(folder / "warm.npz", **{"gyro [deg/s]": gyro.values + slow / 100, "temperature [degC]": 20 + slow})
    (folder / "folder").mkdir()
    for name in ("gyro.npz", "other.npz"):
        os.link(folder / name, folder / "folder" / name)


def verb(line: str, folder: Path) -> subprocess.Popen[bytes]:
    """Start a verb; a batch would go on where it has stopped."""
    shutil.rmtree(folder / "results", ignore_errors=True)
    return started(line, folder)


def main() -> int:
    run = begin(__doc__, files=100, verbs=3, samples=5_000_000)
    for number in SIGNALS:  # which a shell or nohup may have let programs ignore
        signal.signal(number, signal.default_int_handler if number == signal.SIGINT else signal.SIG_DFL)
    headings = ("job", "takes s", "runs", "ended by the signal", "slowest s", "failures")
    with tempfile.TemporaryDirectory() as short, tempfile.TemporaryDirectory() as long:
        samples, folder = run.asked.samples, Path(long)
        of_files = list(files(Path(short), samples // 12, run.asked.files))
        recordings(folder, samples)
        lines = [line.replace("SAMPLES", str(samples)) for line in VERBS]
        of_verbs = [moments(each, partial(verb, each, folder), str, SIGNALS[:1], run.asked.verbs) for each in lines]
    wrong = [each for _, why in of_files + of_verbs for each in why]
    notes = (
        "run k of a job has the seed (crc32 of its name, k); the slowest is that of all runs, to the end",
        f"failures: {len(wrong)}",
        *(f"failed: {each}" for each in wrong),
    )
    run.publish("Programs ended at random moments", notes, [
        *section("Files, by three signals", headings, [row for row, _ in of_files]),
        *section("Verbs, by Ctrl-C", headings, [row for row, _ in of_verbs]),
    ])  # fmt: skip
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
