"""A comparison or a pool as CSV: the coefficients, and below them the points of the curves."""

import csv
import io
import math
from collections.abc import Iterator
from typing import Any

from allanite.comparison.comparison import Comparison
from allanite.comparison.pooled import Pool
from allanite.core.units import convert, readable_unit

from .sheets import Value

PAIR = ("channel", "quantity", "tau_s", "before", "after", "unit", "change_percent", "low_percent", "high_percent",
        "p", "p_holm", "outcome", "edf_before", "edf_after")  # fmt: skip
"""Of a deviation the change and its limits are those of the deviation, whose square is the ratio of the variances."""

POOL = ("channel", "quantity", "tau_s", "common", "low", "high", "unit", "between_percent", "within_percent",
        "chi_square", "dof", "p", "p_holm", "edf")  # fmt: skip


def to_csv(value: Value) -> str:
    """The rows of all channels; the runs of a pool have columns of their own, after these."""
    pair = isinstance(value, Comparison)
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(PAIR if pair else (*POOL, *value.names))
    for row in _pairs(value) if isinstance(value, Comparison) else _pooled(value):
        writer.writerow(["" if v is None or (isinstance(v, float) and math.isnan(v)) else v for v in row])
    return out.getvalue()


def _pairs(value: Comparison) -> Iterator[list[Any]]:
    for row in value.rows()[1]:
        channel, symbol, _, before, after, unit, *rest = row
        yield [channel, symbol, "", before, after, unit, *rest, "", ""]
    for pair in value:
        if pair.ratios is None:
            continue
        unit = readable_unit(pair.ratios.before.unit)
        factor = convert(1.0, pair.ratios.before.unit, unit)
        for tau, before, after, nu, mu, ratio, low, high, p in pair.ratios.rows(value.level)[1]:
            percent = [100 * (math.sqrt(v) - 1) for v in (ratio, low, high)]
            yield [pair.name, pair.ratios.before.statistic, tau, before * factor, after * factor, unit, *percent, p, "",
                   "", nu, mu]  # fmt: skip


def _pooled(value: Pool) -> Iterator[list[Any]]:
    rows = iter(value.rows()[1])
    for channel in value:
        for term in channel.terms:
            name, symbol, _, *numbers = next(rows)
            runs = [None if e.value is None else e.to(term.sheet_unit) for e in term.runs]
            yield [name, symbol, "", *numbers, "", *runs]
    for channel in value:
        if channel.curve is None or channel.p is None:
            continue
        unit = readable_unit(channel.curve.unit)
        whole, runs_shown = channel.curve.to(unit), [curve.to(unit).deviation for curve in channel.curves]
        low, high = whole.interval(value.level)
        for i, tau in enumerate(whole.tau.tolist()):
            limits = [float(v[i]) for v in (whole.deviation, low, high)]
            yield [channel.name, whole.statistic, tau, *limits, unit, "", "", "", "", float(channel.p[i]), "",
                   float(whole.edf[i]), *(float(run[i]) for run in runs_shown)]  # fmt: skip
