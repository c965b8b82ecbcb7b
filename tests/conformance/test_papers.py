"""What five papers say, by commands as anybody can type them: the number of the paper, and ours.

The papers publish no records, so that simulated ones stand in. Where a paper is wrong, the row holds the number that
replaces its own.
"""

import re
import shlex

import numpy as np
import pytest
from tests.commands import run
from tests.conformance.papers import laser, sensors, stabilizer, theoh, torque, vertical
from tests.conformance.papers.inputs import COMMANDS, WRITTEN
from tests.rows import refused, rows

from allanite.papers import paper as papers

MODULES = {"000": stabilizer, "vertical": vertical, "001": theoh, "002": sensors, "003": laser, "004": torque}

SUFFIXES = {"--csv": ".csv", "--coefficients": ".csv", "--json": ".json"}
"""Options that write a file."""


ROWS = [pytest.param(row, id=f"{name} {row.item}") for name, module in MODULES.items() for row in module.ROWS]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    where = tmp_path_factory.mktemp("papers")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(where)
        for command in COMMANDS:
            run(*shlex.split(command), *([] if command.startswith("angle") else ["--quiet"]), code=0)
        for name, write in WRITTEN.items():
            write(name)
        yield where


@pytest.fixture(scope="module")
def written(folder):
    """The file that the last option of a command writes; commands that differ in it alone are one, and run once."""
    options, names = {}, {}
    for row in (row for module in MODULES.values() for row in module.ROWS):
        for command in (row.command,) if isinstance(row.command, str) else row.command:
            *job, option, _ = shlex.split(command)
            options.setdefault(tuple(job), set()).add(option)

    def write(command):
        *job, option, _ = shlex.split(command)
        job = tuple(job)
        if job not in names:
            names[job] = {o: f"{len(names)}{o}{SUFFIXES[o]}" for o in sorted(options[job])}
            run(*job, *(word for pair in names[job].items() for word in pair), "--quiet", code=0)
        return folder / names[job][option]

    return write


@pytest.mark.slow("the examples of all papers")
@rows("row", ROWS)
def test_the_number_is_that_of_the_paper_or_the_one_that_replaces_it(written, row):
    cells = (row.cells,) if isinstance(row.cells, str) else row.cells
    commands = (row.command,) * len(cells) if isinstance(row.command, str) else row.command
    found = row.read(*(papers.number(written(command), cell) for command, cell in zip(commands, cells, strict=True)))
    published = row.published() if callable(row.published) else row.published
    near = pytest.approx(published, rel=row.tolerance, abs=row.tolerance if published == 0 else None)
    assert (found == near) is not row.wrong
    if row.ours is not None:
        assert found == pytest.approx(row.ours, rel=0.01)


ITEMS = [item for name in papers.PAPERS for item in papers.paper(name).items]
"""Every table, figure and claim of the papers: it has a verdict, and a reason where ours differs."""

WIDTHS = (32, 16, 36)
"""Letters of an item with its claim, of what is printed, and of the verdict with the first clause of its reason."""


def test_items_of_papers_are_complete():
    for item in ITEMS:
        read = any(": " in place for place in item.here)
        assert item.verdict in ("", *papers.VERDICTS), item
        assert item.why or item.tolerance or item.verdict in ("", papers.AGREES), item
        assert read == bool(item.numbers or item.ours), f"numbers that nothing is compared with: {item}"
        assert read or not item.here or item.verdict in ("", papers.DRAWN, papers.SHOWN), (
            f"a verdict that cannot fail: {item}"
        )
        assert item.here or item.verdict in (papers.SHOWN, papers.MISSING), f"a verdict that cannot fail: {item}"
        assert not item.numbers or item.paper or item.source, item
        assert not item.source or item.numbers, f"a source without its number: {item}"


def test_every_verdict_turns_with_each_of_its_numbers():
    for item in ITEMS:
        right = list(item.ours or item.numbers)
        assert not right or papers.verdict_on(item, right)[1], item
        for at, each in enumerate(right):
            planted = [*right[:at], each + 2 * (item.tolerance + 0.01) * (abs(each) or 1), *right[at + 1 :]]
            assert not papers.verdict_on(item, planted)[1], f"{item}: {planted} changes nothing"


def test_a_verdict_fails_where_the_files_hold_other_numbers(tmp_path):
    (tmp_path / "a.csv").write_text("value,kind\n7,a\n3,b\n4,b\n", "utf-8")
    for more, verdict in (
        ({"numbers": (7.0,)}, True), ({"numbers": (8.0,)}, False), ({"ours": (7.0,), "verdict": "computed"}, True),
        ({"ours": (8.0,), "verdict": "computed"}, False), ({"numbers": (7.0,), "verdict": "misprint"}, False),
        ({"numbers": (8.0,), "verdict": "misprint", "ours": (9.0,)}, False),
        ({"numbers": (3.5355,), "here": ("a.csv: rms value @ kind=b",)}, True),
        *(({"numbers": numbers, "here": [f"a.csv: value @ value={v}" for v in values], "read": read}, True)
          for read, values, numbers in (
              ("ratio", (7, 7, 3, 4), (1, 3 / 4)), ("mu", (7, 3), (-0.74,)), ("flatness", (3, 4, 7), (4 * 9 / 49,)))),
    ):  # fmt: skip
        given = {"here": ("a.csv: value",), "tolerance": 0.01} | more
        found = papers.compared(papers.Item("eq. 1", "a claim", "7", **given), tmp_path)
        assert found.expected is verdict, more
    absent = papers.Item("eq. 1", "a claim", "7", here=("a.csv: value @ value=9",))
    refused(LookupError, r"a\.csv has no row value=9", lambda: papers.compared(absent, tmp_path))


def test_a_cell_is_a_quantile_of_the_scatter_of_groups(tmp_path):
    rates = np.random.default_rng(1).standard_normal(60)
    (tmp_path / "a.csv").write_text("rate\n" + "\n".join(map(repr, rates.tolist())), "utf-8")
    scatters = np.sort(rates.reshape(5, 4, 3).mean(axis=2).std(axis=1, ddof=1))
    for share, at in ((0, 0), (0.5, 2), (1, 4)):
        assert papers.number(tmp_path / "a.csv", f"{share} of 4 of 3 of rate") == pytest.approx(scatters[at])


def test_a_line_of_the_first_screen_is_not_too_wide():
    for item in ITEMS:
        verdict = item.verdict or (papers.AGREES if item.numbers else papers.DRAWN)
        first_clause = re.split("[:;] ", item.why)[0]
        shown = (f"{item.item}: {item.claim}", item.paper or item.source, f"{verdict}: {first_clause}")
        assert [(text, most) for text, most in zip(shown, WIDTHS, strict=True) if len(text) > most] == [], item.item
