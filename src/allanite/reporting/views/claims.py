"""How a claim is shown, and what a record says of it."""

import math
from collections.abc import Iterator, Sequence
from typing import Any

from allanite.claims.claim import CUTOFF, RATE, SETTINGS, ClaimedNoise
from allanite.claims.result import OUTCOMES, UNCLAIMED, CheckedTerm, ClaimCheck
from allanite.core.limits import NOT_DECIDED
from allanite.core.readings import MINIMUM
from allanite.core.units import Signal
from allanite.phrases.phrase import Phrase, join, say
from allanite.reporting import figures, words
from allanite.reporting.digits import rounded
from allanite.reporting.first import DETAILS, FIGURES, ChannelRow, Channels, First, Remark, plus_minus
from allanite.reporting.sheet import Column, Drawing, Face, Mark, Note, Sheet, Table
from allanite.terms import TERMS

from . import Rows, view
from .channels import how_read, title_of
from .jobs import channel_sheet, doubts, job_face, source_of

TITLES = {
    "T": say("correlation time of the bias"), "curve": say("Allan deviation"),
    "kurtosis": say("excess kurtosis of the residuals"), MINIMUM: say("minimum of the Allan deviation"),
    CUTOFF: say("low-pass filter, -3 dB"), RATE: say("samples of the sensor a second"),
}  # fmt: skip
"""What the quantities are called that are no terms."""

MIN_LIMITS_RATIO = 1.2  # ratio of the limits of a factor from which these are shown instead of its value

AT_MOST = ("--at-most", say("the claim as upper bounds"))

_OUTCOMES = say("agrees"), say("differs"), say("exceeds"), say("not claimed"), say("not decided")
OUTCOME_WORDS: dict[str, Phrase] = {word: word for word in _OUTCOMES}

HOW = (say(
    "Exact values: the likelihood of the record (binned powers of the cosine transform) is maximized over the "
    "coefficients of the terms that are claimed, with the claimed correlation time; the interval of a factor is that "
    "of its profile. The correlation time is that of all channels of a sensor together. Other noise is there if it "
    "raises the likelihood significantly. The Allan deviation at each octave is held against the one that is claimed, "
    "with the distribution that it has under the claim. Light tails of the residuals show numbers that are not "
    "Gaussian."
), say(
    "Upper bounds: the interval of each coefficient that was identified, or its upper limit, is held against the bound."
), say(
    "Low-pass filter: the -3 dB frequency over all models that are consistent with the record, whether they have a "
    "filter or not. Rate: the sampling rate, less the samples that repeat the one before periodically."
), say(
    "All comparisons of a record share the chance of a false alarm, which is one minus the confidence level in all. A "
    "convention is named if its factor lies in the interval."
))  # fmt: skip


def _title(row: CheckedTerm) -> Phrase | str:
    return TITLES[row.quantity] if row.quantity in TITLES else words.title(row.quantity, row.signal)


def _symbol(quantity: str) -> str:
    return quantity if quantity in TERMS or quantity == "T" else ""


def first_of_check(value: ClaimCheck, level: float) -> First:
    """The factor of every number by channel, and what explains those that are wrong."""
    shown = {row.signal.name: row.signal for row in value.terms}
    answer = [table for signal in shown.values() for table in _tables(value, signal)]
    remarks = [Remark(", ".join(cause.channels), (cause.words,), grave=True) for cause in value.causes]
    undecided = [row for row in value.terms if row.quantity in SETTINGS and row.outcome == NOT_DECIDED and row.reason]
    for reason in dict.fromkeys(row.reason for row in undecided):
        remarks.append(Remark(", ".join(row.channel for row in undecided if row.reason == reason), (reason,)))
    remarks += [] if value.agrees else doubts(value.checked)
    legend = [("", say("×: factor on the claimed value; * contradicts the claim, all comparisons considered."))]
    title = join("   ", (title_of(value), say("against {claim}", claim=value.claim.title)))
    after = [FIGURES, DETAILS, *([] if value.agrees or value.claim.bound or not value.claim.models else [AT_MOST])]
    return First(title, value.verdict, answer, remarks, legend, how_read(value), after)


def _tables(value: ClaimCheck, signal: Signal) -> Iterator[Channels]:
    """What is claimed of a kind of sensor with the factor of each channel, and the values of what is not claimed."""
    rows = [row for row in value.terms if row.signal is signal]
    names = list(dict.fromkeys(row.channel for row in rows if row.quantity != "T"))
    quantities, unclaimed = list[ChannelRow](), list[ChannelRow]()
    for quantity in dict.fromkeys(row.quantity for row in rows):
        own = {
            name: row for row in rows if row.quantity == quantity for name in (row.channel, *row.channel.split(", "))
        }
        first = next(iter(own.values()))
        if quantity == "kurtosis" and not first.contradicts:
            continue
        bare = first.claimed is None or quantity in ("curve", "kurtosis")
        claimed = "" if bare else rounded(first.shown(first.claimed) or 0.0)
        symbol = _symbol(quantity)
        unit = first.unit if symbol or quantity in SETTINGS else ""
        cells = [_cell(own.get(name)) for name in names]
        rank = 0 if any(r.contradicts for r in own.values()) else 1
        if first.outcome == UNCLAIMED:
            unclaimed.append(ChannelRow(_title(first), symbol, unit, cells, rank))
        else:
            quantities.append(ChannelRow(_title(first), symbol, unit, [claimed, *cells], rank))
    yield Channels([say("claimed"), *names], quantities, signal.sensor)
    if unclaimed:
        yield Channels(names, unclaimed, say("not claimed"))


