"""The page in a browser: what a user does, from the file that is dropped to the command line that repeats it."""

import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import allanite as al

api = pytest.importorskip("playwright.sync_api", reason="the stories of the page need playwright")
pytest.importorskip("fastapi", reason="the page needs allanite[web]")

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on this machine")

AXE = Path(__file__).with_name("axe.min.js")
PATIENCE = 40_000
"""Milliseconds that a step may take on a machine that is busy."""

HOSTILE = "<img src=x onerror=document.title='broken'>.csv"


class Server:
    """``allanite serve`` in a process of its own, with a cache folder of its own."""

    def __init__(self, cache: Path) -> None:
        self.cache = cache

    def start(self, *words: str) -> str:
        command = [sys.executable, "-m", "allanite.cli", "serve", "--no-browser", *words]
        env = {**os.environ, "XDG_CACHE_HOME": str(self.cache)}
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=env)
        assert self.process.stdout is not None
        for line in self.process.stdout:
            if found := re.search(r"http://127\.0\.0\.1:\d+/\?token=\S+", line):
                return found[0]
        raise AssertionError("the server ended before it printed its address")

    def kill(self) -> None:
        self.process.kill()
        self.process.communicate()


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The link that opens the page, once."""
    server = Server(tmp_path_factory.mktemp("cache"))
    yield server.start()
    server.kill()


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with api.sync_playwright() as play:
        one = play.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield one
        one.close()


@pytest.fixture(scope="module")
def context(browser: Any, address: str) -> Iterator[Any]:
    """A browser that has come in by the link; what it asks of other hosts is refused and noted."""
    one = browser.new_context(viewport={"width": 1280, "height": 900}, accept_downloads=True)
    one.set_default_timeout(PATIENCE)
    one.outside = []
    one.broken = []
    one.on("request", lambda request: outside(one, request.url))
    one.on("weberror", lambda error: one.broken.append(str(error.error)))
    first = one.new_page()
    first.goto(address)
    one.address = first.url.partition("#")[0]
    first.close()
    yield one
    one.close()


def outside(context: Any, url: str) -> None:
    if not url.startswith(("http://127.0.0.1:", "data:", "blob:")):
        context.outside.append(url)


@pytest.fixture
def page(context: Any) -> Iterator[Any]:
    """The page with nothing in it."""
    made = context.request.post(f"{context.address}api/workspaces", headers={"Origin": context.address.rstrip("/")})
    assert made.ok, made.text()
    one = context.new_page()
    one.add_init_script("localStorage.clear()")
    one.goto(f"{context.address}#{made.json()['id']}")
    one.wait_for_selector("body[data-ready=true]")
    yield one
    one.close()
    assert context.outside == []
    assert context.broken == []


@pytest.fixture(scope="module")
def six(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Six axes with units in the header."""
    values = np.random.default_rng(1).normal(size=(20_000, 6)) * [0.1, 0.1, 0.1, 1e-3, 1e-3, 1e-3]
    return written(tmp_path_factory.mktemp("data") / "six.csv", values)


def written(path: Path, values: Any) -> Path:
    names = ("gx [deg/s]", "gy [deg/s]", "gz [deg/s]", "ax [g]", "ay [g]", "az [g]")[: values.shape[1]]
    rows = np.column_stack([np.arange(len(values)) / 100.0, values])
    np.savetxt(path, rows, delimiter=",", header=",".join(("time [s]", *names)), comments="", fmt="%.7g")
    return path


