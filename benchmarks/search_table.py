"""The table of `search_cells`: what was said of each cell, beside the truth."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

CLAIMED = ("identified", "weak")
MARKOV = ("GM", "GML", "GM2", "GMA")
FAMILY = {"GM": {"GM", "GML"}}  # symbols under which a term may be claimed, if not its own alone

GRADES = ("explained", "approximate", "unexplained", "failed")

HEADINGS = (
    "cell", "side", "records", "N: claimed %", "covered", "median", "rms %", "width %", "wrong", "honest",
    "B: claimed %", "covered", "median", "rms %", "width %", "false K / GM claimed %", "limits hold",
    "false term %", "explained / approximate / unexplained / failed %", "filter %", "CPU s",
)  # fmt: skip
"""Of N and B: share claimed; claimed and covered; median and RMS error of the claimed values; their median width,
(high - low) / 3.92 over the value. wrong: claimed, the model not unexplained, and not covered; honest: not claimed, or
unexplained. limits hold: absent terms that are there, and are below their limit."""

Line = dict[str, Any]
Row = tuple[str, ...]


def rows_of(sides: dict[str, list[Line]]) -> tuple[Row, list[Row]]:
    """Headings, and a row for each cell and side, of the records that all sides have."""
    cells: dict[str, dict[str, dict[int, Line]]] = {}
    for side, lines in sides.items():
        for line in lines:
            cells.setdefault(line["cell"], {}).setdefault(side, {})[line["index"]] = line
    rows = []
    for cell, by_side in cells.items():
        common = set.intersection(*(set(lines) for lines in by_side.values()))
        for side in sides:
            lines = [by_side[side][i] for i in sorted(common)] if side in by_side else []
            rows += [(cell, side, *_row(lines))] if lines else []
    return HEADINGS, rows


def _row(lines: list[Line]) -> Row:
    """A cell by one code."""
    good = [line for line in lines if "error" not in line]
    if not good:
        return (str(len(lines)), *[""] * (len(HEADINGS) - 5), "failed", "")
    B = _size(good, "B")[:-2]
    return (
        str(len(lines)), *_size(good, "N"), *B, _also(good), _limits(good),
        _percent([bool(_false(line)) for line in good]), _grades(lines),
        _percent([line["filter"] is not None for line in good]), f"{np.median([line['cpu'] for line in good]):.2f}",
    )  # fmt: skip


def _ends(truth: float | Sequence[float]) -> tuple[float, float]:
    """The range in which the truth is."""
    return (truth[0], truth[-1]) if isinstance(truth, list) else (truth, truth)  # type: ignore[return-value]


def _interval(term: Line) -> tuple[float, float]:
    """The limits of a term."""
    return term["low"] or 0.0, math.inf if term["high"] is None else term["high"]


def _inside(term: Line, truth: float | Sequence[float]) -> bool:
    """Whether the limits of a term hold the truth."""
    (low, high), (least, most) = _interval(term), _ends(truth)
    return low <= most and least <= high


def _size(lines: list[Line], symbol: str) -> Row:
    """Claimed, covered, median, RMS error, width, wrong, honest."""
    if symbol not in lines[0]["truth"]:
        return ("",) * 7
    claimed = [(line, line["terms"][symbol]) for line in lines if _claims(line, symbol)]
    covered = [_inside(term, line["truth"][symbol]) for line, term in claimed]
    solid = [line["validity"] != "unexplained" for line, _ in claimed]
    wrong = sum(valid and not inside for valid, inside in zip(solid, covered, strict=True))
    honest = len(lines) - sum(solid)
    share = f"{100 * len(claimed) / len(lines):.0f}"
    if not claimed:
        return share, "", "", "", "", "0", str(honest)
    ratio = np.array([term["value"] / np.mean(_ends(line["truth"][symbol])) for line, term in claimed])
    width = [(high - low) / 3.92 / term["value"] for _, term in claimed for low, high in [_interval(term)]]
    rms = 100 * math.sqrt(np.mean((ratio - 1) ** 2))
    sizes = f"{np.median(ratio):.3f}", f"{rms:.2g}", f"{100 * np.median(width):.2g}"
    return share, f"{sum(covered)}/{len(claimed)}", *sizes, str(wrong), str(honest)


def _claims(line: Line, symbol: str) -> bool:
    term = line["terms"].get(symbol)
    return term is not None and term["status"] in CLAIMED and bool(term["value"])


def _false(line: Line) -> set[str]:
    """Terms that are claimed and are not there."""
    there = {*line["truth"], *line["allowed"].split()}
    there = there.union(*(FAMILY.get(symbol, set()) for symbol in there))
    return {symbol for symbol in line["terms"] if _claims(line, symbol)} - there


def _also(lines: list[Line]) -> str:
    """Shares of records with a false K, and with any Gauss-Markov term."""
    K = _percent(["K" in _false(line) for line in lines])
    return f"{K} / {_percent([any(_claims(line, symbol) for symbol in MARKOV) for line in lines])}"


def _limits(lines: list[Line]) -> str:
    """Of the terms that are there and called absent: how many are below the limit that is given."""
    hold = []
    for line in lines:
        for symbol, truth in line["truth"].items():
            term = line["terms"].get(symbol)
            if symbol != "GM" and term is not None and term["status"] == "absent" and term["upper"] is not None:
                hold.append(_ends(truth)[0] <= term["upper"])
    return f"{sum(hold)}/{len(hold)}" if hold else ""


def _grades(lines: list[Line]) -> str:
    """Shares of the grades, and of records without an answer."""
    grades = [line.get("validity", "failed") for line in lines]
    return " / ".join(_percent([grade == name for grade in grades]) for name in GRADES)


def _percent(which: Sequence[bool]) -> str:
    return f"{100 * float(np.mean(which)):.0f}"
