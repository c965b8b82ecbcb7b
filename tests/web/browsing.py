"""The page in a browser, as a user holds it."""

import shutil
from pathlib import Path

import numpy as np
import pytest

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
SUITE = pytest.mark.nightly("the page in a browser")
"""Mark of every module that drives the browser, but those of one story and of who may come in."""

AXE = Path(__file__).with_name("axe.min.js")

PATIENCE = 120_000
"""Milliseconds that a step may take on a machine that is busy."""


def written(path, values):
    names = ("gx [deg/s]", "gy [deg/s]", "gz [deg/s]", "ax [g]", "ay [g]", "az [g]")[: values.shape[1]]
    rows = np.column_stack([np.arange(len(values)) / 100.0, values])
    np.savetxt(path, rows, delimiter=",", header=",".join(("time [s]", *names)), comments="", fmt="%.7g")
    return path


def drop(page, path):
    """Drop a file on the page, as a mouse does."""
    page.get_by_test_id("choose-file").set_input_files(str(path))


def curves(page, count=1):
    page.wait_for_selector(f"#curve-plot[data-curves='{count}']")


def finished(page, text):
    """Wait until the command line shows this."""
    page.wait_for_function(
        "(text) => document.querySelector('[data-testid=command]')?.textContent.includes(text)", arg=text
    )


def state(page):
    return page.evaluate("import('/api.js').then((api) => api.workspace(location.hash.slice(1)))")


def kept(page):
    """Wait until the choices are kept by the server."""
    page.wait_for_selector("body[data-kept=yes]")


def saved(page, form):
    with page.expect_download() as download:
        page.get_by_test_id(f"save-{form}").click()
    return Path(download.value.path()).read_text("utf-8")


def clear(page, width):
    """No barrier for anyone, and nothing wider than the screen."""
    page.evaluate(AXE.read_text("utf-8"))
    violations = page.evaluate("axe.run({resultTypes: ['violations']}).then((r) => r.violations)")
    assert [(one["id"], [node["target"] for node in one["nodes"]]) for one in violations] == []
    assert page.evaluate("document.documentElement.scrollWidth") <= width


def drag(page, box, start, end):
    """Draw over a part of a chart, from left to right."""
    middle = box["y"] + box["height"] / 2
    page.mouse.move(box["x"] + start * box["width"], middle)
    page.mouse.down()
    for part in (0.5, 1.0):
        page.mouse.move(box["x"] + (start + part * (end - start)) * box["width"], middle + part, steps=5)
    page.mouse.up()
