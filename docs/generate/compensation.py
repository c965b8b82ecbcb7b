"""Before and after compensation: the coefficients of a paper, simulated, fitted and compared when the page is made."""

import math
from pathlib import Path

import numpy as np

import allanite as al
from allanite.core.model import coefficient_factor, term
from allanite.core.units import convert
from allanite.reporting.digits import digits, printed_unit
from allanite.reporting.views.comparison import change_of
from allanite.reporting.words import probability
from generate.markdown import figure, table

UNITS = {"Q": "arcsec", "N": "deg/sqrt(h)", "B": "deg/h", "K": "deg/h/sqrt(h)", "R": "deg/h^2"}
TABLE_2 = {"Q": 0.963036, "N": 2.525648, "B": 12.023988, "K": 32.724570, "R": 38.789995}
TABLE_3 = {"Q": 0.916159, "N": 2.365199, "B": 3.235266, "K": 10.682979, "R": 23.970946}
PRINTED = {"Q": 4.87, "N": 6.35, "B": 73.09, "K": 36.80, "R": 38.20}
"""Reductions in percent, as the paper prints them."""

RATE = 1000.0
PAPER = (
    "M. Geng, Y. Ren, Y. Fan, L. Wang and C. Yu (*Random error test and error source analysis of MSCSG*, Journal of "
    "Beijing University of Aeronautics and Astronautics 47 (2021) 1697-1704, doi:10.13700/j.bh.1001-5965.2020.0269, in "
    "Chinese)"
)


def model_of(values: dict[str, float]) -> al.Model:
    """The model of a table."""
    return al.Model(tuple(term(symbol, value, UNITS[symbol]) for symbol, value in values.items()))


def compensation_page(
    folder: Path,
    before: dict[str, float] = TABLE_2,
    after: dict[str, float] = TABLE_3,
    *,
    seconds: float = 3600.0,
) -> list[str]:
    """The page as lines; the figure goes into `folder`."""
    records = [
        al.simulate(model_of(values), round(seconds * RATE), RATE, rng=np.random.default_rng(seed), name="X")
        for seed, values in enumerate((before, after), 1)
    ]
    found = al.compare(*records)
    path = folder / "compensation_paper.svg"
    al.plot(found, path=path, force=True)
    return [
        "# Before and after compensation: what one hour can tell", "",
        *_paper(before, after), *_units(before), *_result(records, found, (before, after)),
        *figure(path, "Both curves with their bands, and the ratio of their variances"),
        *_reach(found), *_naive(records),
        "## With your own records", "",
        "```sh", "allanite compare before.csv after.csv --rate 1000 --unit deg/h --report page.html", "```", "",
        "```python", "found = al.compare(before, after)", "print(found.verdict)", "```", "",
    ]  # fmt: skip


def _paper(before: dict[str, float], after: dict[str, float]) -> list[str]:
    reductions = {s: 100 * (1 - after[s] / before[s]) for s in before}
    rows = [
        (s, printed_unit(UNITS[s]), f"{before[s]:g}", f"{after[s]:g}", f"{reductions[s]:.2f}", f"{PRINTED[s]:.2f}")
        for s in before
    ]
    off = [s for s in before if abs(reductions[s] - PRINTED[s]) > 0.02]
    would = {s: before[s] * (1 - PRINTED[s] / 100) for s in off}
    slips = [
        f"For {s} its own numbers give {reductions[s]:.2f} %, and it prints {PRINTED[s]:.2f} %: that would require "
        f"{would[s]:.3f} after the compensation, where the table has {after[s]:.3f}."
        for s in off
    ]
    return [
        f"{PAPER} measure the X channel of a magnetically suspended control and sensing gyroscope at rest, one hour at "
        "1 kHz, before and after a better cable, connector and thermal compensation. Five coefficients are fitted to "
        "each Allan deviation by least squares. Reductions are printed to four digits; their significance is "
        "not tested. Everything below is computed when this page is built.", "",
        *table(("", "unit", "before (table 2)", "after (table 3)", "reduction by these, %", "printed, %"), rows),
        *([" ".join(slips), ""] if slips else []),
    ]  # fmt: skip


