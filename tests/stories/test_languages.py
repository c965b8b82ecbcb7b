"""Nothing that is shown stays English: every result in letters that are not Latin, and the words left over."""

import math
import re
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace
from html.parser import HTMLParser
from xml.etree import ElementTree

import pytest
from matplotlib.text import Text
from tests.rows import rows
from tests.verbs import ROWS, run

import allanite as al
from allanite.applications.attitude import FILTERS
from allanite.applications.constant_rate import RATE_ESTIMATORS
from allanite.cli import deliver
from allanite.core.errors import UndrawnError
from allanite.exporting.exports import EXPORTS, TEMPERATURE
from allanite.identification.methods import METHODS
from allanite.phrases.phrase import Phrase
from allanite.readers import live
from allanite.reporting import html, language, printing, text
from allanite.reporting.sheet import Code, Fold
from allanite.reporting.sketch.axis import Unsketched
from allanite.reporting.views import level_of, view_of
from allanite.statistics import STATISTICS
from allanite.study import watching
from allanite.terms import TERMS

pytestmark = pytest.mark.nightly("what every verb shows, in other letters: releases ask for translations")

LETTERS = {ord(latin): ord("а") + i for i, latin in enumerate("abcdefghijklmnopqrstuvwxyz")}
LETTERS |= {ord(chr(latin).upper()): ord(chr(other).upper()) for latin, other in LETTERS.items()}
FIELD = re.compile(r"(\{\{|\}\}|\{[^{}]*\})")


class Pseudo:
    """A catalogue that has every template, in letters that are not Latin."""

    def gettext(self, message):
        parts = FIELD.split(message)
        parts[::2] = [part.translate(LETTERS) for part in parts[::2]]
        return "".join(parts)

    def ngettext(self, one, many, count):
        return self.gettext(one if count == 1 else many)


DATA = [
    r"(?<![\w-])--[a-z][\w-]*(=\S+)?",  # options
    r"\ballanite \w+ .*?(?=[;:)]|\s\s|$)",  # commands
    r"\ballanite\b|\bsha256\b|\b[0-9a-f]{12,}\b|\.dev\w+",  # the program, digests
    r"(?<!\w)/\S+|\b[\w-]+\.(csv|toml|json|html|npz|py)\b",  # files
    r"\b(al|prepare|planning)\.\w+(\.\w+)*(\([^)]*\))?",  # calls
    r"\b(ISO|IEEE|IEC|NIST|RFC|PDF|CSV|JSON|TOML|DCT-II|Std|SP) ?[\d-]*",  # standards and formats
    r"'time \[s\]'",  # a column
    rf"^({'|'.join(FILTERS)})$",  # the name of a filter in a cell
    r"imu = \S.*|config = \S.*",  # notes that are code
    *(re.escape(row.reference) for row in FILTERS.values() if not isinstance(row.reference, Phrase)),
]
"""What is no word of a sentence."""

FIELDS = {field.full for row in EXPORTS.values() for field in row.fields}
FIELDS |= {part for name in FIELDS for part in (name.split(".")[-1], f"{name.split('.')[0]}.")}
KNOWN = sorted(FIELDS | {*EXPORTS, *STATISTICS} | {row.name for row in TEMPERATURE.values()}, key=len, reverse=True)
DATA.append(rf"(?<![\w.])({'|'.join(map(re.escape, KNOWN))})(?!\w)")

QUOTED = {text for sheet in al.planning.DATASHEETS.values() for text in (sheet.name, sheet.maker, sheet.document)}
QUOTED |= {text for c in al.planning.DATASHEETS["ADIS16470"].claims for text in (c.printed, c.conditions, c.place)}
DATA += sorted((rf"(?<!\w){re.escape(text)}(?!\w)" for text in QUOTED), key=len, reverse=True)

UNITS = "deg rad arcsec sqrt Hz kHz min mGal ug mg ms degC ppm rms LSB bit nT mV uV mA uA Nm kg"
SYMBOLS = "beta GM ARW VRW RRW tau edf dof chi AIC ADC DAC Phi Qd"
NAMES = "adis gx gy gz ay ux temp enc ref h_polar q_polar offset ax az fog mems hann python operator arXiv Shupe Zhuo"
CODES = {"ru", "zh", "en"}


