"""Names of recordings and channels that are markup, scripts, links or too long: clicks through page and reports."""

import re

import numpy as np
import pytest

import allanite as al

from .browsing import SUITE, curves

pytestmark = SUITE

HIT = "window.hit=(window.hit||0)+1;document.title='broken';alert(1)"
NAMES = [
    f'<img src=x onerror="{HIT}">',
    f'"><script>{HIT}</script>',
    f"' onmouseover='{HIT}' onfocus='{HIT}' autofocus='",
    f'<a href="javascript:{HIT}">click</a>',
    '<a href="https://evil.example/">%{x}</a>',
    "\u202egnp.cilam \u2066gx",
    "two\nlines",
    "x" * 5000,
]
FILE = f'"><img src=x onerror={HIT}>\u202e.npz'

FOUND = """() => ({
    hit: window.hit ?? 0, title: document.title, dead: document.querySelectorAll('img[src="x"], main script').length,
    links: [...document.querySelectorAll('a')].map((a) => a.getAttribute('href') ?? a.getAttribute('xlink:href') ?? '')
        .filter((to) => !to.startsWith('data:application/gzip;base64,') && /evil|javascript/i.test(to)),
    handlers: [...document.querySelectorAll('*')]
        .filter((one) => [...one.attributes].some((a) => a.name.startsWith('on'))).length,
    wide: document.documentElement.scrollWidth - innerWidth})"""
SOUND = {"hit": 0, "dead": 0, "links": [], "handlers": 0}


@pytest.fixture(scope="module")
def study():
    rng = np.random.default_rng(1)
    return al.analyze(
        al.Recording(tuple(al.Record(rng.normal(size=3000), 100.0, "deg/s", name=name) for name in NAMES))
    )


def sound(page, title="allanite"):
    found = page.evaluate(FOUND)
    assert {key: found[key] for key in SOUND} == SOUND
    assert found["title"] == title
    assert found["wide"] <= 0


BUTTONS = (
    "button:visible:enabled:not([data-testid^=file]):not([data-testid^=save]):not(.copy):not([data-testid=cancel])"
)
# in one step, so that the answer to an earlier click cannot take the button away between the look and the click
CLICK = """(name) => {
    const button = document.querySelector(`button[data-testid="${name}"]`);
    if (button && button.checkVisibility() && !button.disabled) button.click();
}"""


@pytest.mark.parametrize("width", [1280, 390])
def test_names_are_text_wherever_they_are_clicked(page, study, tmp_path, width):
    stored, dialogs = tmp_path / "r.npz", []
    al.write(al.Recording(tuple(channel.record for channel in study)), stored)
    page.on("dialog", lambda dialog: (dialogs.append(dialog.message), dialog.dismiss()))
    page.set_viewport_size({"width": width, "height": 900})
    page.get_by_test_id("choose-file").set_input_files(
        {"name": FILE, "mimeType": "application/octet-stream", "buffer": stored.read_bytes()}
    )
    curves(page)
    assert page.get_by_test_id("file").inner_text().startswith('"><img src=x onerror=window.hit')
    shown = page.get_by_test_id("tab").all_text_contents()
    assert shown[0] == NAMES[0]
    sound(page)
    page.get_by_test_id("over-all").click()
    curves(page, len(NAMES))
    sound(page)
    for i in range(len(NAMES)):
        page.get_by_test_id("tab").nth(i).click()
        page.get_by_test_id("curve").hover()
        sound(page)
    for target in page.get_by_test_id("target").locator("option").evaluate_all("(all) => all.map((one) => one.value)"):
        page.get_by_test_id("target").select_option(target)
        page.get_by_test_id("export").click()
        page.wait_for_selector("#exported[aria-busy=false]")
    for summary in page.locator("summary").all():
        if summary.is_visible():  # one within another that was open is closed with it
            summary.click()
    for name in page.locator(BUTTONS).evaluate_all("(all) => [...new Set(all.map((one) => one.dataset.testid))]"):
        page.wait_for_selector("body:not(.busy)")
        page.evaluate(CLICK, name)
        sound(page)
        page.keyboard.press("Escape")  # a dialog
    assert dialogs == []


@pytest.mark.parametrize("how", ["report", "notebook"])
def test_names_are_text_in_a_report_and_a_notebook(browser, study, tmp_path, how):
    path, dialogs = tmp_path / "r.html", []
    if how == "report":
        al.report(study, path)
    else:  # what a notebook does with it
        path.write_text(f"<!DOCTYPE html><meta charset=utf-8><title>t</title>{study._repr_html_()}", "utf-8")
    page = browser.new_page(viewport={"width": 1280, "height": 900})
    page.on("dialog", lambda dialog: (dialogs.append(dialog.message), dialog.dismiss()))
    page.goto(path.as_uri())
    for summary in page.locator("summary:visible").all():
        summary.click()
    found = page.evaluate(FOUND)
    assert {key: found[key] for key in SOUND} == SOUND
    assert found["title"] != "broken"
    assert NAMES[0] in page.locator("body").text_content()
    assert dialogs == []
    page.close()


def test_a_pdf_of_these_names_has_no_script_and_no_action(study, tmp_path):
    al.report(study, tmp_path / "r.pdf")
    data = (tmp_path / "r.pdf").read_bytes()
    assert data.startswith(b"%PDF")
    assert not re.findall(rb"/(JS|JavaScript|OpenAction|AA|Launch|URI|SubmitForm|EmbeddedFile|RichMedia)\b", data)
