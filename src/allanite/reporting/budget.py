"""A budget for people and machines: table, figure, page, CSV."""

import csv
import io
from collections.abc import Iterator
from pathlib import PurePath
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from allanite.reporting.sheet import printable, printed_unit
from allanite.signals import StageNoise, TorqueScale
from allanite.signals.study import BudgetChannel, BudgetStudy

from . import style, words
from .tables import prose_lines, table_lines

HEADINGS = ("stage", "bits", "full scale", "step", "makes", "adds", "measured", "unit", "share", "bits enough", "codes",
            "missing", "clipped")  # fmt: skip


def render(study: BudgetStudy, width: int = 120) -> str:
    """The study as text, in ASCII."""
    out = [f"file      {study.provenance.get('source') or '(data in memory)'}"]
    out += [f"{'' if i else 'assumed':<10}{note}" for i, note in enumerate((*_scale(study), *study.notes))]
    for channel in study.channels:
        out += ["", *_lines(channel, width)]
    return "".join(f"{printable(line)}\n" for line in out)


def _scale(study: BudgetStudy) -> list[str]:
    scale = study.path.scale
    if scale is None:
        return []
    if isinstance(scale, TorqueScale):
        return [f"{scale}, of {scale.sides:g} coil side(s)"]
    return [f"K_i = {scale:.6g} rad/s per A, as given"]


def _lines(channel: BudgetChannel, width: int) -> Iterator[str]:
    yield f"{channel.record.name or 'channel'}  {words.about(channel.record)}"
    for alert in alerts(channel):
        yield from prose_lines(alert, width, "  ! ")
    if channel.budget is None:
        return
    for sentence in sentences(channel):
        yield from prose_lines(sentence, width)
    yield ""
    yield from table_lines(HEADINGS, [row(s) for s in channel.budget.stages])


def alerts(channel: BudgetChannel) -> list[str]:
    """What must stand above the numbers."""
    refusal = [f"no result: {channel.refusal}"] if channel.refusal else []
    findings = [] if channel.budget is None else [str(f) for f in channel.budget.findings]
    return [*refusal, *findings, *channel.alerts]


def sentences(channel: BudgetChannel) -> Iterator[str]:
    """What the budget says of each stage."""
    if channel.budget is None:
        return
    for s in channel.budget.stages:
        name = printable(s.stage.name)
        adds = f"{name} adds {s.symbol} = {number(s.to(s.coefficient))} {s.sheet_unit}"
        if s.measured is None:
            limit = (
                "" if s.limit is None else f"; {s.symbol} was not found, below {number(s.to(s.limit))} {s.sheet_unit}"
            )
            yield f"{adds}{limit}."
        elif s.matters:
            yield f"{adds}, {percent(s.share)} of the square of what was measured: more bits would help ({s.enough})."
        else:
            yield f"{adds}, {percent(s.share)} of the square of what was measured: more bits would change nothing."


def row(s: StageNoise) -> list[str]:
    """A stage in print."""
    seen = ("", "") if s.codes is None else (str(s.codes.distinct), str(s.codes.missing))
    measured = number(s.to(s.measured)) if s.measured is not None else f"< {number(s.to(s.limit))}" if s.limit else ""
    return [
        s.stage.name, str(s.stage.bits),
        f"+-{s.stage.full_scale:g} {s.stage.unit}", f"{s.stage.step:.4g} {s.stage.unit}", s.symbol,
        number(s.to(s.coefficient)), measured, s.sheet_unit, percent(s.share),
        "" if s.enough is None else str(s.enough), *seen, str(s.clipped),
    ]  # fmt: skip


def number(value: float | None) -> str:
    """Four digits; empty where there is none."""
    return "" if value is None else f"{value:.4g}"


def percent(share: float | None) -> str:
    """A share."""
    return "" if share is None else f"{100 * share:.2g} %"


def plot(channel: BudgetChannel) -> Figure:
    """What each stage adds by its bits, beside what was measured."""
    with style.look():
        figure = style.new_figure(6.4, 3.8)
        ax = figure.subplots()
        _draw(ax, channel)
    return figure


def _draw(ax: Axes, channel: BudgetChannel) -> None:
    assert channel.budget is not None  # noqa: S101 - channels without one are not drawn
    stages = channel.budget.stages
    # one unit to an axis: what the first stage makes
    shown = [s for s in stages if s.symbol == stages[0].symbol]
    bits = range(max(1, min(s.stage.bits for s in shown) - 6), max(s.stage.bits for s in shown) + 7)
    style.grid(ax)
    for s, color, marker in zip(shown, style.SERIES * 9, style.MARKERS * 9, strict=False):
        at = s.to(s.coefficient) or 0.0
        ax.plot(bits, [at * 2.0 ** (s.stage.bits - b) for b in bits], color=color, lw=1.1)
        ax.plot([s.stage.bits], [at], marker, color=color, ms=7, label=f"{printable(s.stage.name)}, as it is")
    known = shown[0].measured if shown[0].measured is not None else shown[0].limit
    if known is not None:
        label = "measured" if shown[0].measured is not None else "not found: limit"
        level = shown[0].to(known) or 0.0
        ax.axhline(level, color=style.INK, lw=1.2, label=label)
        ax.axhline(level / 10, color=style.INK, lw=0.9, ls=(0, (5, 3)), label="1 % of its square")
    unit = printed_unit(shown[0].sheet_unit)
    ax.set(yscale="log", xlabel="bits", ylabel=f"{shown[0].symbol} by rounding ({unit})")
    style.plain_ticks(ax.yaxis)
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    ax.set_title(printable(channel.record.name), loc="left", fontweight="bold", parse_math=False)
    ax.legend(loc="best")


def figure(study: BudgetStudy, suffix: str) -> bytes:
    """The figure of the first channel with a budget, in the format of the suffix."""
    shown = next(channel for channel in study.channels if channel.budget is not None)
    return style.encode(plot(shown), suffix.lower().lstrip("."))


def page(study: BudgetStudy) -> str:
    """The study as one self-contained HTML file."""
    from .html import svg

    env = Environment(
        loader=PackageLoader("allanite", "reporting"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    env.filters["clean"], env.filters["minus"] = printable, _printed
    channels = [
        {
            "name": c.record.name or "channel",
            "about": words.about(c.record),
            "alerts": alerts(c),
            "sentences": list(sentences(c)),
            "rows": [row(s) for s in c.budget.stages] if c.budget else [],
            "doubt": c.budget is None or any(s.matters for s in c.budget.stages),
            "figure": svg(plot(c), f"budget{i}", "noise of rounding by bits") if c.budget else "",
        }
        for i, c in enumerate(study.channels)
    ]
    content: dict[str, Any] = {
        "name": PurePath(study.provenance.get("source", "")).name or "data in memory",
        "channels": channels,
        "headings": HEADINGS,
        "notes": (*_scale(study), *study.notes),
        "provenance": study.provenance,
    }
    return env.get_template("budget.html.j2").render(content)


def _printed(text: str) -> str:
    """A cell with the signs of mathematics."""
    return printed_unit(text.replace("+-", "±").replace("-", "−"))


def to_csv(study: BudgetStudy) -> str:
    """The table of all channels, unrounded."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    found = [(c.record.name, *c.budget.rows()) for c in study.channels if c.budget is not None]
    writer.writerow(["channel", *found[0][1]])
    for name, _, rows in found:
        writer.writerows([name, *("" if cell is None else cell for cell in cells)] for cells in rows)
    return out.getvalue()
