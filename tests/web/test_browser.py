"""The page in a browser: what a user does, from the file that is dropped to the command line that repeats it."""

import json
import subprocess
import sys

import numpy as np
import pytest

import allanite as al

from .browsing import SUITE, curves, drag, drop, finished, kept, saved, state, written
from .served import waiting_file

pytestmark = SUITE


def test_a_channel_without_a_name_has_its_curve(page, tmp_path):
    record = al.simulate(al.N(0.1, "deg/sqrt(h)"), 5000, 100.0, rng=np.random.default_rng(1))
    assert record.name == ""
    al.write(record, tmp_path / "nameless.npz")
    drop(page, tmp_path / "nameless.npz")
    curves(page)


def test_numbers_are_drawn_before_their_rate_is_known_and_a_curve_before_the_fit(page, tmp_path):
    path = tmp_path / "plain.npy"
    np.save(path, np.random.default_rng(6).normal(size=30_000))
    drop(page, path)
    page.get_by_test_id("error-rate").wait_for()
    page.wait_for_selector("#trace-plot[data-points]")
    assert page.get_by_test_id("raw").inner_text().endswith("Not known yet: Rate, Unit")
    assert page.evaluate("document.querySelector('#trace-plot').layout.xaxis.title.text") == "Sample"
    page.get_by_test_id("option-rate").fill("1000")
    page.get_by_test_id("option-rate").press("Enter")
    page.get_by_test_id("unit-deg/s").click()
    curves(page)
    assert page.locator("#curve-plot").get_attribute("data-early") == "column 1"


def test_a_guide_reads_a_coefficient(page, six):
    drop(page, six)
    curves(page)
    page.get_by_test_id("guide-term").select_option("N")
    page.get_by_test_id("guide-add").click()
    found = float(page.get_by_test_id("guide-value").input_value())
    assert found == pytest.approx(0.1 / np.sqrt(100) * 60, rel=0.3)  # deg/sqrt(h), touching the curve from below
    line = page.locator("#curve-plot .shapelayer path").first
    line.scroll_into_view_if_needed()
    box = line.bounding_box()
    x, y = box["x"] + box["width"] / 3, box["y"] + box["height"] / 3
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x, y - 20, steps=4)
    page.mouse.move(x, y - 40, steps=4)
    page.mouse.up()
    page.wait_for_function(
        "(old) => Number(document.querySelector('[data-testid=guide-value]').value) > old", arg=found
    )


def test_a_disturbance_is_looked_at_and_cut_with_the_mouse(page, tmp_path):
    values = 0.1 * np.random.default_rng(8).normal(size=(20_000, 1))
    values[9000:10_000] *= 6.0
    drop(page, written(tmp_path / "bumped.csv", values))
    curves(page)
    assert page.get_by_test_id("curve").get_attribute("data-validity") == "unexplained"
    plot = page.locator("#trace-plot .draglayer .nsewdrag").first
    plot.scroll_into_view_if_needed()
    box = plot.bounding_box()
    drag(page, box, 0.4, 0.6)
    page.wait_for_function("() => Math.abs(document.querySelector('#trace-plot').layout.xaxis.range[0] - 80) < 3")
    page.get_by_test_id("mode-select").click()
    drag(page, box, 0.2, 0.55)  # of the 40 s that are seen
    page.wait_for_function("() => Math.abs(document.querySelector('[data-testid=select-from]').value - 88) < 2")
    page.get_by_test_id("cut").click()
    finished(page, "--exclude")
    page.wait_for_selector("#curve-plot[data-validity=explained]")
    # undone, done with numbers, undone and redone
    gone = "() => !document.querySelector('[data-testid=command]').textContent.includes('exclude')"
    page.get_by_test_id("undo").click()
    page.wait_for_function(gone)
    page.get_by_test_id("select-from").fill("90")
    page.get_by_test_id("select-until").fill("99")
    page.get_by_test_id("select-until").press("Tab")
    page.get_by_test_id("cut").click()
    finished(page, "--exclude 90..99")
    page.get_by_test_id("undo").click()
    page.wait_for_function(gone)
    page.get_by_test_id("redo").click()
    finished(page, "--exclude 90..99")


