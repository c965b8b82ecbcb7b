"""The tables and the figure of the page of methods: one simulated record of each sensor, read by all of them."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np

import allanite as al
from generate.markdown import table, table_of

RATE, SIZE, SEED = 100.0, 2**18, 1

TRUTHS = {
    "MEMS": al.N(0.005, "deg/sqrt(s)") + al.B(0.002, "deg/s") + al.K(3e-4, "deg/s/sqrt(s)"),
    "FOG": al.Q(0.4, "arcsec")
    + al.N(3, "deg/h*sqrt(s)")
    + al.B(1, "deg/h")
    + al.K(0.09, "deg/h/sqrt(s)")
    + al.R(0.002, "deg/h/s"),
    "RLG": al.Q(0.5, "arcsec") + al.N(0.18, "arcsec/sqrt(s)") + al.B(0.05, "deg/h"),
}
"""As in benchmarks/methods.py."""


def methods_page(folder: Path) -> list[str]:
    """What is included by docs/methods.md."""
    fits = {name: _fits(model) for name, model in TRUTHS.items()}
    lines = [
        *table(("method", "what it does", "reads", "error / bound"), _about()),
        "## One record of each sensor", "",
        f"{SIZE} samples at {RATE:g} Hz, seed {SEED}; the true terms were asked for and no others. A method that gives "
        "intervals has those of 95 % in brackets.", "",
    ]  # fmt: skip
    for name, by_method in fits.items():
        lines += [f"### {name}", "", *_values(TRUTHS[name], by_method)]
    path = _figure(fits, folder)
    return [*lines, f"![Coefficients of every method over their true values](generated/{path.name})", ""]


def _fits(model: al.Model) -> dict[str, al.Fit]:
    record = al.simulate(model, SIZE, RATE, rng=np.random.default_rng(SEED))
    terms = "".join(t.symbol for t in model)
    return {method: al.identify(record, method, terms=terms) for method in al.identification.METHODS}


def _about() -> Iterable[tuple[str, ...]]:
    for name, row in al.identification.METHODS.items():
        yield f"`{name}`", row.title, ", ".join(row.allowed) or row.statistic or "the record", row.efficiency


def _values(model: al.Model, fits: dict[str, al.Fit]) -> list[str]:
    units = {t.symbol: model.signal.sheet[t.row.power] for t in model}
    headings = ["", *(f"{symbol}, {unit}" for symbol, unit in units.items())]
    truth = ["**true**", *(f"**{t.to(units[t.symbol]):.4g}**" for t in model)]
    rows = [
        [f"`{name}`", *(fit[s].words(unit).replace(f" {unit}", "") for s, unit in units.items())]
        for name, fit in fits.items()
    ]
    return table(headings, [truth, *rows])


def _figure(fits: dict[str, dict[str, al.Fit]], folder: Path) -> Path:
    """Value over truth, a panel a sensor."""
    from allanite.reporting import printing, style

    path = folder / "methods.svg"
    with printing.look():
        figure = printing.new_figure(7.6, 3.4)
        for ax, (name, by_method) in zip(figure.subplots(1, len(fits), sharey=True), fits.items(), strict=True):
            for i, method in enumerate(by_method):
                _dots(ax, i, TRUTHS[name], by_method[method])
            ax.axvline(1.0, color=style.INK, lw=0.6)
            ax.set(xscale="log", xlim=(0.3, 3.4), title=name, xlabel="value / truth")
            ax.set_xticks([0.5, 1, 2], labels=["0.5", "1", "2"])
            ax.set_xticks([], minor=True)
            ax.set_yticks(range(len(by_method)), labels=list(by_method))
            ax.set_ylim(len(by_method) - 0.5, -0.5)
            ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.1), ncols=5, handletextpad=0.1, columnspacing=0.6)
    path.write_bytes(printing.encode(figure, "svg"))
    return path


def _dots(ax, row: int, model: al.Model, fit: al.Fit) -> None:

    for j, t in enumerate(model):
        e = fit[t.symbol]
        y, color = row + 0.12 * (j - (len(model.terms) - 1) / 2), t.row.color
        low, high = e.interval(0.95)
        if e.value is not None and np.isfinite(low):
            ax.plot([max(low, 1e-9) / t.value for low in (low, high)], [y, y], color=color, lw=1)
        at = np.clip(e.value / t.value, 0.31, 3.3) if e.value is not None and e.value > 0 else np.nan
        outside = at in (0.31, 3.3)
        ax.plot(at, y, (("<" if at < 1 else ">") if outside else "o"), ms=3.5, mew=0, color=color)
        if row == 0:
            ax.plot(np.nan, np.nan, "o", ms=3.5, mew=0, color=color, label=t.symbol)


def efficiencies(results: Path, section: str) -> list[str]:
    """Error over the bound from a section of a table of benchmarks, a row a term and a column a method."""
    rows = table_of(results, section)
    ways = list(dict.fromkeys(row["method"] for row in rows))
    keys = list(dict.fromkeys((row["sensor"], row["n"], row["term"], row["bound %"]) for row in rows))
    rmse = {(row["sensor"], row["n"], row["term"], row["bound %"], row["method"]): row["rmse"] for row in rows}
    return table(
        ("sensor", "n", "term", "bound %", *ways), [(*key, *(rmse[(*key, way)] for way in ways)) for key in keys]
    )
