"""How an experiment is shown: the rates of all methods over the intervals of a record."""

import math
from collections.abc import Iterator, Sequence
from typing import Any

from allanite.applications.rate import Experiment, Ranking
from allanite.applications.rate.estimates import rate_factor
from allanite.core.units import unit_of
from allanite.phrases.phrase import join, say, say_count
from allanite.reporting import figures, words
from allanite.reporting.sheet import Column, Drawing, Face, Note, Sheet, Table
from allanite.statistics import expected

from . import View

BRAND = say("a constant rate in a short time")

KEY = say(
    "std: scatter of the errors, with its 68 % interval; neighbours: the same from differences of neighbouring "
    "intervals, which a slow drift does not reach; predicted: under the noise model, without these data."
)
CAPTION = say(
    "Error of every method in each interval; below, where the record is long enough, the standard deviation against "
    "the measuring time."
)


def _experiment_face(found: Experiment, level: float) -> Face:
    table = (table_of(found),) if found.start.size > 1 else ()
    drawing = Drawing(lambda: figures.plot_rates([(found, ())]), say("errors of all methods"), CAPTION)
    return Face(found.name or say("Rate"), BRAND, (Sheet(found.name, parts=(*sentences(found), *table, drawing)),))


def sentences(found: Experiment) -> Iterator[Note]:
    """What was found in the intervals."""
    unit = found.signal.sheet[0]
    if found.ranking is not None:
        yield Note(told(found.ranking), "strong")
    if found.start.size > 1:
        reference = found.reference / unit_of(unit).factor
        length = words.duration(found.duration)
        count = say_count(
            found.start.size, "{count} interval of {length}", "{count} intervals of {length}", length=length
        )
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
            unit = found.signal.sheet[0]
            both = math.sqrt(float(expected(found.ranking.model, "adev", found.duration)[0])) / unit_of(unit).factor
            yield Note(
                say(
                    "predicted is the error of each interval's own mean rate; {terms} moves that from interval to "
                    "interval, so that neighbouring averages differ by {deviation:.3g} {unit} (their Allan deviation)",
                    terms=", ".join(wandering),
                    deviation=both,
                    unit=unit,
                )
            )
    yield from map(Note, found.notes)
    for method, why in found.left_out.items():
        yield Note(say("{method} is left out: {reason}", method=method, reason=why))


def told(ranking: Ranking) -> str:
    """The recommendation for the length of the intervals."""
    return say("in {length}: {verdict}", length=words.duration(ranking.duration), verdict=ranking.verdict)


def table_of(found: Experiment) -> Table:
    """The scatter of every method, rounded to three digits of the least."""
    unit = found.signal.sheet[0]
    _, rows = found.rows(unit)
    least = min((row[2] for row in rows if row[2] > 0), default=1.0)
    places = max(0, 2 - math.floor(math.log10(least)))
    heads = (
        Column(say("method"), "symbol"), Column(join(" ", (say("std"), f"[{unit}]"))),
        Column(words.interval(0.68), "interval"), Column(say("neighbours")), Column(say("predicted")),
        Column(say("3 sigma"), aside=True), Column(say("mean error"), aside=True), Column(say("worst"), aside=True),
    )  # fmt: skip
    cells = []
    for method, mean, std, low, high, neighbours, bound, worst, predicted in rows:
        said = f"{predicted:.{places}f}" if math.isfinite(predicted) else say("not predicted")
        first, beside, three = (f"{v:.{places}f}" for v in (std, neighbours, bound))
        limits = f"{low:.{places}f} .. {high:.{places}f}"
        cells.append([method, first, limits, beside, said, three, f"{mean:+.{places}f}", f"{worst:+.{places}f}"])
    return Table(heads, cells, key=KEY)


def every_interval(found: Experiment) -> Table:
    """The rate of every interval by every method; on a page, folded."""
    unit = found.signal.sheet[0]
    heads = (Column(say("interval")), Column(say("start [s]")), *(Column(method) for method in found.methods))
    rates = found.rates.T / rate_factor(unit, found.signal)
    rows = [
        [str(i), f"{start:.6g}", *(f"{rate:.7g}" for rate in row)]
        for i, (start, row) in enumerate(zip(found.start.tolist(), rates.tolist(), strict=True), 1)
    ]
    return Table(heads, rows, say("rate of every interval [{unit}]", unit=unit), details=True, where="page")


def by_time(series: Sequence[Experiment]) -> Iterator[Table]:
    """The scatter of every method against the measuring time, and what the noise predicts of it."""
    ordered = sorted((e for e in series if e.start.size > 1), key=lambda e: e.duration)
    unit = ordered[0].signal.sheet[0]
    methods = list(dict.fromkeys(method for e in ordered for method in e.methods))
    counts = [str(e.start.size) for e in ordered]
    yield _against_time(ordered, methods, say("std against the measuring time [{unit}]", unit=unit), counts)
    predicted = [m for m in methods if any(math.isfinite(_number(e, m, "predicted")) for e in ordered)]
    if predicted:
        yield _against_time(ordered, predicted, say("predicted std against the measuring time [{unit}]", unit=unit))


def _against_time(
    series: Sequence[Experiment], methods: Sequence[str], title: str, counts: Sequence[str] = ()
) -> Table:
    """A row a measuring time; the measured scatter where there are `counts` of intervals, else the predicted."""
    name = "deviation" if counts else "predicted"
    heads = [Column(say("measuring time"), "name"), *map(Column, methods)]
    rows = []
    for e in series:
        numbers = (_number(e, method, name) for method in methods)
        rows.append([words.duration(e.duration), *(f"{v:.3g}" if math.isfinite(v) else "" for v in numbers)])
    if counts:
        heads.append(Column(say("intervals"), aside=True))
        rows = [[*row, count] for row, count in zip(rows, counts, strict=True)]
    return Table(heads, rows, title)


def _number(found: Experiment, method: str, name: str) -> float:
    """A number of the scatter of a method, in the unit of data sheets; NaN where the method was left out."""
    if method not in found.methods:
        return math.nan
    return float(getattr(found.scatter(method), name)) / rate_factor(found.signal.sheet[0], found.signal)


HEADINGS = (
    "channel", "method", "duration_s", "intervals", "rate", "rate_low", "rate_high", "mean_error", "std", "std_low",
    "std_high", "neighbours", "three_sigma", "worst", "predicted", "unit",
)  # fmt: skip


def experiment_rows(found: Experiment) -> Iterator[list[Any]]:
    """The rows of an experiment under `HEADINGS`."""
    unit = found.signal.sheet[0]
    means = dict(zip(found.methods, found.rates.mean(axis=1) / rate_factor(unit, found.signal), strict=True))
    for method, *numbers in found.rows(unit)[1]:
        yield [found.name, method, found.duration, found.start.size, float(means[method]), "", "",
               *map(finite, numbers), unit]  # fmt: skip


def finite(value: float) -> float | str:
    """A number for a CSV file; empty if there is none."""
    return value if math.isfinite(value) else ""


EXPERIMENT = View(
    _experiment_face,
    lambda values, fit, level: figures.plot_rates([(found, ()) for found in values]),
    lambda found, level: (HEADINGS, list(experiment_rows(found))),
)
