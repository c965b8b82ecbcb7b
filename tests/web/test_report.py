"""The report of six channels in a browser: how long it is, whether it fits, and whether it can be read by all."""

import warnings

import pytest
from tests.rows import paired

import allanite as al
from allanite.reporting.fonts import FontWarning

from .browsing import SUITE, clear

pytestmark = SUITE

HIGH = 800  # pixels of a screen


@pytest.fixture(scope="module")
def reports(six, tmp_path_factory):
    """By language."""
    study, folder = al.analyze(six), tmp_path_factory.mktemp("report")
    paths = {lang: folder / f"{lang}.html" for lang in ("en", "ru", "zh")}
    for lang, path in paths.items():
        with warnings.catch_warnings():  # the widths of letters are guessed where this machine has no font for them
            warnings.simplefilter("ignore", FontWarning)
            al.report(study, path, lang=lang)
    return paths


@pytest.fixture
def opened(browser, reports):
    """Opens the report in a language, on a screen of so many pixels, light or dark."""
    pages = []

    def open_one(lang, width, theme="light"):
        page = browser.new_page(viewport={"width": width, "height": HIGH}, color_scheme=theme)
        pages.append(page)
        page.goto(reports[lang].as_uri())
        return page

    yield open_one
    for page in pages:
        page.close()


@pytest.mark.parametrize(("lang", "width", "theme"), paired(("en", "ru", "zh", "en"), (1280, 390), ("light", "dark")))
def test_no_barrier_and_nothing_beyond_the_screen(opened, lang, width, theme):
    page = opened(lang, width, theme)
    page.evaluate("document.querySelectorAll('details').forEach((part) => { part.open = true })")
    figures = page.evaluate("[...document.querySelectorAll('figure svg')].map((f) => f.getBoundingClientRect().width)")
    shown = [wide for wide in figures if wide]
    assert 2 * len(shown) == len(figures)  # one of two forms of each
    assert max(shown) <= width
    clear(page, width)


@pytest.mark.parametrize("lang", ["en", "ru", "zh"])
def test_tables_and_figure_share_the_first_screen_and_a_channel_has_two(opened, lang):
    boxes = "[...document.querySelectorAll('.channels > .scroll')]"
    page = opened(lang, 1280)
    heights = page.evaluate(
        "[...document.querySelectorAll('#summary, .channel')].map((part) => part.getBoundingClientRect().height)"
    )
    assert len(heights) == 7
    assert max(heights) <= 2 * HIGH, heights
    top, bottom = page.evaluate(
        "['top', 'bottom'].map((side) => document.querySelector('#summary figure').getBoundingClientRect()[side])"
    )
    assert page.evaluate(f"{boxes}.map((box) => box.scrollWidth - box.clientWidth)") == [0, 0]
    assert (top <= 430, bottom <= HIGH + 40) == (True, True), (top, bottom)
    # on a phone they are scrolled, and their first column stays
    page = opened(lang, 390)
    page.evaluate(f"{boxes}.forEach((box) => {{ box.scrollLeft = 60 }})")
    first = f"{boxes}.map((box) => box.querySelector('tbody th').getBoundingClientRect().left)"
    assert page.evaluate(first) == page.evaluate(f"{boxes}.map((box) => box.getBoundingClientRect().left)")


def test_a_button_copies_the_file_of_a_filter_or_selects_it(opened):
    page = opened("en", 1280)
    button = page.locator("#summary button.copy")
    button.click()
    page.wait_for_function("() => document.querySelector('#summary button.copy').textContent === 'Copied'")
    page.evaluate("() => Object.defineProperty(navigator, 'clipboard', { value: undefined })")
    button.click()
    assert "gyroscope_noise_density: " in page.evaluate("getSelection().toString()")
    page.emulate_media(media="print")
    assert not button.is_visible()


def test_letters_of_figures_can_be_read_on_a_phone(opened):
    page = opened("en", 390)
    sizes = page.evaluate(
        """[...document.querySelectorAll('.channel > figure .narrow svg')].map((f) =>
             f.getBoundingClientRect().width / f.viewBox.baseVal.width *
             Math.min(...[...f.querySelectorAll('text')].map((t) => parseFloat(getComputedStyle(t).fontSize))))"""
    )
    assert min(sizes) > 10
