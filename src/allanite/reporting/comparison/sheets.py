"""The tables of a comparison and of a pool in plain text: what the terminal and the page both show."""

import math
from collections.abc import Iterator
from typing import NamedTuple

from allanite.comparison.change import LEAST_P, Change, alpha_of
from allanite.comparison.comparison import Comparison, Pair, Ratios
from allanite.comparison.pooled import Pool, PooledChannel, PooledTerm
from allanite.core.curve import Curve
from allanite.core.fit import Estimate
from allanite.core.record import Header, Record
from allanite.core.units import convert, readable_unit
from allanite.reporting import words
from allanite.reporting.digits import digits
from allanite.statistics import STATISTICS
from allanite.terms import TERMS

Value = Comparison | Pool


class Table(NamedTuple):
    """Headings and rows of text; `marks` has the style of each row, and `left` the columns that begin at the left."""

    title: str
    headings: list[str]
    rows: list[list[str]]
    marks: list[str]
    left: int = 1


class Sheet(NamedTuple):
    """What is said of a channel; `doubt` where that should not be passed over."""

    name: str
    verdict: str
    doubt: bool
    about: list[str]
    alerts: tuple[str, ...]
    refusal: str
    tables: list[Table]


def sheets(value: Value) -> Iterator[Sheet]:
    """A sheet for each channel."""
    if isinstance(value, Comparison):
        return (_of_pair(pair, value) for pair in value)
    return (_of_pooled(channel, value) for channel in value)


def _of_pair(pair: Pair, whole: Comparison) -> Sheet:
    about = [f"{name}: {_about(record)}" for name, record in zip(whole.names, pair.records or (), strict=False)]
    if pair.band is not None:
        about.append(_band(pair.band))
    tables = [_changes(pair, whole)] if pair.changes else []
    tables += [_ratios(pair.ratios, whole)] if pair.ratios is not None else []
    return Sheet(pair.name, pair.verdict, bool(pair.refusal), about, pair.alerts, pair.refusal, tables)


def _about(record: Record | Header) -> str:
    return "; ".join((words.about(record), *record.history))


def _band(band: tuple[float, float]) -> str:
    return f"compared from {band[0]:.4g} to {band[1]:.6g} Hz, which all have"


def _changes(pair: Pair, whole: Comparison) -> Table:
    names = list(whole.names)
    headings = ["term", *names, *(["whole"] * (pair.whole is not None)), "unit", "change", _level(whole.level),
                "p", "p (Holm)", "outcome"]  # fmt: skip
    rows = []
    for c in pair.changes:
        estimates = [c.before, c.after, *([pair.whole[c.symbol]] if pair.whole is not None else [])]
        values = [value_of(e, whole.level) for e in estimates]
        rows.append([
            f"{c.symbol}  {words.title(c.symbol, c.signal)}", *values, c.before.sheet_unit, *change_of(c, whole.level),
            chance(c.p), chance(c.adjusted), c.outcome,
        ])  # fmt: skip
    return Table("coefficients", headings, rows, [c.outcome for c in pair.changes])


def value_of(estimate: Estimate, level: float) -> str:
    """A coefficient to its significant digits, or its upper limit."""
    number, most = words.shown(estimate, estimate.sheet_unit, level), words.limit(estimate, estimate.sheet_unit)
    if number is not None:
        return number.plain()[0]
    return f"< {most.plain()[0]}" if most else "-"


def change_of(change: Change, level: float) -> tuple[str, str]:
    """The change and its interval in percent."""
    low, high = change.interval(level)
    least = -100.0 if TERMS[change.symbol].waveform is None else -math.inf
    if low > least and math.isfinite(high) and math.isfinite(change.ratio):
        number = digits(change.percent, low, high, signed=True)
        return f"{number.plain()[0]} %", f"{number.low} .. {number.high} %"
    size = f"{change.percent:+.3g} %" if math.isfinite(change.ratio) and math.isfinite(high) else "-"
    if math.isfinite(high):
        return size, f"below {high:+.3g} %"
    return "-", f"above {low:+.3g} %" if low > least else "any"