def _units(before: dict[str, float]) -> list[str]:
    """What the printed unit of Q would mean."""
    tau = 1 / RATE
    levels = []
    for unit in ("deg", "arcsec"):
        q, n = al.Q(before["Q"], unit), al.N(before["N"], UNITS["N"])
        sigma = math.sqrt(float(al.expected(q, "oadev", [tau])[0]))
        levels.append((convert(sigma, "rad/s", "deg/h"), 3 * q.value**2 / n.value**2))
    (high, late), (fit, early) = levels
    return [
        f"The paper gives Q in degrees. Then the deviation at 1 ms would be {high:.2g} deg/h, and quantization would "
        f"dominate the curve up to {late:.4g} s. With Q in arcseconds it adds {fit:.4g} deg/h there, and angle "
        f"random walk dominates from {1e3 * early:.2g} ms on, which must be what the authors meant. The paper "
        f"also divides B by "
        f"0.6648 to get the floor of the curve, which lies at {math.sqrt(2 * math.log(2) / math.pi):.4f} B.", "",
    ]  # fmt: skip


def _result(records: list[al.Record], found: al.Comparison, truth: tuple[dict[str, float], ...]) -> list[str]:
    hours = records[0].duration / 3600
    rows = []
    for change in found.terms:
        before, after = (values[change.symbol] for values in truth)
        values = [_value(e) for e in (change.before, change.after)]
        size, interval = change_of(change, found.level)
        rows.append((
            change.symbol, printed_unit(UNITS[change.symbol]), *values, f"{100 * (after / before - 1):+.1f}",
            size, interval, probability(change.adjusted), change.outcome,
        ))  # fmt: skip
    headings = ("", "unit", "before", "after", "true change, %", "found", "95 % interval", "p (Holm)", "verdict")
    return [
        "## Result of a comparison", "",
        f"Two records of {hours:g} h at {RATE:g} Hz, simulated with the coefficients of the two tables (seeds 1 and "
        "2), and compared by `al.compare`:", "",
        f"> {found.verdict}", "",
        *table(headings, rows),
        *_claims(found),
    ]  # fmt: skip


def _value(estimate: al.Estimate) -> str:
    if estimate.value is None:
        return f"< {digits(_upper(estimate), figures=2).plain()[0]}"
    unit = UNITS[estimate.symbol]
    low, high = (v / coefficient_factor(estimate.symbol, unit) for v in estimate.interval(0.95))
    return digits(estimate.to(unit), low, high).plain()[0]


def _upper(estimate: al.Estimate) -> float:
    assert estimate.upper is not None  # noqa: S101 - an absent term has a limit
    return estimate.upper / coefficient_factor(estimate.symbol, UNITS[estimate.symbol])


def _claims(found: al.Comparison) -> list[str]:
    """Which of the paper's percentages such a pair of records can support."""
    seen = [c.symbol for c in found.terms if c.significant]
    unseen = [c.symbol for c in found.terms if c.outcome == "not resolvable"]
    lines = []
    if seen:
        named = " and ".join(f"{s} (printed: {PRINTED[s]:.2f} %)" for s in seen)
        lines.append(f"The change of {named} is more than chance.")
    if unseen:
        named = ", ".join(f"{s} ({PRINTED[s]:.2f} %)" for s in unseen)
        lines.append(
            f"The paper's reductions of {named} are not resolvable in records of this length: a change by a factor of "
            "two in either direction could not be distinguished from none."
        )
    return [" ".join(lines), ""] if lines else []


def _reach(found: al.Comparison) -> list[str]:
    ratios = found.pairs[0].ratios
    assert ratios is not None  # noqa: S101 - records of one rate share their averaging times
    apart = ratios.tau[ratios.p <= 0.05]
    last = len(ratios.tau) - 1
    low, high = ratios.interval(found.level)
    longest = f", the longest of them {apart.max():.4g} s" if apart.size else ""
    return [
        f"The curves differ at {apart.size} of {ratios.tau.size} averaging times{longest} (ratio of the variances, "
        f"each time by itself). At {ratios.tau[last]:.4g} s the variance is known with "
        f"{ratios.before.edf[last]:.2g} and {ratios.after.edf[last]:.2g} degrees of freedom; its ratio lies between "
        f"{low[last]:.2g} and {high[last]:.2g}.", "",
    ]  # fmt: skip


def _naive(records: list[al.Record]) -> list[str]:
    """The paper's own fit of the same records."""
    fits = [al.identify(al.deviation(record, "oadev", taus="log", noise=None), "ls") for record in records]
    rows = [
        (s, printed_unit(UNITS[s]), *(f"{fit[s].to(UNITS[s]):.4g}" for fit in fits), *(fit[s].status for fit in fits))
        for s in UNITS
    ]
    return [
        "## The paper's method on the same records", "",
        "Least squares on the Allan variance, every point with the same weight. A negative number is the signed root "
        "of a negative square, which no noise has: except for Q and N these numbers are scatter, and so are their "
        "percentages.", "",
        *table(("", "unit", "before", "after", "status before", "status after"), rows),
    ]  # fmt: skip
