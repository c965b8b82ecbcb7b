"""What five papers say, by commands as anybody can type them: the number of the paper, and ours.

The papers publish no records, so that simulated ones stand in. Where a paper is wrong, the row holds the number that
replaces its own.
"""

import shlex

import pytest
from click.testing import CliRunner
from tests.conformance.papers import laser, sensors, stabilizer, theoh, torque, vertical
from tests.conformance.papers.inputs import COMMANDS, WRITTEN
from tests.conformance.papers.rows import number

from allanite.cli import main

PAPERS = {"000": stabilizer, "vertical": vertical, "001": theoh, "002": sensors, "003": laser, "004": torque}


def rows(table):
    """A parameter for every row of the tables of this name, with the number of its paper."""
    found = ((paper, row) for paper, module in PAPERS.items() for row in getattr(module, table))
    return [pytest.param(row, id=f"{paper} {row.item}") for paper, row in found]


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
    done = CliRunner().invoke(main, shlex.split(command))
    assert done.exit_code == code, done.output
    return done.stderr if code else done.stdout


@pytest.fixture(scope="module")
def typed(folder):
    """The standard output of a command, that of errors if it is to end with a code; the same command runs once."""
    found = {}
    return lambda command, code=0: found[command] if command in found else found.setdefault(command, run(command, code))


@pytest.mark.parametrize("row", rows("ROWS"))
def test_the_number_is_that_of_the_paper_or_the_one_that_replaces_it(typed, row):
    cells = (row.cells,) if isinstance(row.cells, str) else row.cells
    commands = (row.command,) * len(cells) if isinstance(row.command, str) else row.command
    found = row.read(*(number(typed(command), cell) for command, cell in zip(commands, cells, strict=True)))
    published = row.published() if callable(row.published) else row.published
    near = pytest.approx(published, rel=row.tolerance, abs=row.tolerance if published == 0 else None)
    assert (found == near) is not row.wrong
    if row.ours is not None:
        assert found == pytest.approx(row.ours, rel=0.01)


@pytest.mark.parametrize("row", rows("TOLD"))
def test_the_sentence_is_said(typed, row):
    assert row.words in " ".join(typed(row.command, row.code).split())


@pytest.mark.parametrize("row", rows("DRAWN"))
def test_the_figure_or_table_is_written(folder, row):
    run(f"{row.command} --force{'' if 'simulate' in row.command else ' --quiet'}")
    written = folder / row.command.split()[-1]
    assert written.stat().st_size > (200 if written.suffix == ".csv" else 10_000)
