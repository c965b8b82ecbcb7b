"""The pages of the statistics."""

import re
from fractions import Fraction
from pathlib import Path

import numpy as np

import allanite as al
from allanite.core.model import term
from allanite.reporting.digits import printed_unit
from allanite.statistics import STATISTICS
from allanite.statistics.row import Statistic
from generate.markdown import figure, sections, table, typeset

EXAMPLE = (("Q", 3.0, "arcsec"), ("N", 0.1, "deg/sqrt(h)"), ("B", 1.0, "deg/h"), ("K", 10.0, "deg/h/sqrt(h)"))
"""The noise of the curves on the pages of the statistics."""

BLIND = {1: "a constant angle", 2: "a constant rate", 3: "a constant rate and a rate ramp"}


def statistic_index() -> list[str]:
    """All statistics side by side."""
    rows = [(f"[{name}]({name}.md)", row.title, _reach(row), typeset(row.use)) for name, row in STATISTICS.items()]
    return [
        "# Statistics", "",
        "Each is `al.deviation(record, name)` and `allanite deviation FILE --statistic name`, for any averaging "
        "factors, and `al.dynamic` in sliding windows. Angle x and rate y are the same record: "
        "$x_{i+1} = x_i + \\tau_0 y_i$. An averaging factor m means $\\tau = m \\tau_0$; T is the duration of "
        "the record. "
        "[Choosing a statistic](../../choosing_statistic.md) says which one to use.", "",
        *table(("", "name", "longest τ", "use it for"), rows),
        "```{toctree}", ":hidden:", "", *STATISTICS, "```",
    ]  # fmt: skip


def _reach(row: Statistic) -> str:
    """The longest averaging time as a part of the duration T."""
    n = 1_000_000
    part = Fraction(row.largest(n) * row.tau_factor / n).limit_denominator(100)
    return "T" if part == 1 else f"{part} T"


def statistic_page(name: str, folder: Path) -> list[str]:
    """What the statistic is, and what an example looks like in it."""
    row = STATISTICS[name]
    return [
        f"# {name}: {row.title} ({_short(name)})", "", typeset(row.meaning), "", *_formula(name), "",
        *figure(_statistic_figure(name, folder), f"{row.title} of a simulated record, and what its model expects"),
        "The simulated record is the same on the pages of all statistics: "
        + ", ".join(f"{symbol} = {value:g} {printed_unit(unit)}" for symbol, value, unit in EXAMPLE)
        + ". Lines are the exact expectations of the model and of each of its terms.", "",
        *sections(row, [("use", "When to use it"), ("limits", "Limits"), ("cost", "Cost")]),
        "## Facts", "",
        *table(("", ""), [
            ("insensitive to", BLIND.get(row.order, "")),
            ("windows", "start at every sample" if row.overlapped else "start every m samples"),
            ("τ", "m τ₀" if row.tau_factor == 1 else f"{row.tau_factor:g} m τ₀"),
            ("longest τ", _reach(row)),
        ]),
        "```python", f'curve = al.deviation(record, "{name}", taus="octave")', "```", "",
        "## Source", "", typeset(row.reference) + ".",
    ]  # fmt: skip


SHORT = {"haar": "WV", "theo1": "Thêo1", "theobr": "ThêoBR", "theoh": "ThêoH", "tierms": "TIE rms"}
"""Abbreviations in print that are not the name in capitals."""

LEFT = {"haar": "", "mtie": r"\mathrm{MTIE}^2(\tau) = ", "tierms": r"\mathrm{TIE}_\mathrm{rms}^2(\tau) = "}
"""Left-hand sides of the formulas of what is not a variance; that of haar is in its formula."""


def _short(name: str) -> str:
    """The abbreviation in print."""
    return SHORT.get(name, name.upper())


def _formula(name: str) -> list[str]:
    """The variance, its left-hand side included; words behind it become a line of text."""
    formula, _, words = STATISTICS[name].formula.partition(r", \quad e: ")
    side = LEFT.get(name, r"\sigma^2(\tau) = ")
    meaning = re.sub(r"\\text\{(.*?)\}", r"\1", words).replace(" 3m ", "$3m$")
    return ["$$", side + formula, "$$", *(["", f"where *e* is the {meaning}."] if meaning else [])]


def _statistic_figure(name: str, folder: Path) -> Path:
    """One simulated record in this statistic, with the expectation of its true terms."""
    model = al.Model(tuple(term(*part) for part in EXAMPLE))
    record = al.simulate(model, 16_384, 1.0, rng=np.random.default_rng(2), name="example")
    curve = al.deviation(record, name, taus="octave")
    truth = tuple(al.Estimate(t.symbol, t.signal, t.value, None, "identified", None, "truth") for t in model)
    path = folder / f"{name}.svg"
    try:
        al.plot(curve, al.Fit(truth, "truth", model.signal, model), path=path)
    except al.UsageError:  # a statistic without an expectation, such as a maximum, has no lines to draw
        al.plot(curve, path=path, force=True)
    return path
