"""The table, the figures and the page of a study made by hand."""

import base64
import csv
import hashlib
import io
import json
import math
import re
from dataclasses import replace
from html.parser import HTMLParser

import matplotlib as mpl
import numpy as np
import pytest
from tests.rows import rows

import allanite as al
from allanite.batch.batch import Batch, unit_of
from allanite.batch.specification import Specification
from allanite.cli.deliver import Outputs, deliver
from allanite.core.fit import Goodness
from allanite.core.model import term
from allanite.core.syntax import toml
from allanite.core.units import signal_named
from allanite.core.validity import Finding, Quality
from allanite.phrases.phrase import say
from allanite.reporting import page, plot, table, to_csv
from allanite.reporting.figures.record import plot_goodness
from allanite.reporting.json import to_json
from allanite.reporting.printing import encode, new_figure, printed
from allanite.reporting.sheet import Table
from allanite.reporting.views import view_of
from allanite.study.results import Channel, Noise

HOSTILE = "<script>alert('x')</script>"


def found(part, relative=0.02, status="identified"):
    ends, size = sorted((part.value * (1 - 2 * relative), part.value * (1 + 2 * relative))), abs(part.value)
    error, most = size * relative, 1.1 * size
    return al.Estimate(part.symbol, part.signal, part.value, error, status, most, "whittle", lambda level: tuple(ends))


def absent(symbol, limit, unit):
    part = term(symbol, limit, unit)
    most, limits = part.value, lambda level: (0.0, part.value)
    return al.Estimate(symbol, part.signal, None, None, "absent", most, "whittle", limits)


def channel_of(name="gyro_z", p=0.4, reasons=(), warnings=()):
    model = al.N(0.05, "deg/sqrt(h)") + al.B(0.5, "deg/h") + al.R(-0.4, "deg/h^2")
    estimates = (
        absent("Q", 0.12, "arcsec"), found(model["N"]), found(model["B"], 0.3, "weak"),
        absent("K", 2.1, "deg/h/sqrt(h)"), found(model["R"], 0.1),
    )  # fmt: skip
    z = np.linspace(-1.5, 1.5, 24)
    good = Goodness(np.geomspace(1e-4, 5, 25), np.exp(z / 10), z, p, tuple(reasons))
    m = np.unique(np.geomspace(1, 30_000, 40).astype(np.int64))
    edf = np.geomspace(5000, 0.8, m.size)
    law = lambda level: (edf, np.exp(-1 / edf**0.5), np.exp(3 / edf**0.5))  # noqa: E731
    numbers = (m, m / 10.0, al.expected(model, "oadev", m / 10.0), m[::-1].copy(), np.ones(m.size))
    curve = al.Curve("oadev", *numbers, "rad/s", 10.0, name=name, noise=model, law=law)
    record = al.Record(np.sin(np.arange(600.0)), 10.0, "deg/h", name=name)
    fit = al.Fit(estimates, "whittle", signal_named("gyro"), model=model, name=name, goodness=good, curve=curve)
    quality = Quality(tuple(Finding("spikes", what, remedy="look at them") for what in warnings))
    return Channel(record, quality, Noise(fit), curves=(curve,))


def refused(name="gyro_x"):
    record = al.Record(np.arange(300.0), 10.0, "deg/h", name=name)
    return Channel(record, Quality(()), refusal=f"{name!r} never changes; check the plug")


def study_of(*channels, source="bench/fog.csv", notes=("rate 10 Hz from column 'time [s]'",), **choices):
    provenance = {"allanite": "1.2.3", "python": "3.12.0", "source": source, "sha256": "ab" * 32}
    return al.Study(tuple(channels), al.Recipe(**choices), (), tuple(notes), provenance)


@pytest.fixture(scope="module")
def study():
    return study_of(channel_of(), refused())


