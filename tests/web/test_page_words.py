"""What the page says and shows: the answer first, names instead of paths, controls instead of options, and ways on."""

import numpy as np
import pytest

import allanite as al

from .browsing import PATIENCE, SUITE, clear, curves, drop, finished, state, written
from .served import served

pytestmark = SUITE


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Files of every state of the page: without units, no recording at all, and one with a few wild samples."""
    folder, rng = tmp_path_factory.mktemp("data"), np.random.default_rng(5)
    stamps = np.arange(20_000) / 100.0
    rows = np.column_stack([stamps, rng.normal(size=(stamps.size, 3))])
    np.savetxt(folder / "bare.csv", rows, delimiter=",", header="time,gyro_x,gyro_y,gyro_z", comments="", fmt="%.6g")
    (folder / "notes.txt").write_text("this is no recording\n", encoding="utf-8")
    walking = al.simulate(al.N(0.6, "deg/sqrt(h)") + al.B(100, "deg/h"), 20_000, 100.0, rng=rng)
    values = np.degrees(walking.rate_values)[:, None]
    written(folder / "walk.csv", values)
    values[[4000, 12_345], 0] = -30.0, 80.0
    written(folder / "wild.csv", values)
    return folder


def disabled(page, *names):
    return [name for name in names if page.get_by_test_id(name).is_disabled()]


def test_the_answer_is_on_the_first_screen(page, six):
    drop(page, six)
    curves(page)
    curve, card = (page.get_by_test_id(name).first.bounding_box() for name in ("curve", "card"))
    assert curve["y"] + curve["height"] < 900
    assert card["x"] >= curve["x"] + curve["width"]
    assert card["y"] + card["height"] < 900
    names = page.get_by_test_id("card-name")
    assert names.all_inner_texts() == ["gx", "gy", "gz", "ax", "ay", "az"]
    assert "Angle random walk" in page.get_by_test_id("card").first.inner_text()
    names.nth(3).click()
    page.wait_for_function("() => document.querySelector('[data-testid=card-name][aria-current]').textContent === 'ax'")
    page.wait_for_function("() => /m\\/s|µg|ug/.test(document.querySelector('#curve-plot').layout.yaxis.title.text)")


def test_a_curve_has_a_legend_and_its_coefficients_at_the_lines(page, files):
    drop(page, files / "walk.csv")
    curves(page)
    legend = page.locator("#curve-plot .legendtext").all_text_contents()
    assert {"95 % interval", "gx", "Model", "N angle random walk", "B bias instability"} <= set(legend)
    labels = page.locator("#curve-plot .annotation-text").all_text_contents()
    card = " ".join(page.get_by_test_id("card").inner_text().split())
    for label in labels:
        symbol, number = label.split(" ", 1)
        assert f"({symbol}), {number.split()[1]} {number.split()[0]}" in card
    assert len(labels) == 2
    assert page.locator("#curve-plot .ytick").count() >= 4
    page.get_by_test_id("model").uncheck()
    page.wait_for_function("() => !document.querySelector('#curve-plot .annotation-text')")


def test_found_terms_differ_from_those_that_are_allowed_and_are_fitted_again(page, files):
    drop(page, files / "walk.csv")
    curves(page)
    before = page.get_by_test_id("sheet").inner_text()
    marks = {symbol: page.get_by_test_id(f"mark-{symbol}") for symbol in "QNBW"}
    assert {symbol: mark.inner_text() for symbol, mark in marks.items()} == {"Q": "○", "N": "●", "B": "●", "W": ""}
    assert marks["N"].get_attribute("aria-label") == "found"
    page.get_by_test_id("term-Q").uncheck()
    page.wait_for_selector("#curve-plot[data-refits='1']")
    assert (marks["Q"].inner_text(), marks["N"].inner_text()) == ("", "●")
    assert page.get_by_test_id("sheet").inner_text() != before
    page.get_by_test_id("fit-auto").click()
    page.wait_for_selector("#curve-plot[data-refits='2']")
    assert disabled(page, "fit-auto") == ["fit-auto"]
    page.get_by_test_id("terms-fold").click()
    page.get_by_test_id("term-GM").click()
    page.wait_for_selector("#curve-plot[data-refits='3']")
    assert page.get_by_test_id("term-GM").is_checked()
    page.get_by_test_id("undo").click()
    page.wait_for_function("() => !document.querySelector('[data-testid=term-GM]').checked")


def test_numbers_are_drawn_before_their_unit_is_known(page, files):
    drop(page, files / "bare.csv")
    error = page.get_by_test_id("error-unit")
    error.wait_for()
    page.wait_for_selector("#trace-plot[data-points]")
    assert page.get_by_test_id("raw").inner_text().endswith("Not known yet: Unit")
    shown = page.evaluate("() => { const {layout, data} = document.querySelector('#trace-plot'); "
                          "return [layout.yaxis.title.text, Math.max(...data[1].y)]; }")  # fmt: skip
    assert shown[0] == "Number in the file"
    assert 3 < shown[1] < 6  # standard deviations of 1, as in the file
    assert error.inner_text().startswith("bare.csv: ")
    assert "--" not in error.inner_text()
    assert "“Unit”" in error.inner_text()
    every = ("cut", "only", "mask", "whole", "undo", "redo", "spectrum", "dynamic")
    assert disabled(page, *every) == list(every)
    page.get_by_test_id("unit-deg/s").click()
    curves(page)
    assert page.get_by_test_id("raw").is_hidden()
    assert disabled(page, "spectrum", "dynamic") == []


def test_what_the_logger_did_is_told_of_the_file_and_what_happened_on_the_card(page, tmp_path):
    rng = np.random.default_rng(6)
    written(tmp_path / "held.csv", np.repeat(rng.normal(size=(10_000, 1)), 3, axis=0))
    drop(page, tmp_path / "held.csv")
    curves(page)
    for place in (page.get_by_test_id("assumed"), page.get_by_test_id("findings")):
        assert place.locator("li").first.inner_text().startswith("held from 33.333 Hz: the logger repeats each sample")
    loud = np.repeat(rng.random(200) < 0.25, 50)[:, None]
    written(tmp_path / "bursts.csv", rng.normal(size=(10_000, 1)) * np.where(loud, 4, 1))
    drop(page, tmp_path / "bursts.csv")
    page.get_by_test_id("card-finding").get_by_text("bursts of stronger noise").wait_for()
    assert page.get_by_test_id("finding").first.inner_text().startswith("bursts of stronger noise")


def test_a_few_wild_samples_do_not_make_a_line_of_the_others(page, files):
    drop(page, files / "wild.csv")
    curves(page)
    beyond = page.get_by_test_id("beyond")
    assert "288000" in beyond.inner_text()
    assert "-108000" in beyond.inner_text()
    low, high = page.evaluate("document.querySelector('#trace-plot').layout.yaxis.range")
    assert -10_000 < low < -500
    assert 500 < high < 10_000
    clear(page, 1280)


def test_a_file_opened_by_its_path_is_called_by_its_name(page, files):
    path = files / "walk.csv"
    assert disabled(page, "open") == ["open"]
    page.get_by_test_id("open-path").fill(str(path))
    page.get_by_test_id("open").click()
    curves(page)
    file = page.get_by_test_id("file")
    assert file.inner_text() == "walk.csv"
    assert file.get_attribute("title") == str(path)
    assert page.get_by_test_id("command").inner_text() == f"allanite analyze {path}"


def test_a_bad_file_leaves_ways_on(page, files):
    drop(page, files / "walk.csv")
    curves(page)
    drop(page, files / "notes.txt")
    failed = page.get_by_test_id("failed")
    failed.wait_for()
    assert "notes.txt: no rows of numbers" in failed.inner_text()
    assert page.get_by_test_id("curve").is_hidden()
    assert page.get_by_test_id("choose-file").is_visible()
    assert page.get_by_test_id("file").all_inner_texts() == ["walk.csv"]
    page.get_by_test_id("failed-back").click()
    curves(page)
    assert failed.is_hidden()


def test_analyze_repeats_nothing(page, files):
    drop(page, files / "walk.csv")
    curves(page)
    page.wait_for_selector("[data-testid=analyze]:disabled")
    count = len(state(page)["jobs"])
    page.keyboard.press("a")
    page.get_by_test_id("term-Q").uncheck()
    page.wait_for_selector("[data-testid=analyze]:enabled")
    assert len(state(page)["jobs"]) == count
    page.get_by_test_id("analyze").click()
    finished(page, "--terms")
    page.wait_for_selector("[data-testid=analyze]:disabled")
    assert disabled(page, "over-all", "whole") == ["over-all", "whole"]
    page.get_by_test_id("export-channel").uncheck()
    assert disabled(page, "export", "datasheet") == ["export", "datasheet"]


def test_every_control_says_of_what(page, files):
    assert page.locator("#examples-title").inner_text() == "Simulated examples"
    drop(page, files / "walk.csv")
    curves(page)
    page.evaluate("document.querySelectorAll('details').forEach((one) => { one.open = true; })")
    labels = page.locator("aside label:not(.drop), #trace-section label").all_inner_texts()
    assert len(set(labels)) == len(labels) > 20


def test_the_first_run_says_that_it_prepares(browser, files, tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "kernels"))
    one = browser.new_page()
    one.set_default_timeout(2 * PATIENCE)
    with served(tmp_path) as (_, link):
        one.goto(link)
        one.wait_for_selector("body[data-ready=true]")
        drop(one, files / "walk.csv")
        one.get_by_text("Preparing, once after an installation").wait_for()
        curves(one)
    one.close()
