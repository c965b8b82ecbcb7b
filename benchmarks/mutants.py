"""Planted faults: which of them the tests find, those of every day and all of them.

    python benchmarks/mutants.py [--faults 60] [--seed 1] [--only 3,7] [--marker slow] [--jobs 2] [--write PATH]

Each fault is planted into a copy of the package; `--list` only shows them. The tests that run its line are those of the
file `--lines`, which is made by running all tests under coverage if it is not there. Nearest tests come first: those of
its room, then all others that run the line, then what is left of its room. Lines that no test is seen to run have the
tests of their file; those that run when a module is imported have all tests, and kernels have those of their users.
A fault is found if a test fails twice, or does not end in `--limit` seconds, and passes without the fault. `make test`
runs the tests without the marker; a fault that they miss goes to those with it.
What has been found out stands in `--outcomes`, where a run that was interrupted goes on; `--keep` takes over what was
found with other commits. Fault k of a seed is always the same unless the package is changed in its room.
"""

from table import ROOT, begin, markdown

import contextlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import covering
from planted import EQUIVALENT, KINDS, PACKAGE, Fault, drawn, rooms

NEAR = {"web": "tests/web/"}
"""Where tests of a room are, if not in the folder of tests/unit with its name."""

WHOLE = 20
"""Times the limit of one test that all tests of a fault may take."""

FAST, SLOW = "make test", "make test-all"


@dataclass
class Tests:
    """How the tests are run: those of every day and the others, and for how long each."""

    marker: str
    limit: float
    lines: covering.Lines
    failing: set[str] = field(default_factory=set)
    """Tests that fail without a fault."""

    def __post_init__(self) -> None:
        self.present = {fast: self._present(fast) for fast in (True, False)}
        self._once = threading.Lock()

    def words(self, fast: bool) -> tuple[str, ...]:
        """What pytest is told to run a set."""
        return ("-m", f"not {self.marker}" if fast else self.marker) if self.marker else ()

    def _present(self, fast: bool) -> list[str]:
        """The test functions of a set; without a marker all belong to the first."""
        if not (fast or self.marker):
            return []
        command = [sys.executable, "-m", "pytest", "--collect-only", "-q", *self.words(fast)]
        said = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False).stdout
        return list(dict.fromkeys(line.partition("[")[0] for line in said.splitlines() if line.startswith("tests/")))

    def of(self, fault: Fault, fast: bool) -> list[str]:
        """The tests of a set that meet a fault, nearest first."""
        if fault.room == "kernels":
            return self._of_kernel(fault, fast)
        present, near = self.present[fast], NEAR.get(fault.room, f"tests/unit/{fault.room}/")
        close = [one for one in present if one.startswith(near)]
        by_line = self.lines.of(fault.file)
        running = set().union(*(by_line.get(line, ()) for line in fault.lines))
        if not running or not fault.called:
            whole = set().union(*by_line.values())
            beside = [one for one in present if one in whole]
            return _unique(_nearest(close, fault), beside, present if not (beside and fault.called) else ())
        listed = [one for one in present if one in running]
        return _unique(_nearest((one for one in listed if one.startswith(near)), fault), listed, close)

    def _of_kernel(self, fault: Fault, fast: bool) -> list[str]:
        """The tests of what uses a kernel, those of its first users in front."""
        parts = []
        for path in users(fault):
            running = set().union(*self.lines.of(path).values())
            room = f"tests/unit/{path.partition('/')[0]}/"
            both = [one for one in self.present[fast] if one in running]
            parts.append([one for one in both if one.startswith(room)])
            parts.append(both)
        return _unique(*parts[::2], *parts[1::2])

    def failed(self, tests: Sequence[str], source: Path, fast: bool) -> str:
        """The first test that fails with the package of a folder, again too, but not with ours; empty if none does."""
        passed = set[str]()
        while True:
            tests = [one for one in tests if one not in self.failing | passed]
            by = self._first(tests, source, fast)
            if not by or by not in tests:
                return by
            with self._once:
                sound = not self._first([by], PACKAGE.parent, fast)
            if sound and self._first([by], source, fast):
                return by
            (passed if sound else self.failing).add(by)
            print(f"fails {'once only' if sound else 'without a fault'}: {by}", flush=True)

    def _first(self, tests: Sequence[str], source: Path, fast: bool) -> str:
        """The first of some tests that fails, or what else went wrong."""
        if not tests:
            return ""
        with tempfile.TemporaryDirectory() as folder:
            listed = Path(folder, "tests")
            listed.write_text("\n".join(tests), encoding="utf-8")
            searched = os.pathsep.join([str(source), str(ROOT / "benchmarks"), str(ROOT / "tools")])
            command = [sys.executable, "-m", "pytest", "-x", "-v", "-p", "no:cacheprovider", *self.words(fast)]
            command += ["-o", f"faulthandler_timeout={self.limit}", "-o", "faulthandler_exit_on_timeout=true"]
            settings = {"PYTHONPATH": searched, "HYPOTHESIS_STORAGE_DIRECTORY": folder, "PYTHONUNBUFFERED": "1"}
            output = Path(folder, "said")
            with output.open("w") as file:
                running = subprocess.Popen(
                    [*command, f"--basetemp={Path(folder, 'files')}", f"@{listed}"],
                    cwd=ROOT, env=os.environ | settings, stdout=file, stderr=subprocess.STDOUT, start_new_session=True,
                )  # fmt: skip
                try:
                    code = running.wait(WHOLE * self.limit)
                except subprocess.TimeoutExpired:
                    code = None
                finally:
                    _end(running)
            return _verdict(code, output.read_text("utf-8", errors="replace"))


