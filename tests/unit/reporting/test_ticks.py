"""Ticks that are drawn at once are those that matplotlib draws one by one, pixel by pixel."""

import io

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.backends.backend_svg import RendererSVG
from matplotlib.font_manager import FontProperties
from matplotlib.image import imread

import allanite as al
from allanite.reporting import style
from allanite.reporting.measure import measured
from allanite.reporting.ticks import drawn_at_once

X = np.geomspace(0.01, 3e4, 50)


def new(rows=1, **options):
    with style.look():
        figure = style.new_figure(6.0, 4.0)
        return figure, figure.subplots(rows, 1, squeeze=False, **options)[:, 0]


def logarithmic():
    figure, (ax,) = new()
    ax.loglog(X, 1 / np.sqrt(X))
    style.grid(ax)
    style.plain_ticks(ax.xaxis, ax.yaxis)
    ax.set(xlabel="averaging time", ylabel="deviation")
    return figure


def two_and_five():
    figure, (ax,) = new()
    ax.loglog([3, 40], [0.11, 0.4])
    style.plain_ticks(ax.xaxis, ax.yaxis)
    return figure


def shared():
    figure, panels = new(2, sharex="col")
    panels[0].plot([0, 1], [1e9 + 1, 1e9 + 2])
    panels[1].plot([0, 1e7], [0, 1e-7])
    for ax in panels:
        style.grid(ax)
    panels[1].set_xlabel("time (s)")
    return figure


def named():
    figure, (ax,) = new()
    ax.barh([0, 1, 2], [3, 1, 2])
    ax.set_yticks([0, 1, 2], ["one", "two", "a long name"])
    ax.tick_params(axis="x", labelrotation=30, top=True, labeltop=True)
    ax.yaxis.set_label_position("right")
    ax.set_ylabel("name")
    return figure


def second_scale():
    figure, (ax,) = new()
    ax.plot([1, 2], [3, 4])
    ax.secondary_xaxis("top", functions=(lambda x: 2 * x, lambda x: x / 2)).set_xlabel("twice")
    ax.inset_axes((0.1, 0.6, 0.3, 0.3)).plot([0, 1])
    return figure


def colored():
    figure, (ax,) = new()
    shades = ax.pcolormesh(np.arange(7.0).reshape(1, 7) ** 2)
    figure.colorbar(shades, ax=ax, label="power")
    ax.invert_yaxis()
    return figure


def without_axes():
    figure, panels = new(2)
    panels[0].set_axis_off()
    panels[1].xaxis.set_visible(False)
    return figure


def pixels(figure):
    buffer = io.BytesIO()
    with style.look(), mpl.rc_context({"savefig.dpi": 100}):
        figure.savefig(buffer, format="png")
    buffer.seek(0)
    return imread(buffer)


@pytest.mark.parametrize(
    "make",
    [logarithmic, two_and_five, shared, named, second_scale, colored, without_axes],
    ids=lambda make: make.__name__,
)
def test_ticks_are_drawn_as_one_by_one(make):
    expected = pixels(make())
    figure = make()
    visible = [axis.get_visible() for ax in figure.axes for axis in (ax.xaxis, ax.yaxis)]
    with drawn_at_once(figure):
        drawn = pixels(figure)
    # a grid line may be drawn above or below another
    assert (np.abs(drawn - expected).max(axis=2) > 0.1).mean() < 1e-4
    assert [axis.get_visible() for ax in figure.axes for axis in (ax.xaxis, ax.yaxis)] == visible
    assert not any("Ticks" in type(artist).__name__ for ax in figure.axes for artist in ax.get_children())


@pytest.mark.slow("figures, drawn twice")
def test_figures_of_results():
    record = al.simulate(al.N(0.1, "deg/sqrt(h)") + al.B(1.0, "deg/h"), 20_000, 100.0, rng=np.random.default_rng(1))
    plan = al.plan(al.N(0.1, "deg/sqrt(h)"), 100.0)
    for value in (al.deviation(record), al.spectrum(record), al.dynamic(record), plan):
        figure = al.plot(value)
        expected = pixels(figure)
        with drawn_at_once(figure):
            drawn = pixels(figure)
        assert (np.abs(drawn - expected).max(axis=2) > 0.1).mean() < 1e-3


def test_texts_are_as_large_as_the_renderer_finds_them():
    renderer = RendererSVG(100, 100, io.StringIO())
    for words, size, is_math in (("10 s", 8.0, False), ("10 s", 9.0, False), ("$10^{-3}$", 9.0, True)):
        font = FontProperties(size=size)
        for _ in range(2):
            assert measured(words, font, is_math) == renderer.get_text_width_height_descent(words, font, is_math)
        font.set_size(2 * size)
        once = measured(words, FontProperties(size=size), is_math)[0]
        assert measured(words, font, is_math)[0] == pytest.approx(2 * once)
