"""What five papers say, by commands as anybody can type them: the number of the paper, and ours.

The papers publish no records, so that simulated ones stand in. Where a paper is wrong, the row holds the number that
replaces its own.
"""

import re
import shlex

import numpy as np
import pytest
from click.testing import CliRunner
from tests.conformance.papers import laser, sensors, stabilizer, theoh, torque, vertical
from tests.conformance.papers.inputs import COMMANDS, WRITTEN
from tests.conformance.papers.rows import number
from tests.rows import rows

from allanite.cli import main
from allanite.papers.paper import (
    AGREES,
    DRAWN,
    MISSING,
    PAPERS,
    SHOWN,
    VERDICTS,
    Item,
    compared,
    number as cell_of,
    paper,
    verdict_on,
)

MODULES = {"000": stabilizer, "vertical": vertical, "001": theoh, "002": sensors, "003": laser, "004": torque}

SUFFIXES = {"--csv": "csv", "--coefficients": "csv", "--readings": "csv", "--json": "json", "--plot": "svg",
            "--closeup": "svg"}  # fmt: skip
"""Options that write a file."""


ROWS = [pytest.param(row, id=f"{paper} {row.item}") for paper, module in MODULES.items() for row in module.ROWS]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    where = tmp_path_factory.mktemp("papers")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(where)
        for command in COMMANDS:
            run(f"{command}{'' if command.startswith('angle') else ' --quiet'}")
        for name, write in WRITTEN.items():
            write(name)
        yield where


def run(command, code=0):
    words = shlex.split(command) if isinstance(command, str) else command
    done = CliRunner().invoke(main, words)
    assert done.exit_code == code, done.output
    return done.stderr if code else done.stdout


def parted(command):
    """A command without the option that writes its result, and that option."""
    *job, option, _ = ("", "", *shlex.split(command))
    return (tuple(job[2:]), option) if option in SUFFIXES else (tuple(shlex.split(command)), "")


def wanted():
    """What is wanted of each job, so that it runs once: the options that write files, and the text where it is said."""
    found = {}
    for module in MODULES.values():
        for row in module.ROWS:
            for command in (row.command,) if isinstance(row.command, str) else row.command:
                job, option = parted(command)
                found.setdefault(job, set()).add(option)
    return found


@pytest.fixture(scope="module")
def written(folder):
    """The text of a job, or the file that an option of it writes."""
    jobs, said = wanted(), {}

    def write(command, code=0):
        job, option = parted(command)
        name = f"{list(jobs).index(job)}{option}"
        if job not in said:
            paths = [(o, f"{list(jobs).index(job)}{o}.{SUFFIXES[o]}") for o in sorted(jobs[job] - {""})]
            quiet = () if "" in jobs[job] or "simulate" in job else ("--quiet",)
            said[job] = run([*job, *(word for path in paths for word in path), *quiet], code)
        return folder / f"{name}.{SUFFIXES[option]}" if option else said[job]

    return write


@pytest.mark.slow("the examples of all papers")
@rows("row", ROWS)
def test_the_number_is_that_of_the_paper_or_the_one_that_replaces_it(written, row):
    cells = (row.cells,) if isinstance(row.cells, str) else row.cells
    commands = (row.command,) * len(cells) if isinstance(row.command, str) else row.command
    found = row.read(*(number(written(command), cell) for command, cell in zip(commands, cells, strict=True)))
    published = row.published() if callable(row.published) else row.published
    near = pytest.approx(published, rel=row.tolerance, abs=row.tolerance if published == 0 else None)
    assert (found == near) is not row.wrong
    if row.ours is not None:
        assert found == pytest.approx(row.ours, rel=0.01)


ITEMS = [item for name in PAPERS for item in paper(name).items]
"""Every table, figure and claim of the papers: it has a verdict, and a reason where ours differs."""

WIDTHS = (32, 16, 36)
"""Letters of an item with its claim, of what is printed, and of the verdict with the first clause of its reason."""


def test_items_of_papers_are_complete():
    for item in ITEMS:
        read = any(": " in place for place in item.here)
        assert item.verdict in ("", *VERDICTS), item
        assert item.why or item.tolerance or item.verdict in ("", AGREES), item
        assert read == bool(item.numbers or item.ours), f"numbers that nothing is compared with: {item}"
        assert read or not item.here or item.verdict in ("", DRAWN, SHOWN), f"a verdict that cannot fail: {item}"
        assert item.here or item.verdict in (SHOWN, MISSING), f"a verdict that cannot fail: {item}"
        assert not item.numbers or item.paper or item.source, item
        assert not item.source or item.numbers, f"a source without its number: {item}"


def test_every_verdict_turns_with_each_of_its_numbers():
    for item in ITEMS:
        right = list(item.ours or item.numbers)
        assert not right or verdict_on(item, right)[1], item
        for at, each in enumerate(right):
            planted = [*right[:at], each + 2 * (item.tolerance + 0.01) * (abs(each) or 1), *right[at + 1 :]]
            assert not verdict_on(item, planted)[1], f"{item}: {planted} changes nothing"


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
        found = compared(Item("eq. 1", "a claim", "7", **given), tmp_path)
        assert found.expected is verdict, more
    with pytest.raises(LookupError, match=r"a\.csv has no row value=9"):
        compared(Item("eq. 1", "a claim", "7", here=("a.csv: value @ value=9",)), tmp_path)


def test_a_cell_is_a_quantile_of_the_scatter_of_groups(tmp_path):
    rates = np.random.default_rng(1).standard_normal(60)
    (tmp_path / "a.csv").write_text("rate\n" + "\n".join(map(repr, rates.tolist())), "utf-8")
    scatters = np.sort(rates.reshape(5, 4, 3).mean(axis=2).std(axis=1, ddof=1))
    for share, at in ((0, 0), (0.5, 2), (1, 4)):
        assert cell_of(tmp_path / "a.csv", f"{share} of 4 of 3 of rate") == pytest.approx(scatters[at])


def test_a_line_of_the_first_screen_is_not_too_wide():
    for item in ITEMS:
        verdict = item.verdict or (AGREES if item.numbers else DRAWN)
        shown = (
            f"{item.item}: {item.claim}",
            item.paper or item.source,
            f"{verdict}: {re.split('[:;] ', item.why)[0]}",
        )
        assert [(text, most) for text, most in zip(shown, WIDTHS, strict=True) if len(text) > most] == [], item.item
