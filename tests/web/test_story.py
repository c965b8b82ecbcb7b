"""The story of the page in a browser: a file is dropped, and its noise is there."""

from pathlib import Path
from typing import Any

from .browsing import curves, drop, needed

pytestmark = needed


def test_a_file_is_dropped_and_analyzed(page: Any, six: Path) -> None:
    drop(page, six)
    curves(page)
    assert page.get_by_test_id("tab").all_inner_texts() == ["gx", "gy", "gz", "ax", "ay", "az"]
    assert page.get_by_test_id("option-rate").get_attribute("placeholder") == "100"
    assert "100" in page.get_by_test_id("assumed").inner_text()
    assert int(page.get_by_test_id("trace").get_attribute("data-points")) > 200
    assert page.get_by_test_id("curve").get_attribute("data-validity") == "explained"
