"""The figure of a spectrum: amplitude spectral density against frequency, and the terms of the model."""

import math
from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from allanite.core.arrays import FloatArray
from allanite.core.display_units import readable_unit
from allanite.core.fit import Fit
from allanite.core.model import Model, Term
from allanite.core.spectrum import SIDES, Spectrum
from allanite.identification.likelihood.filters import FILTERS
from allanite.phrases.phrase import join, say
from allanite.reporting import style, words
from allanite.terms import TERMS, WHITE

from . import drawing
from .panels import printed_model

MAX_BAND_POINTS = 200  # values that are drawn as points in a band; more are a line, and its band would hide it


SIDED = {"one": say("one-sided"), "two": say("two-sided")}  # words for the sides of a spectrum


@style.plotted
def plot_spectra(
    new_figure: style.NewFigure, spectra: Sequence[Spectrum], fits: Mapping[str, Fit], *, level: float = 0.95
) -> Figure:
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


def _draw_model(ax: Axes, spectrum: Spectrum, fitted: tuple[Fit, Model], level: float) -> None:
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
