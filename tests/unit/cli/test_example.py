"""``allanite example``: every paper by commands that can be typed."""

import re

import pytest
from click.testing import CliRunner
from tests import thinned

from allanite.cli import VERBS, main
from allanite.cli.example import EXAMPLES

SHORTER = {
    "--duration '188 min'": "--duration '8 min'", "--duration '30 min'": "--duration '2 min'",
    "--duration 1h": "--duration 240", "--duration 2h": "--duration 600", "--part 1800": "--part 120",
}  # fmt: skip
"""Lengths for the test."""


def run(*arguments):
    return CliRunner().invoke(main, list(map(str, arguments)))


def test_the_list_and_an_unknown_paper():
    listed = run("example").stdout
    assert all(name in listed for name in EXAMPLES)
    refused = run("example", "999")
    assert refused.exit_code == 2
    assert "unknown paper '999'; known papers: 00" in refused.stderr


@pytest.mark.parametrize("paper", EXAMPLES)
def test_the_commands_are_verbs(paper):
    lines = run("example", paper, "--commands").stdout.splitlines()
    assert len(lines) == len(EXAMPLES[paper].commands)
    assert all(line.split()[0] == "allanite" and line.split()[1] in VERBS for line in lines)


@pytest.mark.parametrize("paper", thinned(EXAMPLES, 2, "every example whole"))
def test_an_example_writes_its_files(paper, tmp_path, monkeypatch):
    row = EXAMPLES[paper]
    shorter = []
    for command in row.commands:
        for long, short in SHORTER.items():
            command = command.replace(long, short)  # noqa: PLW2901 - one after the other
        shorter.append(command)
    monkeypatch.setitem(EXAMPLES, paper, type(row)(row.name, row.title, row.source, tuple(shorter)))
    done = run("example", paper, tmp_path / "made")
    assert done.exit_code == 0, done.stderr
    named = set(re.findall(r"[\w.]+\.(?:html|png|csv|npz)", " ".join(shorter)))
    assert named == {path.name for path in (tmp_path / "made").iterdir()}
    again = run("example", paper, tmp_path / "made")
    assert again.exit_code == 2
    assert "exists" in again.stderr
    first = next(command for command in shorter if re.search(r"\.(?:html|png|csv|npz)", command))
    monkeypatch.setitem(EXAMPLES, paper, type(row)(row.name, row.title, row.source, (first,)))
    forced = run("example", paper, tmp_path / "made", "--force", "--quiet")
    assert forced.exit_code == 0, forced.stderr
