"""Ctrl-C in every verb and every statistic at 5 million samples: the time until the program has ended.

    python benchmarks/interruption.py [--runs 3] [--samples 5000000] [--write PATH]

Each command is interrupted at moments drawn from the time that it takes, or the first 10 s of it. Run k of a job has
the seed (crc32 of its name, k). Ends with exit code 1 if a program needs more than 1 s, leaves a process behind, or
ends in other words than those of an interruption.
"""

from table import begin, markdown

import gzip
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import zlib
from pathlib import Path

import numpy as np

import allanite as al

STARTED, LONGEST, LIMIT = 0.25, 10.0, 1.0
"""Seconds until the program has taken the signal over, of a job that are looked at, and in which it has to end."""

CODES = {-2, 130}
"""Of a program that Ctrl-C has ended: -2 is how Python itself ends, 130 in a shell."""

MODEL = ("--model", "N 0.01 deg/sqrt(h), B 0.1 deg/h, K 0.1 deg/h^1.5")

VERBS: dict[str, tuple[str, ...]] = {
    "info": ("info", "gyro.npz"),
    "analyze": ("analyze", "gyro.npz"),
    "analyze --report": ("analyze", "gyro.npz", "--report", "page.html", "--force"),
    "analyze of a .csv": ("analyze", "gyro.csv"),
    "analyze of a .csv.gz": ("analyze", "gyro.csv.gz"),
    "analyze --memory": ("analyze", "gyro.npy", "--rate", "100", "--unit", "deg/s", "--memory", "20MB"),
    "analyze --method gls": ("analyze", "gyro.npz", "--method", "gls"),
    "deviation --taus all": ("deviation", "gyro.npz", "--taus", "all"),
    "deviation --taus all, mtie": ("deviation", "gyro.npz", "--statistic", "mtie", "--taus", "all"),
    "deviation --threads 2, mtotdev": ("deviation", "gyro.npz", "--statistic", "mtotdev", "--threads", "2"),
    "spectrum": ("spectrum", "gyro.npz"),
    "spectrum --estimator multitaper": ("spectrum", "gyro.npz", "--estimator", "multitaper"),
    "dynamic": ("dynamic", "gyro.npz"),
    "dynamic --statistic theo1": ("dynamic", "gyro.npz", "--statistic", "theo1"),
    "compare": ("compare", "gyro.npz", "other.npz"),
    "compare --part": ("compare", "gyro.npz", "--part", "10000"),
    "rate": ("rate", "gyro.npz"),
    "compensate": ("compensate", "warm.npz", "--rate", "100", "--regressors", "temperature", "--degree", "3"),
    "vertical": ("vertical", "six.npz", "--rate", "100"),
    "export": ("export", "gyro.npz", "--to", "kalibr", "--model", "N 100 ug/sqrt(Hz), K 10 ug/sqrt(h)"),
    "statespace": ("statespace", "gyro.npz"),
    "plan of a file": ("plan", "gyro.npz"),
    "selfcheck of a file": ("selfcheck", "gyro.npz", "--records", "50"),
    "batch": ("batch", "folder", "--out", "results"),
    "simulate": ("simulate", "made.npz", *MODEL, "--rate", "100", "--samples", "{samples}", "--force"),
    "plan": ("plan", *MODEL, "--rate", "100", "--durations", "50000,500000"),
    "selfcheck": ("selfcheck", *MODEL, "--rate", "100", "--samples", "{samples}", "--records", "50"),
    "example": ("example", "000", "papers", "--force"),
}
JOBS = {
    **{f"deviation --statistic {name}": ("deviation", "gyro.npz", "--statistic", name) for name in al.STATISTICS},
    **VERBS,
}


