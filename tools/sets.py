"""Write docs/tests.md: which tests `make test-all` alone runs, and why.

    python tools/sets.py [--check]

With --check, end with exit code 1 if the page is not up to date.
"""

import sys
from collections import Counter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "tests.md"
HEAD = """# Tests

`make quick` checks the code and runs the tests of the packages that have changed: it is for every few minutes of work.
`make test` runs the {quick} cases that every change has to pass: grids over the tables and the verbs, anchors, papers,
real recordings, security, the examples of README and documentation, and the story of the page in a browser.
`make test-all` then runs the {slow} cases listed here, and {again} cases again with more: properties with five times as
many examples, and ensembles with five times as many records. Continuous integration runs both.

A test says itself why it is here, by its mark: `@pytest.mark.slow("why")`, or a case of a grid by `thinned` or
`all_but` of `tests`. This page is written by `python tools/sets.py`.

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


def main() -> None:
    """Write or check the page."""
    found = Collected()
    words = ["--collect-only", "-qq", "--no-header", str(ROOT / "tests")]
    if code := pytest.main(words, plugins=[found]):
        sys.exit(code)
    text = page(found.items)
    if "--check" in sys.argv:
        sys.exit(text != PAGE.read_text("utf-8") and "docs/tests.md is not up to date: python tools/sets.py")
    PAGE.write_text(text, "utf-8")


if __name__ == "__main__":
    main()