class Tags(HTMLParser):
    """Every tag with its attributes, and the text outside of style."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.text = [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data):
        self.text.append(data)


@rows("width", [80, 100, 120, 160])
def test_no_line_of_the_table_is_wider_than_the_terminal(study, width):
    text = table(study, width=width)
    assert max(map(len, text.splitlines())) <= width
    assert "\x1b" not in text
    assert all(line == line.rstrip() for line in text.splitlines())


def test_the_table_of_a_study(study):
    text, broad, shown = table(study), table(study, width=160), page(study)
    assert "°/√h" in next(line for line in broad.splitlines() if "angle random walk" in line)
    assert "rad/√s" not in broad
    assert "rad/√s" in shown
    # values carry the digits of their interval; a ramp has a sign
    assert "0.0500  0.0480 .. 0.0520" in text
    assert "1.454 × 10⁻⁵" in shown
    assert "1.396 × 10⁻⁵ … 1.513 × 10⁻⁵" in shown
    assert "-0.400  -0.480 .. -0.320" in text
    # absent terms are said to be not identified with their limit
    assert re.search(r"Q  quantization noise +below 0.12 +arcsec +absent", text)
    assert re.search(r"K  rate random walk +below 2.1 +°/h/√h +absent", text)
    assert "one-sided 95 % upper limit" in text
    # what was assumed and what made it stand in the header
    for word in ("bench/fog.csv", "rate 10 Hz from column 'time [s]'", "ab" * 32, "allanite 1.2.3", "1 min"):
        assert word in text.replace("60 s", "1 min")
    # a refused channel says why
    assert "no result: 'gyro_x' never changes; check the plug" in text
    # colour is for terminals
    assert "\x1b[" in table(study, color=True)


def test_other_tables():
    channel = channel_of()
    fit = replace(channel.fit, estimates=(absent("Q", 2e-5, "arcsec"), *channel.fit.estimates[1:]))
    assert "below 2.0e-5" in table(study_of(replace(channel, noise=Noise(fit))))
    # warnings and a model that explains nothing stand above the numbers
    text = table(study_of(channel_of(p=1e-9, reasons=("a line at 3 Hz",), warnings=("12 spikes",))))
    first = text.index("no model of these terms explains the record")
    assert first < text.index("angle random walk")
    assert text.index("12 spikes; look at them") < text.index("angle random walk")
    assert "a line at 3 Hz" in text
    # a name is no markup
    assert "[31mred[/bold]" in table(study_of(channel_of("\x1b[31mred[/bold]")), color=False)


def test_a_page_says_nothing_twice():
    """In the part of a channel: one grade with all warnings, two densities, no coefficient in the data sheet."""
    channel = channel_of(reasons=("heavy tails",), warnings=(say("one outlier"), say("coarse steps")))
    text = page(study_of(channel))
    part = text[text.index('<section id="s1"') : text.index('<section id="method"')]
    shown = re.sub("<svg.*?</svg>", "", part[: part.index("<details")], flags=re.DOTALL)
    assert shown.count("xplained") == 1
    warnings = ["Heavy tails", "One outlier; look at them", "Coarse steps; look at them"]
    assert re.findall("<li>(.*?)</li>", shown)[:3] == warnings
    assert shown.count("noise density") == 2
    assert 'class="alert"' not in text
    for cell in ("0.0500", "angle random walk", "1.454 × 10⁻⁵"):
        assert shown.count(f">{cell}<") == 1, cell


@pytest.mark.slow("takes more than half a second")
def test_each_channel_has_a_figure_of_its_own_where_the_path_says_so(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    study = study_of(channel_of("Gyro. X"), channel_of("../y"), channel_of("..:y"), refused())
    deliver(study, Outputs({"plot": "curve_{channel}.svg"}, quiet=True))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["curve_Gyro._X.svg", "curve_y.svg", "curve_y3.svg"]
    with pytest.raises(al.UsageError, match="already exists"):
        deliver(study, Outputs({"plot": "curve_{channel}.svg"}, quiet=True))
    with pytest.raises(al.UsageError, match="leave out"):
        deliver(study.channels[0].curve, Outputs({"plot": "{channel}.svg"}, quiet=True))


def test_limits_add_to_the_report_of_one_file(study):
    limits = Specification.from_toml({"limits": {"N": {"max": "0.04 deg/sqrt(h)"}}})
    batch = Batch((unit_of("fog.csv", study, limits),), {}, 0.95, limits)
    alone, judged = view_of(study).face(study, 0.95), view_of(batch).face(batch, 0.95)
    assert [sheet.name for sheet in judged.sheets] == [sheet.name for sheet in alone.sheets]
    assert judged.how == alone.how
    added = [part for part in judged.parts if part not in alone.parts]
    assert len(judged.parts) == len(alone.parts) + len(added)
    assert any("0.04 deg/sqrt(h)" in cell for part in added if isinstance(part, Table) for cell in part.rows[0])


def test_figures_of_a_study(study):
    assert len(plot(study_of(channel_of("x"), channel_of("y"), channel_of("z"))).axes) == 3
    before = dict(mpl.rcParams)
    (ax,) = plot(study).axes
    assert dict(mpl.rcParams) == before
    # labels give the coefficients
    texts = [text.get_text() for text in ax.texts]
    assert "N = 0.0500 (0.0480 … 0.0520) °/√h\nat τ = 1 s: 3 °/h" in texts
    assert "0.664 B = 0.332 °/h\nB = 0.50 (0.20 … 0.80) °/h" in texts
    assert "R = −0.400 (−0.480 … −0.320) °/h²" in texts
    assert "slope −½" in texts
    assert not any(text.startswith("K =") for text in texts)
    # few degrees of freedom and doubt are said
    figure = plot(study_of(channel_of(p=1e-9)))
    legend = [text.get_text() for text in figure.legends[0].get_texts()]
    assert "below 2 degrees of freedom" in legend
    assert figure.axes[0].get_title("right") == "not explained, p = 1e-09"
    assert ax.get_title("right") == "explained, p = 0.4"
    # a bare curve can be drawn
    curve = study.channels[0].curve
    bare = replace(curve, name="", noise=None, law=None)
    assert plot(bare).axes[0].get_xlabel() == "averaging time τ (s)"
    assert plot(bare.to("deg/s")).axes[0].get_ylabel().endswith("(°/s)")
    # what cannot be drawn is said
    with pytest.raises(al.UsageError, match="a int cannot be shown: compute a result first"):
        plot(3)
    with pytest.raises(al.UsageError, match="no samples"):
        plot(al.Study.from_dict(study_of(refused()).to_dict()))


@pytest.mark.slow("takes more than half a second")
def test_the_model_that_is_drawn_has_the_warm_up_that_was_found():
    y = np.random.default_rng(3).standard_normal(40_000) - 3 * np.exp(-np.arange(40_000) / 4000)
    study = al.analyze(al.Record(y, 20.0, "deg/h", name="gx"))
    (line,) = [line for line in plot(study).axes[0].lines if line.get_label() == "model"]
    curve = study["gx"].curve
    drawn = np.interp(curve.tau, line.get_xdata(), line.get_ydata())
    assert drawn[-8:] == pytest.approx(np.degrees(curve.deviation[-8:]) * 3600, rel=0.1)


@pytest.mark.slow("takes more than half a second")
@rows("suffix", ["png", "svg", "pdf"])
def test_a_saved_figure_is_the_same_every_time(study, tmp_path, suffix):
    paths = [tmp_path / f"{name}.{suffix}" for name in "ab"]
    for path in paths:
        plot(study, path=path)
    first, second = (path.read_bytes() for path in paths)
    assert first == second
    assert len(first) > 5000


@pytest.mark.slow("takes more than half a second")
@rows("least", [1e-9, 0.0, 0.9])
def test_a_cell_without_power_does_not_spoil_the_strips(least):
    z = np.linspace(-4, 1.5, 24)
    ratio = np.where(z == z.min(), least, 1.0)
    figure = printed(plot_goodness(Goodness(np.geomspace(1e-4, 5, 25), ratio, z, 0.2), "x"))
    encode(figure, "svg")  # lays it out
    assert all(ax.get_position().height > 0.2 for ax in figure.axes)
    assert figure.axes[0].get_ylim()[0] > 0.04


def test_the_page_loads_nothing_and_tells_the_whole_story():
    channels = (channel_of(HOSTILE, p=1e-9, warnings=(HOSTILE,)), channel_of("b$x_{\\evil$"), refused(f"r{HOSTILE}"))
    source = f"bench/{HOSTILE.replace('/', '')}.csv"
    text = page(study_of(*channels, source=source, notes=(HOSTILE,), unit="deg/h"))
    parsed = Tags(text)
    tags, words = parsed.tags, "".join(parsed.text)
    assert not {tag for tag, _ in tags} & {"iframe", "img", "object", "embed", "base", "form"}
    links = [value for _, attrs in tags for key, value in attrs.items() if key in ("src", "href", "xlink:href", "data")]
    assert all(link.startswith(("#", "data:")) for link in links)
    assert not any(key.startswith("on") for _, attrs in tags for key in attrs)
    assert "@import" not in text
    assert all(part.startswith("#") for part in text.split("url(")[1:])
    policy = next(a["content"] for t, a in tags if t == "meta" and a.get("http-equiv") == "Content-Security-Policy")
    (script,) = re.findall(r"<script[^>]*>(.*?)</script>", text, re.DOTALL)  # its own, which nothing can be put into
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    assert policy.startswith(f"default-src 'none'; script-src 'sha256-{digest}';")
    # the pictures are in the page and share no names
    assert [tag for tag, _ in tags].count("svg") == 22
    ids = [attrs["id"] for _, attrs in tags if "id" in attrs]
    # within one picture matplotlib names a glyph once; between pictures the prefix differs
    assert len(ids) == len(set(ids))
    # hostile names come out as text
    assert text.count("<script") == 1
    assert HOSTILE in words
    # the page tells the whole story
    told = ("DOES NOT FIT", "below 2.1", "Whittle", "upper limit", 'unit = "deg/h"', "ab" * 32, "1.2.3",
            "What was assumed", "No result")  # fmt: skip
    assert [part for part in told if part not in words] == []
    assert "<math" in text
    # warnings stand above the numbers of the channels
    assert text.index('class="alert" role="note"') < text.index('id="s1"')


def test_what_machines_read(tmp_path, study):
    recipe = al.Recipe(about=('serial=a"b\\',), channels=("x", "ü"), taus=(1.0, 10.0), band=(0.1, 5.0), rate=100.0)
    (tmp_path / "recipe.toml").write_text(toml(recipe.to_dict()), encoding="utf-8")
    assert al.Recipe.load(tmp_path / "recipe.toml") == recipe
    # json is strict and complete
    broken = study_of(channel_of(), refused())
    m = broken.channels[0].curve.m.size
    object.__setattr__(broken.channels[0].curve, "law", lambda level: tuple(np.full(m, math.nan) for _ in range(3)))
    data = json.loads(to_json(broken), parse_constant=pytest.fail)
    assert data["channels"][0]["curves"][0]["edf"] == [None] * m
    assert json.loads(to_json(study)) == json.loads(json.dumps(study.to_dict()))
    # csv holds the curves in the units of data sheets
    rows, curve = list(csv.DictReader(io.StringIO(to_csv(study)))), study.channels[0].curve
    assert (len(rows), rows[0]["unit"]) == (curve.m.size, "deg/h")
    low, value, high = (float(rows[3][key]) for key in ("low", "deviation", "high"))
    assert value == pytest.approx(curve.to("deg/h").deviation[3])
    assert low < value < high


@rows(("statistic", "share"), [("mdev", "0.546 B"), ("mtotdev", "0.462 B")])
def test_flicker_has_the_level_of_the_statistic(statistic, share):
    record = al.simulate(al.N(1, "deg/sqrt(h)") + al.B(10, "deg/h"), 8000, 1.0, rng=np.random.default_rng(2))
    fit = al.identify(record)
    figure = plot(al.deviation(record, statistic, taus="octave", noise=fit), fit)
    assert any(text.get_text().startswith(f"{share} = ") for text in figure.axes[0].texts)


@pytest.mark.slow("takes more than half a second")
def test_labels_of_tall_figures_are_inside():
    figure = new_figure(6.6, 14.837)
    for ax in figure.subplots(3, 1):
        ax.set(xscale="log", yscale="log", xlim=(0.11, 7400), ylim=(1.1, 4100), title="gx", ylabel="deviation")
        ax.set_aspect("equal", adjustable="box", anchor="N")
    figure.draw_without_rendering()
    assert all(ax.yaxis.label.get_window_extent().x0 > 0 for ax in figure.axes)
