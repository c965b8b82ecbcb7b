"""What somebody waits for who has read the README and has a recording: parts of benchmarks/speed.py.

The commands and the Python of README.md are run word for word, in the order of the page: each that needs no
installation (uvx, pipx) in a home of its own, the others in one more, with a new virtual environment. A home is empty,
so are the caches of pip, uv and numba; variables of the environment are cleared but for those that lead to the package
index; the current folder has nothing but FILE, an hour of a gyro at 100 Hz. For the repository stands a clone of the
commit in a folder. Commands that analyze are run a second time.

Jobs: a CSV of six channels by the commands that a user types, each a new process with nothing set, over the time in
which pyarrow reads the same file in one thread.
"""

from table import ROOT, least, section

import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
import pyarrow as pa
from pyarrow import csv

import allanite as al

FIRST, WHOLE = 8.0, 30.0
"""Seconds of a first analysis, and from nothing to a figure of the user's own sensor, on two idle processors."""

MOST = {"html": 10.0, "json": 6.0}
"""Bounds of the time of jobs: times the read."""

GYRO, ACCEL = "N 0.5 deg/sqrt(h), B 5 deg/h, K 20 deg/h/sqrt(h)", "N 100 ug/sqrt(Hz), B 20 ug"
ADDRESS = "https://github.com/allanite/"
INDEX = ("PIP_", "UV_", "SSL_CERT_FILE")  # beginnings of variables that lead to the package index
ALONE = ("uvx", "pipx")  # programs that install what they run


def commands(readme: str) -> list[str]:
    """What the README says to type, in its order: lines of shell, and whole blocks of Python as `python -c`."""
    lines_typed = []
    for language, block in re.findall(r"^```(sh|console|python)\n(.*?)^```", readme, re.DOTALL | re.MULTILINE):
        lines = block.splitlines()
        typed = {
            "sh": [line for line in lines if not line.startswith("#")],
            "console": [line.removeprefix("$ ") for line in lines if line.startswith("$ ")],
            "python": [shlex.join(["python", "-c", block])],
        }
        lines_typed += typed[language]
    return lines_typed


def spent(words: list[Any], **how: Any) -> tuple[float, float]:
    """Time of a command that has to succeed, and that of the processors in it and its processes, s."""
    start, before = time.perf_counter(), os.times()
    done = subprocess.run(list(map(str, words)), capture_output=True, text=True, check=False, **how)
    wall, after = time.perf_counter() - start, os.times()
    used = after.children_user - before.children_user + after.children_system - before.children_system
    if done.returncode:
        sys.exit(f"{words}\n{done.stdout}{done.stderr}")
    return wall, used


@dataclass
class Place:
    """A home with nothing in it, and the folder in which commands are typed."""

    home: Path
    recording: Path
    origin: Path
    tools: tuple[Path, ...]

    def __post_init__(self) -> None:
        self.folder = self.home / "work"
        self.folder.mkdir(parents=True)
        (self.home / ".gitconfig").write_text(f'[url "file://{self.origin}/"]\n\tinsteadOf = {ADDRESS}\n')
        kept = {name: value for name, value in os.environ.items() if name.startswith(INDEX)}
        path = ":".join(map(str, (*self.tools, "/usr/bin", "/bin")))
        self.environment = kept | {"HOME": str(self.home), "PATH": path, "LANG": "C.UTF-8"}

    def typed(self, line: str, **more: str) -> tuple[float, float]:
        """Time of a command and of the processors, s; the next one is typed where it ended."""
        if not (self.folder / "FILE").exists():
            shutil.copy(self.recording, self.folder / "FILE")
        where = self.home / "where"
        words = ["sh", "-c", f'{line}\ncode=$?; pwd > "{where}"; exit $code']
        times = spent(words, cwd=self.folder, env=self.environment | more)
        self.folder = Path(where.read_text().strip())
        return times

    def row(self, line: str) -> tuple[str, float, float | None]:
        """A command, its time, and that of the same again if it analyzes; what it wrote is removed before."""
        before = set(self.folder.iterdir())
        first, *_ = self.typed(line)
        if " analyze " not in line:
            return line, first, None
        for path in set(self.folder.iterdir()) - before - {self.folder / "FILE"}:
            path.unlink()
        return line, first, self.typed(line)[0]


def python_of(folder: Path) -> Path:
    """A new virtual environment."""
    subprocess.run([sys.executable, "-m", "venv", folder], check=True)
    return folder / "bin"


