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

import numpy as np
import pytest
from tests.rows import rows

import allanite as al
from allanite.batch.batch import Batch, unit_of
from allanite.batch.specification import Specification
from allanite.cli.deliver import Outputs, deliver
from allanite.core.curve import Curve
from allanite.core.estimate import Estimate
from allanite.core.fit import Fit, Goodness
from allanite.core.model import B, N, R, term
from allanite.core.record import Record
from allanite.core.syntax import toml
from allanite.core.units import signal_named
from allanite.core.validity import Finding, Quality
from allanite.phrases.phrase import say
from allanite.reporting import page, plot, table, to_csv
from allanite.reporting.digits import printed_unit
from allanite.reporting.figures.record import plot_goodness
from allanite.reporting.json import to_json
from allanite.reporting.printing import encode, new_figure, printed
from allanite.reporting.sheet import Table
from allanite.reporting.views import view_of
from allanite.reporting.words import title
from allanite.statistics import expected
from allanite.study.recipe import Recipe
from allanite.study.results import Channel, Noise, Study

HOSTILE = "<script>alert('x')</script>"


def found(part, relative=0.02, status="identified"):
    low, high = sorted((part.value * (1 - 2 * relative), part.value * (1 + 2 * relative)))
    limits = lambda level: (low, high)  # noqa: E731
    size = abs(part.value)
    return Estimate(part.symbol, part.signal, part.value, size * relative, status, 1.1 * size, "whittle", limits)


def absent(symbol, limit, unit):
    most = term(symbol, limit, unit)
    return Estimate(symbol, most.signal, None, None, "absent", most.value, "whittle", lambda level: (0.0, most.value))


def curve_of(model, name, points=40):
    m = np.unique(np.geomspace(1, 30_000, points).astype(np.int64))
    variance = expected(model, "oadev", m / 10.0)
    edf = np.geomspace(5000, 0.8, m.size)
    law = lambda level: (edf, np.exp(-1 / edf**0.5), np.exp(3 / edf**0.5))  # noqa: E731
    return Curve(
        "oadev", m, m / 10.0, variance, m[::-1].copy(), np.ones(m.size), "rad/s", 10.0, name=name, noise=model, law=law
    )


def channel_of(name="gyro_z", p=0.4, reasons=(), warnings=()):
    model = N(0.05, "deg/sqrt(h)") + B(0.5, "deg/h") + R(-0.4, "deg/h^2")
    estimates = (
        absent("Q", 0.12, "arcsec"),
        found(model["N"]),
        found(model["B"], 0.3, "weak"),
        absent("K", 2.1, "deg/h/sqrt(h)"),
        found(model["R"], 0.1),
    )
    z = np.linspace(-1.5, 1.5, 24)
    good = Goodness(np.geomspace(1e-4, 5, 25), np.exp(z / 10), z, p, tuple(reasons))
    curve = curve_of(model, name)
    record = Record(np.sin(np.arange(600.0)), 10.0, "deg/h", name=name)
    fit = Fit(estimates, "whittle", signal_named("gyro"), model=model, name=name, goodness=good, curve=curve)
    quality = Quality(tuple(Finding("spikes", what, remedy="look at them") for what in warnings))
    return Channel(record, quality, Noise(fit), curves=(curve,))


def refused(name="gyro_x"):
    record = Record(np.arange(300.0), 10.0, "deg/h", name=name)
    return Channel(record, Quality(()), refusal=f"{name!r} never changes; check the plug")


def study_of(*channels, source="bench/fog.csv", notes=("rate 10 Hz from column 'time [s]'",), **choices):
    provenance = {"allanite": "1.2.3", "python": "3.12.0", "source": source, "sha256": "ab" * 32}
    return Study(tuple(channels), Recipe(**choices), (), tuple(notes), provenance)


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


# the table


@rows("width", [80, 100, 120, 160])
def test_no_line_of_the_table_is_wider_than_the_terminal(study, width):
    text = table(study, width=width)
    assert max(map(len, text.splitlines())) <= width
    assert "\x1b" not in text
    assert all(line == line.rstrip() for line in text.splitlines())


