"""What all benchmarks share: one thread, where a table comes from, Markdown, and committed tables read back.

Imported before numpy, which asks for the number of threads when it is loaded.
"""

import os
import sys

if "numpy" not in sys.modules:
    for _library in ("OMP", "OPENBLAS", "MKL", "NUMBA", "ARROW"):
        os.environ[f"{_library}_NUM_THREADS"] = "1"

import argparse
import math
import platform
import re
import shlex
import subprocess
import time
import zlib
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from datetime import date
from functools import cached_property
from multiprocessing import Pool
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "benchmarks" / "results"
CODE = ("src", "benchmarks/*.py", "tests/reference")  # what a figure depends on

ROOMS = {
    "angle": "applications/angle",
    "check": "claims identification", "comparison": "comparison",
    "compensation": "applications/compensation",
    "curves": "identification statistics", "consistency": "exporting",
    "drift": "planning", "environments": "",
    "grid": "identification kernels prepare study",
    "fuzz": "batch cli core readers study web", "logs": "readers",
    "methods": "identification planning/bound.py statespace", "moments": "statistics",
    "kills": "cli parallel statistics", "prices": "identification", "rate": "applications/constant_rate",
    "recordings": "claims identification interpretation planning prepare",
    "simulation": "simulation",
    "speed": "cli identification kernels readers reporting statistics study", "streams": "readers stream study",
    "theoh_paper": "identification statistics", "vertical": "applications/attitude",
}  # fmt: skip
"""Folders and files of the package that the tables of a script describe, "" all of it: see tools/stale.py."""

sys.path.insert(0, str(ROOT))  # the referees are among the tests

Row = tuple[str, ...]
Cell = tuple[Any, ...]


def _git(*words: str) -> str:
    return subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()


def commit() -> str:
    """The commit of the code that runs, and whether files differ from it."""
    changed = _git("status", "--porcelain", "--", *CODE)
    return _git("rev-parse", "--short=7", "HEAD") + (" + uncommitted changes" if changed else "")


def unchanged(since: str, rooms: str) -> bool:
    """Whether rooms of the package are what they were at a commit."""
    if "+" in since:
        return False
    folders = [f"src/allanite/{room}" for room in rooms.split()] or ["src"]
    return not _git("diff", "--name-only", since, "--", *folders)


def processor() -> str:
    """Name of the processor, or its architecture where the system does not tell the name."""
    about = Path("/proc/cpuinfo")
    lines = about.read_text().splitlines() if about.exists() else []
    return next((line.split(":")[1].strip() for line in lines if line.startswith("model name")), platform.machine())


@dataclass(frozen=True)
class Run:
    """One run of a script: what was asked for, of which code, since when."""

    asked: argparse.Namespace
    command: str
    commit: str
    begin: float

    def publish(self, title: str, notes: Iterable[str], body: Iterable[str]) -> None:
        """Print the page of a title, where it comes from, notes (the first says the seeds) and tables; write it."""
        import numpy as np

        origin = (
            f"commit {self.commit}, {date.today()}, {processor()}, Python {platform.python_version()}, "
            f"numpy {np.__version__}, {time.perf_counter() - self.begin:.0f} s"
        )
        rooms = ROOMS[Path(sys.argv[0]).stem] or "all"
        listed = (f"- {note}" for note in (f"{origin}, of {rooms}", f"command: `{self.command}`", *notes))
        text = "\n".join([f"# {title}", "", *listed, "", *body])
        print(text)
        if self.asked.write:
            self.asked.write.write_text(text, encoding="utf-8")


def begin(doc: str, **options: object) -> Run:
    """Read the command line: an option for each default; a tuple is a choice that must be made.

    A list is any number of its values, of its type: of text, only those in it. False is a switch. --write names the
    file of the table, which is refused for code that is not committed unless --dirty is given.
    """
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name, default in options.items():
        if isinstance(default, tuple):
            parser.add_argument(name, choices=default)
        elif isinstance(default, bool):
            parser.add_argument(f"--{name}", action="store_true")
        elif isinstance(default, list):
            known = default if isinstance(default[0], str) else None
            parser.add_argument(f"--{name}", nargs="+", type=type(default[0]), choices=known, default=default)
        else:
            parser.add_argument(f"--{name}", type=type(default), default=default, help=f"default {default}")
    parser.add_argument("--write", type=Path, help="file of the table")
    parser.add_argument("--dirty", action="store_true", help="write the table of code that is not committed")
    asked, code = parser.parse_args(), commit()
    if asked.write and "+" in code and not asked.dirty:
        parser.error(f"{', '.join(CODE)} differ from the commit a table would name: commit them, or give --dirty")
    words = ["python", f"benchmarks/{Path(sys.argv[0]).name}"]
    for name, default in options.items():
        value = getattr(asked, name)
        if isinstance(default, bool):
            words += [f"--{name}"] if value else []
            continue
        words += [] if isinstance(default, tuple) else [f"--{name}"]
        words += map(str, value) if isinstance(value, list) else [str(value)]
    return Run(asked, shlex.join(words), code, time.perf_counter())


