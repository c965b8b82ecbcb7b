"""The document for archives: text of the terminal, all figures, the same bytes for the same result."""

import re

import pytest
from click.testing import CliRunner
from tests.unit.reporting.test_report import channel_of, refused, study_of

from allanite.cli import main
from allanite.core.errors import UsageError
from allanite.reporting import document, page, report

HOSTILE = "gx $\\frac{1}{$ \u202e"


@pytest.fixture(scope="module")
def study():
    return study_of(channel_of(HOSTILE), refused("gz"), about=("serial=SN 12",))


COMMAND = "allanite analyze fog.csv --report page.pdf"


@pytest.fixture(scope="module")
def made(study):
    return document(study, command=COMMAND)


def pages(made):
    return len(re.findall(rb"/Type /Page\b", made))


def test_it_has_a_page_for_the_text_and_one_for_each_figure(study, made):
    assert made.startswith(b"%PDF-")
    assert pages(made) == 1 + page(study).count('<svg role="img"')


@pytest.mark.slow("two reports as PDF")
def test_the_same_result_makes_the_same_bytes(study, made):
    assert document(study, command=COMMAND) == made
    assert b"/CreationDate" not in made


def test_the_suffix_says_that_it_is_one(study, tmp_path):
    curve = study.channels[0].curve
    report(curve, tmp_path / "page.PDF")
    assert (tmp_path / "page.PDF").read_bytes().startswith(b"%PDF-")
    with pytest.raises(UsageError, match="already exists"):
        report(curve, tmp_path / "page.PDF")


def test_the_command_line_writes_one(tmp_path):
    out = tmp_path / "plan.pdf"
    words = ["plan", "--sensor", "mems", "--rate", "10", "--report", str(out)]
    done = CliRunner().invoke(main, words)
    assert done.exit_code == 0, done.output
    assert out.read_bytes().startswith(b"%PDF-")