def test_the_table_of_a_study(study):
    line = next(line for line in table(study, width=160).splitlines() if "angle random walk" in line)
    assert "°/√h" in line
    assert "rad/√s" not in table(study, width=160)
    assert "rad/√s" in page(study)
    # values carry the digits of their interval
    assert "0.0500  0.0480 .. 0.0520" in table(study)
    assert "1.454 × 10⁻⁵" in page(study)
    assert "1.396 × 10⁻⁵ … 1.513 × 10⁻⁵" in page(study)
    # absent terms are said to be not identified with their limit
    text = table(study)
    assert re.search(r"Q  quantization noise +below 0.12 +arcsec +absent", text)
    assert re.search(r"K  rate random walk +below 2.1 +°/h/√h +absent", text)
    assert "one-sided 95 % upper limit" in text
    # the ramp has a sign
    assert "-0.400  -0.480 .. -0.320" in table(study)
    # what was assumed and what made it stand in the header
    text = table(study)
    for word in ("bench/fog.csv", "rate 10 Hz from column 'time [s]'", "ab" * 32, "allanite 1.2.3", "1 min"):
        assert word in text.replace("60 s", "1 min")
    # a refused channel says why
    assert "no result: 'gyro_x' never changes; check the plug" in table(study)
    # colour is for terminals
    assert "\x1b[" in table(study, color=True)


def test_other_tables():
    channel = channel_of()
    estimates = (absent("Q", 2e-5, "arcsec"), *channel.fit.estimates[1:])
    fit = Fit(estimates, "whittle", channel.fit.signal, model=channel.fit.model)
    assert "below 2.0e-5" in table(study_of(Channel(channel.record, channel.quality, Noise(fit))))
    # warnings and a model that explains nothing stand above the numbers
    text = table(study_of(channel_of(p=1e-9, reasons=("a line at 3 Hz",), warnings=("12 spikes",))))
    first = text.index("no model of these terms explains the record")
    assert first < text.index("angle random walk")
    assert text.index("12 spikes; look at them") < text.index("angle random walk")
    assert "a line at 3 Hz" in text
    # names cannot drive the terminal
    text = table(study_of(channel_of("\x1b[31mred[/bold]")), color=False)
    assert "\x1b" not in text
    assert "[31mred[/bold]" in text
    # an accelerometer has its own words
    accelerometer = signal_named("accelerometer")
    assert title("N", accelerometer) == "velocity random walk"
    assert title("K", accelerometer) == "acceleration random walk"
    assert printed_unit("ug/sqrt(Hz)") == "µg/√Hz"


# words


def test_a_page_says_nothing_twice():
    """In the part of a channel: one grade with all warnings, two densities, no coefficient in the data sheet."""
    channel = channel_of(reasons=("heavy tails",), warnings=(say("one outlier"), say("coarse steps")))
    text = page(study_of(channel))
    part = text[text.index('<section id="s1"') : text.index('<section id="method"')]
    shown = re.sub("<svg.*?</svg>", "", part[: part.index("<details")], flags=re.DOTALL)
    assert shown.count("xplained") == 1
    assert re.findall("<li>(.*?)</li>", shown)[:3] == [
        "Heavy tails",
        "One outlier; look at them",
        "Coarse steps; look at them",
    ]
    assert shown.count("noise density") == 2
    assert 'class="alert"' not in text
    for found in ("0.0500", "angle random walk", "1.454 × 10⁻⁵"):
        assert shown.count(f">{found}<") == 1, found


# figures


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


def test_limits_add_to_the_report_of_one_file():
    study = study_of(channel_of(), refused())
    limits = Specification.from_toml({"limits": {"N": {"max": "0.04 deg/sqrt(h)"}}})
    batch = Batch((unit_of("fog.csv", study, limits),), {}, 0.95, limits)
    alone, judged = view_of(study).face(study, 0.95), view_of(batch).face(batch, 0.95)
    assert [sheet.name for sheet in judged.sheets] == [sheet.name for sheet in alone.sheets]
    assert judged.how == alone.how
    added = [part for part in judged.parts if part not in alone.parts]
    assert len(judged.parts) == len(alone.parts) + len(added)
    assert any("0.04 deg/sqrt(h)" in cell for part in added if isinstance(part, Table) for cell in part.rows[0])


