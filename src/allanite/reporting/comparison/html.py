"""A comparison or a pool as one HTML page that needs nothing else."""

import re
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from allanite.comparison.change import OUTCOMES
from allanite.comparison.comparison import Comparison
from allanite.core.version import __version__
from allanite.reporting import words
from allanite.reporting.html import svg
from allanite.reporting.sheet import printable, printed_unit

from .figures import plot_comparison
from .sheets import Value, sheets

_MINUS = re.compile(r"(?<![A-Za-z])-(?=\d)|(?<=e)-(?=\d)")
"""The sign of a number, not the hyphen of a name."""

COMPARED = (
    "The two records are supposed to be independent. The verdict is the likelihood ratio of one common noise model "
    "against a model for each record, of the terms that the common model holds (binned powers of the cosine "
    "transform, Whittle). Coefficients end at zero, and some stand on few powers, so that its law is drawn from the "
    "common model (a parametric bootstrap, stopped early where chance is likely enough); where chi-square leaves a "
    "probability below 1e-4 nothing is drawn.",
    "The change of a coefficient is the ratio of the two, with profile limits: the ratios that the two records "
    "together do not contradict, whatever their other coefficients are. Its p is adjusted for the number of "
    "coefficients by Holm's method. Ramps keep their sign; their limits are Fieller's.",
    "The ratio of the variances has the law of a ratio of two weighted sums of chi-squares, which is Fisher's F with "
    "both equivalent degrees of freedom where these are many. For it every term is let in, and coefficients that are "
    "not told apart are supposed common. Neighbouring averaging times share their data: of twenty that are equal one "
    "differs by chance, and where one does its neighbours tend to.",
)
POOLED = (
    "The runs are supposed to be independent. One noise for all is tested by the likelihood ratio against a model for "
    "each run, its law drawn from the common model. The common coefficient is the one that all runs together make "
    "most likely, with profile limits.",
    "Between runs: standard deviation of the runs' coefficients, in percent of the common one. Within runs: what "
    "equal sensors would show, from the standard errors. Their difference is tested by a chi-square of homogeneity, "
    "adjusted by Holm's method.",
    "A run lies apart if it differs from all others together (likelihood ratio, adjusted by Holm's method); the worst "
    "one is taken out and the others are looked at again. Variances are averaged by their degrees of freedom, which "
    "add up; that they are equal is tested at each averaging time by Bartlett's test.",
)


def page(value: Value) -> str:
    """The page as text."""
    env = Environment(
        loader=PackageLoader("allanite", "reporting"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    env.filters["clean"], env.filters["printed"] = printable, _printed
    return env.get_template("comparison/comparison.html.j2").render(_content(value))


def _printed(cell: str, unit: bool) -> str:
    """A cell with the signs of print: of a unit its roots and powers, of a number its minus."""
    shown = printable(cell)
    if unit:
        return printed_unit(shown)
    return _MINUS.sub("−", shown)


def _content(value: Value) -> dict[str, Any]:
    pair = isinstance(value, Comparison)
    return {
        "title": " and ".join(value.names) if pair else f"{len(value.names)} runs",
        "brand": "allanite · what has changed" if pair else "allanite · what runs have in common",
        "names": value.names,
        "sheets": [
            sheet._asdict() | {"tables": [table._asdict() for table in sheet.tables]} for sheet in sheets(value)
        ],
        "figure": _figure(value),
        "outcomes": OUTCOMES if pair else {},
        "how": COMPARED if pair else POOLED,
        "notes": value.notes,
        "choices": value.choices or {},
        "provenance": {"allanite": __version__, **(value.provenance or {})},
        "level": words.percent(value.level),
    }


def _figure(value: Value) -> str:
    drawn = [p.ratios if hasattr(p, "ratios") else p.curve for p in value]
    return (
        svg(plot_comparison(value), "compare", "curves with bands, and the ratio of their variances")
        if any(item is not None for item in drawn)
        else ""
    )
