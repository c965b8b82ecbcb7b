"""How measured rates are shown."""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from allanite.core.errors import UsageError
from allanite.core.language import join, say, say_count
from allanite.core.record import Record
from allanite.core.units import unit_of
from allanite.rate import RATE_ESTIMATORS, Closeup, Experiment, Ranking, RateEstimate, closeup
from allanite.rate.estimates import rate_factor
from allanite.rate.study import RateChannel, RateSettings, RateStudy
from allanite.reporting import figures, words
from allanite.reporting.digits import digits
from allanite.reporting.sheet import Column, Drawing, Face, Note, Part, Sheet, Table, columns
from allanite.statistics import expected

from . import Rows, View
from .closeup import parts as closeup_parts
from .jobs import channel_sheet, job_face, source_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BRAND = say("a constant rate in a short time")

KEY = say(
    "std: scatter of the errors, with its 68 % interval; neighbours: the same from differences of neighbouring "
    "intervals, which a slow drift does not reach; predicted: under the noise model, without these data."
)
CAPTION = say(
    "Error of every method in each interval; below, where the record is long enough, the standard deviation against "
    "the measuring time."
)
NO_ERROR = say("no standard errors: give a noise model (--noise)")


def _face(study: RateStudy, level: float) -> Face:
    sheets = [_sheet(channel, study.settings, level) for channel in study.channels]
    title = say("Rate of {source}", source=source_of(study))
    return replace(job_face(study, (title, BRAND), sheets), how=[_methods()])


def _sheet(channel: RateChannel, settings: RateSettings, level: float) -> Sheet:
    given = settings.noise
    name, found = channel.record.name, channel.experiment
    said: str = say("no result: {reason}", reason=channel.refusal) if channel.refusal else ""
    if found is not None and found.ranking is not None:
        said = _advice(found)
    verdicts = (join(", ", (name or say("the channel"), said)),) if said else ()
    doubt = bool(channel.refusal) or (given is None and (channel.noise is None or not channel.noise.explained))
    return channel_sheet(channel, _parts(channel, settings, level), verdicts, doubt=doubt)


def _parts(channel: RateChannel, settings: RateSettings, level: float) -> Iterator[Part]:
    given = settings.noise
    if channel.noise is not None and channel.noise.explained:
        yield Note(say("noise: {model}", model=str(channel.noise.fit.model)))
    elif given is not None and not channel.refusal:
        yield Note(say("noise as given: {model}", model=str(given)))
    found = channel.experiment
    if found is None:
        return
    yield from _sentences(found)
    if channel.bias is not None:
        yield Note(say("bias by reversal: {bias}", bias=channel.bias.words(level=level)))
    if channel.north is not None:
        yield Note(channel.north.words(), "strong")
    if found.start.size > 1:
        yield _table(found)
    yield from _estimates(channel.estimates, level)
    yield Drawing(lambda: _draw([channel]), say("errors of all methods"), CAPTION)
    if found.start.size > 1:
        yield _every(found)
    if isinstance(channel.record, Record):
        yield from closeup_parts(first_of(channel.record, found, settings), "page")


def first_of(record: Record, found: Experiment, settings: RateSettings) -> Closeup:
    """The first interval of an experiment in detail."""
    return closeup(record, settings=settings.experiment, start=float(found.start[0]))


def _every(found: Experiment) -> Table:
    """The rate of every interval by every method; on a page, folded."""
    unit = found.signal.sheet[0]
    heads = (Column(say("interval")), Column(say("start [s]")), *(Column(method) for method in found.methods))
    rates = found.rates.T / rate_factor(unit, found.signal)
    rows = [
        [str(i), f"{start:.6g}", *(f"{rate:.7g}" for rate in row)]
        for i, (start, row) in enumerate(zip(found.start.tolist(), rates.tolist(), strict=True), 1)
    ]
    return Table(heads, rows, say("rate of every interval [{unit}]", unit=unit), details=True, where="page")


def interval_rows(study: RateStudy) -> Rows:
    """The rate of every interval by every method, unrounded, in the unit of data sheets."""
    heads = ("channel", "interval", "start_s", "duration_s", "method", "rate", "error", "unit")
    rows = []
    for found in (channel.experiment for channel in study if channel.experiment is not None):
        unit = found.signal.sheet[0]
        factor = rate_factor(unit, found.signal)
        for i, start in enumerate(found.start.tolist()):
            for method, rate, error in zip(found.methods, found.rates[:, i], found.errors[:, i], strict=True):
                numbers = (float(rate) / factor, float(error) / factor)
                rows.append([found.name, i + 1, start, found.duration, method, *numbers, unit])
    return heads, rows


def _advice(found: Experiment) -> str:
    return "" if found.ranking is None else _told(found.ranking)


def _told(ranking: Ranking) -> str:
    return say("in {length}: {verdict}", length=words.duration(ranking.duration), verdict=ranking.verdict)


def _sentences(found: Experiment) -> Iterator[Note]:
    """What was found in the intervals."""
    unit = found.signal.sheet[0]
    if found.ranking is not None:
        yield Note(_advice(found), "strong")
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
    yield from _wander(found)
    yield from map(Note, found.notes)
    for method, why in found.left_out.items():
        yield Note(say("{method} is left out: {reason}", method=method, reason=why))


