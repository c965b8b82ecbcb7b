"""Sigma-tau figures: deviation against averaging time, with band, model and terms; amplitude spectral density."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.display_units import readable_unit
from allanite.core.fit import Fit
from allanite.core.model import Model, Term
from allanite.core.spectrum import SIDES, Spectrum
from allanite.identification.likelihood.filters import FILTERS
from allanite.phrases.phrase import join, say
from allanite.reporting import style, words
from allanite.reporting.digits import printable
from allanite.reporting.sketch.panel import Panel
from allanite.statistics import statistic_named
from allanite.terms import TERMS, WHITE

from . import drawing
from .panels import CurvePanel, columns_of, points, printed_model, samples, span
from .terms import draw_model

MIN_FILLED_EDF = 2.0  # equivalent degrees of freedom below which a point is drawn open
WEIGHS = 0.37  # frequency times averaging time where the Allan deviation is most sensitive

FILTERED = say("lowered by the filter")
"""What is shaded at averaging times at which the filter, which the model includes, has not settled."""

LANDMARKS = ((60.0, "1 min"), (3600.0, "1 h"), (86400.0, "1 d"))

MIN_PANEL_INCHES, MAX_PANEL_INCHES = 3.2, 5.6  # height of a panel, inches
MIN_LABELLED_INCHES = 4.5  # width of a panel with room for intervals and slopes, inches

Span = tuple[tuple[float, float], tuple[float, float]]


@style.plotted
def plot_panels(
    new_figure: style.NewFigure, panels: Sequence[CurvePanel], *, level: float = 0.95, titled: bool = True
) -> style.Figure:
    """A panel for each curve, with its name if `titled`: sensors side by side, their channels below each other."""
    columns = columns_of(panels)
    rows = max(map(len, columns))
    wide = min(6.4 if len(panels) == 1 else 5.8, new_figure.room / len(columns) - 0.8)
    spans = [(panel.unit, span(panel)) for panel in panels]
    sizes = [_scaled([extent for unit, extent in spans if unit == column[0].unit], wide) for column in columns]
    width = sum(size[1] for size in sizes) + 0.8 * len(columns)
    above = 1.1 if wide > MIN_LABELLED_INCHES else 1.6  # the legend has more lines in a narrow figure
    height = rows * (max(size[2] for size in sizes) + (0.3 if titled else 0.0)) + above
    figure = new_figure(width, height)
    grid = figure.subplots(rows, len(columns), squeeze=False, width_ratios=[size[1] for size in sizes])
    for ax in grid.flat:
        ax.set_axis_off()
    for j, column in enumerate(columns):
        axes = list(grid[: len(column), j])
        (tau, deviation), inches, _, equal = sizes[j]
        for ax, panel in zip(axes, column, strict=True):
            ax.set_axis_on()
            ax.set(xscale="log", yscale="log", xlim=tau, ylim=deviation)
            if equal:
                ax.set_aspect("equal", adjustable="box", anchor="N")
            style.plain_ticks(ax.xaxis)
            style.plain_ticks(ax.yaxis, most=3000)
            _draw_panel(ax, panel._replace(brief=wide < MIN_LABELLED_INCHES), level)
            if titled:
                drawing.draw_titles(ax, (panel.name, panel.facts), panel.fit, room=72 * inches)
            ax.tick_params(labelbottom=ax is axes[-1])
        axes[-1].set_xlabel(drawing.TIME)
    drawing.draw_legend(figure)
    return figure


def _scaled(spans: Sequence[Span], wide: float) -> tuple[Span, float, float, bool]:
    """Common ranges of both axes, the width and height in inches, and whether these make the decades equal."""
    (shortest, longest), (low, high) = ((min(s[i][0] for s in spans), max(s[i][1] for s in spans)) for i in (0, 1))
    across, up = math.log10(longest / shortest), math.log10(high / low)
    inches = min(wide / across, MAX_PANEL_INCHES / up)
    if up * inches < MIN_PANEL_INCHES:  # a flat panel has no room for labels
        low, up = high / 10 ** (MIN_PANEL_INCHES / inches), MIN_PANEL_INCHES / inches
    # where a deviation falls by many decades, as that of a periodic record does, a column would have no room either
    width = max(across * inches, min(MIN_PANEL_INCHES, wide))
    return ((shortest, longest), (low, high)), width, up * inches, width == across * inches


def _draw_panel(ax: style.Axes, panel: CurvePanel, level: float) -> None:
    style.grid(ax)
    placed = _draw_landmarks(ax, 8.0 if panel.brief else 7.5)
    drawn, title = points(panel, level), statistic_named(panel.curve.statistic).title
    if panel.model is None:
        if drawn.low is not None and drawn.high is not None:
            label = words.interval(level)
            ax.fill_between(drawn.tau, drawn.low, drawn.high, color=style.DATA, alpha=0.18, lw=0, zorder=2, label=label)
        # an unknown number of degrees of freedom is not many
        few = np.zeros(drawn.tau.size, dtype=bool) if drawn.edf is None else ~(drawn.edf >= MIN_FILLED_EDF)
        size = 3.4 if drawn.tau.size <= 150 else 0.0
        ax.plot(drawn.tau, drawn.deviation, color=style.DATA, lw=0.9, zorder=4)
        dots: dict[str, Any] = {"ls": "-" if size == 0 else "", "marker": "o", "color": style.DATA, "zorder": 4}
        ax.plot(drawn.tau[~few], drawn.deviation[~few], ms=size, mew=0, label=title, **dots)
        if few.any():
            label = say("below {count:g} degrees of freedom", count=MIN_FILLED_EDF)
            ax.plot(drawn.tau[few], drawn.deviation[few], ms=3.6, mfc="white", mew=0.8, label=label, **dots)
    if panel.fit is not None:
        fit = panel.fit
        if fit.scope is not None and fit.valid is not None:
            # of a frequency, the averaging times at which it weighs most in the deviation
            shortest, longest = fit.scope.times
            masks = ((WEIGHS / high, WEIGHS / low) for low, high in fit.scope.masks)
            drawing.shade(ax, ((0.0, shortest),), FILTERED if fit.scope.filter else drawing.UNREAD)
            drawing.shade(ax, (*masks, (longest, math.inf)), drawing.UNREAD)
    draw_model(ax, panel, drawn, placed, level)
    if not panel.brief:
        _hint(ax, {"": panel}, level)
    ax.set_ylabel(drawing.with_unit(title, panel.unit))


def _hint(ax: style.Axes, panels: dict[str, CurvePanel], level: float) -> None:
    """Show the values of curves under the cursor, by what each is called."""
    texts: dict[float, list[str]] = {}
    for name, panel in panels.items():
        for tau, text in samples(panel, level).items():
            texts.setdefault(tau, []).append(join(": ", filter(None, (name, text))))
    between = ": " if len(panels) == 1 else "\n"
    hints = [join(between, (f"τ = {words.averaging(tau)}", *texts[tau])) for tau in sorted(texts)]
    if isinstance(ax, Panel):  # of a page
        ax.hint(sorted(texts), hints)


def _draw_landmarks(ax: style.Axes, size: float) -> list[drawing.LabelBox]:
    """Rules at a minute, an hour and a day; where their labels are."""
    (low, high), taken = ax.get_xlim(), []
    for tau, label in LANDMARKS:
        if low < tau < high / 1.2:
            ax.axvline(tau, color=style.OTHER, lw=0.7, ls=(0, (1, 2)), zorder=1)
            ax.annotate(label, (tau, 1), xycoords=("data", "axes fraction"), xytext=(2, -3), textcoords="offset points",
                va="top", fontsize=size, color=style.SOFT)  # fmt: skip
            taken.append(drawing.LabelBox(math.log(tau / low) / math.log(high / low) + 0.035, 0.965, 0.07, 0.05))
    return taken


MAX_BANDS = 3  # curves of a panel whose confidence bands can still be told apart


@style.plotted
def plot_overlay(new_figure: style.NewFigure, panels: Sequence[CurvePanel], *, level: float = 0.95) -> style.Figure:
    """A panel for each channel with all its statistics, or one for all of a single statistic; models are dashed."""
    # columns by unit, of panels by channel, of curves
    single = len({panel.curve.statistic for panel in panels}) == 1
    by_unit: dict[str, dict[str, list[CurvePanel]]] = {}
    for panel in panels:
        by_unit.setdefault(panel.unit, {}).setdefault("" if single else panel.name, []).append(panel)
    columns = [list(by_name.values()) for by_name in by_unit.values()]
    figure, grid = drawing.stacked(new_figure, [len(column) for column in columns])
    for column, axes in zip(columns, grid, strict=True):
        spans = [span(drawn)[0] for group in column for drawn in group]
        for ax, group in zip(axes, column, strict=True):
            ax.set(xscale="log", xlim=(min(low for low, _ in spans), max(high for _, high in spans)))
            called = _draw_group(ax, group, level)
            if math.isinf(new_figure.room):
                _hint(ax, called, level)
        axes[-1].set_xlabel(drawing.TIME)
    apart = single and len(columns) > 1 and all(len(group) > 1 for column in columns for group in column)
    drawing.draw_legend(figure, marks=False, apart=apart)
    return figure


def _draw_group(ax: style.Axes, group: Sequence[CurvePanel], level: float) -> dict[str, CurvePanel]:
    """Draw curves in one panel, and say what they are called."""
    spans = [span(panel)[1] for panel in group]
    ax.set(yscale="log", ylim=(min(low for low, _ in spans), max(high for _, high in spans)))
    style.plain_ticks(ax.xaxis)
    style.plain_ticks(ax.yaxis, most=3000)
    style.grid(ax)
    names, titles = (dict.fromkeys(texts) for texts in zip(*map(_called, group), strict=True))
    called: dict[str, CurvePanel] = {}
    for i, panel in enumerate(group):
        name, title = _called(panel)
        told = [part for part, known in ((name, names), (title, titles)) if len(known) > 1]
        label = join(", ", told) or title or name
        called[label] = panel
        _draw_curve(ax, panel, (i, label), level if len(group) <= MAX_BANDS else None)
    ax.set_title(next(iter(names)) if len(names) == 1 else "", loc="left", fontweight="bold", parse_math=False)
    what = next(iter(titles)) if len(titles) == 1 else say("deviation")
    ax.set_ylabel(drawing.with_unit(what, group[0].unit))
    return called


def _called(panel: CurvePanel) -> tuple[str, str]:
    return printable(panel.name), statistic_named(panel.curve.statistic).title


def _draw_curve(ax: style.Axes, panel: CurvePanel, label: tuple[int, str], level: float | None) -> None:
    i, text = label
    drawn = points(panel, level or 0.95)
    color, marker = style.SERIES[i % len(style.SERIES)], style.MARKERS[i % len(style.MARKERS)]
    if drawn.low is not None and drawn.high is not None and level is not None:
        ax.fill_between(drawn.tau, drawn.low, drawn.high, color=color, alpha=0.14, lw=0, zorder=2)
    size = 3.4 if drawn.tau.size <= 40 else 0.0
    ax.plot(drawn.tau, drawn.deviation, color=color, lw=1.1, marker=marker, ms=size, mew=0, zorder=3, label=text)
    if panel.fit is not None and panel.drawn is not None:
        tau = np.geomspace(drawn.tau[0], drawn.tau[-1], 200)
        ax.plot(tau, panel.whole(tau), color=color, lw=1.0, ls=(0, (5, 3)), zorder=2.5, label=drawing.EXPECTED)


MAX_BAND_POINTS = 200  # values that are drawn as points in a band; more are a line, and its band would hide it

SIDED = {"one": say("one-sided"), "two": say("two-sided")}  # words for the sides of a spectrum


@style.plotted
def plot_spectra(
    new_figure: style.NewFigure, spectra: Sequence[Spectrum], fits: Mapping[str, Fit], *, level: float = 0.95
) -> style.Figure:
    """One panel for each channel; sensors of different units side by side."""
    columns: dict[str, list[Spectrum]] = {}
    for spectrum in spectra:
        columns.setdefault(readable_unit(spectrum.unit), []).append(spectrum)
    figure, grid = drawing.stacked(new_figure, [len(column) for column in columns.values()])
    for axes, column in zip(grid, columns.values(), strict=True):
        lowest, highest = min(s.frequency[0] for s in column), max(s.rate / 2 for s in column)
        for ax, spectrum in zip(axes, column, strict=True):
            ax.set(xscale="log", xlim=(lowest / 1.3, highest * 1.15))
            shown, fit = spectrum.to(readable_unit(spectrum.unit)), fits.get(spectrum.name)
            f, amplitude = shown.frequency, shown.amplitude
            positive = amplitude[amplitude > 0] if amplitude.any() else np.ones(1)
            ax.set_yscale("log")
            ax.set_ylim(positive.min() / (5 if fit else 2), positive.max() * 2)
            style.plain_ticks(ax.xaxis, ax.yaxis)
            style.grid(ax)
            size, width = (3.0, 0.9) if f.size <= MAX_BAND_POINTS else (0.0, 0.5)
            if f.size <= MAX_BAND_POINTS:
                low, high = map(np.sqrt, shown.interval(level))
                label = words.interval(level)
                ax.fill_between(f, low, high, color=style.DATA, alpha=0.2, lw=0, zorder=2, label=label)
            label = say("spectrum")
            ax.plot(f, amplitude, color=style.DATA, lw=width, marker="o", ms=size, mew=0, zorder=3, label=label)
            drawing.draw_titles(ax, (spectrum.name,), fit, before=spectrum.method)
            model = None if fit is None else printed_model(fit)
            if fit is not None and model is not None:
                drawing.shade(ax, fit.scope.unread if fit.scope else (), drawing.UNREAD)
                _draw_model(ax, shown, (fit, model), level)
            sides, unit = SIDED[spectrum.sides], shown.amplitude_unit
            ax.set_ylabel(say("{sides} amplitude\nspectral density ({unit})", sides=sides, unit=unit))
        axes[-1].set_xlabel(say("frequency (Hz)"))
    drawing.draw_legend(figure, marks=False, columns=4)
    return figure


def _draw_model(ax: style.Axes, spectrum: Spectrum, fitted: tuple[Fit, Model], level: float) -> None:
    fit, model = fitted
    f = np.geomspace(ax.get_xlim()[0], spectrum.rate / 2, 300)
    behind = fit.scope.filter if fit.scope else None
    whole = _expected(spectrum, model, f)
    if behind is not None:
        whole = whole * np.sqrt(FILTERS[behind.row].gain(f / spectrum.rate, behind.cutoff / spectrum.rate))
    ax.plot(f, whole, color=style.INK, lw=1.3, zorder=4, label=drawing.MODEL)
    lines = {term.symbol: _expected(spectrum, term, f) for term in model if term.row.waveform is None}
    for symbol, line in lines.items():
        ax.plot(f, line, color=drawing.color_of(symbol), lw=1.2, ls=drawing.dashes(symbol), zorder=2.5)
    paths = {symbol: drawing.fractions(ax, drawing.pairs(f, line)) for symbol, line in lines.items()}
    curves = (drawing.pairs(spectrum.frequency, spectrum.amplitude), drawing.pairs(f, whole)[::4])
    avoid = drawing.together([*(drawing.fractions(ax, c) for c in curves), *(path[::4] for path in paths.values())])
    placed: list[drawing.LabelBox] = []
    for e in (e for e in fit if e.value is not None and e.symbol in lines):
        anchors = paths[e.symbol][drawing.by_share(lines[e.symbol], whole)]
        visible = anchors[((anchors > 0.01) & (anchors < 0.99)).all(axis=1)]
        if len(visible):
            text = drawing.label_of(e, level)
            if TERMS[e.symbol].slope == WHITE:
                # its level on the axis, which depends on the convention: ``√2 N = 10.1 deg/h/√Hz, one-sided``
                factor, unit = math.sqrt(SIDES[spectrum.sides]), spectrum.amplitude_unit
                name = "N" if factor == 1 else "√2 N"
                size = f"{name} = {factor * e.to(unit):.3g} {unit}"
                text = join("", (text, "\n", join(", ", (size, SIDED[spectrum.sides]))))
            placed.append(drawing.draw_label(ax, (e.symbol, text), visible[::8], avoid, placed))


def _expected(spectrum: Spectrum, model: Model | Term, f: FloatArray) -> FloatArray:
    """Amplitude spectral density of a model at other frequencies; NaN where it is zero."""
    density = spectrum.expected(model, f)
    return np.sqrt(np.where(density > 0, density, np.nan))