def prepared(folder: Path) -> Callable[[str], Place]:
    """Makes places of a name; before, the recording, the repository, and the programs which a user has."""
    samples = np.degrees(al.simulate(al.Model("N 0.3 deg/sqrt(h), B 10 deg/h"), rate=100, duration=3600, rng=1))
    recording, origin, tools = folder / "gyro.txt", folder / "origin", python_of(folder / "tools")
    recording.write_text("".join(f"{value:.9f}\n" for value in samples), "utf-8")
    subprocess.run(["git", "clone", "-q", "--bare", ROOT, origin / "allanite"], check=True)
    subprocess.run([tools / "python", "-m", "pip", "install", "-q", *("uv", "pipx")], check=True)
    return lambda name: Place(folder / name, recording, origin, (python_of(folder / name / "venv"), tools))


def first_runs(place: Place, folder: Path, count: int) -> dict[str, list[tuple[float, float]]]:
    """Time, and that of the processors, of analyses with an empty cache of kernels, and with what those left."""
    line = "allanite analyze examples/tactical_gyro.csv"
    caches = [{"NUMBA_CACHE_DIR": str(folder / f"kernels{i}")} for i in range(count)]
    return {which: [place.typed(line, **cache) for cache in caches] for which in ("first", "second")}


def shown(line: str, first: float, again: float | None) -> tuple[str, ...]:
    """The row of a command, of a block its first line."""
    begin, *more = line.splitlines()
    return f"`{begin}{' ...' if more else ''}`", f"{first:.1f}", "" if again is None else f"{again:.1f}"


def sections(rounds: int) -> list[str]:
    """The sections of the first run."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        place_of = prepared(folder)
        common, rows = place_of("common"), []
        for number, line in enumerate(commands((ROOT / "README.md").read_text("utf-8"))):
            place = place_of(f"alone{number}") if line.startswith(ALONE) else common
            rows.append(place.row(line))
        times = first_runs(common, folder, rounds)
    limits = {
        "a first run": (min(wall for wall, _ in times["first"]), FIRST),
        "from nothing to a figure": (min(first for line, first, _ in rows if line.startswith(ALONE)), WHOLE),
    }
    bounds = (
        f"{what} {s:.1f} s of {most:g} s: {'met' if s <= most else 'MISSED'}" for what, (s, most) in limits.items()
    )
    medians = [
        (which, f"{min(runs)[0]:.1f}", *(f"{median(part):.1f}" for part in zip(*runs, strict=True)))
        for which, runs in times.items()
    ]
    return [
        *section("Commands of the README", ("command", "first [s]", "again [s]"), [shown(*row) for row in rows],
                 "FILE is an hour of a gyro at 100 Hz.", f"On two idle processors: {'; '.join(bounds)}."),
        *section("First run", ("run", "shortest", "median", "median, of the processors"), medians,
                 f"The sample, {rounds} times with an empty cache of kernels and with the one that this run left."),
    ]  # fmt: skip


# --- jobs ------------------------------------------------------------------------------------------------------------


def six(path: Path, samples: int) -> None:
    """Write stamps, three gyroscopes and three accelerometers."""
    columns = {"time [s]": np.arange(samples) / 100.0}
    sensors = [(f"gyro_{a}", "deg/s", GYRO) for a in "xyz"] + [(f"accel_{a}", "m/s^2", ACCEL) for a in "xyz"]
    for i, (name, unit, model) in enumerate(sensors):
        values = al.simulate(al.Model(model), samples, 100.0, rng=np.random.default_rng([1, i])).values
        columns[f"{name} [{unit}]"] = np.round(np.degrees(values) if unit == "deg/s" else values, 9)
    csv.write_csv(pa.table(columns), path, csv.WriteOptions(quoting_style="none"))


def jobs(samples: int, rounds: int) -> tuple[list[tuple[str, ...]], str]:
    """Rows of the commands, and what is said about them."""
    kept = {name: value for name, value in os.environ.items() if not name.endswith("_NUM_THREADS")}
    kept.pop("PYTHONDONTWRITEBYTECODE", None)  # an installed package is compiled
    rows, alone = [], csv.ReadOptions(use_threads=False)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "six.csv")
        six(path, samples)
        analyze, single = [sys.executable, "-m", "allanite.cli", "analyze", path, "--force"], ("--threads", "1")
        read = least(partial(csv.read_csv, path, read_options=alone), rounds + 1, time.perf_counter)
        for name, option in (("html", "--report"), ("json", "--json")):
            command = [*analyze, option, path.with_suffix(f".{name}")]
            times = [(*spent(command, env=kept), spent([*command, *single], env=kept)[0]) for _ in range(rounds)]
            free, used, pinned = np.min(times, axis=0)
            ends = (f"{MOST[name]:g}", "met" if free <= MOST[name] * read else "MISSED")
            rows.append((name, f"{free:.2f}", f"{used:.2f}", f"{pinned:.2f}", f"{free / read:.1f}", *ends))
        size = path.stat().st_size / 1e6
    return rows, f"{samples} samples of six channels with stamps, {size:.0f} MB, read by pyarrow in {read:.2f} s."
