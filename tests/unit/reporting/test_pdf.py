"""The document for archives: text of the terminal, all figures, the same bytes for the same result."""

import re
from itertools import pairwise

import pytest
from matplotlib.backends import backend_pdf
from tests.commands import run
from tests.unit.reporting.test_report import channel_of, refused, study_of

import allanite as al
from allanite.reporting import document, page, report
from allanite.reporting.pdf import PAPER

pytestmark = pytest.mark.slow("figures by matplotlib")


@pytest.fixture(scope="module")
def study():
    return study_of(channel_of("gx $\\frac{1}{$ \u202e"), refused("gz"), about=("serial=SN 12",))


COMMAND = "allanite analyze fog.csv --report page.pdf"


def test_figures_have_the_order_of_the_page_and_lie_on_nothing(study, monkeypatch):
    sheets = []
    monkeypatch.setattr(backend_pdf.PdfPages, "savefig", lambda _, sheet: sheets.append(sheet))
    monkeypatch.setattr(backend_pdf.PdfPages, "close", lambda _: None)
    document(study, command=COMMAND)
    placed = [list(getattr(sheet, "placed", ())) for sheet in sheets]
    words = "\n".join(text.get_text() for sheet in sheets for text in sheet.texts)
    order = (
        "Summary: model fits", "±: 95 % half width", "explained", "angle random walk", "Data sheet", "does the model",
        "Record and spectrum", "gz", "no result", "How this was computed", "Command line", "Recipe", "Provenance",
    )  # fmt: skip
    places = [0]
    for part in order:
        places.append(words.lower().index(part.lower(), places[-1]))
    assert sum(map(len, placed)) * 2 == page(study).count('<svg role="img"')
    # nothing lies on something else nor beyond the paper
    for figures in placed:
        boxes = sorted((figure.bbox_inches.y0, figure.bbox_inches.y1) for figure in figures)
        assert all(top <= foot for (_, top), (foot, _) in pairwise(boxes))
        assert all(low > 0.5 and high < PAPER[1] - 0.5 for low, high in boxes)
        assert all(figure.bbox_inches.x0 > 0.5 for figure in figures)


def test_a_report_of_six_channels_has_at_most_twenty_pages():
    names = ("gx", "gy", "gz", "ax", "ay", "az")
    channels = [channel_of(name, warnings=("one outlier", "coarse steps")) for name in names]
    assert len(re.findall(rb"/Type /Page\b", document(study_of(*channels)))) <= 20


def test_the_same_result_makes_the_same_bytes(study):
    made = document(study, command=COMMAND)
    assert document(study, command=COMMAND) == made
    assert b"/CreationDate" not in made


def test_the_suffix_says_that_it_is_one(study, tmp_path):
    curve = study.channels[0].curve
    report(curve, tmp_path / "page.PDF")
    assert (tmp_path / "page.PDF").read_bytes().startswith(b"%PDF-")
    with pytest.raises(al.UsageError, match="already exists"):
        report(curve, tmp_path / "page.PDF")
    # the command line writes one
    out = tmp_path / "plan.pdf"
    run("plan", "--sensor", "mems", "--rate", 10, "--report", out, code=0)
    assert out.read_bytes().startswith(b"%PDF-")
