"""The first run after an installation: the sample's analysis while nothing is compiled, and the next one.

    python benchmarks/first_run.py [--rounds 10] [--write PATH]

Each round copies the package into a fresh folder, makes its byte code as pip does, and runs the command twice, with an
empty cache of kernels and with the one that the first run left. Then every kernel is compiled in one process, for the
time of each; and the fastest kernels are timed as compiled for this processor and for any of its architecture, which is
what a wheel with kernels compiled ahead of time would hold. Ends with exit code 1 if the bound is missed.
"""

from table import ROOT, begin, markdown

import compileall
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

MOST = 8.0
"""Seconds from the command to its end, on two processors that have nothing else to do."""

LARGEST = 12
"""Kernels that are listed."""

COMPILED = """
import json, time
from numba.core import event
from allanite.kernels import ahead

class Times(event.Listener):
    open, found = [], []
    def on_start(self, e):
        self.open.append([time.process_time(), 0.0])
    def on_end(self, e):
        function = e.data["dispatcher"].py_func
        begin, inner = self.open.pop()
        spent = time.process_time() - begin
        own = function.__module__.startswith("allanite")
        if self.open:  # what numpy's functions need counts for the kernel that calls them
            self.open[-1][1] += spent if own else inner
        if own:
            self.found.append((f"{function.__module__.rpartition('.')[2]}.{function.__name__}", spent - inner))

with event.install_listener("numba:compile", Times()):
    ahead.load({**ahead.THERE, **ahead.HERE})
print(json.dumps(Times.found))
"""

TIMED = """
import json, time
import numpy as np
from allanite.kernels import overlapped, summed, theo
x = np.random.default_rng(1).standard_normal(400_001).cumsum()
m = np.unique(np.geomspace(1, 100_000, 60).astype(np.int64))
few = np.arange(2, 200, 2)
jobs = {
    "overlapping Allan deviation": lambda: overlapped.overlapped(x, m, 2),
    "modified Allan deviation": lambda: summed.modified(x, m),
    "Theo1": lambda: theo.theo1(x[:20_001], few),
}
def spent(job):
    start = time.process_time()
    job()
    return time.process_time() - start
print(json.dumps({name: min(spent(job) for _ in range(20)) for name, job in jobs.items()}))
"""


def python(arguments: list[str], home: Path, **more: str) -> tuple[str, float, float]:
    """What a process of its own prints, and its time and that of the processors, s."""
    known = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA")}
    environment = known | {"PYTHONPATH": str(home), "NUMBA_CACHE_DIR": str(home / "kernels")} | more
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    start, before = time.perf_counter(), os.times()
    command = [sys.executable, "-P", *arguments]
    found = subprocess.run(command, env=environment, capture_output=True, check=True, text=True)
    wall, after = time.perf_counter() - start, os.times()
    used = after.children_user - before.children_user + after.children_system - before.children_system
    return found.stdout, wall, used


def installed(folder: Path, name: str) -> Path:
    """A folder with the package and its byte code, and nothing else."""
    home = folder / name
    shutil.copytree(ROOT / "src" / "allanite", home / "allanite", ignore=shutil.ignore_patterns("__pycache__"))
    compileall.compile_dir(home, quiet=2)
    return home


def rounds(folder: Path, count: int) -> dict[str, list[tuple[float, float]]]:
    """Time, and that of the processors, of every first and second run."""
    command = ["-m", "allanite.cli", "analyze", str(ROOT / "examples" / "tactical_gyro.csv")]
    times: dict[str, list[tuple[float, float]]] = {"first": [], "second": []}
    for i in range(count):
        home, said = installed(folder, f"round{i}"), set()
        for run in times.values():
            text, *spent = python(command, home)
            said.add(text)
            run.append((spent[0], spent[1]))
        assert len(said) == 1, "the runs differ"  # noqa: S101
    return times


def main() -> int:
    run = begin(__doc__, rounds=10)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        times = rounds(folder, run.asked.rounds)
        rows = [
            (which, *(f"{median(part):.1f}" for part in zip(*found, strict=True)), f"{max(found)[0]:.1f}")
            for which, found in times.items()
        ]
        alone = installed(folder, "alone")
        kernels = sorted(json.loads(python(["-c", COMPILED], alone)[0]), key=lambda one: -one[1])
        whole, listed = sum(spent for _, spent in kernels), kernels[:LARGEST]
        generic = {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
        own, any_ = (json.loads(python(["-c", TIMED], installed(folder, f"timed{i}"), **more)[0])
                     for i, more in enumerate(({}, generic)))  # fmt: skip
    met = median(wall for wall, _ in times["first"]) <= MOST
    run.publish(
        "First run",
        (
            "seed 1",
            f"load of the machine, with other programs: {os.getloadavg()[1]:.1f} on {os.cpu_count()} processors",
            f"bound of the first run: {MOST:g} s on two processors that have nothing else to do: "
            f"{'met' if met else 'MISSED'}",
        ),
        (
            "Times in s.",
            "",
            *markdown(("run", "median", "median, of the processors", "longest"), rows),
            "## Kernels",
            "",
            f"{len(kernels)} kernels and parts take {whole:.1f} s in one process, without the import of numba.",
            "",
            *markdown(("kernel or part, without the parts that it calls", "s"), [(n, f"{s:.2f}") for n, s in listed]),
            "## For this processor and for any",
            "",
            *markdown(
                ("kernel", "for this processor, ms", "for any of its architecture, ms", "ratio"),
                [(n, f"{1e3 * own[n]:.2f}", f"{1e3 * any_[n]:.2f}", f"{any_[n] / own[n]:.1f}") for n in own],
            ),
        ),
    )
    return int(not met)


if __name__ == "__main__":
    sys.exit(main())
