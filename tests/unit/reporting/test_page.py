"""The page of a study: what a reader without a mouse, a colour or a wide screen gets, and that nothing is fetched."""

import base64
import gzip
import html
import json
import re
from dataclasses import replace
from itertools import pairwise

import pytest
from tests.commands import ends, run
from tests.rows import rows
from tests.unit.reporting.test_colors import READABLE, contrast
from tests.unit.reporting.test_report import HOSTILE, Tags, channel_of, refused, study_of

import allanite as al
from allanite.phrases.phrase import Phrase
from allanite.reporting import page, table
from allanite.reporting.html import _prose
from allanite.reporting.language import catalogue, tr
from allanite.reporting.views import view_of
from allanite.reporting.views.datasheet import alternative


@pytest.fixture(scope="module")
def study():
    about = ("serial=SN 12", f"operator={HOSTILE}", "temperature=23.5 degC")
    return study_of(channel_of("gx"), channel_of("gy", p=1e-9), refused("gz"), about=about)


@pytest.fixture(scope="module")
def text(study):
    return page(study, command="allanite analyze fog.csv --report page.html")


@pytest.fixture(scope="module")
def tags(text):
    return Tags(text).tags


def test_a_phrase_is_shown_in_english_as_it_is(monkeypatch, study):
    """Its template filled once more, as for any other language, is the same."""
    made, form = [], Phrase.__str__
    monkeypatch.setattr(Phrase, "__str__", lambda phrase: made.append(phrase) or form(phrase))
    table(study)
    assert len(made) > 0
    assert all(phrase.within(catalogue("en")) == phrase for phrase in made)


def named(tags, name):
    return [attrs for tag, attrs in tags if tag == name]


def test_a_reader_without_a_mouse_finds_the_way(tags):
    levels = [int(tag[1]) for tag, _ in tags if re.fullmatch(r"h[1-6]", tag)]
    assert levels[0] == 1
    assert levels.count(1) == 1
    assert all(after <= before + 1 for before, after in pairwise(levels))
    # every header cell says what it heads
    cells = named(tags, "th")
    assert len(cells) > 20
    assert {cell.get("scope") for cell in cells} == {"col", "row"}
    # there are landmarks and a way to each channel
    assert [len(named(tags, landmark)) for landmark in ("header", "nav", "main")] == [1, 1, 1]
    assert named(tags, "html")[0]["lang"] == "en"
    assert named(tags, "nav")[0]["aria-label"]
    targets = {attrs["id"] for _, attrs in tags if "id" in attrs}
    inside = [attrs["href"][1:] for attrs in named(tags, "a") if attrs["href"].startswith("#")]
    assert {"summary", "s1", "s2", "s3", "method", "reproduce"} <= set(inside)
    assert set(inside) <= targets
    # what scrolls can be reached by the keyboard
    scrolled = [attrs for _, attrs in tags if attrs.get("role") == "group"]
    assert scrolled
    assert all(attrs["tabindex"] == "0" and attrs["aria-label"] for attrs in scrolled)
    assert not any(attrs.get("role") == "alert" for _, attrs in tags)  # nothing happens on a page


def test_every_figure_is_described_by_its_numbers(tags, study):
    labels = [attrs["aria-label"] for attrs in named(tags, "svg")]
    assert all(attrs["role"] == "img" for attrs in named(tags, "svg"))
    assert len(labels) == 2 * len(set(labels))  # for broad and for narrow screens
    channel = study.channels[0]
    assert tr(alternative(channel, channel.curve, 0.95)) in labels
    assert any("N = 0.0500 (0.0480 … 0.0520) °/√h" in label and "at 0.1 s" in label for label in labels)


@rows("ground", [0, 1])
def test_text_has_contrast_on_both_grounds(text, ground):
    blocks = re.findall(r":root \{([^}]*)\}", text)
    grounds = [dict(re.findall(r"(--[\w-]+): (#[0-9a-f]{3,6})", block)) for block in blocks if "--ground" in block]
    colors = grounds[0] | grounds[ground]
    long = {k: "#" + "".join(2 * c for c in v[1:]) if len(v) == 4 else v for k, v in colors.items()}
    pairs = [(ink, back) for ink in ("ink", "soft") for back in ("ground", "wash")]
    pairs += [("alarm", "ground"), ("weak", "ground"), ("good", "ground"), ("link", "ground"), ("link", "wash")]
    pairs += [("alarm-ink", "alarm-wash"), ("alarm", "alarm-wash"), ("good", "good-wash"), ("weak", "fair-wash")]
    for ink, back in pairs:
        assert contrast(long[f"--{ink}"], long[f"--{back}"]) >= READABLE, (ink, back)


