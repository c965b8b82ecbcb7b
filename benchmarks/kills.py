"""Programs that are ended at random moments: soon, whole or not at all, and without anything that is left behind.

Files: SIGINT, SIGTERM and SIGHUP by turns, on a usual disk and, by the superuser, on one of 5 MB in memory, too small
for some jobs; the target has to be the old file or a whole new one, and nothing else may remain. Verbs: Ctrl-C in every
verb and every statistic.

The moment is drawn from the time that the job takes, at most the first 10 s, after the time that the interpreter needs
to begin. Run k of a job has the seed (crc32 of its name, k). Ends with exit code 1 if a program needs more than 1 s to
end, leaves a process or a file behind, or ends in the words of a defect.
"""

from table import begin, section

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
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

import allanite as al

STARTED, LONGEST, LIMIT = 0.25, 10.0, 1.0
"""Seconds until the program has taken the signals over, of a job that are looked at, and in which it has to end."""

ENDED, FINISHED = {-2, 129, 130, 143}, {0, 4, 5}
"""Exit codes of a program that a signal has ended, -2 is how Python itself ends at Ctrl-C; of one that was done."""

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
OLD = b"what was there before\n"
SMALL = "5m"
MODEL = ("--model", "N 0.01 deg/sqrt(h), B 0.1 deg/h, K 0.1 deg/h^1.5")

VERBS = {
    "deviation --threads 2, mtotdev": "deviation gyro.npz --statistic mtotdev --threads 2",
    "deviation --taus all, mtie": "deviation gyro.npz --statistic mtie --taus all",
    "analyze of a .csv": "analyze gyro.csv",
    "analyze of a .csv.gz": "analyze gyro.csv.gz",
    "analyze --memory": "analyze gyro.npy --rate 100 --unit deg/s --memory 20MB",
    "compensate": "compensate warm.npz --rate 100 --regressors temperature --degree 3",
    "vertical": "vertical six.npz --rate 100",
    "export": ("export", "gyro.npz", "--to", "kalibr", "--model", "N 100 ug/sqrt(Hz), K 10 ug/sqrt(h)"),
    "batch": "batch folder --out results",
    "simulate": ("simulate", "made.npz", *MODEL, "--rate", "100", "--samples", "{samples}", "--force"),
    "plan": ("plan", *MODEL, "--rate", "100", "--durations", "50000,500000"),
    "selfcheck": ("selfcheck", *MODEL, "--rate", "100", "--samples", "{samples}", "--records", "50"),
    "example": "example 000 papers --force",
}
PLAIN = (
    "info", "analyze", "analyze --report page.html --force", "analyze --method gls", "deviation --taus all", "spectrum",
    "spectrum --estimator multitaper", "dynamic", "dynamic --statistic theo1", "compare other.npz",
    "compare --part 10000", "rate", "statespace", "plan", "selfcheck --records 50",
    *(f"deviation --statistic {name}" for name in al.statistics.STATISTICS),
)  # fmt: skip
"""Verbs and options of which nothing else is asked: the record stands between them."""

VERBS = {f"{line} of a file": line.replace(" ", " gyro.npz ", 1) if " " in line else f"{line} gyro.npz"
         for line in PLAIN} | VERBS  # fmt: skip


SIMULATED = "simulate {out}/s.npz --sensor mems --rate 100 --force --samples "
JOBS = {
    "analyze --report": (
        "analyze {in}/gyro.npz --quiet --force --report {out}/a.html", "a.html", b"<!DOCTYPE html>", b"</html>"
    ),
    "simulate .npz": (f"{SIMULATED}300000", "s.npz", b"PK", b""),
    "simulate .npz, too large": (f"{SIMULATED}3000000", "s.npz", b"PK", b""),
    "info of a .csv.gz": ("info {in}/gyro.csv.gz --quiet --force --json {out}/i.json", "i.json", b"{", b"}"),
}  # fmt: skip
"""Commands, their target, and how it begins and ends when it is whole."""

Line = tuple[list[str], list[str]]
"""The cells of a job, and what went wrong."""


def started(words: str | Sequence[str], folder: Path, **more: str) -> subprocess.Popen[bytes]:
    """A command in a folder, with variables besides."""
    command = [sys.executable, "-m", "allanite.cli", *(words.split() if isinstance(words, str) else words)]
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


def undisturbed(start: Callable[[], subprocess.Popen[bytes]]) -> tuple[float, int, list[str]]:
    """How long a job takes if nothing ends it, its exit code, and the last line of its errors."""
    begun, running = time.perf_counter(), start()
    try:
        words = running.communicate(timeout=LONGEST)[1].decode().strip().splitlines()
    except subprocess.TimeoutExpired:
        os.killpg(running.pid, signal.SIGKILL)
        running.communicate()
        return LONGEST, 0, []
    return time.perf_counter() - begun, running.returncode, words[-1:]