def test_export_save_and_repeat_by_the_command_line(page, six, tmp_path):
    drop(page, six)
    curves(page)
    page.get_by_test_id("target").select_option("kalibr")
    page.get_by_test_id("export").click()
    assert "gyroscope_noise_density" in page.get_by_test_id("export-text").text_content()
    page.get_by_test_id("datasheet").click()
    page.wait_for_function(
        "() => !document.querySelector('[data-testid=export-text]').textContent.includes('gyroscope_noise_density')"
    )
    found = json.loads(saved(page, "json"))
    line = page.get_by_test_id("command").inner_text().split()
    assert line[0] == "allanite"
    command = [sys.executable, "-m", "allanite.cli", *line[1:-1], str(six), "--json", "-", "--quiet"]
    again = json.loads(subprocess.run(command, capture_output=True, check=True).stdout)
    assert found["channels"] == again["channels"]
    assert found["recipe"] == again["recipe"]


def test_work_is_restored_after_a_reload(page, six):
    drop(page, six)
    curves(page)
    page.get_by_test_id("statistic").select_option("mdev")
    page.get_by_test_id("over").nth(1).check()
    curves(page, 2)
    kept(page)
    page.reload()
    curves(page, 2)
    page.wait_for_selector("#curve-plot[data-statistic=mdev]")
    assert page.get_by_test_id("file").inner_text() == "six.csv"


def test_two_records_are_compared(page, tmp_path):
    one, other = (
        written(tmp_path / name, 0.1 * np.random.default_rng(seed).normal(size=(20_000, 1)))
        for name, seed in (("before.csv", 5), ("later.csv", 6))
    )
    drop(page, one)
    curves(page)
    drop(page, other)
    page.wait_for_selector("[aria-current=true] >> text=later.csv")
    finished(page, "later.csv")
    page.get_by_test_id("compare").click()
    page.get_by_test_id("compared").first.wait_for()


def test_a_job_is_cancelled(page, tmp_path):
    pipe, path = waiting_file(tmp_path)
    page.get_by_test_id("open-path").fill(str(path))
    page.get_by_test_id("open").click()
    with open(pipe, "wb"):  # once the job has begun to read
        page.get_by_test_id("cancel").click()
        page.wait_for_selector("#progress[hidden]", state="attached")
        assert state(page)["jobs"][-1]["state"] == "cancelled"


def test_a_stream_of_reports_that_breaks_off_is_taken_up_again(page, six):
    broken = []

    def once(route):
        route.continue_() if broken else (broken.append(route.request.url), route.abort())

    page.route("**/events", once)
    drop(page, six)
    page.get_by_text("Waiting for the server").wait_for()
    curves(page)
    assert len(broken) == 1


def test_who_has_no_secret_is_told_where_the_link_is(browser, context):
    stranger = browser.new_page()
    for place in ("", "#token=used"):
        stranger.goto(f"{context.address}{place}")
        stranger.reload()
        stranger.wait_for_selector("body[data-ready=false]")
        assert "allanite serve" in stranger.get_by_test_id("problem").inner_text()
        assert stranger.get_by_test_id("choose-file").is_hidden()
    stranger.close()


def test_everything_often_done_has_a_key(page, six):
    page.keyboard.press("?")
    assert page.get_by_test_id("keys").is_visible()
    page.keyboard.press("Escape")
    drop(page, six)
    curves(page)
    page.keyboard.press("y")
    curves(page, 6)
    page.keyboard.press("s")
    page.wait_for_selector("#curve-plot:not([data-statistic=oadev])")
    page.keyboard.press("d")
    assert page.locator("html").get_attribute("data-theme") == "dark"


@pytest.mark.parametrize(("lang", "word"), [("ru", "Запись"), ("zh", "记录")])
def test_the_page_speaks(page, six, lang, word):
    drop(page, six)
    curves(page)
    page.get_by_test_id("language").select_option(lang)
    page.wait_for_function("(word) => document.querySelector('#trace-title').textContent === word", arg=word)
    page.wait_for_function("() => /[^\\x00-\\x7f]{2}/.test(document.querySelector('#sheet').textContent)")
    assert page.locator("html").get_attribute("lang") == lang
