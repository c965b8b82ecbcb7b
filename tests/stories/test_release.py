"""What a release says of itself: version, date and changes."""

import re
from datetime import date

import pytest
import yaml
from tests import ROOT
from tests.rows import rows

import allanite
import changes

LOG = changes.LOG.read_text("utf-8")
DAY = date(2027, 1, 2)
BEGUN = "# Changelog\n\nWords.\n\n## 1.0 (2026-12-01)\n\nFirst.\n\n### Read\n\n- A.\n\n### Draw\n\n- B.\n"


def test_the_version_is_the_same_everywhere():
    (released,) = re.findall(rf"^## {re.escape(allanite.__version__)} \((.*)\)$", LOG, re.MULTILINE)
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text("utf-8"))
    recipe = yaml.safe_load((ROOT / "packaging" / "conda" / "recipe.yaml").read_text("utf-8"))
    assert (cited["version"], str(cited["date-released"])) == (allanite.__version__, released)
    assert recipe["context"]["version"] == allanite.__version__
    assert f"Status: {allanite.__version__}" in (ROOT / "README.md").read_text("utf-8")


def test_the_changelog_is_short_and_by_job():
    first = LOG.split("\n## ")[1]
    assert len(first.splitlines()) <= 80
    assert re.search(r"unreleased", LOG, re.IGNORECASE) is None
    named = set(re.findall(r"`allanite (\w+)", LOG))
    from allanite.cli import VERBS

    assert named == set(VERBS)


def test_every_fragment_is_taken():
    texts = [path.read_text("utf-8") for path in changes.fragments()]
    grown = changes.joined(LOG, texts, allanite.__version__, DAY)
    assert all(text.split("\n\n", 1)[1] in grown for text in texts)


@rows(
    "version, texts, expected",
    [
        ("1.0", ["### Read\n\n- C\n  D.\n"], BEGUN.replace("- A.\n", "- A.\n- C\n  D.\n")),
        ("1.0", ["### New\n\n- C.\n", "### Draw\n\n- D.\n"], f"{BEGUN}- D.\n\n### New\n\n- C.\n"),
        ("1.1", ["### Read\n\n- C.\n"], BEGUN.replace("## 1.0", "## 1.1 (2027-01-02)\n\n### Read\n\n- C.\n\n## 1.0")),
        ("1.0", [], BEGUN),
    ],
)  # fmt: skip
def test_fragments_join_the_section_of_the_version(version, texts, expected):
    assert changes.joined(BEGUN, texts, version, DAY) == expected


@rows("text", ["- C.\n", "### Read\n- C.\n", "### Read\n\nC.\n", ""])
def test_a_fragment_of_another_form_is_refused(text):
    with pytest.raises(ValueError, match="a fragment is"):
        changes.joined(BEGUN, [text], "1.0", DAY)
