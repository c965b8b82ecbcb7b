"""A rate study for people and machines: table, figure, page, JSON."""

import math
import re
import textwrap
from collections.abc import Iterator
from importlib.resources import files
from pathlib import PurePath

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from allanite.core.units import unit_of
from allanite.rate import RATE_ESTIMATORS, Experiment
from allanite.rate.study import RateChannel, RateStudy
from allanite.statistics import expected

from . import style, words

_LATEX = (
    (r"\hat\Omega", "Ω̂"), (r"\Omega", "Ω"), (r"\sum", "Σ"), (r"\cos", "cos"), (r"\theta", "θ"), (r"\bar t", "t̄"),
    (r"\min", "min"), (r"\lfloor", "⌊"), (r"\rfloor", "⌋"), (r"\varphi", "φ"), ("^T", "ᵀ"), ("^{-1}", "⁻¹"),
    ("_{U, φ}", " over U, φ:"), ("_i", "ᵢ"), ("_j", "ⱼ"), ("_k", "ₖ"), ("_0", "₀"),
)  # fmt: skip
"""What the formulas of the methods hold beyond those of the terms."""

MOST_MARKED = 40
"""Intervals up to which each is marked."""


def rate_text(study: RateStudy, width: int = 120) -> str:
    """The study as text, in ASCII, for a terminal of `width` columns."""
    lines = [f"file      {study.provenance.get('source') or '(data in memory)'}"]
    lines += [f"{'' if i else 'assumed':<10}{note}" for i, note in enumerate(study.notes)]
    for channel in study.channels:
        lines += ["", *_channel_lines(channel, study)]
    return "".join(f"{words.printable(part)}\n" for line in lines for part in _fitted(line, width))


def _fitted(line: str, width: int) -> list[str]:
    """A line, wrapped if it is prose: rows of tables, which hold runs of blanks, stay whole."""
    prose = line.lstrip()
    if len(line) <= width or "   " in prose:
        return [line]
    indent = " " * (len(line) - len(prose))
    return textwrap.wrap(
        prose, max(width, 40), initial_indent=indent, subsequent_indent=indent + "  ", break_long_words=False
    )


def _channel_lines(channel: RateChannel, study: RateStudy) -> Iterator[str]:
    yield f"{channel.record.name or 'channel'}  {words.about(channel.record)}"
    for alert in channel.alerts:
        yield f"  ! {alert}"
    if channel.refusal:
        yield f"  ! no result: {channel.refusal}"
    for line in sentences(channel, study):
        yield f"  {line}"
    if channel.experiment is not None and channel.experiment.start.size > 1:
        yield from _table(channel.experiment)
    if channel.estimates:
        yield from (f"  {e.method:<12} {e.words(level=study.recipe.level)}" for e in channel.estimates)


def sentences(channel: RateChannel, study: RateStudy) -> Iterator[str]:
    """What was found of a channel, in sentences."""
    found, unit = channel.experiment, channel.record.signal.sheet[0]
    if channel.fit is not None:
        yield f"noise: {channel.fit.model}"
    elif study.choices.model is not None:
        yield f"noise as given: {study.choices.model}"
    if found is None:
        return
    if found.ranking is not None:
        yield f"in {words.duration(found.duration)}: {found.ranking.verdict}"
    if found.start.size > 1:
        reference = found.reference / unit_of(unit).factor
        said = f"the true rate, {reference:.6g} {unit}" if found.known else f"their mean, {reference:.6g} {unit}"
        yield f"{found.start.size} intervals of {words.duration(found.duration)}; errors against {said}"
    if found.drift:
        yield found.drift
    yield from _wander(found)
    yield from found.notes
    yield from (f"{method} is left out: {why}" for method, why in found.left_out.items())
    if channel.bias is not None:
        yield f"bias by reversal: {channel.bias.words(level=study.recipe.level)}"
    if channel.north is not None:
        yield channel.north.words()


def _wander(found: Experiment) -> Iterator[str]:
    """Why neighbouring intervals scatter more than each is measured."""
    if found.ranking is None or found.start.size == 1:
        return
    wandering = [t.symbol for t in found.ranking.model if t.row.slope >= 0]
    if wandering:
        unit = found.signal.sheet[0]
        both = math.sqrt(float(expected(found.ranking.model, "adev", found.duration)[0])) / unit_of(unit).factor
        yield (
            f"predicted is the error of each interval's own mean rate; {', '.join(wandering)} moves that from interval "
            f"to interval, so that neighbouring averages differ by {both:.3g} {unit} (their Allan deviation)"
        )


def _table(found: Experiment) -> Iterator[str]:
    headings, rows = shown(found)
    columns = [[h, *(row[i] for row in rows)] for i, h in enumerate(headings)]
    widths = [max(map(len, column)) for column in columns]
    for row in (headings, *rows):
        first, *rest = row
        yield "  " + "  ".join([first.ljust(widths[0]), *(c.rjust(w) for c, w in zip(rest, widths[1:], strict=True))])


