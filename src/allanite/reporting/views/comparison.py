"""How comparisons and pools are shown."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from allanite.comparison.change import OUTCOMES, Change
from allanite.comparison.comparison import Comparison, Pair, Ratios
from allanite.comparison.pooled import Pool, PooledChannel
from allanite.core.curve import Curve
from allanite.core.display_units import readable_unit
from allanite.core.fit import chance
from allanite.core.units import convert
from allanite.phrases.phrase import Phrase, join, say, say_count
from allanite.reporting import figures, words
from allanite.reporting.digits import digits, upper_limit
from allanite.reporting.first import DETAILS, FIGURES, ChannelRow, Channels, First, Remark, merged, plus_minus
from allanite.reporting.sheet import Column, Drawing, Face, Mark, Note, Part, Sheet, Table, header_of, known
from allanite.statistics import statistic_named

from . import Rows, view
from .channels import names_in_order
from .jobs import job_face

MAX_WITH_VALUES = 2  # channels side by side with the coefficients before and after

OUTCOME_WORDS: dict[str, Phrase] = {
    word: word for word in (say("smaller"), say("larger"), say("no change"), say("not resolvable"))
}
Row = tuple[str, ChannelRow]  # of one channel, with the symbol of the term


def first_of_comparison(value: Comparison, level: float) -> First:
    """The change of every coefficient of every channel."""
    title = say("{first} compared with {second}", first=value.names[0], second=value.names[1])
    changed, same = ([pair for pair in value if pair.changed is is_ and not pair.refusal] for is_ in (True, False))
    verdicts = [say("changed: {names}", names=_names(changed))] if changed else []
    verdicts += [say("no change detected: {names}", names=_names(same))] if same else []
    needed = any(c.outcome == "not resolvable" for c in value.terms)
    legend = [("", say("unknown: a change by a factor of 2 is not excluded."))] if needed else []
    rows = partial(_change_rows, level=level, values=len(value.pairs) <= MAX_WITH_VALUES)
    return replace(_first(value, title, verdicts, rows), legend=legend)


def first_of_pool(value: Pool, level: float) -> First:
    """The common coefficients of every channel."""
    differ, alike = ([c for c in value if c.alike is is_ and not c.refusal] for is_ in (False, True))
    verdicts = [say("differ in {names}", names=_names(differ))] if differ else []
    verdicts += [say("no difference detected in {names}", names=_names(alike))] if alike else []
    first = _first(value, _counted(value), verdicts, partial(_common_rows, level=level))
    apart = [Remark.of(c.name, c.verdict, grave=bool(c.apart)) for c in value if c.apart or c in differ]
    return replace(first, remarks=[*apart, *first.remarks])


def _names(channels: Sequence[Pair | PooledChannel]) -> str:
    return ", ".join(channel.name or say("the noise") for channel in channels)


def _first(
    value: Comparison | Pool, title: str, verdicts: Sequence[str], rows_of: Callable[[Any], Iterator[Row]]
) -> First:
    """What both have: the quantities of the channels side by side, and what limits them."""
    kept = [channel for channel in value if not channel.refusal]
    each = [{row.short or row.label: (symbol, row) for symbol, row in rows_of(channel)} for channel in kept]
    known = {label: pair for own in each for label, pair in own.items()}
    order = ["", *names_in_order(symbol for symbol, _ in known.values())]
    rows = []
    for label, (_, row) in sorted(known.items(), key=lambda item: order.index(item[1][0])):
        own = [of_channel[label][1] if label in of_channel else None for of_channel in each]
        cells = ["" if cell is None else cell.cells[0] for cell in own]
        rows.append(replace(row, cells=cells, rank=min(cell.rank for cell in own if cell is not None)))
    sensors = [record.signal.sensor for channel in kept for record in channel.records or ()]
    answer = [Channels([channel.name or say("channel") for channel in kept], rows, next(iter(sensors), ""))]
    remarks = [Remark.of(channel.name, channel.refusal, grave=True) for channel in value if channel.refusal]
    remarks += [Remark.of(channel.name, text, grave=True) for channel in value
                for text, fits in zip(_graded(channel, value.names), channel.explained, strict=False)
                if not fits]  # fmt: skip
    remarks += [Remark.about_finding("", finding) for finding in value.findings]
    remarks += merged(Remark.of(channel.name, alert) for channel in value for alert in channel.alerts)
    return First(title, join("; ", verdicts), answer, remarks, read=list(value.notes), after=[FIGURES, DETAILS])


def _graded(channel: Pair | PooledChannel, names: Sequence[str]) -> list[str]:
    """How well the model of each record explains it."""
    each = zip(names, channel.grades, strict=False)
    return [say("{record} ({grade})", record=name, grade=grade) for name, grade in each]


def _change_rows(pair: Pair, level: float, *, values: bool) -> Iterator[Row]:
    """Rows of one channel, with the symbols of their terms."""
    whole = say("changed, {p}", p=chance(pair.p)) if pair.p <= pair.alpha else say("no change, {p}", p=chance(pair.p))
    yield "", ChannelRow(say("noise as a whole"), "", "", [whole])
    for c in pair.changes:
        symbol, rank = "" if c.parameter else c.symbol, int(c.outcome == "not resolvable")
        yield c.symbol, ChannelRow(_title(c), symbol, c.unit, [_cell(c, level, values=values)], rank, c.label)


def _common_rows(channel: PooledChannel, level: float) -> Iterator[Row]:
    """Rows of one channel: the common coefficients with limits, and the scatter of records that differ in one."""
    yield "", ChannelRow(say("noise as a whole"), "", "", [chance(channel.test.p) if channel.test else ""])
    for term in channel.terms:
        _, _, value, low, high, *_ = term.row(level)
        absent = low <= 0 <= high
        cell = f"< {upper_limit(max(-low, high)).plain()[0]}" if absent else plus_minus(value, low, high)
        if term.adjusted <= channel.alpha and math.isfinite(term.between):
            cell = join("  ", (cell, say("scatter {share:.2g} %", share=100 * term.between)))
        title = words.title(term.symbol, term.signal)
        yield term.symbol, ChannelRow(title, term.symbol, term.sheet_unit, [cell], int(absent))


def _title(change: Change) -> str:
    """The parameter, or the term, with the frequency of a sinusoid."""
    return change.shape.title if change.parameter else change.named(words.title(change.symbol, change.signal))


def _cell(change: Change, level: float, *, values: bool) -> str:
    """The coefficient before and after, and its change."""
    size, interval = words.change_of(change, level)
    outcome: str = say("unknown")
    if change.outcome != "not resolvable":
        outcome = join(" ", (OUTCOME_WORDS[change.outcome], join("", ("(", size if size != "-" else interval, ")"))))
    both = " -> ".join(words.brief(e, level, change.parameter) for e in (change.before, change.after))
    return join("  ", (both, outcome)) if values else outcome


Value = Comparison | Pool

MARKS: dict[str, Mark] = {"smaller": "good", "larger": "alarm", "not resolvable": "quiet"}
"""Mark of a row by the outcome of its coefficient."""

COMPARED = (
    say("The two records are assumed to be independent, unless they contain the same noise, as raw and corrected "
        "samples do: those are compared as a pair, by the correlation of their sum and difference (Pitman and "
        "Morgan)."),
    say("The verdict is the likelihood ratio of one common noise model against a separate model for each record, with "
        "the terms that the common model holds (binned powers of the cosine transform, Whittle likelihood). Because "
        "coefficients cannot be negative, and some rest on few powers, the distribution of the ratio is simulated "
        "from the common model (a parametric bootstrap, stopped early where p is clearly large); nothing is simulated "
        "where chi-square gives p below 1e-4."),
    say("The change of a coefficient is the ratio of the two, with profile limits: the ratios that both records "
        "together are consistent with, whatever their other coefficients are. Its p is adjusted for the number of "
        "coefficients by Holm's method. Ramps keep their sign; their limits are Fieller's. Sinusoids, and terms with "
        "a time constant or a frequency that both records have, are compared by the intervals of both (Donner and "
        "Zou)."),
    say("The ratio of the variances is distributed as a ratio of two weighted sums of chi-squares, which is Fisher's "
        "F with both equivalent degrees of freedom where these are many. All terms are included for it, and "
        "coefficients that cannot be told apart are assumed equal. Neighbouring averaging times share data: of twenty "
        "equal ones about one differs by chance, and its neighbours tend to differ with it."),
)  # fmt: skip
PAIRS = ("channel", "quantity", "tau_s", "before", "after", "unit", "change_percent", "low_percent", "high_percent",
        "p", "p_holm", "outcome", "edf_before", "edf_after")  # fmt: skip
"""The change of a deviation and its interval refer to the deviation; its square is the ratio of the variances."""


def face_of(value: Value, drawn: bool, level: float, **own: Any) -> Face:
    """What both have, and what is their `own`."""
    source = value.provenance.get("source", "")
    header: list[tuple[str, str]] = [(say("file"), source)] if source and "source 2" not in value.provenance else []
    header += [(say("with") if i else say("compared"), name) for i, name in enumerate(value.names)]
    header += [("" if i else say("assumed"), note) for i, note in enumerate(value.notes)]
    caption = say("Deviation by averaging time with {level} confidence bands, and the ratio of the variances with its "
                  "{level} interval at each averaging time.", level=words.percent(level))  # fmt: skip
    label = say("curves with bands, and the ratio of their variances")
    drawing = Drawing(lambda: figures.plot_comparison([value], level), label, caption)
    names = _counted(value), say("what has changed")
    header.append(header_of(value.provenance, ())[-1])
    return replace(job_face(value, names, (), [drawing] if drawn else [], header=header), **own)


def _counted(value: Value) -> Phrase:
    """What is compared: runs, or axes."""
    if any(isinstance(channel, PooledChannel) and channel.of_axes for channel in value):
        return say_count(len(value.names), "Comparison of {count} axis", "Comparison of {count} axes")
    return say_count(len(value.names), "Comparison of {count} run", "Comparison of {count} runs")


def sheet_of(result: Pair | PooledChannel, names: Sequence[str], doubt: bool, tables: Sequence[Table]) -> Sheet:
    """What the sheets of both have: records, grades of their models, the band, the verdict."""
    records = zip(names, result.records or (), strict=False)
    about = [join(": ", (name, join("; ", (words.about(record), *record.history)))) for name, record in records]
    if result.grades:
        about.append(say("noise models: {models}", models=join(", ", _graded(result, names))))
    if result.band is not None:
        low, high = result.band
        about.append(say("compared from {low:.4g} to {high:.6g} Hz, the frequencies that all have", low=low, high=high))
    verdict = Note(result.verdict, "alert" if result.refusal else "strong")
    parts: list[Part] = [*(Note(alert, "alert") for alert in result.alerts), verdict, *tables]
    sentence = join(": ", (result.name, result.verdict)) if result.name else result.verdict
    return Sheet(result.name, about, parts, (sentence,), "alert" if doubt or result.refusal else "")


def _changes_table(pair: Pair, whole: Comparison, level: float) -> Table:
    values = [*whole.names, *([say("whole")] * (pair.whole is not None))]
    heads = (
        Column("", "symbol"), Column(say("term"), "name"), *map(Column, values), Column(say("unit"), "unit"),
        Column(say("change")), Column(words.interval(level), "interval"),
        Column("p", aside=True, form=words.probability), Column(say("p (Holm)"), aside=True, form=words.probability),
        Column(say("outcome"), "name"),
    )  # fmt: skip
    rows = []
    for c in pair.changes:
        each = [c.before, c.after, *([pair.whole[c.symbol]] if pair.whole is not None and c.frequency is None else [])]
        cells = [*(words.brief(e, level, c.parameter) for e in each), *["-"] * (len(values) - len(each))]
        rows.append([c.symbol, _title(c), *cells, c.unit, *words.change_of(c, level), c.p, c.adjusted,
                     OUTCOME_WORDS[c.outcome]])  # fmt: skip
    return Table(heads, rows, say("coefficients"), marks=[MARKS.get(c.outcome, "") for c in pair.changes])


def _ratio_rows(ratios: Ratios, level: float) -> Iterator[list[float]]:
    """Those of the ratios, with the deviations in the unit that is shown."""
    factor = convert(1.0, ratios.before.unit, readable_unit(ratios.before.unit))
    for tau, before, after, *rest in ratios.rows(level)[1]:
        yield [tau, before * factor, after * factor, *rest]


def _ratios_table(ratios: Ratios, whole: Comparison, levels: tuple[float, float]) -> Table:
    level, alpha = levels
    unit = readable_unit(ratios.before.unit)
    heads = (
        Column("tau [s]", form=".6g"), *(Column(join(" ", (name, f"[{unit}]")), form=".5g") for name in whole.names),
        *(Column(say("edf of {record}", record=name), aside=True, form=".4g") for name in whole.names),
        Column(say("variance ratio"), form=".4g"), Column(words.interval(level), "interval"),
        Column("p", form=words.probability),
    )  # fmt: skip
    rows, marks = [], []
    for *numbers, ratio, low, high, p in _ratio_rows(ratios, level):
        rows.append([*numbers, ratio, f"{low:.4g} .. {high:.4g}", p])
        marks.append(MARKS["smaller" if ratio < 1 else "larger"] if p <= alpha else "")
    title = say("{statistic} and ratio of the variances", statistic=statistic_named(ratios.before.statistic).title)
    return Table(heads, rows, title, marks=marks)


def _compared_rows(value: Comparison, level: float) -> Rows:
    """The changes of the coefficients of each channel, and then of the curves."""
    rows: list[list[Any]] = []
    for pair in value:
        for c in pair.changes:
            label, _, *rest = c.row(level)
            rows.append([pair.name, label, None, *rest, None, None])
    for name, ratios in ((pair.name, pair.ratios) for pair in value if pair.ratios is not None):
        unit = readable_unit(ratios.before.unit)
        for tau, before, after, nu, mu, *limits, p in _ratio_rows(ratios, level):
            percent = [100 * (math.sqrt(v) - 1) for v in limits]
            rows.append([name, ratios.before.statistic, tau, before, after, unit, *percent, p, None, None, nu, mu])
    return PAIRS, rows


@view(lambda values, fit, level: figures.plot_comparison(values, level), _compared_rows, first=first_of_comparison)
def comparison_view(value: Comparison, level: float) -> Face:
    """What has changed in each channel."""
    met = {change.outcome for change in value.terms}
    meanings = [[OUTCOME_WORDS[outcome], meaning] for outcome, meaning in OUTCOMES.items()]
    outcomes = Table((Column(say("outcome"), "name"), Column(say("meaning"), "text")), meanings)
    sheets = []
    for pair in value:
        tables = [_changes_table(pair, value, level)] if pair.changes else []
        tables += [_ratios_table(pair.ratios, value, (level, pair.alpha))] if pair.ratios is not None else []
        sheets.append(sheet_of(pair, value.names, not all(pair.explained), tables))
    title = say("Comparison of {first} and {second}", first=value.names[0], second=value.names[1])
    close = [Note(join(": ", (OUTCOME_WORDS[outcome], meaning)), "quiet", where="text")
             for outcome, meaning in OUTCOMES.items() if outcome in met]  # fmt: skip
    own = {"title": title, "sheets": sheets, "close": close, "how": [*map(Note, COMPARED), outcomes]}
    return face_of(value, any(pair.ratios is not None for pair in value), level, **own)


POOLED = (
    say("The runs are assumed to be independent. One noise model for all is tested by its likelihood ratio against a "
        "separate model for each run, with the distribution simulated from the common model. The common coefficient "
        "is the one that all runs together make most likely; its limits are averaged over the sets of terms that may "
        "be there. Where the runs scatter more than their errors, it is their mean, with weights that include the "
        "variance between runs (Paule and Mandel). The limits are those of Student's t with the degrees of freedom of "
        "the runs (Hartung and Knapp), and never narrower than those of runs that are alike; two runs have the latter "
        "unless they differ."),
    say("Between runs: standard deviation of the runs' coefficients, in percent of the common one. Within runs: the "
        "scatter that equal sensors would show, from the standard errors. The difference is tested by a chi-square of "
        "homogeneity, adjusted by Holm's method. Each run has its own ramp, which the noise model does not contain."),
    say("A run is an outlier if it differs from all the others taken together (likelihood ratio, adjusted by Holm's "
        "method); the worst one is removed and the others are tested again. Variances are averaged with their degrees "
        "of freedom as weights; that they are equal is tested at each averaging time by Bartlett's test."),
)  # fmt: skip
RUNS = ("channel", "quantity", "tau_s", "common", "low", "high", "unit", "between_percent", "within_percent",
        "chi_square", "dof", "p", "p_holm", "edf")  # fmt: skip
"""The runs have columns of their own, after these."""


_SCATTER = known(".3g", "-", " %")


def _terms_table(channel: PooledChannel, level: float) -> Table:
    scatter = (say("between records"), say("within a record"))
    scatter = (say("between axes"), say("within an axis")) if channel.of_axes else scatter
    heads = (
        Column("", "symbol"), Column(say("term"), "name"), Column(say("common")),
        Column(words.interval(level), "interval"), Column(say("unit"), "unit"),
        *(Column(heading, form=_SCATTER) for heading in scatter),
        Column(say("chi-square"), aside=True, form=".3g"), Column(say("dof"), aside=True, form="g"),
        Column("p", aside=True, form=words.probability), Column(say("p (Holm)"), form=words.probability),
    )  # fmt: skip
    rows = []
    for term in channel.terms:
        symbol, title, value, low, high, *rest = term.row(level)
        limit = say("below {limit}", limit=upper_limit(high).plain()[0])
        rows.append([symbol, title, *(digits(value, low, high).plain() if value else ("-", limit)), *rest])
    marks: list[Mark] = ["alarm" if term.adjusted <= channel.alpha else "" for term in channel.terms]
    return Table(heads, rows, say("what the records have in common"), marks=marks)


def _runs_table(channel: PooledChannel, whole: Pool, level: float) -> Table:
    heads = (Column(say("record"), "name"), *(Column(f"{term.symbol} [{term.sheet_unit}]") for term in channel.terms),
        Column(say("apart, p"), form=lambda p: "" if p is None else words.probability(p)))  # fmt: skip
    each = zip(whole.names, channel.fits, strict=True)
    rows = [[name, *(words.brief(fit[t.symbol], level) for t in channel.terms), channel.apart.get(name)]
            for name, fit in each]  # fmt: skip
    marks: list[Mark] = ["alarm" if name in channel.apart else "" for name in whole.names]
    return Table(heads, rows, say("record by record"), marks=marks)


def _curve_rows(channel: PooledChannel, curve: Curve, level: float) -> Iterator[list[float]]:
    """tau, deviation, its limits, edf and p of the common curve, then the deviation of each run."""
    assert channel.p is not None  # noqa: S101 - comes with the curve
    unit = readable_unit(curve.unit)
    whole, runs = curve.to(unit), [curve.to(unit).deviation for curve in channel.curves]
    numbers = (whole.tau, whole.deviation, *whole.interval(level), whole.edf, channel.p, *runs)
    yield from (list(row) for row in zip(*(column.tolist() for column in numbers), strict=True))


def _curve_table(channel: PooledChannel, curve: Curve, level: float) -> Table:
    whole = join(" ", (say("all records"), f"[{readable_unit(curve.unit)}]"))
    heads = (Column("tau [s]", form=".6g"), Column(whole), Column(words.interval(level), "interval"),
        Column(say("edf"), form=".4g"), Column(say("p of one variance"), form=words.probability))  # fmt: skip
    rows, marks = [], list[Mark]()
    for tau, value, low, high, edf, p, *_ in _curve_rows(channel, curve, level):
        rows.append([tau, *digits(value, low, high).plain(), edf, p])
        marks.append("alarm" if p <= channel.alpha else "")
    title = say("{statistic} of all records", statistic=statistic_named(curve.statistic).title)
    return Table(heads, rows, title, marks=marks)


def _pooled_rows(value: Pool, level: float) -> Rows:
    """The coefficients of each channel, and then the curves."""
    rows: list[list[Any]] = []
    for channel in value:
        for term in channel.terms:
            symbol, _, *numbers = term.row(level)
            runs = [None if e.value is None else e.to(term.sheet_unit) for e in term.runs]
            rows.append([channel.name, symbol, None, *numbers, None, *runs])
    for channel, curve in ((channel, channel.curve) for channel in value if channel.curve is not None):
        unit = readable_unit(curve.unit)
        for tau, size, low, high, edf, p, *each in _curve_rows(channel, curve, level):
            rows.append([channel.name, curve.statistic, tau, size, low, high, unit, *[None] * 4, p, None, edf, *each])
    return (*RUNS, *value.names), rows


@view(lambda values, fit, level: figures.plot_comparison(values, level), _pooled_rows, first=first_of_pool)
def pool_view(value: Pool, level: float) -> Face:
    """What the runs of each channel have in common."""
    sheets = []
    for channel in value:
        tables = [_terms_table(channel, level), _runs_table(channel, value, level)] if channel.terms else []
        if channel.curve is not None:
            tables.append(_curve_table(channel, channel.curve, level))
        doubt = not channel.alike or bool(channel.apart) or not all(channel.explained)
        sheets.append(sheet_of(channel, value.names, doubt, tables))
    own = {"brand": say("what records have in common"), "sheets": sheets, "how": [*map(Note, POOLED)]}
    return face_of(value, any(channel.curve is not None for channel in value), level, **own)