def moments(
    name: str, start: Callable[[], subprocess.Popen[bytes]], look: Callable[[], str], signals: Sequence[int], runs: int
) -> Line:
    """The line of a job that is started anew for each run; `look` tells what is left."""
    takes, usual, words = undisturbed(start)
    wrong = [f"{name}: {words}"] if signals == SIGNALS[:1] and usual not in FINISHED else []
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
            "" if code in {*ENDED, *FINISHED, usual} else f"exit code {code}: {printed!r:.200}",
            "words of a defect" if b"Traceback" in printed or b"internal error" in printed else "",
            "" if alone(running.pid) else "a process is left",
            look(),
        ]
        wrong += [f"{name}, run {k}, {signal.Signals(number).name} at {at:.3f} s: {each}" for each in why if each]
    print(name, *wrong, sep="\n", file=sys.stderr, flush=True)
    seconds = f"{takes:.1f}" if takes < LONGEST else f"over {LONGEST:g}"
    return [name, seconds, str(runs), str(ended), f"{slowest:.2f}", str(len(wrong))], wrong


# --- files -----------------------------------------------------------------------------------------------------------


@contextlib.contextmanager
def disks(root: Path) -> Iterator[dict[str, Path]]:
    """Folders on the disks where jobs run."""
    usual, small = root / "usual", root / "small"
    usual.mkdir()
    small.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", f"size={SMALL}", "tmpfs", str(small)]
    mounted = os.name == "posix" and not subprocess.run(mount, capture_output=True, check=False).returncode
    try:
        yield {"usual disk": usual} | ({"disk of 5 MB": small} if mounted else {})
    finally:
        if mounted:
            subprocess.run(["umount", str(small)], check=True)


class Place(NamedTuple):
    """Where a job reads and writes."""

    source: Path
    disk: Path
    words: str
    target: str
    begins: bytes
    ends: bytes

    def start(self) -> subprocess.Popen[bytes]:
        """Start it, with an old file in the place of its target."""
        out, copies = self.disk / "out", self.disk / "copies"
        for folder in (out, copies):
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir()
        (out / self.target).write_bytes(OLD)
        words = self.words.replace("{in}", str(self.source)).replace("{out}", str(out))
        return started(words, self.disk, TMPDIR=str(copies))

    def wrong(self) -> str:
        """What is not as it should be once the program has ended."""
        target = self.disk / "out" / self.target
        data = target.read_bytes()
        others = [p.name for folder in ("out", "copies") for p in (self.disk / folder).iterdir() if p != target]
        if others:
            return f"left: {', '.join(others)}"
        whole = data.startswith(self.begins) and data.rstrip().endswith(self.ends) and readable(target)
        return "" if data == OLD or whole else f"a target of {len(data)} bytes that is not whole"


def readable(target: Path) -> bool:
    """Whether a record is read from a target that holds one."""
    try:
        return target.suffix != ".npz" or al.read(target)[0].size > 0
    except al.AllaniteError:
        return False


def files(folder: Path, samples: int, runs: int) -> Iterator[Line]:
    """The lines of jobs that write a file."""
    recordings(folder, samples)
    with disks(folder) as places:
        for name, job in JOBS.items():
            for disk, path in places.items():
                place = Place(folder, path, *job)
                yield moments(f"{name}, {disk}", place.start, place.wrong, SIGNALS, runs)


# --- verbs -----------------------------------------------------------------------------------------------------------


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


def verbs(folder: Path, samples: int, runs: int) -> Iterator[Line]:
    """The lines of verbs and statistics."""
    recordings(folder, samples)
    for name, line in VERBS.items():
        words = line.split() if isinstance(line, str) else line
        words = [word.replace("{samples}", str(samples)) for word in words]

        def start(words: Sequence[str] = words) -> subprocess.Popen[bytes]:
            shutil.rmtree(folder / "results", ignore_errors=True)  # a batch goes on where it has stopped
            return started(words, folder)

        yield moments(name, start, str, SIGNALS[:1], runs)


def main() -> int:
    run = begin(__doc__, files=100, verbs=3, samples=5_000_000)
    for number in SIGNALS:  # which a shell or nohup may have let programs ignore
        signal.signal(number, signal.default_int_handler if number == signal.SIGINT else signal.SIG_DFL)
    headings = ("job", "takes s", "runs", "ended by the signal", "slowest s", "failures")
    with tempfile.TemporaryDirectory() as a, tempfile.TemporaryDirectory() as b:
        of_files = list(files(Path(a), run.asked.samples // 12, run.asked.files))
        of_verbs = list(verbs(Path(b), run.asked.samples, run.asked.verbs))
    wrong = [each for _, why in of_files + of_verbs for each in why]
    notes = (
        "run k of a job has the seed (crc32 of its name, k); the slowest is that of all runs, to the end",
        f"a failure is more than {LIMIT:g} s, a process or a file that is left, a target that is neither the old file "
        f"nor a whole new one, or the words of a defect: {len(wrong)}",
        *(f"failed: {each}" for each in wrong),
    )
    run.publish("Programs ended at random moments", notes, [
        *section("Files, by three signals", headings, [row for row, _ in of_files]),
        *section("Verbs, by Ctrl-C", headings, [row for row, _ in of_verbs]),
    ])  # fmt: skip
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
