"""From a file to a page: a CSV of six channels by the commands that a user types, against reading the file alone.

Every command is a new process. It runs with nothing set, as users do, with the threads of BLAS limited to one, and with
`--threads 1`. The unit of the ratios is the time in which pyarrow reads the same file in one thread. Beside the time
stands that of the processors, which other programs on the machine do not make longer as they do the time. Ends with
exit code 1 if a bound is missed.
"""

from table import begin, markdown, section

import cProfile
import io
import os
import pstats
import subprocess
import sys
import tempfile
import time
from contextlib import redirect_stdout, suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pyarrow as pa
from pyarrow import csv

import allanite as al

PIN = ("OMP", "OPENBLAS", "MKL", "NUMBA", "ARROW")
GYRO, ACCEL = "N 0.5 deg/sqrt(h), B 5 deg/h, K 20 deg/h/sqrt(h)", "N 100 ug/sqrt(Hz), B 20 ug"
MOST = {"page": 10.0, "json": 6.0}  # bounds: times the read
ALIKE = 0.2  # by how much the time with nothing set may differ from the time with threads pinned

STAGES = {
    "reading": "readers/__init__.py:read",
    "inspection": "prepare/quality.py:inspect",
    "identification: the search": "identification/front.py:started",
    "identification: what follows from it": "identification/front.py:fit",
    "residuals and their tests": "identification/checks/residuals.py:residuals",
    "limits of curves": "core/curve.py:_limits",
    "figures": "reporting/matplotlib_svg.py:drawn",
    "text for the terminal": "reporting/__init__.py:first_screen",
}
"""Functions whose time is listed: the end of a path, and a name; a stage may contain another."""

PEER = """
import sys, numpy, allantools
data = numpy.loadtxt(sys.argv[1], delimiter=",", skiprows=1)
for column in data.T[1:]:
    m = numpy.unique(numpy.geomspace(1, len(column) // 4, 100).astype(int))
    allantools.oadev(column, rate=100.0, data_type="freq", taus=m / 100)
"""


def make(path: Path, samples: int) -> None:
    """Stamps, three gyroscopes and three accelerometers."""
    columns = {"time [s]": np.arange(samples) / 100.0}
    for i, (name, unit, model) in enumerate(
        [(f"gyro_{axis}", "deg/s", GYRO) for axis in "xyz"] + [(f"accel_{axis}", "m/s^2", ACCEL) for axis in "xyz"]
    ):
        record = al.simulate(al.Model(model), samples, 100.0, rng=np.random.default_rng([1, i]))
        values = np.degrees(record.values) if unit == "deg/s" else record.values
        columns[f"{name} [{unit}]"] = np.round(values, 9)
    csv.write_csv(pa.table(columns), path, csv.WriteOptions(quoting_style="none"))


def read_alone(path: Path) -> float:
    """Time of pyarrow's read in one thread, s."""
    start = time.perf_counter()
    csv.read_csv(path, read_options=csv.ReadOptions(use_threads=False))
    return time.perf_counter() - start


class Spent(NamedTuple):
    """Time of a command, and that of the processors in it and its processes, s."""

    wall: float
    processors: float


def spent(arguments: list[str], *, pinned: bool = False) -> Spent:
    """What a command takes in a process of its own."""
    environment = {name: value for name, value in os.environ.items() if not name.endswith("_NUM_THREADS")}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)  # an installed package is compiled
    if pinned:
        environment |= {f"{library}_NUM_THREADS": "1" for library in PIN}
    start, before = time.perf_counter(), os.times()
    subprocess.run([sys.executable, *arguments], env=environment, capture_output=True, check=True)
    wall, after = time.perf_counter() - start, os.times()
    used = after.children_user - before.children_user + after.children_system - before.children_system
    return Spent(wall, used)


def stages(path: Path, page: Path) -> list[tuple[str, str, str]]:
    """Share of each stage of the command that makes the page, by a profile, which makes Python's own work longer."""
    from allanite.cli import main as command

    profile = cProfile.Profile()
    with redirect_stdout(io.StringIO()), suppress(SystemExit):
        profile.runcall(command, ["analyze", str(path), "--threads", "1", "--report", str(page), "--force"])
    found = pstats.Stats(profile).stats  # type: ignore[attr-defined]
    whole = max(entry[3] for entry in found.values())
    rows = []
    for stage, place in STAGES.items():
        end, name = place.split(":")
        entries = [entry for (file, _, function), entry in found.items() if file.endswith(end) and function == name]
        if not entries:
            raise LookupError(f"{stage}: {place} was not called; name the function that does this now")
        rows += [(stage, f"{entry[0]}", f"{entry[3] / whole:.0%}") for entry in entries]
    return rows


def main() -> int:
    run = begin(__doc__, samples=1_000_000, rounds=3)
    with tempfile.TemporaryDirectory() as folder:
        path, page, stored = (Path(folder) / name for name in ("six.csv", "six.html", "six.json"))
        make(path, run.asked.samples)
        read = min(read_alone(path) for _ in range(run.asked.rounds + 1))
        rows = []
        for name, output in (("page", ["--report", str(page)]), ("json", ["--json", str(stored)])):
            command = ["-m", "allanite.cli", "analyze", str(path), *output, "--force"]
            times: dict[str, list[Spent]] = {"free": [], "pinned": [], "one": []}
            for _ in range(run.asked.rounds):  # in turn, so that a busy minute is not that of one of them
                times["free"].append(spent(command))
                times["pinned"].append(spent(command, pinned=True))
                times["one"].append(spent([*command, "--threads", "1"]))
            free, pinned, one = (Spent(*(min(part) for part in zip(*found, strict=True))) for found in times.values())
            met = free.wall <= MOST[name] * read and abs(free.wall / pinned.wall - 1) <= ALIKE
            shown = [f"{found.wall:.2f} ({found.processors:.2f})" for found in (free, pinned, one)]
            rows.append(
                (name, *shown, f"{free.wall / read:.1f}", f"{MOST[name]:g}", f"{free.wall / pinned.wall - 1:+.0%}",
                 "met" if met else "MISSED")
            )  # fmt: skip
        peer = spent(["-c", PEER, str(path)]).wall
        run.publish(
            "From a file to a page",
            (
                "seed 1",
                f"{run.asked.samples} samples of six channels with stamps, {path.stat().st_size / 1e6:.0f} MB; "
                f"pyarrow reads them in {read:.2f} s with one thread",
                f"load of the machine, with other programs: {os.getloadavg()[1]:.1f} on {os.cpu_count()} processors",
                f"numpy.loadtxt and allantools.oadev at 100 averaging times, and nothing else: {peer:.1f} s",
            ),
            (
                "Times in s, those of the processors in brackets.",
                "",
                *markdown(
                    ("command", "nothing set", "pinned", "--threads 1", "over the read", "wanted", "apart", ""), rows
                ),
                *section(
                    "Where the time goes",
                    ("stage", "calls", "share"),
                    stages(path, page),
                    "Shares of the whole for the page with `--threads 1`; a stage may be part of another.",
                ),
            ),
        )
    return int(any(row[-1] == "MISSED" for row in rows))


if __name__ == "__main__":
    sys.exit(main())