def _cell(row: CheckedTerm | None) -> str:
    """The factor of a channel, with a sign if it contradicts the claim."""
    if row is None or row.outcome == NOT_DECIDED:
        return "" if row is None else say("not decided")
    factor: str = say("agrees")
    if row.outcome == UNCLAIMED:
        factor = rounded(row.shown(row.found) or 0.0)
    elif row.quantity == "kurtosis":
        factor = say("uniform")
    elif row.quantity == "curve":
        factor = join(" ", (f"×{rounded(row.ratio)}", row.reason)) if row.contradicts else factor
    elif math.isinf(row.high):
        factor = say("above {limit}", limit=f"×{rounded(row.low)}") if row.low > 0 else factor
    elif row.low <= 0:
        factor = say("below {limit}", limit=f"×{rounded(row.high)}")
    elif row.high > MIN_LIMITS_RATIO * row.low:
        factor = f"×{rounded(row.low)} .. {rounded(row.high)}"
    else:
        factor = f"×{plus_minus(row.ratio, row.low, row.high)}"
    return join("", (factor, " *")) if row.contradicts else factor


MARKS: dict[str, Mark] = {"agrees": "good", "not decided": "quiet"}
COLUMNS = (
    Column(say("quantity"), "symbol"), Column("", "text"), Column(say("claimed"), form=rounded),
    Column(say("found"), form=rounded), Column(say("unit"), "unit"), Column(say("factor"), form=rounded),
    Column(say("interval"), "interval"), Column(say("outcome"), "name"), Column("", "text", aside=True),
)  # fmt: skip


def _table(rows: Sequence[CheckedTerm]) -> Table:
    cells = [
        [_symbol(row.quantity), _title(row), *_numbers(row), OUTCOME_WORDS[row.outcome], row.reason] for row in rows
    ]
    return Table(COLUMNS, cells, marks=[MARKS.get(row.outcome, "alarm") for row in rows])


def _numbers(row: CheckedTerm) -> list[Any]:
    """Claimed and found, unit, factor, interval."""
    known = row.high == row.high  # no NaN
    interval = f"{rounded(row.low)} .. {rounded(row.high)}" if known else ""
    return ["" if v is None else v for v in (row.shown(row.claimed), row.shown(row.found))] + [
        row.unit, "" if math.isnan(row.ratio) else row.ratio, interval,
    ]  # fmt: skip


@view(lambda values, fit, level: figures.plot_claims(values, level), lambda value, level: value.rows(level),
      first=first_of_check)  # fmt: skip
def check_view(value: ClaimCheck, level: float) -> Face:
    """What is claimed and found of each channel."""
    causes = [Note(join(": ", (", ".join(cause.channels), cause.words)), "alert") for cause in value.causes]
    timed = [row for row in value.terms if row.quantity == "T"]
    common = [_table(timed)] if timed else []
    drawn = [channel for channel in value.checked if channel.curve is not None]
    label = say("measured curves with the claimed ones")
    caption = say("Deviation by averaging time with its confidence band, and the one that is claimed (dashed).")
    drawing = [Drawing(lambda: figures.plot_claims([value], level), label, caption)] if drawn else []
    own = ((c, [row for row in value.terms if row.channel == c.record.name]) for c in value.checked)
    sheets = [channel_sheet(channel, [_table(rows)]) for channel, rows in own]
    met = {row.outcome for row in value.terms}
    meanings = [
        Note(join(": ", (OUTCOME_WORDS[name], text)), "quiet") for name, text in OUTCOMES.items() if name in met
    ]
    return job_face(
        value, (say("{file} against {claim}", file=source_of(value), claim=value.claim.title), say("noise and claim")),
        sheets, [Note(value.verdict, "good" if value.agrees else "strong"), *causes, *drawing, *common],
        close=meanings, how=[Note(text) for text in HOW],
    )  # fmt: skip


def _claim_rows(value: ClaimedNoise, _: float) -> Rows:
    terms = [[t.symbol, t.value, t.unit] for model in value.models for t in model]
    return ("term", "value", "unit"), [*terms, *([s.quantity, s.value, "Hz"] for s in value.settings)]


@view(rows=_claim_rows)
def claim_view(value: ClaimedNoise, level: float) -> Face:
    """The terms that are claimed."""
    rows = [[t.symbol, words.title(t.symbol, t.signal), str(t)] for model in value.models for t in model]
    rows += [["", TITLES[s.quantity], s.words()] for s in value.settings]
    table = Table((Column(say("term"), "symbol"), Column("", "text"), Column("", "text")), rows)
    return Face(say("what {source} claims", source=value.title), say("noise and claim"), [Sheet("", (), [table])])
