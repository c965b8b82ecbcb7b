"""What somebody waits for who has read the README and has a recording: its commands in an empty place, timed.

The commands and the Python of README.md are run word for word, in the order of the page: each that needs no
installation (uvx, pipx) in a home of its own, the others in one more, with a new virtual environment. A home is empty,
so are the caches of pip, uv and numba; variables of the environment are cleared but for those that lead to the package
index; the current folder has nothing but FILE, an hour of a gyro at 100 Hz. For the repository stands a clone of the
commit in a folder. Commands that analyze are run a second time.

Then the parts of the wait: what is downloaded, unpacked and compiled. Ends with exit code 1 if a bound is missed.
"""

from table import ROOT, begin, markdown, section

import json
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
from pathlib import Path
from statistics import median
from typing import Any

FIRST, WHOLE = 8.0, 30.0
"""Seconds of a first analysis, and from nothing to a figure of the user's own sensor, on two idle processors."""

LARGEST = 12
"""Kernels that are listed."""

ADDRESS = "https://github.com/allanite/"
INDEX = ("PIP_", "UV_", "SSL_CERT_FILE")  # beginnings of variables that lead to the package index
ALONE = ("uvx", "pipx")  # programs that install what they run

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
from allanite.kernels import squared, summed, theo
x = np.random.default_rng(1).standard_normal(400_001).cumsum()
m = np.unique(np.geomspace(1, 100_000, 60).astype(np.int64))
few = np.arange(2, 200, 2)
jobs = {
    "overlapping Allan deviation": lambda: squared.overlapped(x, m, 2),
    "modified Allan deviation": lambda: summed.modified(x, m),
    "Theo1": lambda: theo.theo1(x[:20_001], few),
}
def spent(job):
    start = time.process_time()
    job()
    return time.process_time() - start