def test_the_page_tells_of_channels_device_command_and_data(text, study):
    # the cells of the first screen, in the classes of what they say
    shown = re.search(r'<div class="channels">.*?</table>', text, re.DOTALL)[0].replace("\N{NO-BREAK SPACE}", " ")
    assert re.findall(r'<a href="#(s\d)">(\w+)</a>', shown) == [("s1", "gx"), ("s2", "gy"), ("s3", "gz")]
    cells = [re.findall(r'<td class="([\w-]*)">([^<]*)', row) for row in shown.split("<tr>")[2:]]
    (table_of,) = view_of(study).first(study, 0.95).tables
    assert [[html.unescape(cell) for _, cell in row] for row in cells] == [list(row.cells) for row in table_of.rows]
    assert cells[0] == [("identified", "0.0500 ± 4 %"), ("", ""), ("", "")]
    assert cells[2][0] == ("absent", "&lt; 2.1")
    assert cells[-1] == [("good", "fits, p 0.4"), ("alert", "DOES NOT FIT"), ("alert", "no result")]
    summary = text[text.index('id="summary"') : text.index('id="s1"')]
    assert summary.index("<figure") < summary.index('role="note"') < summary.index("never changes")
    # the header names the device
    words = "".join(Tags(text).text)
    assert [part for part in ("serial", "SN 12", HOSTILE, "23.5 degC", "10 Hz", "60 s") if part not in words] == []
    # the page holds its command and its data
    assert '<pre tabindex="0">allanite analyze fog.csv --report page.html</pre>' in text
    packed = re.search(r"data:application/gzip;base64,([\w+/=]+)", text)[1]
    data = json.loads(gzip.decompress(base64.b64decode(packed)))
    assert data == json.loads(json.dumps(study.to_dict()))
    # the data sheet is on the page in the terminal and in json
    assert "noise density, one-sided" in words
    # 0.05 deg/sqrt(h) = 0.000833 deg/s/sqrt(Hz), and sqrt(2) times that
    assert "0.001179" in words
    assert "noise density, one-sided" in table(study)
    entries = study.to_dict()["channels"][0]["data_sheet"]
    assert {"quantity", "value", "low", "high", "unit", "tau", "remark", "coefficient"} == set(entries[0])


def test_a_page_is_small_and_shows_another_unit_everywhere(study):
    channels = tuple(channel_of(name) for name in ("gx", "gy", "gz"))
    assert len(page(study_of(*channels)).encode()) < 600_000
    # another unit is used everywhere
    shown = replace(study, channels=(study.channels[0].to("deg/s"),), recipe=al.Recipe(to=("deg/s",)))
    text = table(shown)
    assert re.search(r"angle random walk +8.33e-4 .*°/s/√Hz", text)
    assert re.search(r"bias instability +1.39e-4 .*°/s", text)


@rows("choice, words", [
    ({"to": ("deg/s^3",)}, "no noise coefficient has the unit"), ({"about": ("SN 12",)}, "KEY=VALUE"),
])  # fmt: skip
def test_a_unit_of_nothing_and_a_fact_without_a_value_are_refused(choice, words):
    with pytest.raises(al.UsageError, match=words):
        al.Recipe(**choice)
    assert al.Recipe(about=("serial=SN=12",)).labels == {"serial": "SN=12"}


@pytest.mark.slow("takes more than half a second")
@rows("unit", ["V", "m/s^2"])
def test_a_unit_of_no_channel_is_refused(tmp_path, unit):
    rows = "\n".join(f"{(-1) ** i * (1 + (i * 7919 % 101) / 50)}" for i in range(3000))
    file = tmp_path / "x.csv"
    file.write_text(f"gx [deg/s]\n{rows}\n", encoding="utf-8")
    done = run("analyze", file, "--rate", "10", "--to", unit)
    ends(done, 2, f"no channel has a coefficient in '{unit}' (--output-unit); the channels are in deg/h")
    with pytest.raises(al.UsageError, match=r"\(to=\); the channels are in deg/h"):
        al.analyze(str(file), al.Recipe(rate=10.0, to=(unit,)))


def test_options_are_not_broken_and_names_are_text():
    option = '<span class="option">--{}</span>'.format
    shown = f"&lt;b&gt;: try {option('from 1')} &amp; {option('quiet-window')}"
    assert _prose("<b>: try --from 1 & --quiet-window") == shown
