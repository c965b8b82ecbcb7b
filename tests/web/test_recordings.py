"""Real recordings dropped on the page: what they do not say is asked for beside its control, then they have a curve."""

import pytest
from tests.recordings.test_every_recording import FILES

from .browsing import SUITE, drop

pytestmark = SUITE

NEEDS = {file.name: file.options for file in FILES if file.compared or file.name.endswith("temperature.mat")}
NEEDS |= {name: {"unit": "deg/s"} for name in NEEDS if name.startswith("adis")}
"""What each file needs beside itself."""

REFUSED = {
    "format_only_vn100_moving.mcap": "the body moved",
    "format_only_vn100_moving_0.db3": "IMUmsg is missing",
    "avar_curves_smac/adis_av.rda": "the unit is unknown",
    "avar_curve_cpt7/imu.yaml": "columns instead of",
    "INDEX.md": "is not a number",
}
"""What is no recording, or lacks what no option gives, and the words for it."""

SAID = """() => {
    const shown = [...document.querySelectorAll('[data-testid^=error-], [data-testid=problem], #failed-words')];
    return shown.map((one) => one.checkVisibility() ? one.textContent.trim() : '').filter(Boolean).join(' / ');
}"""
OPENED = "() => document.querySelectorAll('details:has(input)').forEach((one) => { one.open = true; })"
READY = f"() => document.querySelector('#curve-plot[data-curves]') !== null || ({SAID})() !== ''"


@pytest.mark.parametrize("name", NEEDS)
def test_a_recording_has_a_curve_once_it_says_what_it_is(page, recordings, name):
    drop(page, recordings / name)
    page.wait_for_function(READY)
    page.evaluate(OPENED)
    for option, value in NEEDS[name].items():
        control = page.get_by_test_id(f"option-{option}")
        control.fill(",".join(value) if option == "channels" else str(value))
        control.press("Enter")
    page.wait_for_selector("#curve-plot[data-curves]")
    assert page.get_by_test_id("assumed").inner_text().strip()
    assert page.get_by_test_id("curve").get_attribute("data-validity") in ("explained", "approximate", "unexplained")


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_no_recording_is_refused_in_the_words_of_the_command_line(page, recordings, name):
    drop(page, recordings / name)
    page.wait_for_function(READY)
    assert REFUSED[name] in page.evaluate(SAID)
    assert page.locator("#curve-plot[data-curves]").count() == 0
