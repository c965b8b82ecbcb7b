"""Write docs/tests.md: which tests `make test-all` alone runs, and why.

    python tools/sets.py [--check]
    python tools/sets.py --measured REPORT.xml [REPORT.xml]...

With --check, end with exit code 1 if the page is not up to date, or tests/long.txt names a test that is not there.
With reports of runs (pytest --junitxml=REPORT.xml), write tests/long.txt first: the tests whose cases took longer than
`LONG` seconds on average in each of them, and those of the list that were in none.
"""

import sys
from collections import Counter
from pathlib import Path
from statistics import fmean
from xml.etree import ElementTree

import pytest

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "tests.md"
LIST = ROOT / "tests" / "long.txt"
LONG = 0.5
HEAD = """# Tests

`make quick` checks the code and runs the tests of the packages that have changed: it is for every few minutes of work.
`make test` runs the {quick} cases that every change has to pass in a few minutes: grids over the tables and the verbs,
anchors, papers, formats, messages, security. `make test-all` then runs the {slow} cases listed here, and {again} cases
again with more: properties with five times as many examples, and ensembles with five times as many records. Continuous
integration runs both.

A test says itself why it is here, by its mark: `@pytest.mark.slow("why")`, or a case of a grid by `thinned` or
`all_but` of `tests`. What took more than half a second when it was measured is listed in tests/long.txt. This page is
written by `python tools/sets.py`.

| tests | cases | why they are in `make test-all` alone |
|---|---|---|
"""


class Collected:
    """Takes what pytest collects."""

    def __init__(self) -> None:
        self.items: list[pytest.Item] = []

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Keep them."""
        self.items = list(items)


def page(items: list[pytest.Item]) -> str:
    """The page: a row for each file and reason."""
    slow = {item: mark for item in items if (mark := item.get_closest_marker("slow"))}
    fuller = ("ensemble", "hypothesis")
    again = [item for item in items if item not in slow and any(map(item.get_closest_marker, fuller))]
    rows = Counter((item.path.relative_to(ROOT).as_posix(), *mark.args) for item, mark in slow.items())
    lines = (f"| {name} | {count} | {why} |\n" for (name, why), count in sorted(rows.items()))
    return HEAD.format(quick=len(items) - len(slow), slow=len(slow), again=len(again)) + "".join(lines)


def measured(report: Path) -> dict[str, float]:
    """Mean seconds of the cases of each test of a run."""
    times: dict[str, list[float]] = {}
    for case in ElementTree.parse(report).iter("testcase"):  # noqa: S314 - our own
        test = f"{case.attrib['classname'].replace('.', '/')}.py::{case.attrib['name'].partition('[')[0]}"
        if case.find("skipped") is None:
            times.setdefault(test, []).append(float(case.attrib["time"]))
    return {test: fmean(all_) for test, all_ in times.items()}


def listed(reports: list[dict[str, float]], before: list[str]) -> list[str]:
    """The tests that are long: in each of the reports that have them, or in none and long before."""
    there = {test for report in reports for test in report}
    long = {test for test in there if min(report[test] for report in reports if test in report) > LONG}
    return sorted(long | (set(before) - there))


def main() -> None:
    """Write or check the page."""
    if "--measured" in sys.argv:
        reports = [measured(Path(name)) for name in sys.argv[sys.argv.index("--measured") + 1 :]]
        long = listed(reports, LIST.read_text("utf-8").splitlines())
        LIST.write_text("".join(f"{test}\n" for test in long), "utf-8")
    found = Collected()
    words = ["--collect-only", "-qq", "--no-header", str(ROOT / "tests")]
    if code := pytest.main(words, plugins=[found]):
        sys.exit(code)
    text = page(found.items)
    gone = set(LIST.read_text("utf-8").splitlines()) - {item.nodeid.partition("[")[0] for item in found.items}
    if gone:
        sys.exit(f"tests/long.txt names tests that are not there, remove them: {sorted(gone)}")
    if "--check" in sys.argv:
        sys.exit(text != PAGE.read_text("utf-8") and "docs/tests.md is not up to date: python tools/sets.py")
    PAGE.write_text(text, "utf-8")


if __name__ == "__main__":
    main()
