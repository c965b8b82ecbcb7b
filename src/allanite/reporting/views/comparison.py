"""How comparisons are shown."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

from allanite.comparison.change import OUTCOMES
from allanite.comparison.comparison import Comparison, Pair, Ratios
from allanite.comparison.pooled import Pool, PooledChannel
from allanite.core.display_units import readable_unit
from allanite.core.units import convert
from allanite.phrases.phrase import join, say, say_count
from allanite.reporting import figures, words
from allanite.reporting.sheet import Column, Drawing, Face, Mark, Note, Part, Sheet, Table, header_of
from allanite.statistics import statistic_named

from . import Rows, view
from .changes import OUTCOME_WORDS, change_of, first_of_comparison
from .jobs import job_face

Value = Comparison | Pool

MARKS: dict[str, Mark] = {"smaller": "good", "larger": "alarm", "not resolvable": "quiet"}
"""Mark of a row by the outcome of its coefficient."""

COMPARED = (
    say(
        "The two records are assumed to be independent, unless they contain the same noise, as raw and corrected "
        "samples do: those are compared as a pair, by the correlation of their sum and difference (Pitman and Morgan)."
    ),
    say(
        "The verdict is the likelihood ratio of one common noise model "
        "against a separate model for each record, with the terms that the common model holds (binned powers of the "
        "cosine transform, Whittle likelihood). Because coefficients cannot be negative, and some rest on few powers, "
        "the distribution of the ratio is simulated from the common model (a parametric bootstrap, stopped early where "
        "p is clearly large); nothing is simulated where chi-square gives p below 1e-4."
    ),
    say(
        "The change of a coefficient is the ratio of the two, with profile limits: the ratios that both records "
        "together are consistent with, whatever their other coefficients are. Its p is adjusted for the number of "
        "coefficients by Holm's method. Ramps keep their sign; their limits are Fieller's."
    ),
    say(
        "The ratio of the variances is distributed as a ratio of two weighted sums of chi-squares, which is Fisher's F "
        "with both equivalent degrees of freedom where these are many. All terms are included for it, and coefficients "
        "that cannot be told apart are assumed equal. Neighbouring averaging times share data: of twenty equal ones "
        "about one differs by chance, and its neighbours tend to differ with it."
    ),
)
PAIRS = ("channel", "quantity", "tau_s", "before", "after", "unit", "change_percent", "low_percent", "high_percent",
        "p", "p_holm", "outcome", "edf_before", "edf_after")  # fmt: skip
"""The change of a deviation and its interval refer to the deviation; its square is the ratio of the variances."""


def face_of(value: Value, drawn: bool, level: float, **own: Any) -> Face:
    """What both have, and what is their `own`."""
    source = value.provenance.get("source", "")
    header: list[tuple[str, str]] = [(say("file"), source)] if source and "source 2" not in value.provenance else []
    header += [(say("with") if i else say("compared"), name) for i, name in enumerate(value.names)]
    header += [("" if i else say("assumed"), note) for i, note in enumerate(value.notes)]
    caption = say(
        "Deviation by averaging time with {level} confidence bands, and the ratio of the variances with its {level} "
        "interval at each averaging time.",
        level=words.percent(level),
    )
    label = say("curves with bands, and the ratio of their variances")
    drawing = Drawing(lambda: figures.plot_comparison([value], level), label, caption)
    count = say_count(len(value.names), "Comparison of {count} run", "Comparison of {count} runs")
    names = count, say("what has changed")
    header.append(header_of(value.provenance, ())[-1])
    return replace(job_face(value, names, (), [drawing] if drawn else [], header=header), **own)


def sheet_of(result: Pair | PooledChannel, names: Sequence[str], doubt: bool, tables: Sequence[Table]) -> Sheet:
    """What the sheets of both have: records, grades of their models, the band, the verdict."""
    records = zip(names, result.records or (), strict=False)
    about = [join(": ", (name, join("; ", (words.about(record), *record.history)))) for name, record in records]
    if result.grades:
        graded = (
            say("{record} ({grade})", record=name, grade=grade)
            for name, grade in zip(names, result.grades, strict=False)
        )
        about.append(say("noise models: {models}", models=join(", ", graded)))
    if result.band is not None:
        low, high = result.band
        about.append(say("compared from {low:.4g} to {high:.6g} Hz, the frequencies that all have", low=low, high=high))
    verdict = Note(result.verdict, "alert" if result.refusal else "strong")
    parts: list[Part] = [*(Note(alert, "alert") for alert in result.alerts), verdict, *tables]
    said = join(": ", (result.name, result.verdict)) if result.name else result.verdict
    return Sheet(result.name, about, parts, (said,), doubt or bool(result.refusal))


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
        values = [words.brief(c.before, level), words.brief(c.after, level)]
        if pair.whole is not None:
            values.append("-" if c.frequency is not None else words.brief(pair.whole[c.symbol], level))
        rows.append([
            c.symbol, c.named(words.title(c.symbol, c.signal)), *values, c.before.sheet_unit,
            *change_of(c, level), c.p, c.adjusted, OUTCOME_WORDS[c.outcome],
        ])  # fmt: skip
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
        for change in pair.changes:
            symbol, _, before, after, unit, *rest = change.row(level)
            rows.append([pair.name, symbol, None, before, after, unit, *rest, None, None])
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
    return face_of(
        value,
        any(pair.ratios is not None for pair in value),
        level,
        title=say("Comparison of {first} and {second}", first=value.names[0], second=value.names[1]),
        sheets=sheets,
        close=[
            Note(join(": ", (OUTCOME_WORDS[outcome], meaning)), "quiet", where="text")
            for outcome, meaning in OUTCOMES.items()
            if outcome in met
        ],
        how=[*map(Note, COMPARED), outcomes],
    )
