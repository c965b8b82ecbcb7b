"""A stream that is watched on the page: its curve grows, a jump is said, and what was found remains at the end."""

import re

import numpy as np

from .browsing import SUITE

pytestmark = SUITE

JUMP = re.compile("the bias (jumps|steps)", re.IGNORECASE)

RATE = 100  # samples a second of record


def test_a_stream_has_a_curve_a_jump_is_said_and_the_result_stays(page, tmp_path):
    path, rng = tmp_path / "growing.csv", np.random.default_rng(1)

    def grow(seconds, mean):
        """Add so much of a gyroscope with this mean."""
        with path.open("a", encoding="utf-8") as file:
            np.savetxt(file, mean + 10 * rng.standard_normal(seconds * RATE), fmt="%.6f")

    path.write_text("gx [deg/h]\n", encoding="utf-8")
    grow(120, 0.0)
    page.get_by_test_id("live").click()
    for name, text in (("source", str(path)), ("rate", str(RATE)), ("unit", "deg/h")):
        page.get_by_test_id(f"live-{name}").fill(text)
    page.get_by_test_id("live-start").click()
    page.wait_for_selector("[data-testid=live-plot] .scatterlayer .trace")
    page.reload()
    page.wait_for_selector("[data-testid=live-plot] .scatterlayer .trace")  # it goes on where nobody looked
    grow(30, 60.0)
    page.get_by_text(JUMP).first.wait_for()
    grow(60, 60.0)  # a step that few samples follow is a random walk to the model
    page.get_by_test_id("live-stop").click()
    results = page.get_by_test_id("live-results")
    results.get_by_text("angle random walk").first.wait_for()
    assert page.get_by_test_id("live-start").is_enabled()
    page.reload()
    page.wait_for_function("() => /angle random walk/.test(document.querySelector('#live-results').textContent)")
    assert JUMP.search(results.text_content() or "")
