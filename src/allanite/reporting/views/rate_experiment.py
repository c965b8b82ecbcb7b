"""How an experiment is shown: the rates of all methods over the intervals of a record, and one interval in detail."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from allanite.applications.constant_rate import Closeup, Experiment, Ranking, RateEstimate
from allanite.applications.constant_rate.campaign import RateChannel
from allanite.applications.constant_rate.estimates import sheet_unit
from allanite.applications.constant_rate.experiments import Standing
from allanite.phrases.phrase import join, say, say_count
from allanite.reporting import figures, words
from allanite.reporting.sheet import Column, Drawing, Face, Note, Part, Table, Where, known, one_sheet
from allanite.statistics import expected

from . import Rows, view

BRAND = say("a constant rate in a short time")

KEY = say(
    "std: scatter of the errors; ± of one: error of one interval by Student's t, all methods at once; predicted: under "
    "the noise model, without these data; total error: root mean square against the true rate; times the least: std "
    "over the least one, with limits by which at the same probability the best method is not called worse, if the "
    "intervals are independent; neighbours: std from differences of neighbouring intervals, which a slow drift does "
    "not reach."
)
CAPTION = say(
    "Error of every method in each interval; below, where the record is long enough, the standard deviation against "
    "the measuring time."
)


def sentences(found: Experiment) -> Iterator[Note]:
    """What was found in the intervals."""
    unit, factor = sheet_unit(found.signal)
    if told(found):
        yield Note(told(found), "strong")
    if found.start.size > 1:
        reference = found.reference / factor
        count = say_count(found.start.size, "{count} interval of {length}", "{count} intervals of {length}",
                          length=words.duration(found.duration))  # fmt: skip
        if found.known:
            against = say("errors against the true rate, {rate:.6g} {unit}", rate=reference, unit=unit)
        else:
            against = say("errors against their mean, {rate:.6g} {unit}", rate=reference, unit=unit)
        yield Note(join("; ", (count, against)))
    if found.drift:
        yield Note(found.drift)
    # why neighbouring intervals scatter more than each is measured
    if found.ranking is not None and found.start.size != 1:
        wandering = [t.symbol for t in found.ranking.model if t.row.slope >= 0]
        if wandering:
            both = math.sqrt(float(expected(found.ranking.model, "adev", found.duration)[0])) / factor
            yield Note(say("predicted is the error of each interval's own mean rate; {terms} moves that from interval "
                           "to interval, so that neighbouring averages differ by {deviation:.3g} {unit} (their Allan "
                           "deviation)", terms=", ".join(wandering), deviation=both, unit=unit))  # fmt: skip
    yield from map(Note, found.notes)
    for method, why in found.left_out.items():
        yield Note(say("{method} is left out: {reason}", method=method, reason=why))


def told(found: Ranking | Experiment) -> str:
    """The recommendation for the length of the intervals: by the noise model, or else by how they scatter."""
    by = (found.ranking or found) if isinstance(found, Experiment) else found
    return say("in {length}: {verdict}", length=words.duration(by.duration), verdict=by.verdict) if by.verdict else ""


def table_of(found: Experiment, level: float) -> Table:
    """The scatter of every method beside the prediction and the least one, to three digits of the least."""
    (unit, factor), scatters, standings = sheet_unit(found.signal), found.scatters(), found.standings(level)
    least = min((v for s in scatters for v in (s.deviation, s.predicted) if v > 0), default=1.0)
    form = f".{max(0, 2 - math.floor(math.log10(least)))}f"
    plain, signed, errors = known(form), known(f"+{form}"), scatters if found.start.size > 1 or found.known else []
    columns: list[tuple[Column, list[Any]]] = [
        (Column(say("method"), "symbol"), list(found.methods)),
        (Column(say("std"), form=plain), [s.deviation for s in scatters]),
        (Column(say("± of one"), form=plain), [s.half / factor for s in standings]),
        (Column(say("predicted"), form=plain), [s.predicted for s in scatters]),
        (Column(say("total error"), form=plain), [s.total for s in scatters]),
        (Column(say("verdict"), "text"), [s.verdict for s in standings]),
        (Column(say("times the least"), form=known(".3g")), [s.ratio for s in standings]),
        (Column(words.interval(level), "interval"), [_between(s) for s in standings]),
        (Column(say("mean rate"), aside=True, form=".8g"), (found.rates.mean(axis=1) / factor).tolist()),
        (Column(say("mean error"), aside=True, form=signed), [s.mean for s in errors]),
        (Column(say("worst"), aside=True, form=signed), [s.worst for s in errors]),
        (Column(say("neighbours"), aside=True, form=plain), [s.neighbours for s in scatters]),
    ]
    shown = [(column, cells) for column, cells in columns
        if any(cell if isinstance(cell, str) else math.isfinite(cell) for cell in cells)]  # fmt: skip
    heads = [column for column, _ in shown]
    heads[1] = replace(heads[1], heading=join(" ", (heads[1].heading, f"[{unit}]")))
    return Table(heads, list(zip(*(cells for _, cells in shown), strict=True)), key=KEY)


def _between(standing: Standing) -> str:
    """The limits of the ratio to the least scatter; nothing for that one itself, or where it is not compared."""
    return f"{standing.low:.3g} .. {standing.high:.3g}" if standing.low != standing.high and standing.verdict else ""


def every_interval(found: Experiment) -> Table:
    """The rate of every interval by every method; on a page, folded."""
    unit, factor = sheet_unit(found.signal)
    methods = (Column(method, form=".7g") for method in found.methods)
    heads = (Column(say("interval")), Column(say("start [s]"), form=".6g"), *methods)
    rates = (found.rates.T / factor).tolist()
    rows = [[i, start, *row] for i, (start, row) in enumerate(zip(found.start.tolist(), rates, strict=True), 1)]
    return Table(heads, rows, say("rate of every interval [{unit}]", unit=unit), details=True, where="page")


def series_of(channel: RateChannel) -> list[Experiment]:
    """The experiment of a channel and those of the other measuring times."""
    if channel.experiment is None:
        return []
    return [channel.experiment, *(e for e in channel.by_duration if e.duration != channel.experiment.duration)]


def certain_limits(estimates: Sequence[RateEstimate]) -> Iterator[str]:
    """What counts without noise prove about the rate."""
    for estimate in (e for e in estimates if e.limits is not None):
        (unit, factor), (low, high) = sheet_unit(estimate.signal), estimate.interval()
        yield say("an ideal staircase: {pulses:.10g} ± 1 pulses alone leave ±{alone:.2g} {unit}, its steps ±{half:.2g} "
                  "{unit}, and no other rate gives these counts without noise", pulses=estimate.details["pulses"],
                  alone=abs(estimate.details["rate of a pulse"] / factor), half=(high - low) / 2 / factor,
                  unit=unit)  # fmt: skip


def by_time(channel: RateChannel) -> Iterator[Table]:
    """The scatter of every method against the measuring time, if there are several, and what the noise predicts."""
    if not any(e.start.size > 1 for e in channel.by_duration):
        return
    ordered = sorted(series_of(channel), key=lambda e: e.duration)
    unit, factor = sheet_unit(ordered[0].signal)
    methods = list(dict.fromkeys(method for e in ordered for method in e.methods))
    measured = say("std against the measuring time [{unit}]", unit=unit)
    predicted = say("predicted std against the measuring time [{unit}]", unit=unit)
    scatters = [{s.method: s for s in e.scatters()} for e in ordered]
    for name, title in (("deviation", measured), ("predicted", predicted)):
        numbers = {m: [getattr(s[m], name) if m in s else math.nan for s in scatters] for m in methods}
        if name == "predicted":
            numbers = {m: each for m, each in numbers.items() if any(map(math.isfinite, each))}
        heading = join(" ", (say("std"), f"[{unit}]")) if len(methods) == 1 and name == "deviation" else ""
        heads = [Column(say("measuring time"), "name"), *(Column(heading or m, form=known(".3g")) for m in numbers)]
        rows = [[words.duration(e.duration), *row] for e, *row in zip(ordered, *numbers.values(), strict=True)]
        if name == "deviation":
            heads.append(Column(say("intervals"), aside=len(methods) > 1))
            rows = [[*row, e.start.size] for row, e in zip(rows, ordered, strict=True)]
            if len(methods) == 1:
                heads.append(Column(say("mean rate"), form=".8g"))
                rows = [[*row, float(e.rates.mean()) / factor] for row, e in zip(rows, ordered, strict=True)]
        if numbers:
            yield Table(heads, rows, title)


HEADINGS = (
    "channel", "method", "duration_s", "intervals", "rate", "rate_low", "rate_high", "mean_error", "std", "std_low",
    "std_high", "neighbours", "three_sigma", "worst", "predicted", "total_error", "half_width", "over_least",
    "over_least_low", "over_least_high", "verdict", "positions", "unit",
)  # fmt: skip


def experiment_rows(found: Experiment) -> Iterator[list[Any]]:
    """The rows of an experiment under `HEADINGS`."""
    unit, factor = sheet_unit(found.signal)
    means = (found.rates.mean(axis=1) / factor).tolist()
    for mean, (method, *numbers), s in zip(means, found.scatters(), found.standings(), strict=True):
        compared = map(finite, (*numbers, s.half / factor, s.ratio, s.low, s.high))
        yield [found.name, method, found.duration, found.start.size, mean, "", "", *compared, s.verdict,
               found.positions, unit]  # fmt: skip


def finite(value: float) -> float | str:
    """A number for a CSV file; empty if there is none."""
    return value if math.isfinite(value) else ""


@view(
    lambda values, fit, level: figures.plot_rates([(experiment, ()) for experiment in values]),
    lambda found, level: (HEADINGS, list(experiment_rows(found))),
)
def experiment_view(found: Experiment, level: float) -> Face:
    """The rates of all methods over the intervals of a record."""
    table = [table_of(found, level)] if found.start.size > 1 else []
    drawing = Drawing(lambda: figures.plot_rates([(found, ())]), say("errors of all methods"), CAPTION)
    return one_sheet(found.name or say("Rate"), BRAND, found.name, (*sentences(found), *table, drawing))


CLOSEUP_CAPTION = say(
    "One interval: the slope of each regression line by its start, each line one sample later than the one before; "
    "below, the first counts with the staircase nearest to them, and what is left over of all."
)


def closeup_parts(found: Closeup, where: Where = "") -> Iterator[Part]:
    """Notes on one interval, and its figure."""
    unit, factor = sheet_unit(found.signal)
    low, high = float(found.slopes.min()) / factor, float(found.slopes.max()) / factor
    lines = say("{lines} regression lines in the interval from {start}, {kept} kept: slopes from {low:.9g} to "
                "{high:.9g} {unit}", lines=found.slopes.size, start=words.duration(found.start),
                kept=int(found.kept.sum()), low=low, high=high, unit=unit)  # fmt: skip
    yield Note(lines, where=where)
    if found.counts.size:
        rms = float(np.sqrt(np.square(found.misfit).mean()))
        yield Note(say("counts less the staircase: {rms:.3g} quanta RMS", rms=rms), where=where)
    yield Drawing(lambda: figures.plot_closeups([found]), say("one interval in detail"), CLOSEUP_CAPTION)


def _slope_rows(found: Closeup, _: float) -> Rows:
    """The regression lines of one interval."""
    unit, factor = sheet_unit(found.signal)
    each = enumerate(zip(found.slopes.tolist(), found.kept.tolist(), strict=True))
    rows = [[i / found.rate, slope / factor, unit, kept] for i, (slope, kept) in each]
    return ["start_s", "slope", "unit", "kept"], rows


@view(lambda values, fit, level: figures.plot_closeups(values), _slope_rows)
def closeup_view(found: Closeup, _: float) -> Face:
    """One interval in detail."""
    name = found.name or say("Rate")
    return one_sheet(name, BRAND, name, closeup_parts(found))