def _ratios(ratios: Ratios, whole: Comparison) -> Table:
    unit = readable_unit(ratios.before.unit)
    headings = ["tau [s]", *(f"{name} [{unit}]" for name in whole.names), "edf before", "edf after", "variance ratio",
                _level(whole.level), "p"]  # fmt: skip
    factor = convert(1.0, ratios.before.unit, unit)
    rows, marks = [], []
    for tau, before, after, nu, mu, ratio, low, high, p in ratios.rows(whole.level)[1]:
        number = digits(ratio, low, high)
        rows.append([
            f"{tau:.6g}", f"{before * factor:.5g}", f"{after * factor:.5g}", f"{nu:.4g}", f"{mu:.4g}",
            *number.plain(), chance(p),
        ])  # fmt: skip
        marks.append(("smaller" if ratio < 1 else "larger") if p <= alpha_of(whole.level) else "")
    title = f"{STATISTICS[ratios.before.statistic].title} and ratio of the variances"
    return Table(title, headings, rows, marks, left=0)


def _of_pooled(channel: PooledChannel, whole: Pool) -> Sheet:
    about = [f"{name}: {_about(record)}" for name, record in zip(whole.names, channel.records, strict=False)]
    if channel.band is not None:
        about.append(_band(channel.band))
    tables = [_pooled_terms(channel, whole), _runs(channel, whole)] if channel.terms else []
    tables += [_pooled_curve(channel.curve, channel, whole)] if channel.curve is not None else []
    doubt = not channel.alike or bool(channel.apart)
    return Sheet(channel.name, channel.verdict, doubt, about, channel.alerts, channel.refusal, tables)


def _pooled_terms(channel: PooledChannel, whole: Pool) -> Table:
    headings = ["term", "common", _level(whole.level), "unit", "between runs", "within runs", "chi-square", "dof", "p",
                "p (Holm)"]  # fmt: skip
    rows = [
        _pooled_row(term, row, whole.level) for term, row in zip(channel.terms, _numbers(channel, whole), strict=True)
    ]
    return Table("what the runs have in common", headings, rows, _marks(channel))


def _marks(channel: PooledChannel) -> list[str]:
    return ["larger" if term.adjusted <= channel.alpha else "" for term in channel.terms]


def _numbers(channel: PooledChannel, whole: Pool) -> list[list[float]]:
    rows = Pool((channel,), whole.names, whole.level).rows()[1]
    return [[*row[3:6], *row[7:]] for row in rows]


def _pooled_row(term: PooledTerm, row: list[float], level: float) -> list[str]:
    value, low, high, between, within, statistic, dof, p, adjusted = row
    number = digits(value, low, high)
    shown = number.plain() if value > 0 else ("-", f"below {digits(high, figures=2).plain()[0]}")
    scatter = [f"{v:.3g} %" if math.isfinite(v) else "-" for v in (between, within)]
    return [f"{term.symbol}  {words.title(term.symbol, term.signal)}", *shown, term.sheet_unit, *scatter,
            f"{statistic:.3g}", f"{dof:g}", chance(p), chance(adjusted)]  # fmt: skip


def _runs(channel: PooledChannel, whole: Pool) -> Table:
    apart = channel.apart or {}
    headings = ["run", *(f"{t.symbol} [{t.sheet_unit}]" for t in channel.terms), "apart, p"]
    rows = [
        [
            name,
            *(value_of(fit[t.symbol], whole.level) for t in channel.terms),
            chance(apart[name]) if name in apart else "",
        ]
        for name, fit in zip(whole.names, channel.fits, strict=True)
    ]
    return Table("run by run", headings, rows, ["larger" if name in apart else "" for name in whole.names])


def _pooled_curve(curve: Curve, channel: PooledChannel, whole: Pool) -> Table:
    shown = curve.to(readable_unit(curve.unit))
    low, high = shown.interval(whole.level)
    assert channel.p is not None  # noqa: S101 - comes with the curve
    headings = ["tau [s]", f"all runs [{shown.unit}]", _level(whole.level), "edf", "p of one variance"]
    rows = [
        [f"{tau:.6g}", *digits(v, a, b).plain(), f"{nu:.4g}", chance(p)]
        for tau, v, a, b, nu, p in zip(shown.tau, shown.deviation, low, high, shown.edf, channel.p, strict=True)
    ]
    marks = ["larger" if p <= channel.alpha else "" for p in channel.p]
    return Table(f"{STATISTICS[curve.statistic].title} of all runs", headings, rows, marks, left=0)


def chance(p: float) -> str:
    """A probability, as far as it means anything."""
    return f"{p:.2g}" if p >= LEAST_P else f"< {LEAST_P:g}"


def _level(level: float) -> str:
    return f"{words.percent(level)} interval"
