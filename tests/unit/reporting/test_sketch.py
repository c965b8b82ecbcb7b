"""Figures of pages: what they draw is what matplotlib draws."""

import re
import subprocess
import sys
from dataclasses import replace
from itertools import combinations, pairwise
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import example, given, settings, strategies as st
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import TextToPath
from matplotlib.ticker import FuncFormatter, LogLocator, MultipleLocator
from tests import examples
from tests.rows import rows

import allanite as al
from allanite.reporting import style
from allanite.reporting.digits import digits
from allanite.reporting.figures import panels_of, plot_overlay, plot_panels
from allanite.reporting.figures.drawing import draw_titles, ratio_axis
from allanite.reporting.figures.panels import MAX_HINTS, printed_model
from allanite.reporting.matplotlib_svg import drawn
from allanite.reporting.printing import printed
from allanite.reporting.sheet import Drawing, Fold
from allanite.reporting.sketch.axis import Side, Unsketched, plain
from allanite.reporting.sketch.chart import Chart
from allanite.reporting.sketch.panel import place_in
from allanite.reporting.sketch.svg import wide
from allanite.reporting.views import view_of

SVG = "{http://www.w3.org/2000/svg}"
BLUE = "#2e5c94"


def chart(width=5.0, height=3.0):
    """An empty figure."""
    return Chart(width, height, "#1a1a1a", "#555b63")


def places(svg):
    """Level lines of words with their left, top, right and bottom, by the widths of their letters."""
    for text in ElementTree.fromstring(svg).iter(f"{SVG}text"):
        if text.get("transform") is None:
            look = text.get("style")
            size = float(re.search(r"([\d.]+)px", look)[1])
            width, foot = size * wide(text.text, bold="bold" in look), float(text.get("y"))
            anchor = re.search(r"text-anchor: (\w+)|$", look)[1]
            left = float(text.get("x")) - width * {"middle": 0.5, "end": 1.0}.get(anchor, 0.0)
            yield text.text, (left, foot - 0.7 * size, left + width, foot)


def overlapping(svg):
    """Pairs of lines of words that lie on each other."""
    return [
        (one, other)
        for (one, a), (other, b) in combinations(places(svg), 2)
        if min(a[2], b[2]) - max(a[0], b[0]) > 0.5 and min(a[3], b[3]) - max(a[1], b[1]) > 1.0
    ]


def drawings(parts):
    """The figures of a page, in its folds too."""
    for part in parts:
        yield from drawings(part.parts) if isinstance(part, Fold) else [part] if isinstance(part, Drawing) else []


@pytest.fixture(scope="module")
def figures(study):
    """The figures of the page of an analysis."""
    face = view_of(study).face(study, 0.95)
    return list(drawings([*face.parts, *(part for sheet in face.sheets for part in sheet.parts)]))


@pytest.fixture(scope="module")
def study():
    """Three channels of two sensors."""
    model = al.Model("N 0.1 deg/sqrt(h), K 20 deg/h/sqrt(h)")
    made = [al.simulate(model, 4000, 20.0, rng=np.random.default_rng(i), name=f"g{i} $x_{{<&") for i in range(2)]
    other = al.simulate(al.N(100, "ug/sqrt(Hz)"), 4000, 20.0, rng=np.random.default_rng(9), name="ax")
    return al.analyze(al.Recording((*made, other)))


@pytest.mark.slow("takes more than half a second")
def test_every_figure_of_an_analysis_is_sketched_and_no_words_lie_on_others(figures):
    assert len(figures) > 15
    for drawing in figures:
        assert isinstance(drawing.draw().sketched(), Chart)
        assert not overlapping(drawn(drawing).text)


NAMES = st.text("abcgxyz_[] 0123456789陀螺", min_size=1, max_size=90).filter(str.strip)


