"""What pages show below a command is what it prints today."""

import pytest

import excerpts

PAGES = [page for page in excerpts.pages() if excerpts.BLOCK.search(page.read_text("utf-8"))]


@pytest.mark.slow("takes more than half a second")
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_the_output_on_a_page_is_that_of_its_commands(page):
    text = page.read_text("utf-8")
    assert excerpts.renewed(text) == text, "python tools/excerpts.py renews it"


@pytest.mark.slow("takes more than half a second")
def test_a_stale_page_is_renewed_and_the_pipes_shorten(tmp_path):
    stale = "# A page\n\n```console\n$ allanite plan --details --sensor fog --rate 100 | grep fog\nold\n```\n"
    fresh = excerpts.renewed(stale)
    assert "old" not in fresh
    assert fresh.count("\n") == stale.count("\n")
    assert "fog  100 Hz" in fresh
    assert excerpts.renewed(fresh.replace("| grep", "| tail -1 | grep")).count("\n") == stale.count("\n") - 1
    with pytest.raises(SystemExit, match="exit code 3"):
        excerpts.renewed("```console\n$ allanite analyze no.csv\n```\n")
