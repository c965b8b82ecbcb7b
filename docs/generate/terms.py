"""The pages of the noise terms."""

from pathlib import Path

import numpy as np

import allanite as al
from allanite.core.model import term
from allanite.core.units import SIGNALS, convert
from allanite.reporting.digits import printed_unit
from allanite.terms import TERMS
from generate.markdown import figure, sections, shown, table, typeset

ABBREVIATIONS = {
    "N": "ARW; VRW of accelerometers", "B": "BI, flicker", "K": "RRW", "R": "RR", "GM": "exponentially correlated",
    "F": "FPM of clocks", "GM2": "damped oscillation",
}  # fmt: skip
"""What data sheets call the terms, beside their names."""


def _title(symbol: str) -> str:
    """The name, with what it is called for short."""
    short = ABBREVIATIONS.get(symbol)
    return f"{TERMS[symbol].title} ({short})" if short else TERMS[symbol].title


def _short(symbol: str) -> str:
    """The formula, where it fits into a column."""
    formula = TERMS[symbol].formula
    return f"${formula}$" if len(formula) < 60 else f"[on its page]({symbol}.md)"


def term_index() -> list[str]:
    """All terms side by side."""
    rows = [
        (f"[{s}]({s}.md)", _title(s), _short(s), _slope(row.slope), _read_off(symbol=s),
         *(printed_unit(signal.sheet[row.power]) for signal in SIGNALS[:2]))
        for s, row in TERMS.items()
    ]  # fmt: skip
    return [
        "# Noise terms", "",
        "A model is a sum of these. Each enters every statistic through one function, its structure function, so any "
        "model has an exact expected curve in any statistic. For an accelerometer read velocity for angle and "
        "acceleration for rate.", "",
        "![The five terms of IEEE Std 952 and their sum](../slopes.svg)", "",
        *table(("", "name", "Allan variance", "slope", "read off", "gyroscope", "accelerometer"), rows),
        "The slope is that of the deviation. The unit of τ is that of the coefficient: hours for deg/√h, seconds for "
        "rad/√s. [What a coefficient means in a sensor](devices.md) has likely causes by device.", "",
        "```{toctree}", ":hidden:", "", *TERMS, "devices", "```",
    ]  # fmt: skip


def _spectrum(density: str) -> list[str]:
    if not density:
        return []
    return ["## Spectrum", "", "Two-sided power spectral density of the rate:", "", f"$$\n{density}\n$$", ""]


def _slope(value: float) -> str:
    """A multiple of one half."""
    if np.isnan(value):
        return "none"
    halves = {-1: "−1", -0.5: "−1/2", 0: "0", 0.5: "+1/2", 1: "+1"}
    return halves.get(value, f"{value:+g}")


def _read_off(symbol: str) -> str:
    """Where the asymptote has the value of the coefficient; or at which share of it a level line lies."""
    row = TERMS[symbol]
    if row.transient:
        return "the record itself"
    if np.isnan(row.level):
        return "its top"
    if row.per_sample:
        return f"depends on the rate, {np.sqrt(row.level):.3f} {symbol} at one sample of 1 s"
    if not np.isclose(row.level * row.read_at ** (2 * row.slope), 1.0):
        return f"lies at {np.sqrt(row.level):.3f} {symbol}"
    whole = round(row.read_at, 9).is_integer()
    return f"τ = {row.read_at:g}" if whole else f"τ = √{row.read_at**2:.3g}"


def term_page(symbol: str, folder: Path) -> list[str]:
    """What the term is, what it looks like, and its units."""
    row = TERMS[symbol]
    units = [
        (signal.name, f"`{signal.si[row.power]}`", f"`{signal.sheet[row.power]}`",
         shown(convert(1.0, signal.sheet[row.power], signal.si[row.power])))
        for signal in SIGNALS[:2]
    ]  # fmt: skip
    return [
        f"# {symbol}: {_title(symbol)}", "", typeset(row.meaning[0].upper() + row.meaning[1:]) + ".", "",
        f"$$\n{row.formula}\n$$", "", *_line(symbol), "",
        *figure(_term_figure(symbol, folder), _caption(row.title)),
        *sections(row, [("origin", "Where it comes from"), ("advice", "Reading and using it")]),
        *_spectrum(row.density),
        "## Units", "", *table(("sensor", "SI", "data sheet", "1 data-sheet unit in SI"), units),
        "```python", f'al.{symbol}({row.typical:g}, "{SIGNALS[0].sheet[row.power]}"{_arguments(symbol)})',
        "```", "",
        "## Source", "", f"{_source(row.reference)}. [Theory](../../theory.md) has the derivation.",
    ]  # fmt: skip


def _caption(title: str) -> str:
    return f"Left: a simulated rate of {title}. Right: Allan deviation of 20 simulated records and its expectation"


def _source(reference: str) -> str:
    """Where the formula stands, editions and annex included."""
    editions = "IEEE Std 952-1997 (R2008), Annex C, and IEEE Std 952-2020"
    return typeset(reference.replace("IEEE Std 952", editions))


def _line(symbol: str) -> list[str]:
    """The straight line that the term is, if it is one."""
    row, place = TERMS[symbol], _read_off(symbol)
    if row.transient:
        return ["What it adds to a curve depends on the record's length: it has no line of its own."]
    if row.per_sample:
        return [f"The Allan deviation falls nearly with slope {_slope(row.slope)} against τ; its height {place}."]
    if np.isnan(row.slope):
        return ["The Allan deviation is not a straight line but a hump."]
    where = f"At {place} the line of this slope has the value of {symbol}." if "=" in place else f"The line {place}."
    return [f"The Allan deviation has slope {_slope(row.slope)} against τ. {where}"]


def _arguments(symbol: str) -> str:
    wanted = [p for p in TERMS[symbol].parameters if p.default is None]
    return "".join(f", {p.name}={p.typical:g}" for p in wanted)


def _term_figure(symbol: str, folder: Path) -> Path:
    """A simulated rate, and the deviation of twenty such records with the exact expectation."""
    from allanite.reporting import printing, style

    row, signal = TERMS[symbol], SIGNALS[0]
    unit = signal.sheet[row.power]
    noise = term(symbol, row.typical, unit, tuple(p.typical for p in row.parameters))
    rng = np.random.default_rng(1)
    records = [al.simulate(noise, 20_000, 10.0, rng=rng) for _ in range(20)]
    record = records[0]
    curves = [al.deviation(each, "oadev", taus="log", noise=None).to("deg/h") for each in records]
    path = folder / f"{symbol}.svg"
    with printing.look():
        drawn = printing.new_figure(7.6, 2.9)
        left, right = drawn.subplots(1, 2)
        time = np.arange(record.size) / record.rate
        left.plot(time, np.degrees(record.values) * 3600, color=style.DATA, lw=0.4, rasterized=True)
        left.set(xlabel="time (s)", ylabel="rate (deg/h)")
        right.set(xscale="log", yscale="log", xlabel="averaging time τ (s)", ylabel="Allan deviation (deg/h)")
        tau = curves[0].tau
        for curve in curves:
            label = "20 records" if curve is curves[0] else None
            right.plot(tau, curve.deviation, color=style.DATA, alpha=0.3, lw=0.7, label=label)
        expected = np.degrees(np.sqrt(al.expected(noise, "oadev", tau, rate=10.0, size=20_000))) * 3600
        right.plot(tau, expected, color=style.INK, lw=1.8, label="expected")
        style.grid(right)
        style.plain_ticks(right.xaxis, right.yaxis)
        right.legend()
    path.write_bytes(printing.encode(drawn, "svg"))
    return path