@settings(deadline=None, max_examples=examples(30))
@given(NAMES, st.floats(3.0, 12.0))
def test_a_name_of_any_length_leaves_room_for_the_grade(study, name, inches):
    fit = study.channels[0].fit
    made = chart(inches, 3.0)
    panel = made.subplots()
    panel.set(xlim=(0.0, 1.0), ylim=(0.0, 1.0))
    draw_titles(panel, (name, "20 Hz, 3.3 min"), fit)
    svg = made.svg()
    assert not overlapping(svg)
    assert all(right <= made.width + 4 for _, (_, _, right, _) in places(svg))
    shown = "".join(text for text, _ in places(svg))
    assert "".join(name.split()) in "".join(shown.split())


@pytest.mark.slow("takes more than half a second")
def test_values_stand_under_the_cursor_and_each_sensor_has_its_own_legend(study):
    panels = panels_of(study)
    picture = drawn(Drawing(lambda: plot_panels(panels[:1], titled=False), "curve"))
    (group,) = [part for part in ElementTree.fromstring(picture.text).iter(f"{SVG}g") if part.get("aria-hidden")]
    hints, curve = [title.text for title in group.iter(f"{SVG}title")], study.channels[0].curve
    assert len(hints) == min(curve.tau.size, MAX_HINTS)
    shown = curve.to("deg/h")
    size = digits(shown.deviation[0], *(limit[0] for limit in shown.interval(0.95))).pretty()
    assert re.fullmatch(rf"τ = 0.05 s: {re.escape(size)} °/h; model [\d.]+", hints[0])
    assert "<title>" not in picture.narrow.text
    gyros, _ = plot_overlay([*panels, panels[-1]]).sketched().axes
    assert gyros.legends[0].labels == ["g0 $x_{<&", "g1 $x_{<&", "expected by the model"]


def test_a_term_that_is_absent_is_not_drawn(study):
    fit = study.channels[0].fit
    wider = replace(fit, model=al.Model((*fit.model, al.B(5, "deg/h"))))
    assert "B" in {term.symbol for term in wider.valid} - {e.symbol for e in fit if e.valued}
    assert tuple(printed_model(wider)) == tuple(printed_model(fit))


@rows(("far", "end"), [(1, 3.0), (4, 34.5)])
def test_ratios_have_an_axis_about_one_and_few_of_them_beyond_it_an_arrow(far, end):
    panel, ratio = chart().subplots(), np.r_[np.ones(30), np.full(far, 30.0)]
    shown = ratio_axis(panel, np.arange(1.0, ratio.size + 1), ratio)
    assert panel.get_ylim() == pytest.approx((1 / end, end))
    assert shown.max() == pytest.approx(min(end, 30.0))
    arrows = [mark for mark in panel.marks if getattr(mark, "marker", None)]
    assert [mark.x.tolist() for mark in arrows] == ([[31.0]] if far == 1 else [])


def test_error_bars_reach_as_far_as_those_of_matplotlib():
    x, y, error = np.array([1.0, 2.0, 4.0]), np.array([3.0, 5.0, 4.0]), [[1.0, 0.5, 2.0], [2.0, 0.1, 1.0]]
    look = {"fmt": "o", "ms": 3.6, "mew": 0, "color": BLUE, "elinewidth": 1.0, "capsize": 2.0, "label": "ratio"}
    made = chart()
    panel, axes = made.subplots(), Figure().subplots()
    panel.errorbar(x, y, error, **look)
    container = axes.errorbar(x, y, error, **look)
    bars, low, high, points = (np.column_stack([mark.x, mark.y]) for mark in panel.marks)
    data, caps, (segments,) = container
    np.testing.assert_allclose(bars.reshape(3, 3, 2)[:, :2], segments.get_segments())
    for own, other in zip((low, high, points), (*caps, data), strict=True):
        np.testing.assert_allclose(own, other.get_xydata())
    assert panel.get_legend_handles_labels()[1] == ["ratio"]
    assert panel.get_ylim() == pytest.approx(axes.get_ylim())
    assert made.svg().count("<path") > 4


def test_names_of_the_user_are_no_formulas_and_no_markup(figures):
    assert any("g0 $x_{&lt;&amp;" in drawn(drawing).text for drawing in figures)


def test_what_only_matplotlib_draws_is_left_to_it():
    @style.plotted
    def draw(new_figure):
        figure = new_figure(4.0, 3.0)
        figure.subplots().scatter([1.0, 2.0], [1.0, 2.0])
        return figure

    assert isinstance(printed(draw()), Figure)
    assert "<path" in drawn(Drawing(draw, "points")).text