print(json.dumps({name: min(spent(job) for _ in range(20)) for name, job in jobs.items()}))
"""


def commands(readme: str) -> list[str]:
    """What the README says to type, in its order: lines of shell, and whole blocks of Python as `python -c`."""
    found = []
    for language, block in re.findall(r"^```(sh|console|python)\n(.*?)^```", readme, re.DOTALL | re.MULTILINE):
        lines = block.splitlines()
        typed = {
            "sh": [line for line in lines if not line.startswith("#")],
            "console": [line.removeprefix("$ ") for line in lines if line.startswith("$ ")],
            "python": [shlex.join(["python", "-c", block])],
        }
        found += typed[language]
    return found


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

    def typed(self, line: str, **more: str) -> tuple[float, float, str]:
        """Time of a command and of the processors, s, and what it printed; the next one is typed where it ended."""
        if not (self.folder / "FILE").exists():
            shutil.copy(self.recording, self.folder / "FILE")
        there = self.home / "there"
        words = ["sh", "-c", f'{line}\ncode=$?; pwd > "{there}"; exit $code']
        start, before = time.perf_counter(), os.times()
        done = subprocess.run(
            words, cwd=self.folder, env=self.environment | more, capture_output=True, text=True, check=False
        )
        wall, after = time.perf_counter() - start, os.times()
        if done.returncode:
            sys.exit(f"{line}\n{done.stdout}{done.stderr}")
        self.folder = Path(there.read_text().strip())
        used = after.children_user - before.children_user + after.children_system - before.children_system
        return wall, used, done.stdout

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
    import numpy as np

    import allanite as al

    samples = np.degrees(al.simulate(al.Model("N 0.3 deg/sqrt(h), B 10 deg/h"), rate=100, duration=3600, rng=1))
    recording, origin, tools = folder / "gyro.txt", folder / "origin", python_of(folder / "tools")
    recording.write_text("".join(f"{value:.9f}\n" for value in samples), "utf-8")
    subprocess.run(["git", "clone", "-q", "--bare", ROOT, origin / "allanite"], check=True)
    subprocess.run([tools / "python", "-m", "pip", "install", "-q", *("uv", "pipx")], check=True)
    return lambda name: Place(folder / name, recording, origin, (python_of(folder / name / "venv"), tools))


def parts(place: Place, target: str) -> list[tuple[str, ...]]:
    """What an installation by pip does: its name, seconds and MB."""
    wheels, unpacked = place.home / "wheels", place.home / "unpacked"
    steps = {
        "download, and building the wheel": f"pip wheel -q -w {wheels} {target}",
        "unpacking": f"pip install -q --no-compile --no-index --find-links {wheels} -t {unpacked} allanite",
        "byte code": f"python -m compileall -q {unpacked}",
    }
    made, rows = (wheels, unpacked, unpacked), []
    for (name, line), folder in zip(steps.items(), made, strict=True):
        seconds, *_ = place.typed(line)
        size = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())
        rows.append((name, f"{seconds:.1f}", f"{size / 1e6:.0f}"))
    return rows


def first_runs(place: Place, folder: Path, count: int) -> dict[str, list[tuple[float, float]]]:
    """Time, and that of the processors, of analyses with an empty cache of kernels, and with what those left."""
    line = "allanite analyze examples/tactical_gyro.csv"
    caches = [{"NUMBA_CACHE_DIR": str(folder / f"kernels{i}")} for i in range(count)]
    return {which: [place.typed(line, **cache)[:2] for cache in caches] for which in ("first", "second")}


def printed(place: Place, script: str, **more: str) -> Any:
    """What a script prints as JSON."""
    return json.loads(place.typed(shlex.join(["python", "-c", script]), **more)[2])


def shown(line: str, first: float, again: float | None) -> tuple[str, ...]:
    """The row of a command, of a block its first line."""
    begin, *more = line.splitlines()
    return f"`{begin}{' ...' if more else ''}`", f"{first:.1f}", "" if again is None else f"{again:.1f}"


def main() -> int:
    run = begin(__doc__, rounds=5)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        place_of = prepared(folder)
        common, rows = place_of("common"), []
        for number, line in enumerate(commands((ROOT / "README.md").read_text("utf-8"))):
            place = place_of(f"alone{number}") if line.startswith(ALONE) else common
            rows.append(place.row(line))
            print(*shown(*rows[-1]), file=sys.stderr, flush=True)
        installing = parts(place_of("parts"), f"git+{ADDRESS}allanite")
        times = first_runs(common, folder, run.asked.rounds)
        alone = {"NUMBA_CACHE_DIR": str(folder / "alone")}
        generic = {"NUMBA_CACHE_DIR": str(folder / "generic"), "NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
        kernels = sorted(printed(common, COMPILED, **alone), key=lambda one: -one[1])
        own, any_ = printed(common, TIMED, **alone), printed(common, TIMED, **generic)
    whole = min(first for line, first, _ in rows if line.startswith(ALONE))
    quickest = min(wall for wall, _ in times["first"])
    missed = [text for text, met in (("a first run", quickest <= FIRST), ("the whole", whole <= WHOLE)) if not met]
    rounds = [
        (which, f"{min(found)[0]:.1f}", *(f"{median(part):.1f}" for part in zip(*found, strict=True)))
        for which, found in times.items()
    ]
    run.publish(
        "From the README to a figure",
        (
            "seed 1",
            f"load of the machine, with other programs: {os.getloadavg()[1]:.1f} on {os.cpu_count()} processors",
            f"bounds: {FIRST:g} s for a first run, {WHOLE:g} s from nothing to a figure, on two processors that have "
            f"nothing else to do: {'MISSED by ' + ' and '.join(missed) if missed else 'met'}",
            "a clone of the commit in a folder stands for the repository",
        ),
        (
            "Times in s. Commands are those of README.md; FILE is an hour of a gyro at 100 Hz.",
            "",
            *markdown(("command", "first", "again"), [shown(*row) for row in rows]),
            *section("Installation by pip", ("part", "s", "MB"), installing),
            *section(
                "First run", ("run", "shortest", "median", "median, of the processors"), rounds,
                f"The sample, {run.asked.rounds} times with an empty cache of kernels and with the one that this run "
                "left.",
            ),
            *section(
                "Kernels", ("kernel or part, without the parts that it calls", "s"),
                [(name, f"{seconds:.2f}") for name, seconds in kernels[:LARGEST]],
                f"{len(kernels)} kernels and parts take {sum(seconds for _, seconds in kernels):.1f} s in one process, "
                "without the import of numba.",
            ),
            *section(
                "For this processor and for any",
                ("kernel", "for this processor, ms", "for any of its architecture, ms", "ratio"),
                [(n, f"{1e3 * own[n]:.2f}", f"{1e3 * any_[n]:.2f}", f"{any_[n] / own[n]:.1f}") for n in own],
            ),
        ),
    )  # fmt: skip
    return int(bool(missed))


if __name__ == "__main__":
    sys.exit(main())
