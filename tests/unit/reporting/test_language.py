"""Languages of reports: translations are right, the words fit, and letters that a machine lacks are not drawn."""

import subprocess
import sys
import warnings
from gettext import NullTranslations
from string import Formatter

import pytest
from matplotlib.text import Text
from rich.cells import cell_len
from tests.rows import rows
from tests.unit.reporting.test_report import channel_of, study_of

import allanite as al
import catalogues
import release
from allanite.phrases.phrase import join, say, say_count
from allanite.reporting import fonts, page, printing, table
from allanite.reporting.language import LANGUAGES, speaking, tr
from allanite.reporting.sheet import Column, Face, Note, Sheet, Table
from allanite.reporting.text import pad, render, wrapped

TRANSLATED = [lang for lang in LANGUAGES if lang != "en"]


def fields(text):
    """Names and formats of the fields of a template, in any order."""
    return sorted((name, form, how or "") for _, name, form, how in Formatter().parse(text) if name is not None)


@pytest.fixture(scope="module", params=TRANSLATED)
def stored(request):
    catalogue = catalogues.stored(request.param)
    for message in catalogues.unfinished(catalogue):
        catalogue.delete(message.id, message.context)
    return catalogue


@pytest.fixture(scope="module")
def study():
    return study_of(channel_of("gx"))


class Chinese(NullTranslations):
    """A catalogue of a few words."""

    def gettext(self, message):
        words = {"file": "文件", "assumed": "假设", "averaging time τ (s)": "平均时间 τ (s)", "channel": "通道"}
        return words.get(message, message)


@pytest.fixture
def chinese(monkeypatch):
    catalogues_of = {"en": NullTranslations(), "zh": Chinese()}
    monkeypatch.setattr("allanite.reporting.language.catalogue", catalogues_of.get)


@pytest.mark.slow("seconds of analyses")
def test_sentences_without_a_translation_are_counted_and_asked_for_by_a_release_only(monkeypatch, capsys, tmp_path):
    found = catalogues.Catalog()
    found.add("a new sentence")
    found.add(("{count} new one", "{count} new ones"))
    monkeypatch.setattr(catalogues, "templates", lambda: found)
    monkeypatch.setattr(catalogues.sys, "argv", ["catalogues.py", "--check"])
    catalogues.main()
    lines = [f"{lang}: 2 sentences are shown in English" for lang in sorted(TRANSLATED)]
    assert capsys.readouterr().out.splitlines() == lines
    monkeypatch.setattr(release.sys, "argv", ["release.py", str(tmp_path)])
    with pytest.raises(SystemExit, match=r"2 sentences are shown in English.*run make catalogues"):
        release.main()


def test_a_language_without_a_catalogue_is_english(monkeypatch, study):
    monkeypatch.setitem(LANGUAGES, "de", "Deutsch")
    assert table(study, lang="de") == table(study)
    assert '<html lang="de">' in page(study, lang="de")


def test_a_translation_has_the_fields_and_plural_forms_of_its_template(stored):
    for message in (message for message in stored if message.id):
        template = message.id if isinstance(message.id, str) else message.id[1]
        assert {str(fields(text)) for text in catalogues.strings(message) if text} <= {str(fields(template))}
    assert all(len(catalogues.strings(message)) == stored.num_plurals for message in stored if message.pluralizable)


@rows("lang", TRANSLATED)
def test_what_is_not_translated_is_shown_in_english(lang):
    with speaking(lang):
        assert tr(say("{a} that nobody has translated", a=1)) == "1 that nobody has translated"
        assert tr(join("; ", [])) == ""
        assert tr(say_count(2, "{count} of one", "{count} of those")) == "2 of those"
        assert tr("file") == "file"  # a name, not a phrase


def test_an_unknown_language_is_refused_with_the_known_ones(study, tmp_path):
    for refused in (al.plot, al.report, page, table):
        with pytest.raises(al.UsageError, match=r"unknown language 'xx'; known languages: en, ru, zh"):
            refused(study, *([tmp_path / "a.html"] if refused is al.report else []), lang="xx")


def test_the_language_is_that_of_the_call_alone(study, chinese):
    plain = table(study)
    with speaking("zh"):
        assert table(study) == plain
    assert "文件" in table(study, lang="zh")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fonts.FontWarning)
        assert '<html lang="zh">' in page(study, lang="zh")
    # the words of a figure are phrases until it is done
    assert "averaging time τ (s)" in {text.get_text() for text in al.plot(study).findobj(Text)}


def test_english_needs_no_catalogue():
    code = "import sys, allanite.reporting.language as l; l.catalogue('en'); sys.exit('babel' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_columns_line_up_where_characters_are_wide(chinese):
    cells = Table((Column(say("channel"), "name"), Column("m")), [["a", "1"], ["bb", "22"]])
    facts = [(say("file"), "a.csv"), (say("assumed"), "b")]
    face = Face("", "", [Sheet("gx", (), [cells, Note(say("channel"))])], facts)
    with speaking("zh"):
        first, second, _, _, head, *rows, _ = render(face, width=60).splitlines()
    assert cell_len(first.removesuffix("a.csv")) == cell_len(second.removesuffix("b")) == 10
    assert {cell_len(line) for line in (head, *rows)} == {10}


def test_chinese_is_wrapped_by_cells_and_not_before_a_stop():
    text = "零偏不稳定性，速率随机游走。角度 N 0.3 deg/h"
    lines = wrapped(text, 14, "- ", "  ")
    assert all(cell_len(line) <= 14 for line in lines)
    assert not any(line.strip()[0] in "，。" for line in lines)
    assert "".join(line[2:] for line in lines).replace(" ", "") == text.replace(" ", "")
    assert pad("文件", 10) == "文件      "


def test_letters_that_are_missing(study, chinese, monkeypatch, tmp_path):
    monkeypatch.setattr(fonts, "further", lambda lang: "")
    with pytest.warns(fonts.FontWarning, match="in English, because no font .* install Noto Sans CJK SC"):
        figure = al.plot(study, path=tmp_path / "a.png", lang="zh")
    assert "averaging time τ (s)" in {text.get_text() for text in figure.findobj(Text)}
    # a page leaves letters that are missing to the browser
    with pytest.warns(fonts.FontWarning, match="install Noto Sans CJK SC"):
        written = page(study, lang="zh")
    assert "平均时间 τ (s)</text>" in written


@pytest.mark.skipif(not fonts.further("zh"), reason="no font with Chinese characters is installed")
@rows("form", ["png", "svg", "pdf"])
def test_a_figure_has_chinese_letters(study, chinese, form):
    with speaking("zh"):
        figure = al.plot(study, lang="zh")
        assert "平均时间 τ (s)" in {text.get_text() for text in figure.findobj(Text)}
        data = printing.encode(figure, form)  # a letter that is missing is a warning, and that an error
    assert len(data) < 400_000
