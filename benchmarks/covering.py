"""Which tests run which lines of the package: the tests under coverage, those of programs that they start included.

A plugin of pytest, which names the test function that runs, and the reader of what was recorded. Needs `coverage` 7.10
or later. Compiled code is not seen, and neither is that of processes which are killed.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from collections import defaultdict
from collections.abc import Iterable, Iterator
from functools import cached_property
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[1]

SETTINGS = """[run]
branch = true
parallel = true
source = {source}
data_file = {folder}/part
concurrency = multiprocessing,thread
sigterm = true
patch = _exit
context = ${{RUNNING_TEST-}}
disable_warnings = no-data-collected,module-not-imported,module-not-measured,already-imported
"""


@pytest.hookimpl(hookwrapper=True, tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """Lines that run from now on are those of this test; so are those of programs that it starts."""
    import coverage

    name = item.nodeid.partition("[")[0]
    running = coverage.Coverage.current()
    if running is not None and os.environ.get("RUNNING_TEST") != name:
        os.environ["RUNNING_TEST"] = name
        running.switch_context(name)
    yield


def record(path: Path, words: Iterable[str]) -> None:
    """Run tests, given by words to pytest, and write the file of the lines that each runs."""
    with tempfile.TemporaryDirectory() as folder:
        settings = Path(folder, "settings")
        settings.write_text(SETTINGS.format(source=ROOT / "src" / "allanite", folder=folder), encoding="utf-8")
        searched = [str(ROOT / "benchmarks"), os.environ.get("PYTHONPATH", "")]
        environment = {"COVERAGE_PROCESS_START": str(settings), "PYTHONPATH": os.pathsep.join(filter(None, searched))}
        tests = [sys.executable, "-m", "pytest", "-p", "covering", "-q", *words]
        subprocess.run(tests, cwd=ROOT, env=os.environ | environment, check=False)
        path.parent.mkdir(parents=True, exist_ok=True)
        # what a killed process left half written is passed over
        joined = [sys.executable, "-m", "coverage", "combine", "-q", f"--rcfile={settings}"]
        subprocess.run(joined, cwd=ROOT, check=True)
        shutil.move(Path(folder, "part"), path)


class Lines:
    """What was recorded."""

    def __init__(self, path: Path) -> None:
        from coverage import CoverageData

        self._data: Any = CoverageData(str(path))
        self._data.read()
        self._files = {name.partition("/src/allanite/")[2]: name for name in self._data.measured_files()}
        self._known: dict[str, dict[int, set[str]]] = {}

    @cached_property
    def tests(self) -> set[str]:
        """Every test function that ran a line."""
        return {name for name in self._data.measured_contexts() if name}

    def of(self, file: str) -> dict[int, set[str]]:
        """The test functions that run each line of a file."""
        if file not in self._known:
            lines: dict[int, set[str]] = defaultdict(set)
            if file in self._files:
                for line, contexts in self._data.contexts_by_lineno(self._files[file]).items():
                    lines[line] = {name for name in contexts if name}
            self._known[file] = lines
        return self._known[file]
