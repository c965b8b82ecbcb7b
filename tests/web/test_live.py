"""A stream that is watched on the page: its curve grows, a jump is said, and what was found remains at the end."""

import re
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from .browsing import SUITE

pytestmark = SUITE

JUMP = re.compile("the bias (jumps|steps)")

RATE, EACH, PAUSE = 100, 200, 0.1
"""Samples a second of record, samples in a piece, and seconds between pieces: time runs 20 times as fast."""


class Sensor(threading.Thread):
    """A gyroscope whose file grows, and whose mean jumps when it is told so."""

    def __init__(self, path: Path) -> None:
        super().__init__(daemon=True)
        self.path, self.ended, self.offset, self.written = path, threading.Event(), 0.0, 0
        path.write_text("gx [deg/h]\n", encoding="utf-8")

    def run(self) -> None:
        """Write pieces until the end."""
        rng = np.random.default_rng(1)
        with self.path.open("a", encoding="utf-8") as file:
            while not self.ended.wait(PAUSE):
                values = self.offset + 10 * rng.standard_normal(EACH)
                file.write("".join(f"{value:.6f}\n" for value in values.tolist()))
                file.flush()
                self.written += EACH


@pytest.fixture
def sensor(tmp_path: Path) -> Iterator[Sensor]:
    growing = Sensor(tmp_path / "growing.csv")
    growing.start()
    yield growing
    growing.ended.set()
    growing.join()


def test_a_stream_has_a_curve_a_jump_is_said_and_the_result_stays(page: Any, sensor: Sensor) -> None:
    page.get_by_test_id("live").click()
    for name, text in (("source", str(sensor.path)), ("rate", str(RATE)), ("unit", "deg/h")):
        page.get_by_test_id(f"live-{name}").fill(text)
    page.get_by_test_id("live-start").click()
    page.wait_for_selector("[data-testid=live-plot] .scatterlayer .trace")
    sensor.offset = 60.0
    page.get_by_text(JUMP).first.wait_for()
    enough = sensor.written + 60 * RATE  # a step that few samples follow is a random walk to the model
    while sensor.written < enough:
        page.wait_for_timeout(100)
    page.get_by_test_id("live-stop").click()
    results = page.get_by_test_id("live-results")
    results.get_by_text("angle random walk").first.wait_for()
    assert JUMP.search(results.text_content() or "")
    assert page.get_by_test_id("live-start").is_enabled()
