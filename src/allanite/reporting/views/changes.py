"""The first screen of comparisons: what has changed, by channel and coefficient."""

import math
from collections.abc import Sequence

from allanite.comparison.change import Change
from allanite.comparison.comparison import Comparison, Pair
from allanite.core.fit import chance
from allanite.phrases.phrase import join, say
from allanite.reporting import words
from allanite.reporting.digits import digits
from allanite.reporting.first import DETAILS, FIGURES, Axes, First, Quantity, Remark, merged
from allanite.terms import TERMS

from .axes import names_in_order

WITH_VALUES = 2
"""Channels side by side with the coefficients before and after."""

OUTCOME_WORDS = {
    "smaller": say("smaller"),
    "larger": say("larger"),
    "no change": say("no change"),
    "not resolvable": say("not resolvable"),
}


def first_of_comparison(value: Comparison, level: float) -> First:
    """The change of every coefficient of every channel."""
    changed = [pair.name or say("the noise") for pair in value.pairs if pair.changed and not pair.refusal]
    same = [pair.name or say("the noise") for pair in value.pairs if not pair.changed and not pair.refusal]
    said = [say("changed: {names}", names=", ".join(changed))] if changed else []
    said += [say("no change detected: {names}", names=", ".join(same))] if same else []
    remarks = [Remark.of(pair.name, pair.refusal, grave=True) for pair in value.pairs if pair.refusal]
    remarks += [
        Remark.of(pair.name, say("{record} ({grade})", record=name, grade=grade), grave=True)
        for pair in value.pairs
        for name, grade, fits in zip(value.names, pair.grades, pair.explained, strict=False)
        if not fits
    ]
    remarks += [Remark.about_finding("", finding) for finding in value.findings]
    remarks += merged(Remark.of(pair.name, alert) for pair in value.pairs for alert in pair.alerts)
    title = say("{first} compared with {second}", first=value.names[0], second=value.names[1])
    needed = any(c.outcome == "not resolvable" for pair in value.pairs for c in pair.changes)
    legend = [("", say("unknown: a change by a factor of 2 is not excluded."))] if needed else []
    answer = [_axes([pair for pair in value.pairs if not pair.refusal], level)]
    return First(title, join("; ", said), answer, remarks, legend, list(value.notes), [FIGURES, DETAILS])


def _axes(pairs: Sequence[Pair], level: float) -> Axes:
    changes = [c for pair in pairs for c in pair.changes]
    rows = [Quantity(say("noise as a whole"), "", "", [_whole(pair) for pair in pairs])]
    for symbol in names_in_order(c.symbol for c in changes):
        found = [next((c for c in pair.changes if c.symbol == symbol), None) for pair in pairs]
        there = next(c for c in found if c is not None)
        cells = ["" if c is None else _cell(c, level, values=len(pairs) <= WITH_VALUES) for c in found]
        claimed = any(c is not None and c.outcome != "not resolvable" for c in found)
        rows.append(
            Quantity(words.title(symbol, there.signal), symbol, there.before.sheet_unit, cells, 0 if claimed else 1)
        )
    return Axes([pair.name or say("channel") for pair in pairs], rows, _sensor(pairs))


def _sensor(pairs: Sequence[Pair]) -> str:
    """The kind of sensor, if the records are known."""
    records = [record for pair in pairs for record in pair.records or ()]
    return records[0].signal.sensor if records else ""


def _whole(pair: Pair) -> str:
    if pair.p <= pair.alpha:
        return say("changed, {p}", p=chance(pair.p))
    return say("no change, {p}", p=chance(pair.p))


def _cell(change: Change, level: float, *, values: bool) -> str:
    """The coefficient before and after, and its change."""
    size, interval = change_of(change, level)
    outcome: str = say("unknown")
    if change.outcome != "not resolvable":
        outcome = join(" ", (OUTCOME_WORDS[change.outcome], join("", ("(", size if size != "-" else interval, ")"))))
    both = f"{words.brief(change.before, level)} -> {words.brief(change.after, level)}"
    return join("  ", (both, outcome)) if values else outcome


def change_of(change: Change, level: float) -> tuple[str, str]:
    """The change and its interval in percent."""
    low, high = change.interval(level)
    least = -100.0 if TERMS[change.symbol].waveform is None else -math.inf
    # beside a limit there is no number to compare, but a sinusoid that has gone
    known = math.isfinite(change.ratio) and (None not in (change.before.value, change.after.value) or not change.ratio)
    if low > least and math.isfinite(high):
        size, interval = digits(change.percent if known else high, low, high, signed=True).plain()
        return f"{size} %" if known else "-", f"{interval} %"
    size = f"{change.percent:+.3g} %" if known and math.isfinite(high) else "-"
    if math.isfinite(high):
        return size, say("below {limit}", limit=f"{high:+.3g} %")
    return "-", say("above {limit}", limit=f"{low:+.3g} %") if low > least else say("any")
