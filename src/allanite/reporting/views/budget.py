"""How a budget is shown."""

from collections.abc import Sequence
from typing import Any

from allanite.applications.signals import Budget, StageNoise, TorqueScale
from allanite.applications.signals.budgeting import BudgetChannel, BudgetStudy
from allanite.phrases.phrase import join, say, say_count
from allanite.reporting import figures, words
from allanite.reporting.digits import printable
from allanite.reporting.sheet import Column, Drawing, Face, Note, Part, Sheet, Table, header_of, known

from . import Rows, view
from .jobs import LEVELS, channel_sheet, job_face, source_of

BRAND = say("what rounding adds to the noise")
HOW = (
    say(
        "A stage of b bits over ± full scale rounds to steps s = 2 × full scale / 2ᵇ, and adds errors of variance "
        "s²/12. Errors of a rate (of a current, of a voltage) are white noise of the rate, N = s √(Δt/12), Δt being "
        "the sample interval: slope −1/2 on the Allan curve. Only errors of an angle are quantization noise, "
        "Q = s/√12: slope −1. This holds where the noise before the rounding is above 0.3 steps."
    ),
    say(
        "Bits enough: the fewest with which the share of the measured variance is below 1 %. Codes: how many different "
        "ones occur. Missing: those that never occur between frequent ones. Both are omitted where the samples lie on "
        "no grid of this step, because they were filtered, averaged or rounded again behind it."
    ),
)
WITHOUT = say("no stage is named: --rates writes the rate, --stage 'NAME BITS SCALE' computes what a converter adds")
CAPTION = say("What each stage adds, by its bits; below the dashed line its share of the variance of the measured "
              "noise is less than 1 %.")  # fmt: skip
COLUMNS = (
    Column(say("stage"), "name"), Column(say("bits")), Column(say("full scale"), aside=True),
    Column(say("step"), aside=True), Column(say("makes"), "symbol"), Column(say("adds"), form=known(".4g")),
    Column(say("measured"), form=known(".4g")), Column(say("unit"), "unit"),
    Column(say("share"), form=known(".2g", unit=" %")), Column(say("bits enough")), Column(say("codes"), aside=True),
    Column(say("missing"), aside=True), Column(say("clipped"), aside=True),
)  # fmt: skip


HEADINGS = ("channel", "stage", "bits", "full_scale", "step", "unit", "makes", "coefficient", "measured",
    "coefficient_unit", "share_percent", "bits_enough", "distinct_codes", "missing_codes", "clipped")  # fmt: skip


def sentence(s: StageNoise) -> str:
    """What the budget says of a stage."""
    unit = s.sheet_unit
    adds = say("{stage} adds {term} = {value} {unit}", stage=printable(s.stage.name), term=s.symbol,
               value=_number(s.to(s.coefficient)), unit=unit)  # fmt: skip
    if s.measured is None:
        if not s.limit:
            return join("", (adds, "."))
        limit = _number(s.to(s.limit))
        return say(
            "{adds}; {term} was not found, below {limit} {unit}.", adds=adds, term=s.symbol, limit=limit, unit=unit
        )
    if s.matters:
        fate = say_count(s.enough or 0, "{count} bit would bring it below 1 %", "{count} bits would bring it below 1 %")
    else:
        fate = say("more bits would change nothing")
    return say("{adds}, {share} of the measured variance: {fate}.", adds=adds,
               share="" if s.share is None else words.percent(s.share, 2), fate=fate)  # fmt: skip


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.4g}"


def _sheet(channel: BudgetChannel) -> Sheet:
    budget, name = channel.budget, channel.record.name
    if budget is None:
        refused = say("{channel}: no result: {reason}", channel=name, reason=channel.refusal)
        return channel_sheet(channel, (), (refused,), "alert")
    told = [sentence(s) for s in budget.stages] or [WITHOUT]
    named = tuple(join(": ", (name or say("channel"), each)) for each in told)
    sentences = (Note(each, where="text") for each in told)
    drawing = Drawing(lambda: figures.plot_budgets([budget]), say("noise of rounding by bits"), CAPTION)
    rows = []
    for s in budget.stages:
        stage, bits, _, step, unit, symbol, size, measured, *rest = _numbers(s)
        if measured is None and s.limit:
            measured = f"< {_number(s.to(s.limit))}"
        rows.append([stage, bits, f"+-{s.stage.reach:g} {unit}", f"{step:.4g} {unit}", symbol, size, measured, *rest])
    table = Table(COLUMNS, rows)
    table = table.only([i for i in range(len(COLUMNS)) if any(row[i] for row in table.rows)])  # not those without cells
    parts: tuple[Part, ...] = (*sentences, *((table, drawing) if rows else ()))
    return channel_sheet(channel, parts, named, LEVELS.get(budget.noise.validity, ""))


def _found(*studies: BudgetStudy) -> list[Budget]:
    return [channel.budget for study in studies for channel in study if channel.budget is not None]


def _rows(budgets: Sequence[Budget]) -> Rows:
    """The coefficients in data-sheet units."""
    return HEADINGS, [[budget.record.name, *_numbers(s)] for budget in budgets for s in budget.stages]


def _numbers(s: StageNoise) -> list[Any]:
    codes = (None, None) if s.codes is None else (s.codes.distinct, s.codes.missing)
    return [s.stage.name, s.stage.bits, s.stage.full_scale, s.stage.step, s.stage.unit, s.symbol, s.to(s.coefficient),
            s.to(s.measured), s.sheet_unit, None if s.share is None else 100 * s.share, s.enough, *codes,
            s.clipped]  # fmt: skip


@view(lambda values, fit, level: figures.plot_budgets(_found(*values)), lambda study, level: _rows(_found(study)))
def study_view(study: BudgetStudy, level: float) -> Face:
    """The stages of each channel."""
    scale, notes = study.settings.torquer, study.notes
    if isinstance(scale, TorqueScale):
        notes = (say("{scale}, of {sides:g} coil side(s)", scale=str(scale), sides=scale.sides), *notes)
    elif scale is not None:
        notes = (say("K_i = {factor:.6g} rad/s per A, as given", factor=scale), *notes)
    title = say("Rounding in {source}", source=source_of(study))
    sheets, header = [_sheet(channel) for channel in study], header_of(study.provenance, notes)
    return job_face(study, (title, BRAND), sheets, header=header, how=[*map(Note, HOW)], notes=notes)


@view(lambda values, fit, level: figures.plot_budgets(values), lambda budget, level: _rows([budget]))
def budget_view(budget: Budget, _: float) -> Face:
    """The stages of one channel."""
    return Face(say("Rounding in {source}", source=budget.record.name or say("a record")), BRAND,
                (_sheet(BudgetChannel(budget.record, budget, budget.alerts)),))  # fmt: skip
