"""A walk over the whole page: six axes without units, curves, guides, residuals, export, comparison, no recording."""

import numpy as np
import pytest

from .browsing import SUITE, clear, curves, drop, finished

pytestmark = SUITE

VIEWS = [(1280, "en", "light"), (390, "ru", "dark"), (390, "zh", "light"), (1280, "zh", "dark")]


def clear_in(page, views):
    """No barrier and nothing wider than the screen, in each view."""
    for width, lang, theme in views:
        page.emulate_media(color_scheme=theme)
        page.set_viewport_size({"width": width, "height": 900})
        page.get_by_test_id("language").select_option(lang)
        page.wait_for_selector(f"html[lang={lang}]")
        page.wait_for_timeout(300)  # the charts and the sheets in the language
        clear(page, width)
    page.get_by_test_id("language").select_option("en")
    page.wait_for_selector("html[lang=en] body:not(.busy)")


def layout(page):
    return page.evaluate("(({yaxis, yaxis2, yaxis3}) => [yaxis, yaxis2, yaxis3].map((one) => one && "
                         "[one.title.text, one.range]))(document.querySelector('#curve-plot').layout)")  # fmt: skip


def test_the_whole_page_is_walked_without_an_error(page, tmp_path):
    rng, troubles = np.random.default_rng(3), []
    page.on("console", lambda told: troubles.append(told.text) if told.type in ("error", "warning") else None)
    values = rng.normal(size=(12_000, 6)) * [0.1, 0.1, 0.1, 1e-2, 1e-2, 1e-2] + [0, 0, 0, 0, 0, 9.8]
    rows = np.column_stack([np.arange(12_000) / 100.0, values])
    header = "time,gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z"
    np.savetxt(tmp_path / "plain.csv", rows, delimiter=",", header=header, comments="", fmt="%.6g")
    (tmp_path / "picture.png").write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(rng.integers(0, 256, 3000, np.uint8)))
    clear_in(page, VIEWS)
    drop(page, tmp_path / "plain.csv")
    page.wait_for_selector("#trace-plot[data-points]")
    clear_in(page, VIEWS)
    page.wait_for_selector("[data-testid=error-unit]:not([hidden])")  # asked once more
    menus = [page.get_by_test_id(f"unit-of-{sensor}") for sensor in ("gyro", "accel")]
    assert [menu.input_value() for menu in menus] == ["", "m/s^2"]  # gravity tells one, nothing the other
    assert page.get_by_test_id("unit-apply").is_disabled()
    menus[0].select_option("deg/s")
    page.get_by_test_id("unit-apply").click()
    finished(page, "--unit 'gyro=deg/s,accel=m/s^2'")
    assert page.locator("#terms label").count() == 5
    page.get_by_test_id("over-all").click()
    curves(page, 6)
    assert page.locator("#curve-plot .legendtext").all_text_contents() == [*header.split(",")[1:], "Model"]
    for symbol in "NB":
        page.get_by_test_id("guide-term").select_option(symbol)
        page.get_by_test_id("guide-add").click()
    page.get_by_test_id("residuals").check()
    page.wait_for_function("() => document.querySelector('#curve-plot').layout.yaxis3")
    (gyro, _), (accel, _), (_, span) = layout(page)
    assert (gyro, accel) == ("Overlapping Allan deviation (°/h)", "Overlapping Allan deviation (µg)")
    assert span == pytest.approx([-np.log10(3), np.log10(3)])
    assert "95 % interval: " in (told := page.evaluate("document.querySelector('#curve-plot').data[2].text[9]"))
    assert "Model: " in told
    page.get_by_test_id("target").select_option("kalibr")
    page.get_by_test_id("export-cover-typed").fill("1,10")
    page.get_by_test_id("export").click()
    page.get_by_test_id("export-fields").get_by_text("gyroscope_noise_density").first.wait_for()
    assert page.get_by_test_id("export-text").is_hidden()
    assert page.get_by_test_id("export-text-copy").is_visible()
    clear_in(page, VIEWS)
    drop(page, tmp_path / "picture.png")
    page.get_by_test_id("failed").wait_for()
    assert page.get_by_test_id("file").all_inner_texts() == ["plain.csv"]  # what cannot be read is not kept
    clear_in(page, VIEWS[:2])
    assert troubles == []


def test_columns_without_names_are_read_by_what_their_rows_say(page, tmp_path):
    rng, troubles = np.random.default_rng(4), []
    page.on("console", lambda told: troubles.append(told.text) if told.type in ("error", "warning") else None)
    stamps = 1_700_000_000_000_000_000 + 5_000_000 * np.arange(12_000)
    lines = ((time, *np.round(row, 6)) for time, row in zip(stamps, rng.normal(size=(12_000, 6)), strict=True))
    (tmp_path / "seven.csv").write_text("".join(",".join(map(str, line)) + "\n" for line in lines), "utf-8")
    drop(page, tmp_path / "seven.csv")
    page.get_by_test_id("columns").wait_for()
    uses = [page.get_by_test_id(f"use-of-{column}") for column in range(1, 8)]
    assert [use.input_value() for use in uses] == ["time|ns", *[""] * 6]  # no unit is invented
    assert "a clock of 200 Hz in ns" in page.get_by_test_id("column").first.inner_text()
    for column, unit in ((2, "deg/s"), (5, "g")):
        assert page.get_by_test_id("columns-apply").is_disabled()
        page.get_by_test_id(f"use-of-{column}").select_option(f"signal|{unit}")
    uses[3].select_option("out")
    clear_in(page, VIEWS)
    page.wait_for_selector("html[lang=en] body:not(.busy) [data-testid=error-rate]:not([hidden])")  # asked once more
    page.get_by_test_id("columns-apply").click()
    finished(page, "--unit 2=deg/s,3=deg/s,5=g,6=g,7=g --channels 2,3,5,6,7 --time '1[ns]'")
    assert page.get_by_test_id("option-rate").get_attribute("placeholder") == "200"
    assert page.get_by_test_id("columns").is_hidden()
    assert troubles == []


SAID = {
    "pass the unit of the samples, --unit UNIT, or write it": "pass the unit of the samples, “Unit”, or write it",
    "the parts (--from 100 --until 199.93)": "the parts (“Analyze from” = 100, “Analyze until” = 199.93)",
    "give --rate or --unit deg/s; see --details": "give “Rate” or “Unit” = deg/s; see --details",
    "--cover=no omits the cover": "“Cover” = no omits the cover",
    "--time 1 uses it as time, --channels as a signal": "“Time column” = 1 uses it as time, “Channels” as a signal",
    "its noise: --model 'N 1 ug/sqrt(Hz), K 2'": "its noise: “Noise of the other sensor” = N 1 ug/sqrt(Hz), K 2",
}


def test_sentences_name_controls_instead_of_options(page):
    spoken = "(all) => import('/naming.js').then(({ spoken }) => all.map(spoken))"
    assert page.evaluate(spoken, list(SAID)) == list(SAID.values())