def shown(found: Experiment) -> tuple[list[str], list[list[str]]]:
    """The table of an experiment, rounded to three digits of its least scatter."""
    unit = found.signal.sheet[0]
    _, rows = found.rows(unit)
    headings = ["method", f"std, {unit}", "68 %", "neighbours", "3 sigma", "mean error", "worst", "predicted"]
    least = min((row[2] for row in rows if row[2] > 0), default=1.0)
    digits = max(0, 2 - math.floor(math.log10(least)))
    text = []
    for method, mean, std, low, high, neighbours, bound, worst, predicted in rows:
        said = f"{predicted:.{digits}f}" if math.isfinite(predicted) else "not predicted"
        numbers = [f"{v:.{digits}f}" for v in (std, neighbours, bound)]
        limits = f"{low:.{digits}f} .. {high:.{digits}f}"
        text.append([method, numbers[0], limits, *numbers[1:], f"{mean:+.{digits}f}", f"{worst:+.{digits}f}", said])
    return headings, text


def plot_rate(channel: RateChannel) -> Figure:
    """Errors over the intervals, and the accuracy against the measuring time."""
    found = channel.experiment
    assert found is not None  # noqa: S101 - channels without one are not drawn
    with style.look():
        figure = style.new_figure(7.2, 5.6 if channel.by_duration else 3.2)
        axes = figure.subplots(2 if channel.by_duration else 1, 1, squeeze=False)[:, 0]
        _draw_errors(axes[0], found)
        if channel.by_duration:
            _draw_accuracy(axes[1], channel.by_duration)
        axes[0].set_title(words.printable(found.name), loc="left", fontweight="bold", parse_math=False)
    return figure


def _draw_errors(ax: Axes, found: Experiment) -> None:
    unit = found.signal.sheet[0]
    factor = unit_of(unit).factor
    t = (found.start + found.duration / 2) / 60
    style.grid(ax)
    ax.axhline(0.0, color=style.INK, lw=0.8, zorder=2)
    for method, errors in zip(found.methods, found.errors / factor, strict=True):
        marker = "o" if t.size <= MOST_MARKED else ""
        ax.plot(t, errors, color=RATE_ESTIMATORS[method].color, lw=0.9, marker=marker, ms=2.5, label=method, zorder=3)
    ax.set(xlabel="time after the start of the record (min)", ylabel=f"error ({words.printed_unit(unit)})")
    ax.legend(ncols=len(found.methods), loc="lower center", bbox_to_anchor=(0.5, 1.0), columnspacing=1.0)


def _draw_accuracy(ax: Axes, series: tuple[Experiment, ...]) -> None:
    unit = series[0].signal.sheet[0]
    factor = unit_of(unit).factor
    style.grid(ax)
    for method in series[0].methods:
        kept = [(e.duration, e.scatter(method)) for e in series if method in e.methods]
        times, color = [time for time, _ in kept], RATE_ESTIMATORS[method].color
        ax.plot(times, [s.deviation / factor for _, s in kept], "o", color=color, ms=3.5, label=method, zorder=4)
        predicted = np.array([s.predicted for _, s in kept]) / factor
        if np.isfinite(predicted).any():
            ax.plot(times, predicted, color=color, lw=1.0, zorder=3)
    ax.set(xscale="log", yscale="log", xlabel="measuring time (s)")
    ax.set_ylabel(f"standard deviation ({words.printed_unit(unit)})\npoints measured, lines predicted")
    style.plain_ticks(ax.xaxis, ax.yaxis)


def rate_page(study: RateStudy) -> str:
    """The study as one self-contained HTML file."""
    from jinja2 import Environment, StrictUndefined
    from markupsafe import Markup

    from .html import formula, svg

    folder = files("allanite.reporting")
    look = re.search(r"<style>.*?</style>", folder.joinpath("page.html.j2").read_text(encoding="utf-8"), re.DOTALL)
    assert look is not None  # noqa: S101 - the page of a study holds the style of all pages
    env = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    env.filters["clean"], env.filters["formula"] = words.printable, lambda latex: formula(_plain(latex))
    channels = [
        {
            "name": c.record.name or "channel",
            "about": words.about(c.record),
            "alerts": c.alerts,
            "refusal": c.refusal,
            "sentences": list(sentences(c, study)),
            "table": shown(c.experiment) if c.experiment is not None and c.experiment.start.size > 1 else None,
            "estimates": [(e.method, e.words(level=study.recipe.level)) for e in c.estimates],
            "figure": svg(plot_rate(c), f"rate{i}", "errors of all methods") if c.experiment is not None else "",
        }
        for i, c in enumerate(study.channels)
    ]
    content = {
        "style": Markup(look.group()),  # noqa: S704 - our own template's
        "name": PurePath(study.provenance["source"]).name or "data in memory",
        "channels": channels,
        "methods": RATE_ESTIMATORS.values(),
        "notes": study.notes,
        "provenance": study.provenance,
    }
    return env.from_string(folder.joinpath("rate.html.j2").read_text(encoding="utf-8")).render(content)


def _plain(latex: str) -> str:
    for code, sign in _LATEX:
        latex = latex.replace(code, sign)
    return latex


def rate_figure(study: RateStudy, path: str) -> bytes:
    """The figure of the first channel that was measured, in the format of the path's suffix."""
    figure = plot_rate(next(c for c in study.channels if c.experiment is not None))
    return style.encode(figure, PurePath(path).suffix.lower().lstrip("."))