@rows("ask", [
    lambda panel: panel.scatter([1], [1]), lambda panel: panel.plot([1], [1], color=BLUE, drawstyle="steps"),
    lambda panel: panel.plot([1], [1], "x", color=BLUE), lambda panel: panel.set_aspect("equal"),
    lambda panel: panel.xaxis.set_major_locator(MultipleLocator(2.0)), lambda panel: panel.xaxis.axis_date(),
    lambda panel: panel.set_title("a", pad=3), lambda panel: panel.legend(loc="lower left"),
    lambda panel: panel.figure.subfigures(2),
    lambda panel: (panel.plot([1], [1], color="tab:blue"), panel.figure.svg()),
])  # fmt: skip
def test_what_is_not_known_is_refused(ask):
    panel = chart().subplots()
    with pytest.raises(Unsketched):
        ask(panel)


def side_of(scale, *limits, across=True):
    """An axis of a chart."""
    side = Side(across=across)
    side.scale, side.limits = scale, limits
    return side


EDGES = st.floats(-250, 250).map(lambda x: 10.0**x)


@example(ends=[1e249, 1e-231], log=True, across=False)
@settings(deadline=None, max_examples=examples(60))
@given(ends=st.lists(EDGES, min_size=2, max_size=2, unique=True), log=st.booleans(), across=st.booleans())
def test_ticks_are_within_the_view_and_named(ends, log, across):
    side = side_of("log" if log else "linear", min(ends), max(ends), across=across)
    found = side.ticks(300.0, 9.0)
    places = [*found.major, *found.minor]
    assert all(-1e-9 <= share <= 1 + 1e-9 for share in side.share(places))
    assert len(found.major) <= 20
    assert len(found.labels) == len(found.major) == len(set(found.major))
    assert not set(found.major) & set(found.minor)


@rows("scale", ["linear", "log"])
@rows(("low", "high"), [(0.13, 7.9), (1.0, 1000.0), (3e-5, 8e4), (12.0, 13.5), (0.9, 1.3)])
def test_ticks_are_those_of_matplotlib(scale, low, high):
    figure = Figure(figsize=(5.0, 3.0))
    axes = figure.subplots()
    axes.set(xscale=scale, xlim=(low, high))
    length = axes.bbox.width * 72 / figure.dpi
    side = side_of(scale, low, high)
    first, last = low * (1 - 1e-9), high * (1 + 1e-9)
    expected = [at for at in axes.get_xticks() if first <= at <= last]
    assert side.ticks(length, 10.0).major == pytest.approx(expected)
    fine = [at for at in axes.get_xticks(minor=True) if first <= at <= last]
    assert side.ticks(length, 10.0).minor == pytest.approx(fine)


@rows("scale", ["linear", "log"])
def test_points_are_where_matplotlib_has_them(scale):
    x, y = np.array([1.0, 3.0, 20.0]), np.array([2.0, 50.0, 7.0])
    panel = chart().subplots()
    panel.set(xscale=scale, yscale=scale)
    panel.plot(x, y, color=BLUE)
    axes = Figure().subplots()
    axes.set(xscale=scale, yscale=scale)
    axes.plot(x, y)
    assert panel.get_xlim() == pytest.approx(axes.get_xlim())
    assert panel.get_ylim() == pytest.approx(axes.get_ylim())
    expected = axes.transAxes.inverted().transform(axes.transData.transform(np.column_stack([x, y])))
    across, down = place_in(panel, (0.0, 0.0, 1.0, 1.0))(x, y, "data")
    np.testing.assert_allclose(np.column_stack([across, 1 - down]), expected, atol=1e-9)