def _wander(found: Experiment) -> Iterator[Note]:
    """Why neighbouring intervals scatter more than each is measured."""
    if found.ranking is None or found.start.size == 1:
        return
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


def _table(found: Experiment) -> Table:
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


def _estimates(estimates: Sequence[RateEstimate], level: float) -> Iterator[Part]:
    if not estimates:
        return
    rows = []
    for e in estimates:
        unit = e.signal.sheet[0]
        factor = rate_factor(unit, e.signal)
        rows.append([e.method, *digits(e.to(unit), *(v / factor for v in e.interval(level)), figures=8).plain(), unit])
    heads = (Column(say("method"), "symbol"), Column(say("rate")), Column(words.interval(level), "interval"))
    yield Table((*heads, Column(say("unit"), "unit")), rows)
    if any(math.isnan(e.standard_error) and e.limits is None for e in estimates):
        yield Note(NO_ERROR)
    certain = [e.method for e in estimates if e.limits is not None]
    if certain:
        methods = ", ".join(certain)
        yield Note(
            say("the limits of {methods} are certain: no other rate gives these counts without noise", methods=methods)
        )


def _methods() -> Table:
    heads = (
        Column(say("method"), "symbol"), Column(say("what it is"), "text"), Column(say("formula"), "formula"),
        Column(say("optimal under"), "text"), Column(say("source"), "text"),
    )  # fmt: skip
    rows = [[r.name, r.title, r.formula, r.assumes, r.reference] for r in RATE_ESTIMATORS.values()]
    return Table(heads, rows, say("the methods"))


def _draw(channels: Iterable[RateChannel]) -> "Figure":
    shown = [(c.experiment, c.by_duration) for c in channels if c.experiment is not None]
    if not shown:
        raise UsageError("there is nothing to draw: no channel was measured")
    return figures.plot_rates(shown)


HEADINGS = (
    "channel", "method", "duration_s", "intervals", "rate", "rate_low", "rate_high", "mean_error", "std", "std_low",
    "std_high", "neighbours", "three_sigma", "worst", "predicted", "unit",
)  # fmt: skip


def _rows(study: RateStudy, level: float) -> Rows:
    return HEADINGS, [row for channel in study.channels for row in _channel_rows(channel, level)]


def _channel_rows(channel: RateChannel, level: float) -> Iterator[list[Any]]:
    found = channel.experiment
    series = [] if found is None else [found, *(e for e in channel.by_duration if e.duration != found.duration)]
    for one in series:
        yield from _experiment_rows(one) if one.start.size > 1 else ()
    for e in channel.estimates:
        unit = e.signal.sheet[0]
        numbers = [v / rate_factor(unit, e.signal) for v in (e.value, *e.interval(level), e.standard_error)]
        yield [channel.record.name, e.method, e.duration, 1, *map(_finite, numbers[:3]), *[""] * 7,
               _finite(numbers[3]), unit]  # fmt: skip


def _experiment_rows(found: Experiment) -> Iterator[list[Any]]:
    unit = found.signal.sheet[0]
    means = dict(zip(found.methods, found.rates.mean(axis=1) / rate_factor(unit, found.signal), strict=True))
    for method, *numbers in found.rows(unit)[1]:
        yield [found.name, method, found.duration, found.start.size, float(means[method]), "", "",
               *map(_finite, numbers), unit]  # fmt: skip


def _finite(value: float) -> float | str:
    return value if math.isfinite(value) else ""


def _experiment_face(found: Experiment, level: float) -> Face:
    table = (_table(found),) if found.start.size > 1 else ()
    drawing = Drawing(lambda: figures.plot_rates([(found, ())]), say("errors of all methods"), CAPTION)
    return Face(found.name or say("Rate"), BRAND, (Sheet(found.name, parts=(*_sentences(found), *table, drawing)),))


def _ranking_face(ranking: Ranking, level: float) -> Face:
    heads = say("method"), say("standard error, {unit}", unit=ranking.signal.sheet[0]), say("over the bound")
    _, rows = ranking.rows()
    cells = [[method, *(f"{v:.4g}" if math.isfinite(v) else "" for v in numbers)] for method, *numbers in rows]
    parts = (
        Note(_told(ranking), "strong"),
        Note(say("noise: {model}", model=str(ranking.model))),
    )
    sheet = Sheet(say("methods"), parts=(*parts, Table(columns(*heads), cells)))
    return Face(say("Methods"), BRAND, (sheet,), how=(_methods(),))


def _estimate_face(found: RateEstimate, level: float) -> Face:
    alerts = (Note(str(finding), "alert") for finding in found.findings)
    sheet = Sheet(found.name or say("rate"), found.history, (*alerts, *_estimates([found], level)))
    return Face(found.name or say("Rate"), BRAND, (sheet,))


STUDY = View(
    _face,
    lambda values, fit, level: _draw(channel for study in values for channel in study),
    _rows,
    lambda study, level: interval_rows(study),
)
EXPERIMENT = View(
    _experiment_face,
    lambda values, fit, level: figures.plot_rates([(found, ()) for found in values]),
    lambda found, level: (HEADINGS, list(_experiment_rows(found))),
)
RANKING = View(_ranking_face, rows=lambda ranking, level: ranking.rows())
ESTIMATE = View(_estimate_face)