def recordings(folder: Path, samples: int) -> None:
    """The files that the jobs read."""
    rng = np.random.default_rng(1)
    gyro, other = (al.simulate(al.sensor("mems"), samples, 100.0, rng=rng) for _ in range(2))
    al.write(gyro, folder / "gyro.npz")
    al.write(other, folder / "other.npz")
    al.write(gyro, folder / "gyro.csv")
    with open(folder / "gyro.csv", "rb") as plain, gzip.open(folder / "gyro.csv.gz", "wb", 1) as packed:
        shutil.copyfileobj(plain, packed)
    np.save(folder / "gyro.npy", gyro.values)
    names = ("gx [deg/s]", "gy [deg/s]", "gz [deg/s]", "ax [g]", "ay [g]", "az [g]")
    still = gyro.values[: samples // 6]
    np.savez(folder / "six.npz", **{name: still + (name == "az [g]") for name in names})
    slow = np.cumsum(rng.standard_normal(samples)) / np.sqrt(samples)
    np.savez(folder / "warm.npz", **{"gyro [deg/s]": gyro.values + slow / 100, "temperature [degC]": 20 + slow})
    (folder / "folder").mkdir()
    for name in ("gyro.npz", "other.npz"):
        os.link(folder / name, folder / "folder" / name)


def started(words: tuple[str, ...], folder: Path, samples: int) -> subprocess.Popen[bytes]:
    shutil.rmtree(folder / "results", ignore_errors=True)  # a batch goes on where it has stopped
    command = [sys.executable, "-m", "allanite.cli", *(word.replace("{samples}", str(samples)) for word in words)]
    quiet = {"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE}
    return subprocess.Popen(command, cwd=folder, start_new_session=True, **quiet)


def whole(words: tuple[str, ...], folder: Path, samples: int) -> tuple[float, str]:
    """The time that a command takes, at most the longest, and what it says if it fails."""
    start = time.perf_counter()
    running = started(words, folder, samples)
    try:
        said = running.communicate(timeout=LONGEST)[1]
    except subprocess.TimeoutExpired:
        os.killpg(running.pid, signal.SIGKILL)
        running.communicate()
        return LONGEST, ""
    failed = running.returncode not in (0, 4, 5)
    return time.perf_counter() - start, said.decode().strip().splitlines()[-1] if failed else ""


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


def moments(name: str, folder: Path, samples: int, runs: int) -> tuple[list[str], list[str]]:
    """The line of a job, and what went wrong."""
    words, slowest, interrupted, wrong = JOBS[name], 0.0, 0, []
    takes, failed = whole(words, folder, samples)
    if failed:
        wrong.append(f"{name}: {failed}")
    for k in range(runs):
        rng = np.random.default_rng((zlib.crc32(name.encode()), k))
        at = rng.uniform(STARTED, max(takes, 2 * STARTED))
        running = started(words, folder, samples)
        time.sleep(at)
        start = time.perf_counter()
        running.send_signal(signal.SIGINT)
        said = running.communicate()[1]
        took = time.perf_counter() - start
        interrupted += running.returncode in CODES
        slowest = max(slowest, took)
        why = [
            f"{took:.2f} s" if took > LIMIT else "",
            "" if running.returncode in {*CODES, 0, 4, 5} else f"exit code {running.returncode}",
            "a traceback" if b"Traceback" in said or b"internal error" in said else "",
            "" if alone(running.pid) else "a process is left",
        ]
        wrong += [f"{name}, run {k} at {at:.3f} s: {one}" for one in why if one]
    seconds = f"{takes:.1f}" if takes < LONGEST else f"over {LONGEST:g}"
    return [name, seconds, str(runs), str(interrupted), f"{slowest:.2f}", str(len(wrong))], wrong


HEADINGS = ("job", "takes s", "runs", "interrupted", "slowest s", "failures")


def main() -> None:
    run = begin(__doc__, runs=3, samples=5_000_000)
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell lets programs in the background ignore it
    rows, wrong = [], []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        recordings(folder, run.asked.samples)
        for job in JOBS:
            row, why = moments(job, folder, run.asked.samples, run.asked.runs)
            rows.append(row)
            wrong += why
            print(*row, *why, sep=" | ", flush=True)
    notes = (
        f"{run.asked.samples} samples of a simulated MEMS gyro at 100 Hz",
        "run k of a job has the seed (crc32 of its name, k); the slowest is that of all runs, from Ctrl-C to the end",
        f"a failure is more than {LIMIT:g} s, a process that is left, or other words than those of an interruption",
        *(f"failed: {one}" for one in wrong),
    )
    run.publish("Ctrl-C in every verb and every statistic", notes, markdown(HEADINGS, rows))
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
