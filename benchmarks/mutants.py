"""Planted faults: how many of them `make test` finds, and how many continuous integration finds.

    python benchmarks/mutants.py --seed 52 --faults 60 [--only 3,7] [--tests tests/unit] [--jobs 2] [--write PATH]

The faults of a seed are always the same unless the package is changed in their room; `--list` only shows them. First
the tests of `make test` run once with a probe in the function of each fault, which notes the tests that call it. Then
each fault is planted into a copy of the package, and these tests run, those of its room first, until one fails. What
they miss goes the same way through the tests that continuous integration runs besides. A kernel has the tests that call
a function of its users; what runs when a module is imported has those that call a function of it or of its importers.

A fault is found if a test fails, or does not end in `--limit` seconds, that passes without the fault and fails again.
The tests of a fault are given `--budget` seconds of each set: what no test has found until then is missed. Outcomes
stand in `--outcomes`, where a run that was interrupted goes on. Compile the kernels before (tools/kernels.py): each
copy takes them along.
"""

from table import ROOT, begin, markdown

import ast
import contextlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from planted import KINDS, PACKAGE, Fault, drawn, rooms

LEVELS = {"make test": "not slow and not nightly", "CI": "slow and not nightly"}
"""Sets of tests and the marks that pytest is told to run them, each without those of the sets before."""

PROBE = """import contextlib
import os

NOTED = set()


def hit(k):
    key = f"{k} {os.environ.get('RUNNING_TEST', '')}\\n"
    if key not in NOTED and "PROBED" in os.environ:
        NOTED.add(key)
        with contextlib.suppress(OSError):  # a test may forbid all files
            file = os.open(os.environ["PROBED"], os.O_WRONLY | os.O_APPEND)
            os.write(file, key.encode())
            os.close(file)
"""
"""A module beside the copy of the package: notes once that a test has called the function of a fault."""


# --- what pytest loads as a plugin -----------------------------------------------------------------------------------


def _note(mark: str, test: str) -> None:
    if path := os.environ.get("TESTS_NOTED"):
        with Path(path).open("a", encoding="utf-8") as file:
            print(mark, test.partition("[")[0], file=file)


