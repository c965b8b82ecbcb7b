"""``allanite example``: every paper by commands that can be typed, and its numbers beside ours."""

import json
import re

import pytest
from tests import thinned
from tests.commands import ends, run
from tests.rows import rows

from allanite.cli import VERBS
from allanite.papers.paper import PAPERS, paper


def test_the_list_and_an_unknown_paper():
    listed = run("example").stdout
    assert all(name in listed for name in PAPERS)
    refused = run("example", "999", code=2)
    assert "unknown paper '999'; known papers: 00" in refused.stderr
    assert all(row.short in listed and row.short in refused.stderr for row in map(paper, PAPERS))


def test_a_paper_is_known_by_its_short_name_and_explained_and_its_commands_are_verbs():
    for row in map(paper, PAPERS):
        assert paper(row.short.upper()) == row
        explained = run("explain", row.name).stdout
        ways = (f"allanite example {row.short}", row.page, *(f"allanite {line}" for line in row.own))
        assert [way for way in ways if way not in explained] == []
        lines = run("example", row.name, "--commands").stdout.splitlines()
        assert len(lines) == len(row.commands)
        assert all(line.split()[0] == "allanite" and line.split()[1] in VERBS for line in lines)
    assert "allanite example stabilizer" in run("explain", "GM").stdout
    assert "did you mean suspended?" in run("example", "mscsg").stderr


@pytest.mark.slow("takes more than half a second")
@rows("name", thinned(PAPERS, 1))
def test_every_item_of_a_paper_has_the_verdict_that_is_expected(name, tmp_path, monkeypatch):
    monkeypatch.delenv("ALLANITE_DETAILS")
    folder = tmp_path / "made"
    done = run("example", name, folder, code=0)
    assert re.search(r"^ +paper or source +here +verdict\b", done.stdout, re.MULTILINE), "no room for the verdict"
    shown = re.findall(r"[\w.]+\.(?:html|svg|csv|npz|json)", " ".join(paper(name).commands))
    assert {*shown, "page.html", "paper.json"} == {path.name for path in folder.iterdir()}
    found = json.loads((folder / "paper.json").read_text("utf-8"))["items"]
    assert [(item["item"], item["claim"], item["here"]) for item in found if not item["expected"]] == []
    page = (folder / "page.html").read_text("utf-8")
    assert page.count("<figure>") == len(paper(name).captions)
    ends(run("example", name, folder), 2, "exists")