def markdown(headings: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """Lines of a table, and an empty one."""
    return [_line(headings), "|" + "---|" * len(headings), *map(_line, rows), ""]


def section(title: str, headings: Sequence[str], rows: Iterable[Sequence[str]], *about: str) -> list[str]:
    """Lines of a section: its title, what is said about its table, and the table."""
    return [f"## {title}", "", *(line for text in about for line in (text, "")), *markdown(headings, rows)]


def shared(hits: Sequence[bool]) -> str:
    """A share with its standard error, that of one hit in a record more where there is none, %."""
    n, p = len(hits), sum(map(bool, hits)) / len(hits)
    return f"{100 * p:.1f} ± {100 * math.sqrt(max(p * (1 - p), n / (n + 1) ** 2) / n):.1f}"


MOVED = 1e-4  # probability of a difference between two counts by chance, below which a share has moved


def moved(hits: int, records: int, others: int, of: int) -> bool:
    """Whether two shares are not of one population: Fisher's exact test."""
    total, both = math.comb(records + of, hits + others), hits + others
    ways = [math.comb(records, k) * math.comb(of, both - k) / total for k in range(both + 1)]
    return sum(p for p in ways if p <= ways[hits] * (1 + 1e-9)) < MOVED


def least(job: Callable[[], object], rounds: int, clock: Callable[[], float] = time.process_time) -> float:
    """Least time of several, of the processor unless by another clock, s."""
    times = []
    for _ in range(rounds):
        start = clock()
        job()
        times.append(clock() - start)
    return min(times)


SEEDS = "seeds: CRC-32 of the words of each cell, number of the record"


def seeded(number: int, *cell: object) -> "np.random.Generator":
    """Random numbers of a record of a cell, which no other cell has: see SEEDS."""
    import numpy as np

    return np.random.default_rng((zlib.crc32(" ".join(map(str, cell)).encode()), number))


def coefficients(model: Iterable[Any]) -> dict[str, Any]:
    """The terms of a model as judge.sensor takes them, SI."""
    terms = list(model)
    processes = [(term.value, *term.shape) for term in terms if term.symbol == "GM"]
    return {term.symbol: term.value for term in terms if term.symbol != "GM"} | {"GM": processes}


def spread(
    work: Callable[[Any], Any], cells: Iterable[Cell], records: int, processes: int | None = None, first: int = 0
) -> Iterator[tuple[Cell, list[Any]]]:
    """Each cell, which is printed, with what is made, in processes, of it and the number of each record."""
    with Pool(processes) as pool:
        for cell in cells:
            yield cell, pool.map(work, [(*cell, number) for number in range(first, first + records)], chunksize=4)
            print(*cell, file=sys.stderr, flush=True)


def covered(places: Iterable[int]) -> str:
    """How often limits hold the truth, %: places of the truth are -1 below them, 0 within, 1 above."""
    counts = Counter(map(int, places))
    inside, above, below = (100 * counts[place] / counts.total() for place in (0, 1, -1))
    return f"{inside:.1f} (+{above:.1f} -{below:.1f})"


def _line(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cells) + " |"


@dataclass(frozen=True)
class Page:
    """A page with tables."""

    text: str

    @cached_property
    def head(self) -> str:
        """What stands before the first section and the first table."""
        return self.text.split("\n## ")[0].split("\n| ")[0]

    def tables(self, section: str = "") -> list[list[dict[str, str]]]:
        """Rows by heading of every table of a section, which is named by how its title begins; of the page if none."""
        parts = re.split(r"^#+ ", self.text, flags=re.MULTILINE) if section else [self.text]
        part = next(part for part in parts if part.startswith(section))
        found, inside = [], False
        for line in part.splitlines():
            if line.startswith("| "):
                cells = [cell[1:-1] for cell in line.strip("|").split("|")]
                if inside:
                    found[-1][1].append(dict(zip(found[-1][0], cells, strict=True)))
                else:
                    found.append((cells, []))
            inside = line.startswith("|")
        return [rows for _, rows in found]

    def rows(self, section: str = "") -> list[dict[str, str]]:
        """Rows of the only table there."""
        (only,) = self.tables(section)
        return only


def read(name: str) -> Page:
    """A committed table, by the name of its file."""
    return Page((RESULTS / name).read_text(encoding="utf-8"))