@pytest.fixture(scope="module")
def bare(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One column without a unit or a rate."""
    path = tmp_path_factory.mktemp("data") / "bare.txt"
    np.savetxt(path, np.random.default_rng(2).normal(size=20_000), fmt="%.6g")
    return path


def drop(page: Any, path: Path) -> None:
    """Drop a file on the page, as a mouse does."""
    page.get_by_test_id("choose-file").set_input_files(str(path))


def curves(page: Any, count: int = 1) -> None:
    page.wait_for_selector(f"#curve-plot[data-curves='{count}']")


def finished(page: Any, text: str) -> None:
    """Wait until the command line shows this."""
    page.wait_for_function(
        "(text) => document.querySelector('[data-testid=command]')?.textContent.includes(text)", arg=text
    )


def state(page: Any) -> dict[str, Any]:
    ask = "fetch('/api/workspaces/' + location.hash.slice(1)).then((r) => r.json())"
    return page.evaluate(ask)


def saved(page: Any, form: str) -> str:
    with page.expect_download() as download:
        page.get_by_test_id(f"save-{form}").click()
    return Path(download.value.path()).read_text("utf-8")


def test_a_file_is_dropped_and_analyzed(page: Any, six: Path) -> None:
    drop(page, six)
    curves(page)
    assert page.get_by_test_id("tab").all_inner_texts() == ["gx", "gy", "gz", "ax", "ay", "az"]
    assert page.get_by_test_id("option-rate").get_attribute("placeholder") == "100"
    assert "100" in page.get_by_test_id("assumed").inner_text()
    assert int(page.get_by_test_id("trace").get_attribute("data-points")) > 200
    assert page.get_by_test_id("curve").get_attribute("data-validity") == "explained"


def test_a_channel_without_a_name_has_its_curve(page: Any, tmp_path: Path) -> None:
    record = al.simulate(al.N(0.1, "deg/sqrt(h)"), 5000, 100.0, rng=np.random.default_rng(1))
    assert record.name == ""
    al.write(record, tmp_path / "nameless.npz")
    drop(page, tmp_path / "nameless.npz")
    curves(page)


def test_a_first_curve_comes_before_the_fit(page: Any, tmp_path: Path) -> None:
    path = tmp_path / "long.npy"
    np.save(path, np.random.default_rng(6).normal(size=3_000_000))
    page.evaluate(
        """() => new MutationObserver((seen) => {
            const plot = document.querySelector("#curve-plot");
            const only = plot.dataset.early !== undefined && plot.dataset.curves === undefined;
            if (only) document.body.dataset.before = "yes";
        }).observe(document.querySelector("#curve-plot"), {attributes: true})"""
    )
    drop(page, path)
    page.get_by_test_id("error-rate").wait_for()
    page.get_by_test_id("option-rate").fill("1000")
    page.get_by_test_id("option-rate").press("Enter")
    page.get_by_test_id("unit-deg/s").click()
    curves(page)
    assert page.locator("body").get_attribute("data-before") == "yes"
    assert page.locator("#curve-plot").get_attribute("data-early") == "column 1"


def test_an_unknown_unit_is_asked_for_beside_its_control(page: Any, bare: Path) -> None:
    drop(page, bare)
    rate = page.get_by_test_id("error-rate")
    rate.wait_for()
    assert "the sampling rate is not in the file" in rate.inner_text()
    page.get_by_test_id("option-rate").fill("100")
    page.get_by_test_id("option-rate").press("Enter")
    page.wait_for_function("() => /the unit is unknown/.test(document.querySelector('#error-unit').textContent)")
    page.get_by_test_id("unit-deg/s").click()
    curves(page)
    assert "--unit deg/s" in page.get_by_test_id("command").inner_text()


def test_six_axes_are_overlaid_and_the_statistic_is_switched(page: Any, six: Path) -> None:
    drop(page, six)
    curves(page)
    page.get_by_test_id("over-all").click()
    curves(page, 6)
    page.get_by_test_id("statistic").select_option("hdev")
    page.wait_for_selector("#curve-plot[data-statistic=hdev]")
    page.keyboard.press("Escape")
    page.get_by_test_id("bands").uncheck()
    assert page.locator("#over input:checked").count() == 6


def test_a_term_is_toggled_and_fitted_again(page: Any, six: Path) -> None:
    drop(page, six)
    curves(page)
    before = page.get_by_test_id("sheet").inner_text()
    page.get_by_test_id("term-K").click()
    page.wait_for_selector("#curve-plot[data-refits='1']")
    assert page.get_by_test_id("term-K").is_checked()
    assert page.get_by_test_id("sheet").inner_text() != before
    page.get_by_test_id("undo").click()
    page.wait_for_function("() => !document.querySelector('[data-testid=term-K]').checked")


def test_a_guide_reads_a_coefficient(page: Any, six: Path) -> None:
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


def test_a_piece_is_cut_out_undone_and_redone(page: Any, six: Path) -> None:
    drop(page, six)
    curves(page)
    page.get_by_test_id("option-channels").fill("gx")
    page.get_by_test_id("option-channels").press("Enter")
    finished(page, "--channels gx")
    page.get_by_test_id("select-from").fill("150")
    page.get_by_test_id("select-until").fill("160")
    page.get_by_test_id("select-until").press("Tab")
    page.get_by_test_id("cut").click()
    finished(page, "--exclude 150..160")
    page.get_by_test_id("undo").click()
    page.wait_for_function("() => !document.querySelector('[data-testid=command]').textContent.includes('exclude')")
    page.get_by_test_id("redo").click()
    finished(page, "--exclude 150..160")


def test_a_disturbance_is_looked_at_and_cut_with_the_mouse(page: Any, tmp_path: Path) -> None:
    values = 0.1 * np.random.default_rng(8).normal(size=(20_000, 1))
    values[9000:10_000] += 0.5 * np.sin(np.arange(1000) / 7)[:, None]
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


def drag(page: Any, box: dict[str, float], start: float, end: float) -> None:
    """Draw over a part of a chart, from left to right."""
    middle = box["y"] + box["height"] / 2
    page.mouse.move(box["x"] + start * box["width"], middle)
    page.mouse.down()
    for part in (0.5, 1.0):
        page.mouse.move(box["x"] + (start + part * (end - start)) * box["width"], middle + part, steps=5)
    page.mouse.up()


def test_export_save_and_repeat_by_the_command_line(page: Any, six: Path, tmp_path: Path) -> None:
    drop(page, six)
    curves(page)
    page.get_by_test_id("target").select_option("kalibr")
    page.get_by_test_id("export").click()
    assert "gyroscope_noise_density" in page.get_by_test_id("export-text").inner_text()
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
    assert "<!DOCTYPE html>" in saved(page, "report")


def test_work_is_restored_after_a_reload(page: Any, six: Path) -> None:
    drop(page, six)
    curves(page)
    page.get_by_test_id("statistic").select_option("mdev")
    page.get_by_test_id("over").nth(1).check()
    curves(page, 2)
    page.wait_for_timeout(500)
    page.reload()
    curves(page, 2)
    page.wait_for_selector("#curve-plot[data-statistic=mdev]")
    assert page.get_by_test_id("file").inner_text() == "six.csv"


def test_two_records_are_compared(page: Any, tmp_path: Path) -> None:
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


def test_a_job_is_cancelled(page: Any, tmp_path: Path) -> None:
    path = tmp_path / "long.npy"
    np.save(path, np.random.default_rng(3).normal(size=(3_000_000,)))
    drop(page, path)
    page.get_by_test_id("error-rate").wait_for()
    page.get_by_test_id("option-rate").fill("1000")
    page.get_by_test_id("option-rate").press("Enter")
    page.get_by_test_id("unit-deg/s").click()
    page.get_by_test_id("cancel").click()
    page.wait_for_selector("#progress[hidden]", state="attached")
    assert state(page)["jobs"][-1]["state"] == "cancelled"


def test_hostile_names_stay_text(page: Any, bare: Path) -> None:
    path = bare.with_name(HOSTILE)
    header = "gx<script>document.title='broken'</script> [deg/s]"
    np.savetxt(path, np.random.default_rng(4).normal(size=5000), header=header, comments="", fmt="%.6g")
    drop(page, path)
    page.get_by_test_id("error-rate").wait_for()
    page.get_by_test_id("option-rate").fill("100")
    page.get_by_test_id("option-rate").press("Enter")
    curves(page)
    assert page.get_by_test_id("file").inner_text() == HOSTILE
    assert page.title() == "allanite"
    assert page.locator("main script, main img[src=x], aside img").count() == 0


def test_everything_often_done_has_a_key(page: Any, six: Path) -> None:
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


@pytest.mark.parametrize("width", [1280, 390])
@pytest.mark.parametrize("theme", ["light", "dark"])
def test_no_serious_barrier_and_nothing_wider_than_the_screen(page: Any, six: Path, width: int, theme: str) -> None:
    page.emulate_media(color_scheme=theme)
    page.set_viewport_size({"width": width, "height": 844})
    drop(page, six)
    curves(page)
    page.evaluate(AXE.read_text("utf-8"))
    found = page.evaluate("axe.run({resultTypes: ['violations']}).then((r) => r.violations)")
    grave = [
        (one["id"], [node["target"] for node in one["nodes"]])
        for one in found
        if one["impact"] in ("serious", "critical")
    ]
    assert grave == []
    assert page.evaluate("document.documentElement.scrollWidth") <= width


@pytest.mark.parametrize(("lang", "word"), [("ru", "Запись"), ("zh", "记录")])
def test_the_page_speaks(page: Any, six: Path, lang: str, word: str) -> None:
    drop(page, six)
    curves(page)
    page.get_by_test_id("language").select_option(lang)
    page.wait_for_function("(word) => document.querySelector('#trace-title').textContent === word", arg=word)
    page.wait_for_function("() => /[^\\x00-\\x7f]{2}/.test(document.querySelector('#sheet').textContent)")
    assert page.locator("html").get_attribute("lang") == lang


def test_a_server_that_was_killed_comes_back_with_the_work(browser: Any, six: Path, tmp_path: Path) -> None:
    server = Server(tmp_path)
    one = browser.new_page()
    one.set_default_timeout(PATIENCE)
    try:
        address = server.start()
        one.goto(address)
        one.wait_for_selector("body[data-ready=true]")
        drop(one, six)
        curves(one)
        one.get_by_test_id("statistic").select_option("mdev")
        one.wait_for_selector("#curve-plot[data-statistic=mdev]")
        one.wait_for_timeout(500)
        workspace = one.url.partition("#")[2]
        server.kill()
        one.goto(server.start())
        one.wait_for_selector("body[data-ready=true]")
        one.goto(f"{one.url.partition('#')[0]}#{workspace}")
        one.wait_for_selector("#curve-plot[data-statistic=mdev]")
        assert one.get_by_test_id("file").inner_text() == "six.csv"
    finally:
        server.kill()
        one.close()