@pytest.hookimpl(tryfirst=True, hookwrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """Name the test that runs, for the probes of this process and of those that it starts."""
    os.environ["RUNNING_TEST"] = item.nodeid.partition("[")[0]
    _note("?", item.nodeid)
    yield


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Note a test that fails, in a row of a table too."""
    if report.failed:
        _note("!", report.nodeid)


def pytest_collectreport(report: pytest.CollectReport) -> None:
    """Note a file that cannot be collected."""
    if report.failed:
        _note("!", report.nodeid)


# --- copies of the package -------------------------------------------------------------------------------------------


def copied(folder: Path, fault: Fault | None = None) -> Path:
    """A folder with the package, a fault in it if one is given; compiled kernels do not go with a fault in one."""
    without = shutil.ignore_patterns("*.nbi", "*.nbc") if fault and fault.room == "kernels" else None
    shutil.copytree(PACKAGE, folder / "allanite", ignore=without)
    if fault:
        file = folder / "allanite" / fault.file
        file.write_bytes(fault.planted(file.read_bytes()))
        for old in file.parent.glob(f"__pycache__/{file.stem}.*.pyc"):  # a fault may keep size and second
            old.unlink()
    return folder


@cache
def texts() -> dict[str, str]:
    """The text of each module, by its path in the package."""
    return {path.relative_to(PACKAGE).as_posix(): path.read_text("utf-8") for path in sorted(PACKAGE.rglob("*.py"))}


def importers(file: str) -> list[str]:
    """Modules that import from one; of a kernel, those outside of the kernels that use it, through others too."""
    new, found = [file], dict[str, None]()
    while new:
        path = Path(new.pop())
        name = path.parent.name if path.stem == "__init__" else path.stem
        uses = re.compile(rf"^\s*from [.\w]*\b{name} import |^\s*from [.\w]+ import .*\b{name}\b", re.MULTILINE)
        more = [other for other, text in texts().items() if other not in found and uses.search(text)]
        found |= dict.fromkeys(more)
        new += [other for other in more if other.startswith("kernels/")]
    return [other for other in found if not other.startswith("kernels/")]


def places(fault: Fault) -> Iterator[tuple[str, int]]:
    """Files and lines of the functions whose tests meet a fault; line 0 is every function of the file."""
    if fault.room == "kernels":
        yield from ((file, 0) for file in importers(fault.file))
    else:
        yield fault.file, fault.scope
        yield from ((file, 0) for file in importers(fault.file) if not fault.scope)


def probed(text: str, lines: dict[int, set[int]]) -> str:
    """A module whose functions note the numbers of the faults that stand by their lines, 0 being every function."""
    tree = ast.parse(text)
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            after = 1 if ast.get_docstring(node, clean=False) is not None else 0
            numbers = sorted(lines.get(node.lineno, set()) | lines.get(0, set()))
            node.body[after:after] = [ast.parse(f"__import__('mutant_probe').hit({k})").body[0] for k in numbers]
    return ast.unparse(ast.fix_missing_locations(tree))


def instrumented(folder: Path, faults: dict[int, Fault]) -> Path:
    """A folder with the package and a probe for each fault."""
    copied(folder)
    (folder / "mutant_probe.py").write_text(PROBE, encoding="utf-8")
    wanted: dict[str, dict[int, set[int]]] = defaultdict(lambda: defaultdict(set))
    for k, fault in faults.items():
        for file, line in places(fault):
            wanted[file][line].add(k)
    for file, lines in wanted.items():
        (folder / "allanite" / file).write_text(probed(texts()[file], lines), encoding="utf-8")
    return folder


# --- runs of the tests -----------------------------------------------------------------------------------------------


def environment(source: Path, **more: str) -> dict[str, str]:
    """Where tests find the package of a folder, and this plugin."""
    searched = os.pathsep.join(map(str, (source, ROOT / "benchmarks", ROOT / "tools")))
    return os.environ | {"PYTHONPATH": searched, "PYTHONDONTWRITEBYTECODE": "1"} | more


def calls(faults: dict[int, Fault], words: Sequence[str], jobs: int) -> dict[int, list[str]]:
    """The tests that call the function of each fault, of those that pytest is told to run by words."""
    with tempfile.TemporaryDirectory() as name:
        source, noted = instrumented(Path(name, "package"), faults), Path(name, "noted")
        noted.touch()
        command = [sys.executable, "-m", "pytest", "-q", "-p", "mutants", "-p", "no:cacheprovider", *words]
        command += ["-n", str(jobs), "--dist", "worksteal", f"--basetemp={Path(name, 'files')}"]
        subprocess.run(command, cwd=ROOT, env=environment(source, PROBED=str(noted)), stdout=sys.stderr, check=False)
        found: dict[int, dict[str, None]] = {k: {} for k in faults}
        for line in noted.read_text("utf-8").splitlines():
            k, _, test = line.partition(" ")
            found[int(k)] |= {test: None} if test else {}
    return {k: nearest(faults[k], tests) for k, tests in found.items()}


def nearest(fault: Fault, tests: Iterable[str]) -> list[str]:
    """Tests of the module first, then those of its folders, then those that are left."""
    parts = {*Path(fault.file).with_suffix("").parts}
    return sorted(tests, key=lambda test: -len(parts & {*re.split(r"[/_.:]+", test)}))


@dataclass
class Tests:
    """How the tests of a set are run: for how long each one and all of a fault."""

    marks: str
    limit: float
    budget: float
    sound: Path
    failing: set[str] = field(default_factory=set)
    """Tests that fail without a fault."""

    def failed(self, tests: Sequence[str], source: Path) -> str:
        """The first test that fails with the package of a folder, again too, but not without the fault."""
        until = time.monotonic() + self.budget
        while True:
            tests = [test for test in tests if test not in self.failing]
            by = self.first(tests, source, until - time.monotonic())
            if not by or (not self.first([by], self.sound, self.budget) and self.first([by], source, self.budget)):
                return by
            self.failing.add(by)
            print(f"fails without a fault, or once only: {by}", file=sys.stderr, flush=True)

    def first(self, tests: Sequence[str], source: Path, seconds: float) -> str:
        """The first of some tests that fails or hangs; empty if none does, or the time is up."""
        if not tests:
            return ""
        with tempfile.TemporaryDirectory() as name:
            listed, noted, said = (Path(name, part) for part in ("tests", "noted", "said"))
            listed.write_text("\n".join(tests), encoding="utf-8")
            noted.touch()
            command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "mutants", "-p", "no:cacheprovider"]
            command += ["-o", f"faulthandler_timeout={self.limit}", "-o", "faulthandler_exit_on_timeout=true"]
            command += ["-m", self.marks, f"--basetemp={Path(name, 'files')}", f"@{listed}"]
            settings = {"TESTS_NOTED": str(noted), "HYPOTHESIS_STORAGE_DIRECTORY": name}
            with said.open("w") as output:
                code = ended(command, environment(source, **settings), output, seconds)
            lines = noted.read_text("utf-8").splitlines()
            failures = [line[2:] for line in lines if line.startswith("!")]
            if failures or code in (0, 5, None):  # passed, none belongs to the set, time is up
                return next(iter(failures), "")
            return lines[-1][2:] if lines else f"pytest ended with {code}: {said.read_text('utf-8').strip()[-200:]}"


def ended(command: Sequence[str], settings: dict[str, str], output: Any, seconds: float) -> int | None:
    """The exit code of a command, None if it was ended after so many seconds; no process is left behind."""
    running = subprocess.Popen(
        command, cwd=ROOT, env=settings, stdout=output, stderr=subprocess.STDOUT, start_new_session=True
    )
    try:
        return running.wait(max(seconds, 1.0))
    except subprocess.TimeoutExpired:
        return None
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(running.pid, signal.SIGKILL)
        running.wait()


def outcome(fault: Fault, tests: Tests, listed: Sequence[str]) -> tuple[str, float]:
    """The test that finds a fault, and the seconds that it took."""
    begun = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        by = tests.failed(listed, copied(Path(folder), fault))
    return by, time.monotonic() - begun


# --- the table -------------------------------------------------------------------------------------------------------


def table(faults: dict[int, Fault], outcomes: dict[str, dict[str, Any]]) -> list[str]:
    """Shares of the sets, by kind, and a line for each fault."""
    by_level = {level: [f for f in faults.values() if outcomes[f.key]["found"] == level] for level in LEVELS}
    total, shares = 0, []
    for level, found in by_level.items():
        total += len(found)
        kinds = (str(sum(fault.kind == kind for fault in found)) for kind in KINDS)
        shares.append((level, str(total), f"{100 * total / len(faults):.1f}", *kinds))
    rows = []
    for k, fault in faults.items():
        one = outcomes[fault.key]
        before, after = (f"`` {text.replace('|', chr(92) + '|')} ``" for text in (fault.old, fault.after))
        by = one["by"].rpartition("/")[2].replace("|", " ")
        where = f"{fault.file}:{fault.lines.start}"
        rows.append((str(k), where, fault.kind, before, after, one["found"] or "missed", str(one["tests"]), by))
    every = ("all", str(len(faults)), "", *(str(sum(f.kind == kind for f in faults.values())) for kind in KINDS))
    headings = ("fault", "where", "kind", "before", "after", "found by", "tests that call it", "first test")
    shown = markdown(("tests", "found", "found %", *(f"{kind} found first here" for kind in KINDS)), [*shares, every])
    return [*shown, "## Faults", "", *markdown(headings, rows)]


def main() -> None:
    files = {"outcomes": "build/mutants.jsonl"}
    run = begin(__doc__, seed=52, faults=60, only="", tests="", jobs=2, limit=60.0, budget=120.0, list=False, **files)
    asked = run.asked
    faults = dict(enumerate(drawn(asked.faults, asked.seed), 1))
    if asked.only:
        faults = {k: fault for k, fault in faults.items() if str(k) in asked.only.split(",")}
    if asked.list:
        for k, fault in faults.items():
            print(k, fault.kind, fault.lines.start, fault.key, sep=" | ")
        return
    kept = ROOT / asked.outcomes
    kept.parent.mkdir(parents=True, exist_ok=True)
    before = map(json.loads, kept.read_text("utf-8").splitlines() if kept.exists() else ())
    outcomes = {one["fault"]: one for one in before if one["commit"] == run.commit}
    with tempfile.TemporaryDirectory() as name, ThreadPoolExecutor(asked.jobs) as pool, kept.open("a") as file:
        sound = copied(Path(name))
        for level, marks in LEVELS.items():
            left = {k: f for k, f in faults.items() if level not in outcomes.get(f.key, {"asked": []})["asked"]}
            left = {k: f for k, f in left.items() if not outcomes.get(f.key, {"found": ""})["found"]}
            listed = calls(left, ("-m", marks, *asked.tests.split()), asked.jobs) if left else {}
            tests = Tests(marks, asked.limit, asked.budget, sound)
            results = pool.map(lambda k, tests=tests, listed=listed: outcome(faults[k], tests, listed[k]), left)
            for (k, fault), (by, seconds) in zip(left.items(), results, strict=True):
                was = outcomes.get(fault.key, {"asked": [], "tests": 0})
                one = {"fault": fault.key, "commit": run.commit, "found": level if by else "", "by": by}
                one |= {"asked": [*was["asked"], level], "tests": was["tests"] + len(listed[k])}
                outcomes[fault.key] = one
                print(json.dumps(one, ensure_ascii=False), file=file, flush=True)
                print(k, fault.key, one["found"] or f"missed by {level}", by, f"{seconds:.0f} s", sep=" | ", flush=True)
    notes = (
        f"{len(faults)} faults of seed {asked.seed}, in {len(rooms())} rooms: rooms and kinds take turns, in the order "
        "of the SHA-256 of the seed and the fault",
        "; ".join(f"{level}: {marks}" for level, marks in LEVELS.items()) + "; lint and types are not asked",
        f"a test of more than {asked.limit:g} s has failed; a fault has {asked.budget:g} s of each set",
    )
    run.publish("Planted faults and the tests that find them", notes, table(faults, outcomes))


if __name__ == "__main__":
    main()