def test_figures_of_a_study(study):
    assert len(plot(study).axes) == 1
    assert len(plot(study_of(channel_of("x"), channel_of("y"), channel_of("z"))).axes) == 3
    # labels give the coefficients
    texts = [text.get_text() for text in plot(study).axes[0].texts]
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
    assert plot(study).axes[0].get_title("right") == "explained, p = 0.4"
    # a bare curve can be drawn
    curve = study.channels[0].curve
    bare = replace(curve, name="", noise=None, law=None)
    assert plot(bare).axes[0].get_xlabel() == "averaging time τ (s)"
    assert plot(bare.to("deg/s")).axes[0].get_ylabel().endswith("(°/s)")
    # what cannot be drawn is said
    with pytest.raises(al.UsageError, match="a int cannot be shown: compute a result first"):
        plot(3)
    with pytest.raises(al.UsageError, match="no samples"):
        plot(type(study_of(refused())).from_dict(study_of(refused()).to_dict()))
    # drawing leaves the settings of matplotlib alone
    import matplotlib as mpl

    before = dict(mpl.rcParams)
    plot(study)
    assert dict(mpl.rcParams) == before


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
    for name in ("a", "b"):
        plot(study, path=tmp_path / f"{name}.{suffix}")
    first = (tmp_path / f"a.{suffix}").read_bytes()
    assert first == (tmp_path / f"b.{suffix}").read_bytes()
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


# the page


@pytest.fixture(scope="module")
def text():
    channels = (channel_of(HOSTILE, p=1e-9, warnings=(HOSTILE,)), channel_of("b$x_{\\evil$"), refused(f"r{HOSTILE}"))
    return page(study_of(*channels, source=f"bench/{HOSTILE.replace('/', '')}.csv", notes=(HOSTILE,), unit="deg/h"))


def test_the_page_loads_nothing_and_tells_the_whole_story(text):
    tags = Tags(text).tags
    names = {tag for tag, _ in tags}
    assert not names & {"iframe", "img", "object", "embed", "base", "form"}
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
    tags = Tags(text).tags
    assert [tag for tag, _ in tags].count("svg") == 22
    ids = [attrs["id"] for _, attrs in tags if "id" in attrs]
    # within one picture matplotlib names a glyph once; between pictures the prefix differs
    assert len(ids) == len(set(ids))
    # hostile names come out as text
    assert text.count("<script") == 1
    assert HOSTILE in "".join(Tags(text).text)
    # the page tells the whole story
    words = "".join(Tags(text).text)
    for part in (
        "DOES NOT FIT", "below 2.1", "Whittle", "upper limit",
        'unit = "deg/h"', "ab" * 32, "1.2.3", "What was assumed", "No result",
    ):  # fmt: skip
        assert part in words, part
    assert "<math" in text
    # warnings stand above the numbers of the channels
    assert text.index('class="alert" role="note"') < text.index('id="s1"')


def test_what_machines_read(tmp_path, study):
    recipe = Recipe(about=('serial=a"b\\',), channels=("x", "ü"), taus=(1.0, 10.0), band=(0.1, 5.0), rate=100.0)
    (tmp_path / "recipe.toml").write_text(toml(recipe.to_dict()), encoding="utf-8")
    assert Recipe.load(tmp_path / "recipe.toml") == recipe
    # json is strict and complete
    broken = study_of(channel_of(), refused())
    m = broken.channels[0].curve.m.size
    object.__setattr__(broken.channels[0].curve, "law", lambda level: tuple(np.full(m, math.nan) for _ in range(3)))
    data = json.loads(to_json(broken), parse_constant=pytest.fail)
    assert data["channels"][0]["curves"][0]["edf"] == [None] * m
    assert json.loads(to_json(study)) == json.loads(json.dumps(study.to_dict()))
    # csv holds the curves in the units of data sheets
    rows = list(csv.DictReader(io.StringIO(to_csv(study))))
    curve = study.channels[0].curve
    assert len(rows) == curve.m.size
    assert rows[0]["unit"] == "deg/h"
    assert float(rows[3]["deviation"]) == pytest.approx(curve.to("deg/h").deviation[3])
    assert float(rows[3]["low"]) < float(rows[3]["deviation"]) < float(rows[3]["high"])


# for machines


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
