"""How old each committed table of the benchmarks is, and how much of what it describes has changed since.

    python tools/stale.py [TABLE ...]   a line for each table: room, stamp, what has changed in the room, verdict
    python tools/stale.py --check       exit code 1 if a table names no commit of the history, or no known script
    python tools/stale.py --release     exit code 1 if a table is stale as well

The room of a table stands in `ROOMS` of benchmarks/table.py, by the script that its command names. Where the history is
not whole, as in a shallow clone, no table can be judged: this is said, and only --release fails.
"""

import argparse
import re
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "benchmarks"))

from table import RESULTS, ROOMS, Page  # noqa: E402

MOST = 0.02
"""Share of the lines of its room that may differ before a table is stale.

Sentences, comments and names change from day to day and stay below it: 2 % of the 7 000 lines of the identification are
three functions of its usual length. A computation is seldom changed by fewer, its callers and checks included.
"""

SHALLOW = "the history is not whole, no table can be judged: git fetch --unshallow"
SOURCE = "src/allanite"


class Age(NamedTuple):
    """What has changed since a table was made."""

    name: str
    rooms: str
    stamp: str
    commits: int
    changed: int
    lines: int

    @property
    def verdict(self) -> str:
        """Whether the table describes the code of today."""
        if "before" in self.stamp or not self.lines:
            return "stale: not of a commit of the history"
        return "stale" if self.changed > MOST * self.lines else "fresh"

    def __str__(self) -> str:
        share = f"{self.commits} commits, {self.changed} of {self.lines} lines"
        return f"{self.name:24} {self.stamp:14} {share:36} {self.verdict:6} {self.rooms or 'all'}"


def git(*words: str) -> str:
    """What git prints; empty where it fails."""
    done = subprocess.run(["git", "-C", str(ROOT), *words], capture_output=True, text=True, check=False)  # noqa: S603, S607
    return done.stdout


def whole() -> bool:
    """Whether every commit of the history can be asked for."""
    return git("rev-parse", "--is-shallow-repository").strip() == "false"


def script(page: Page) -> str:
    """The script that makes a page: the last that its command names."""
    line = re.search(r"^- command: .*", page.head, re.MULTILINE)
    return (re.findall(r"benchmarks/(\w+)\.py", line[0]) if line else [""])[-1]


def stamp(page: Page) -> tuple[str, str]:
    """The oldest commit that a page names, in its head or in a column, and its date; also "before COMMIT"."""
    rows = (f"{row['commit']}, {row['date']}" for table in page.tables() for row in table if "date" in row)
    pattern = r"^(?:- commit )?((?:before )?[0-9a-f]{7})\b.*?, (\d{4}-\d\d-\d\d)"
    named = re.findall(pattern, "\n".join((page.head, *rows)), re.MULTILINE)
    return min(named, key=lambda each: each[1], default=("", ""))


@cache
def differences(commit: str) -> list[tuple[int, str]]:
    """Lines added and removed in each module since a commit; of a module that was moved, those changed besides."""
    listed = git("diff", "-M", "--numstat", "-z", commit, "HEAD", "--", SOURCE)
    found = re.findall(r"(\d+)\t(\d+)\t(?:\0[^\0]+\0)?([^\0]+\.py)\0", listed)
    return [(int(added) + int(removed), path) for added, removed, path in found]


def known(commit: str) -> bool:
    """Whether a commit belongs to the history."""
    return bool(commit) and git("merge-base", commit[-7:], "HEAD").startswith(commit[-7:])


def age(page: Page, name: str) -> Age:
    """The age of a table."""
    rooms, (commit, _) = ROOMS.get(script(page), "unknown"), stamp(page)
    if not known(commit) or rooms == "unknown":
        return Age(name, rooms, commit, 0, 0, 0)
    places = [f"{SOURCE}/{room}".rstrip("/") for room in rooms.split() or [""]]
    inside = tuple(place if place.endswith(".py") else f"{place}/" for place in places)
    changed = sum(lines for lines, path in differences(commit[-7:]) if path.startswith(inside))
    modules = [path for path in git("ls-files", "--", *places).splitlines() if path.endswith(".py")]
    size = sum((ROOT / path).read_bytes().count(b"\n") for path in modules)
    commits = int(git("rev-list", "--count", "--no-merges", f"{commit[-7:]}..HEAD", "--", *places))
    return Age(name, rooms, commit, commits, changed, size)


def pages() -> Iterator[tuple[str, Page]]:
    """Every committed table and its name."""
    for path in sorted(RESULTS.glob("*.md")):
        yield path.name, Page(path.read_text("utf-8"))


def unstamped() -> list[str]:
    """Tables whose stamp is no commit of the history, or whose script is not known, a line each."""
    bad = ((name, stamp(page)[0]) for name, page in pages() if script(page) not in ROOMS or not known(stamp(page)[0]))
    return [
        f"{name}: no commit of the history ({commit or 'none'}), or no script of benchmarks/" for name, commit in bad
    ]


def unfit() -> list[str]:
    """What speaks against a release, a line each: stamps that are none, and tables that are stale."""
    if not whole():
        return [SHALLOW]
    ages = (age(page, name) for name, page in pages())
    old = (each for each in ages if each.lines and each.verdict != "fresh")
    again = "make it again, or remove it with what cites it"
    return unstamped() + [
        f"{a.name}: {a.changed} of {a.lines} lines have changed since {a.stamp}: {again}" for a in old
    ]


def main() -> None:
    """Print, or judge."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tables", nargs="*", help="names of files of benchmarks/results; all by default")
    parser.add_argument("--check", action="store_true", help="judge the stamps only")
    parser.add_argument("--release", action="store_true", help="judge the stamps and the age")
    asked = parser.parse_args()
    if asked.release or not whole():
        lines = unfit()
        print(*lines, sep="\n")
        sys.exit(asked.release and bool(lines))
    if asked.check:
        sys.exit("\n".join(unstamped()) or 0)
    for name, page in pages():
        if not asked.tables or name in asked.tables:
            print(age(page, name))


if __name__ == "__main__":
    main()
