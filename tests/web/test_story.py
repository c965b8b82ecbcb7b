"""The story of the page in a browser: a file is dropped, its noise is there, and is taken away."""

import json

import pytest

from .browsing import curves, drop, kept, saved

pytestmark = pytest.mark.slow("the page in a browser, by one story")


def test_a_file_is_dropped_analyzed_exported_and_there_after_a_reload(page, six):
    drop(page, six)
    curves(page)
    assert page.get_by_test_id("tab").all_inner_texts() == ["gx", "gy", "gz", "ax", "ay", "az"]
    assert page.get_by_test_id("option-rate").get_attribute("placeholder") == "100"
    assert "100" in page.get_by_test_id("assumed").inner_text()
    assert int(page.get_by_test_id("trace").get_attribute("data-points")) > 200
    assert page.get_by_test_id("curve").get_attribute("data-validity") == "explained"
    page.get_by_test_id("target").select_option("kalibr")
    page.get_by_test_id("export").click()
    assert "gyroscope_noise_density" in page.get_by_test_id("export-text").text_content()
    assert len(json.loads(saved(page, "json"))["channels"]) == 6
    assert "<!DOCTYPE html>" in saved(page, "report")
    page.get_by_test_id("spectrum").click()
    page.wait_for_function("() => document.querySelector('[data-testid=picture-spectrum]')?.naturalWidth > 0")
    kept(page)
    page.reload()
    curves(page)
    assert page.get_by_test_id("file").inner_text() == "six.csv"
