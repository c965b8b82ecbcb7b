"""The tables of `prices`: quantiles of the gains, places and prices that follow, and what is claimed."""

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from allanite.identification.search.components import CLAIMED, COMPONENTS, FACTORS

TAILS = (0.1, 0.03)  # shares of the records, those that gain most, from which the number of places follows

Line = dict[str, Any]
Row = tuple[str, ...]


def sizes_of(lines: Sequence[Line]) -> list[int]:
    """Numbers of samples, the least first."""
    return sorted({line["n"] for line in lines})


def gains_in(lines: Iterable[Line], row: str, which: int = 0) -> np.ndarray:
    """Gains of a row in the records in which it may be added."""
    return np.array([line["gains"][row][which] for line in lines if row in line["gains"]])


def rows_in(lines: Iterable[Line]) -> list[str]:
    """Rows in the order of a record to which all may be added."""
    return list(dict.fromkeys(row for line in lines for row in line["gains"]))


def price_of(row: str, n: int) -> float:
    """The price of today."""
    kind = row.partition(": ")[2]
    return FACTORS[kind] if kind else COMPONENTS[row].price(n)


def places_of(row: str, gain: np.ndarray, share: float) -> float:
    """Independent places of which the best gains as much in a share of records; 0 where one place gains more."""
    from scipy.special import chdtrc

    component = COMPONENTS[row.partition(":")[0]]
    at = float(np.quantile(gain, 1 - share))
    single = float(chdtrc(1, max(at, 0.0))) * (1.0 if component.signed else 0.5)
    return math.log1p(-share) / math.log1p(-single) if single < 1 else 0.0


def percent(hits: Sequence[bool] | np.ndarray) -> str:
    """A share with its standard error, that of one hit where there is none."""
    n, k = len(hits), int(np.sum(hits))
    p = max(k, 1) / n
    return f"{100 * k / n:.1f} ± {100 * math.sqrt(p * (1 - p) / n):.1f}"


def gains_rows(lines: Sequence[Line]) -> tuple[Row, list[Row]]:
    """Quantiles of what each row gains, its price, and the places that follow."""
    heads = (
        "row", "n", "records", "50 %", "90 %", "97 %", "99 %", "largest", "score: 97 %", "largest", "price", "above %",
        "score above %", *(f"places, {100 * share:.0f} %" for share in TAILS), "places now",
    )  # fmt: skip
    rows = []
    for row in rows_in(lines):
        for n in sizes_of(lines):
            some = [line for line in lines if line["n"] == n]
            gain, score, price = gains_in(some, row), gains_in(some, row, 1), price_of(row, n)
            levels = [*np.quantile(gain, (0.5, 0.9, 0.97, 0.99)), gain.max(), np.quantile(score, 0.97), score.max()]
            now = "" if ":" in row else f"{COMPONENTS[row].places(n):.3g}"
            rows.append((
                row, str(n), str(gain.size), *(f"{x:.1f}" for x in (*levels, price)), percent(gain > price),
                percent(score > price), *(f"{places_of(row, gain, share):.2g}" for share in TAILS), now,
            ))  # fmt: skip
    return heads, rows


def nulls_rows(lines: Sequence[Line]) -> tuple[Row, list[Row]]:
    """The 97 % quantile of what each row gains in each null."""
    nulls = list(dict.fromkeys(line["null"] for line in lines))
    rows = []
    for row in rows_in(lines):
        for n in sizes_of(lines):
            each = [gains_in((x for x in lines if x["n"] == n and x["null"] == null), row) for null in nulls]
            rows.append((row, str(n), *(f"{np.quantile(gain, 0.97):.1f}" if gain.size else "" for gain in each)))
    return ("row", "n", *nulls), rows


def claims_rows(lines: Sequence[Line]) -> tuple[Row, list[Row]]:
    """How often each component is claimed in each null."""
    names = [name for name in COMPONENTS if name not in ("term", "sinusoid")]
    rows = []
    for n in sizes_of(lines):
        every = [line for line in lines if line["n"] == n]
        for null in [*dict.fromkeys(line["null"] for line in every), "all"]:
            some = [line for line in every if null in (line["null"], "all")]
            each = [percent([name in line["false"] for line in some]) for name in names]
            finding = [bool(line["false"]) or line["lines"] > 0 for line in some]
            term = [bool(line["terms"]) for line in some]
            either = [a or b for a, b in zip(finding, term, strict=True)]
            waves = percent([line["lines"] > 0 for line in some])
            rows.append((null, str(n), str(len(some)), *each, waves, *map(percent, (finding, term, either))))
    return ("null", "n", "records", *names, "sinusoid", "any false finding", "any false term", "either"), rows


def _lacks(line: Line, name: str) -> bool:
    """Whether a record is made without a component."""
    return name not in line["null"] and not (name == "filter" and "behind" in line["null"])


def weights_rows(lines: Sequence[Line]) -> tuple[Row, list[Row]]:
    """Quantiles of the weights of components that are not there."""
    rows = []
    for name in (name for name in COMPONENTS if name not in ("term", "sinusoid")):
        for n in sizes_of(lines):
            some = [line for line in lines if line["n"] == n and _lacks(line, name)]
            weight = np.array([line["weights"].get(name, 0.0) for line in some])
            levels = [*np.quantile(weight, (0.5, 0.9, 0.97, 0.99)), weight.max()]
            perhaps, claimed = percent(weight > 1 - CLAIMED), percent(weight >= CLAIMED)
            rows.append((name, str(n), str(weight.size), *(f"{x:.2f}" for x in levels), perhaps, claimed))
    levels = ("50 %", "90 %", "97 %", "99 %", "largest", "above 0.27 %", "above 0.73 %")
    return ("component", "n", "records", *levels), rows