def allowed():
    """Words of Latin letters that are names, units or symbols."""
    known = {*UNITS.split(), *SYMBOLS.split(), *NAMES.split(), *CODES, *TERMS, *STATISTICS, *METHODS, *RATE_ESTIMATORS}
    known |= {"bortz", "madgwick", "mahony"}
    return known | {p.letter or p.name for row in TERMS.values() for p in row.parameters}


def left(shown: Iterable[str]) -> list[str]:
    """Lines with words that are still English, each with these words before it."""
    known, found = allowed(), {}
    for line in shown:
        rest = re.sub("|".join(DATA), " ", line)
        words = [word for word in re.findall(r"[A-Za-z]{2,}", rest) if word not in known]
        if words:
            found.setdefault(" ".join(dict.fromkeys(words)), " ".join(line.split())[:160])
    return [f"{words}   <- {line}" for words, line in found.items()]


class Shown(HTMLParser):
    """What a reader of a page sees or hears, without code, scripts and styles."""

    def __init__(self, page):
        super().__init__()
        self.texts, self.inside = [], []
        self.feed(re.sub(r'<span class="option">(.*?)</span>', r"\1", page))  # parts of a sentence

    def handle_starttag(self, tag, attrs):
        if tag in ("style", "script", "pre", "code", "math"):
            self.inside.append(tag)
        self.texts += [value or "" for name, value in attrs if name in ("aria-label", "title", "alt", "data-label")]

    def handle_endtag(self, tag):
        if self.inside and self.inside[-1] == tag:
            self.inside.pop()

    def handle_data(self, data):
        if not self.inside:
            self.texts.append(data)


def without_code(parts):
    """The same parts with nothing that is to be copied into a program."""
    kept = [replace(part, parts=without_code(part.parts)) if isinstance(part, Fold) else part for part in parts]
    return [replace(part, text="") if isinstance(part, Code) else part for part in kept]


def words_of(figure):
    return [artist.get_text() for artist in figure.findobj(Text)]


def shown(value, monkeypatch, drawn, lang="xx"):
    """Everything that terminal, page and figures show of a value; `drawn`: it has a figure for print."""
    level, found = level_of(value), []
    with language.speaking(lang):
        face = view_of(value).face(value, level)
        sheets = [replace(sheet, parts=without_code(sheet.parts)) for sheet in face.sheets]
        parts = {name: without_code(getattr(face, name)) for name in ("parts", "close", "how")}
        face = replace(face, sheets=sheets, choices="", **parts)
        found += text.render(face).splitlines()
        drawn_words = lambda drawing: found.extend(words_of(printing.printed(drawing.draw()))) or ""  # noqa: E731
        monkeypatch.setattr(html, "drawer", lambda *_: drawn_words)
        found += Shown(html.render(replace(face, command="allanite", data=b"x"))).texts
        found += [html.tr(drawn.label) for drawn in drawings(face)]
    if drawn and view_of(value).plot is not None:
        with suppress(UndrawnError):  # such as a file that holds the whole model
            found += words_of(al.plot(value, lang=lang))
    return found


def drawings(face):
    """The figures of a page, in its folds too."""
    pile = [*face.parts, *face.close, *face.how, *(part for sheet in face.sheets for part in sheet.parts)]
    while pile:
        part = pile.pop()
        pile += part.parts if isinstance(part, Fold) else ()
        if hasattr(part, "label"):
            yield part


@pytest.fixture
def pseudo(monkeypatch):
    """The language "xx"."""
    none = language.gettext.NullTranslations()
    monkeypatch.setattr(language, "catalogue", lambda lang: Pseudo() if lang == "xx" else none)


RUNS = {verb: row.runs for verb, row in ROWS.items() if row.runs}


