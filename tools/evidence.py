"""Make every table of the benchmarks again, of the code that is committed, in one sequence.

    python tools/evidence.py [TABLE ...] [--all]

A table is skipped if nothing that it describes has changed since it was made: its room in `ROOMS` of
benchmarks/table.py, its script and the modules beside it, and its options; so a run that was stopped goes on where it
was. --all makes all; names select. What scripts print is in build/evidence. A script that fails does not stop the
others. Ends with exit code 1 if one has failed, of which a demand that is missed is a case: its table is written.
"""

import argparse
import os
import re
import shlex
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "benchmarks"), str(ROOT / "tools")]

from table import RESULTS, ROOMS, Page, commit  # noqa: E402  the number of threads, too

import stale  # noqa: E402

LOGS = ROOT / "build" / "evidence"
LANES = {"pool": 1, "single": 2, "quiet": 1}
"""How many scripts run side by side, in this order: with two processes of their own; with one; with nothing beside."""


class Job(NamedTuple):
    """How a table is made: by what options of its script, in which lane."""

    options: str = ""
    lane: str = "single"


POOL = "compensation drift angle rate vertical recordings simulation"
SINGLE = "logs environments"

TABLES = {
    "grid": Job("make --rounds 100", "pool"),
    **dict.fromkeys(POOL.split(), Job(lane="pool")),
    "methods": Job(lane="pool"),
    "curves": Job("--records 60", "pool"),
    "consistency": Job("--records 30", "pool"),
    "comparison": Job("--pairs 1000", "pool"),
    "check": Job("--records 1 --right 8 --filters 10 --others 4", "pool"),
    "prices": Job("--short 16 --usual 10 --long 4", "pool"),
    "theoh_paper": Job("--records 60 --curves 200 --limits 240", "pool"),
    "fuzz": Job("--share 0.1", "pool"),
    "moments": Job("--hybrids 100 --laws 40"),
    **dict.fromkeys(SINGLE.split(), Job()),
    "kills": Job("--files 40 --verbs 2", "quiet"),
    "streams": Job("--millions 200", "quiet"),
    "speed": Job(lane="quiet"),
}
"""Tables by the name of their file, which is that of their script."""


def command(name: str) -> list[str]:
    """What makes a table."""
    script, options = ROOT / "benchmarks" / f"{name}.py", shlex.split(TABLES[name].options)
    return [sys.executable, str(script), *options, "--write", str(RESULTS / f"{name}.md")]


def beside(script: Path) -> Iterator[Path]:
    """A script, and the modules of the benchmarks and of the tests that it imports, however far."""
    waiting, known = [script], set[Path]()
    while waiting:
        path = waiting.pop()
        if path.exists() and path not in known:
            known.add(path)
            yield path
            text = path.read_text("utf-8")
            imports = re.findall(r"^\s*(?:import|from) ([\w.]+)(?: import (\w+)$)?", text, re.MULTILINE)
            names = [name for module, part in imports for name in (module, f"{module}.{part}")]
            waiting += [root / f"{name.replace('.', '/')}.py" for name in names for root in (ROOT / "benchmarks", ROOT)]


def fresh(name: str) -> bool:
    """Whether a table is there, and is of what it describes as it is."""
    path = RESULTS / f"{name}.md"
    page = Page(path.read_text("utf-8")) if path.exists() else Page("")
    made, _ = stale.stamp(page)
    if not stale.known(made) or "uncommitted" in page.head or "before" in made:
        return False
    asked = re.search(rf"`python benchmarks/{name}\.py ?(.*)`", page.head)
    if not asked or TABLES[name].options not in asked[1]:
        return False
    rooms = (f"{stale.SOURCE}/{room}".rstrip("/") for room in ROOMS.get(name, "").split() or [""])
    scripts = (str(path.relative_to(ROOT)) for path in beside(ROOT / "benchmarks" / f"{name}.py"))
    return not stale.git("diff", "--name-only", made, "HEAD", "--", *rooms, *scripts)


def say(name: str, *words: str) -> None:
    """Print a line of progress."""
    print(f"{time.strftime('%H:%M')} {name:14}", *words, flush=True)


def make(name: str, *, again: bool) -> int:
    """Make a table unless it is fresh: the exit code of its script."""
    if not again and fresh(name):
        say(name, "is of the code as it is")
        return 0
    say(name, "begins")
    begun = time.monotonic()
    single = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    with open(LOGS / f"{name}.log", "wb") as log:
        done = subprocess.run(command(name), cwd=ROOT, env=os.environ | single, stdout=log, stderr=log, check=False)  # noqa: S603
    ended = f"exit code {done.returncode}, see build/evidence/{name}.log" if done.returncode else "made"
    say(name, f"{ended} after {(time.monotonic() - begun) / 60:.0f} minutes")
    return done.returncode


def main() -> int:
    """Make the tables that are asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tables", nargs="*", metavar="TABLE", help=", ".join(TABLES))
    parser.add_argument("--all", action="store_true", help="also those of the code as it is")
    asked = parser.parse_args()
    if unknown := set(asked.tables) - set(TABLES):
        parser.error(f"unknown: {', '.join(sorted(unknown))}; the tables are {', '.join(TABLES)}")
    if "+" in commit():
        parser.error("a table names the commit of its code: commit what has changed")
    LOGS.mkdir(parents=True, exist_ok=True)
    codes = list[int]()
    for lane, width in LANES.items():
        names = [name for name, job in TABLES.items() if job.lane == lane and name in (asked.tables or TABLES)]
        with ThreadPoolExecutor(width) as pool:
            codes += pool.map(partial(make, again=asked.all), names)
    say("all", f"{sum(map(bool, codes))} of {len(codes)} have failed")
    return int(any(codes))


if __name__ == "__main__":
    sys.exit(main())
