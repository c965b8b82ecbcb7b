"""The pages of the statistics."""

from fractions import Fraction
from pathlib import Path

import numpy as np

import allanite as al
from allanite.core.model import term
from allanite.reporting.sheet import printed_unit
from allanite.statistics import STATISTICS
from allanite.statistics.row import Statistic
from generate.markdown import figure, sections, table

EXAMPLE = (("Q", 3.0, "arcsec"), ("N", 0.1, "deg/sqrt(h)"), ("B", 1.0, "deg/h"), ("K", 10.0, "deg/h/sqrt(h)"))
"""The noise of the curves on the pages of the statistics."""

BLIND = {1: "nothing but a constant angle", 2: "a constant rate", 3: "a constant rate and a rate ramp"}


def statistic_index() -> list[str]:
    """All statistics side by side."""
    rows = [
        (f"[{name}]({name}.md)", row.title, BLIND.get(row.order, ""), _reach(row), row.cost)
        for name, row in STATISTICS.items()
    ]
    return [
        "# Statistics", "",
        "Each is `allanite.deviation(record, name)` and `allanite deviation FILE --statistic name`, for any averaging "
        "factors, and `allanite.dynamic` in sliding windows. Angle x and rate are the same record: "
        "$x_{i+1} = x_i + \\tau_0 y_i$; an averaging factor m means $\\tau = m \\tau_0$.", "",
        *table(("", "name", "blind to", "longest τ", "cost"), rows),
        "```{toctree}", ":hidden:", "", *STATISTICS, "```",
    ]  # fmt: skip


def _reach(row: Statistic) -> str:
    """The longest averaging time as a part of the record."""
    n = 1_000_000
    part = Fraction(row.largest(n) * row.tau_factor / n).limit_denominator(100)
    return "the record" if part == 1 else f"{part} of the record"


def statistic_page(name: str, folder: Path) -> list[str]:
    """What the statistic is, and what an example looks like in it."""
    row = STATISTICS[name]
    return [
        f"# {name}: {row.title}", "", row.meaning, "", f"$$\n{row.formula}\n$$", "",
        *figure(_statistic_figure(name, folder), f"{row.title} of an example"),
        "The same simulated record on the pages of all statistics: "
        + ", ".join(f"{symbol} = {value:g} {printed_unit(unit)}" for symbol, value, unit in EXAMPLE)
        + ". Lines are what the model and each of its terms lead one to expect.", "",
        *sections(row, [("use", "When to use it"), ("limits", "Limits"), ("cost", "Cost")]),
        "## Facts", "",
        *table(("", ""), [
            ("blind to", BLIND.get(row.order, "")),
            ("windows", "start at every sample" if row.overlapped else "start every m samples"),
            ("τ", "m τ₀" if row.tau_factor == 1 else f"{row.tau_factor:g} m τ₀"),
            ("longest τ", _reach(row)),
        ]),
        "```python", f'curve = al.deviation(record, "{name}", taus="octave")', "```", "",
        "## Source", "", row.reference + ".",
    ]  # fmt: skip


def _statistic_figure(name: str, folder: Path) -> Path:
    """One simulated record in this statistic, with what its true terms lead one to expect."""
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