def _end(running: subprocess.Popen[bytes]) -> None:
    """Leave no process behind, whatever the tests have started."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(running.pid, signal.SIGKILL)
    running.wait()


def _verdict(code: int | None, said: str) -> str:
    """The test that failed, by what pytest has printed; empty if all passed or none was asked for."""
    if code in (0, 5):
        return ""
    failed = re.search(r"^(?:FAILED|ERROR) ([^\s\[]+)", said, re.MULTILINE)
    if failed:
        return failed[1]
    if code == 4 and "conftest" not in said:
        raise RuntimeError(said)
    begun = re.findall(r"^(tests/[^\s\[]+::[^\s\[]+)", said, re.MULTILINE)
    if begun:
        return begun[-1] if code is not None else ""
    return f"pytest ended with {code}: {said.strip().splitlines()[-1:]}"


def _unique(*parts: Iterable[str]) -> list[str]:
    return list(dict.fromkeys(one for part in parts for one in part))


def _nearest(tests: Iterable[str], fault: Fault) -> list[str]:
    """Tests of the module first."""
    stem = Path(fault.file).stem.strip("_")
    return sorted(tests, key=lambda one: stem not in Path(one.partition("::")[0]).stem)


def users(fault: Fault) -> list[str]:
    """Files that import the module of a kernel, or a kernel that does."""
    texts = {path.relative_to(PACKAGE).as_posix(): path.read_text("utf-8") for path in sorted(PACKAGE.rglob("*.py"))}
    found, new = list[str](), [Path(fault.file).stem]
    seen = set(new)
    while new:
        names = "|".join(new)
        new = []
        for file, text in texts.items():
            inside = file.startswith("kernels/")
            if re.search(rf"from {'[.]' if inside else '[.]*(allanite[.])?kernels[.]'}({names}) import", text):
                name = Path(file).stem
                if not inside:
                    found.append(file)
                elif name not in seen:
                    seen.add(name)
                    new.append(name)
    return list(dict.fromkeys(found))


def copied(fault: Fault, folder: Path) -> Path:
    """A folder with the package and the fault in it; kernels are compiled anew if it is in one of them."""
    without = shutil.ignore_patterns("*.nbi", "*.nbc") if fault.room == "kernels" else None
    package = folder / "allanite"
    shutil.copytree(PACKAGE, package, ignore=without)
    file = package / fault.file
    for old in file.parent.glob(f"__pycache__/{file.stem}.*.pyc"):
        old.unlink()
    file.write_bytes(fault.planted(file.read_bytes()))
    return folder


@dataclass(frozen=True)
class Drawn:
    """A fault, its number and which one of its room and kind it is."""

    number: int
    fault: Fault
    rank: int

    def outcome(self, tests: Tests, code: str) -> dict[str, Any]:
        """Which set of tests finds it, and which test."""
        start, by, found = time.perf_counter(), "", ""
        with tempfile.TemporaryDirectory() as folder:
            source = copied(self.fault, Path(folder))
            for fast in (True, False):
                by = tests.failed(tests.of(self.fault, fast), source, fast)
                if by:
                    found = FAST if fast else SLOW
                    break
        took = round(time.perf_counter() - start)
        return {"number": self.number, "fault": self.fault.key, "found": found, "by": by, "s": took, "commit": code}


def known(path: Path, code: str, keep: bool) -> dict[str, dict[str, Any]]:
    """Outcomes by fault that stand already: those of this commit, or all that were found."""
    lines = path.read_text("utf-8").splitlines() if path.exists() else []
    rows = map(json.loads, lines)
    return {row["fault"]: row for row in rows if row["commit"] == code or (keep and row["found"])}


def table(faults: Sequence[Drawn], outcomes: dict[str, dict[str, Any]]) -> list[str]:
    """Shares of both sets, and a line for each fault."""
    rows, found = [], dict.fromkeys((FAST, SLOW), 0)
    for one in faults:
        fault, outcome = one.fault, outcomes[one.fault.key]
        for which in found:
            found[which] += outcome["found"] in (FAST, which)
        where = f"{fault.file}:{fault.lines.start}"
        changed = [f"`` {text.replace('|', chr(92) + '|')} ``" for text in (fault.old, fault.after)]
        by = outcome["by"].rpartition("/")[2].replace("|", " ")
        rows.append((str(one.number), str(one.rank), where, fault.kind, *changed, outcome["found"] or "missed", by))
    shares = [(name, str(count), f"{100 * count / len(faults):.1f}") for name, count in found.items()]
    headings = ("fault", "draw", "where", "kind", "before", "after", "found by", "first test")
    kinds = []
    for kind in KINDS:
        these = [one for one in faults if one.fault.kind == kind]
        fast = sum(outcomes[one.fault.key]["found"] == FAST for one in these)
        both = sum(bool(outcomes[one.fault.key]["found"]) for one in these)
        kinds.append((kind, str(len(these)), str(fast), str(both)))
    return [
        *markdown(("tests", "found", "found %"), shares),
        *markdown(("kind", "faults", FAST, SLOW), kinds),
        "## Faults",
        "",
        *markdown(headings, rows),
        "## Left out",
        "",
        "Faults that change nothing that can be observed; the next of their room and kind stands in the list instead.",
        "",
        *markdown(("fault", "why"), [(f"`` {k.replace('|', chr(92) + '|')} ``", v) for k, v in EQUIVALENT.items()]),
    ]


def main() -> None:
    options = {"faults": 60, "seed": 1, "only": "", "marker": "slow", "jobs": 2, "limit": 300.0}
    files = {"lines": "build/lines", "outcomes": "build/mutants.jsonl"}
    run = begin(__doc__, **options, **files, list=False, keep=False)
    asked = run.asked
    faults = [Drawn(k, *one) for k, one in enumerate(drawn(asked.faults, asked.seed), 1)]
    if asked.only:
        faults = [one for one in faults if str(one.number) in asked.only.split(",")]
    if asked.list:
        for one in faults:
            print(one.number, one.rank, one.fault.kind, one.fault.lines.start, one.fault.key, sep=" | ")
        return
    lines, kept = ROOT / asked.lines, ROOT / asked.outcomes
    if not lines.exists():
        covering.record(lines, ("-n", "2", "--dist", "worksteal"))
    outcomes = known(kept, run.commit, asked.keep)
    tests = Tests(asked.marker, asked.limit, covering.Lines(lines))
    left = [one for one in faults if one.fault.key not in outcomes]
    kept.parent.mkdir(parents=True, exist_ok=True)
    with ThreadPoolExecutor(asked.jobs) as pool, kept.open("a", encoding="utf-8") as file:
        for done in as_completed([pool.submit(one.outcome, tests, run.commit) for one in left]):
            outcome = done.result()
            outcomes[outcome["fault"]] = outcome
            print(json.dumps(outcome, ensure_ascii=False), file=file, flush=True)
            print(*outcome.values(), sep=" | ", flush=True)
    notes = (
        f"{len(faults)} faults of seed {asked.seed} in {len(rooms())} rooms: rooms and kinds take turns, and draw k is "
        "the k-th of its room and kind in the order of the SHA-256 of the seed and the fault",
        f"{FAST}: tests without the mark {asked.marker}; {SLOW}: all tests; lint and types are not asked",
        "constants of layout count as any other",
        f"a test that takes more than {asked.limit:g} s has failed",
    )
    run.publish("Planted faults and the tests that find them", notes, table(faults, outcomes))


if __name__ == "__main__":
    main()