@settings(deadline=None, max_examples=examples(40))
@given(st.lists(st.floats(), max_size=30), st.sampled_from(["linear", "log"]))
@example([2.790249414259265e283, 1.837351888371521e-213], "log")
def test_any_values_make_a_figure(values, scale):
    made = chart()
    panel = made.subplots()
    panel.set(xlabel="x", ylabel="y", yscale=scale)
    x = np.arange(len(values), dtype=float)
    panel.plot(x, values, color=BLUE, marker="o", label="a")
    panel.fill_between(x, values, 0.0, color=BLUE, alpha=0.2)
    with np.errstate(all="ignore"):
        root = ElementTree.fromstring(made.svg())
    assert not re.search(r"nan|inf\b", ElementTree.tostring(root, encoding="unicode"))


@settings(deadline=None, max_examples=examples(40))
@given(st.floats(2.0, 12.0), st.floats(1.5, 8.0), st.integers(1, 3), st.integers(1, 3))
def test_panels_do_not_overlap_and_are_on_the_page(width, height, rows, columns):
    made = chart(width, height)
    grid = made.subplots(rows, columns, squeeze=False)
    for panel in grid.flat:
        panel.plot([0.0, 1000.0], [0.0, 1.0], color=BLUE)
        panel.set(xlabel="time (s)", ylabel="rate (deg/h)")
        panel.set_title("name", loc="left")
    root = ElementTree.fromstring(made.svg())
    framed = [rect for rect in root.iter(f"{SVG}rect") if rect.get("style")]
    boxes = [[float(rect.get(key)) for key in ("x", "y", "width", "height")] for rect in framed]
    assert len(boxes) == rows * columns
    if width >= 2.5 * columns and height >= 2.0 * rows:
        assert all(x >= 0 and y >= 0 and x + w <= made.width and y + h <= made.height for x, y, w, h in boxes)
        lefts = sorted({x for x, *_ in boxes})
        assert all(b - a > boxes[0][2] for a, b in pairwise(lefts))


def test_ticks_read_as_those_of_matplotlib():
    made = chart()
    panel = made.subplots()
    panel.set(xscale="log", xlim=(1e-6, 10.0), ylim=(-0.5, 0.5))
    style.plain_ticks(panel.xaxis)
    words = {text.text for text in ElementTree.fromstring(made.svg()).iter(f"{SVG}text")}
    assert {"10⁻⁵", "0.001", "10", "−0.4"} <= words
    # letters are as wide as matplotlib has them
    font = FontProperties(family="DejaVu Sans", size=9)
    for text in ("averaging time τ (s)", "N = 0.31 deg/√h", "скорость"):
        width, *_ = TextToPath().get_text_width_height_descent(text, font, False)
        assert 9 * wide(text) == pytest.approx(width, rel=0.05)
    # a formatter and a locator of the figures are taken
    side = side_of("log", 0.1, 100.0, across=False)
    side.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    side.set_major_formatter(FuncFormatter(lambda v, _: f"<{v:g}>"))
    assert "<5>" in side.ticks(200.0, 9.0).labels
    # a power of ten and a name stand at different ends
    made = chart()
    panel = made.subplots()
    panel.plot([0.0, 1.0], [-1.1e6, -1.0e6], color=BLUE)
    style.title(panel, "accelerometer z")
    svg = made.svg()
    assert any("×10⁶" in text for text, _ in places(svg))
    assert not overlapping(svg)
    axes = Figure().subplots()
    style.title(axes, "accelerometer z")
    assert axes.yaxis.get_offset_text().get_horizontalalignment() == "right"


@rows("places, labels, beside", [
    ([0.0, 0.5, 1.0], ["0.0", "0.5", "1.0"], ""), ([-2.0, 0.0, 2.0], ["−2", "0", "2"], ""),
    ([1e8, 2e8], ["1", "2"], "$×10^{8}$"), ([0.0], ["0"], ""), ([], [], ""),
])  # fmt: skip
def test_numbers_at_ticks(places, labels, beside):
    assert plain(places) == (labels, beside)


def test_a_page_needs_no_figure_of_matplotlib():
    code = (
        "import sys, numpy as np, allanite as al; from allanite.reporting import page\n"
        "curve = al.deviation(al.Record(np.sin(np.arange(500) ** 2), rate=1.0, unit='deg/s'))\n"
        "sys.exit('<svg' not in page(curve) or 'matplotlib.figure' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