@pytest.fixture(scope="module")
def values(furnished):
    """What a verb shows, without names of papers: a function of its name."""
    found = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(furnished)
        for table in (EXPORTS, TEMPERATURE):
            for name, row in table.items():
                patch.setitem(getattr(table, "_rows", table), name, replace(row, source=""))
        patch.setattr(watching, "arrivals", lambda feed, _, __, stopped: live.arrivals(feed, math.inf, 1e-9, stopped))

        def values_of(verb):
            if verb not in found:
                found[verb] = []
                with pytest.MonkeyPatch.context() as own:
                    if verb == "explain":
                        for name, statistic in STATISTICS.items():
                            own.setitem(STATISTICS._rows, name, replace(statistic, reference=""))
                    own.setattr(deliver, "text_of", lambda value, *_: found[verb].append(value) or "")
                    for line in RUNS[verb]:
                        run(f"{verb} {line}", 3, 4, 5)
                assert len(found[verb]) == len(RUNS[verb])
            return found[verb]

        yield values_of


@rows("verb", RUNS)
def test_nothing_that_a_verb_shows_is_left_in_english(verb, values, pseudo, monkeypatch):
    pairs = zip(values(verb), RUNS[verb], strict=True)
    drawn = ((one, verb != "info" and "--start" not in line) for one, line in pairs)
    assert left(part for one, figure in drawn for part in shown(one, monkeypatch, figure)) == []


PLAIN = r"(?<!\w)(deg(?!C)|ug|sqrt\((h|s|Hz)\))(?!\w)"  # units as they are typed
TYPED = r"(?<!\w)'[^']*'(?!\w)|\"[^\"]*\"|--\S+ \S+|^(time|enc|ref|g[xyz]|a[xyz]) \[.*"  # where they may be


@rows("verb", RUNS)
@rows("lang", language.LANGUAGES)
@pytest.mark.filterwarnings("ignore::allanite.reporting.fonts.FontWarning")
def test_units_are_shown_with_their_signs(verb, values, lang, monkeypatch):
    lines = (line for one in values(verb) for line in shown(one, monkeypatch, drawn=False, lang=lang))
    assert [line for line in lines if re.search(PLAIN, re.sub(TYPED, "", line))] == []


@rows("verb", RUNS)
def test_a_terminal_without_signs_has_letters_of_ascii(verb, values):
    for one in values(verb):
        face = view_of(one).face(one, level_of(one))
        assert [line for line in text.render(face, ascii=True).splitlines() if not line.isascii()] == []


def printed_words(figure):
    """Lines of titles, names, labels and legends of a figure of matplotlib, without those at ticks."""
    panels = [axes for axes in figure.axes if axes.get_visible()]
    sides = [side for axes in panels for side in (axes.xaxis, axes.yaxis)]
    ticks = {id(text) for side in sides for text in (*side.get_ticklabels(), *side.get_ticklabels(minor=True))}
    hidden = {id(text) for axes in panels if not axes.axison for text in axes.findobj(Text)}
    hidden |= {id(axes.xaxis.label) for axes in panels if not axes.xaxis.get_tick_params()["labelbottom"]}
    texts = [text for text in figure.findobj(Text) if id(text) not in ticks | hidden and text.get_visible()]
    return {line.strip() for text in texts for line in text.get_text().splitlines()} - {""}


@rows("verb", RUNS)
def test_a_figure_on_a_page_has_the_words_of_that_for_print(verb, values):
    for value in values(verb):
        for drawing in drawings(view_of(value).face(value, level_of(value))):
            try:
                page = ElementTree.fromstring(drawing.draw().sketched().svg())
            except Unsketched:
                continue
            wide, high = (float(number) for number in page.get("viewBox").split()[2:])
            texts = list(page.iter("{http://www.w3.org/2000/svg}text"))
            assert all(0 <= float(t.get("x")) <= wide and 0 <= float(t.get("y")) <= high for t in texts)
            said = {" ".join(text.text.split()) for text in texts}
            printed = {" ".join(line.split()) for line in printed_words(printing.printed(drawing.draw()))}
            assert printed - said <= {line for line in printed if "$" in line}, verb
