"""How plans of recordings, checks of the identification and bounds are shown."""

import math
from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np

from allanite.core.fit import Fit
from allanite.core.model import Model
from allanite.phrases.phrase import join, say, say_count
from allanite.planning.bound import Bound, name_of, title_of
from allanite.planning.plan import RecordingPlan
from allanite.planning.selfcheck import SelfCheck
from allanite.reporting import figures, words
from allanite.reporting.sheet import Column, Drawing, Face, Note, Part, Plot, Table, one_sheet
from allanite.study.modelled import Modelled, RecordingPlans

from . import View, view
from .modelled import ModelledForm, job_rows

PLANNED = say(
    "Least relative standard errors (1 sigma, Cramer-Rao bound) of the coefficients by length of the record. A term "
    "is called identified up to 25 %; above 40 % it is hardly seen. The default method reaches the bound where it is "
    "below about 12 %."
)
KNOWN = say("if it is known which terms there are")
SEARCHED = say("if all five terms are looked for, as analyze does")
CHECKED = say(
    "bound: least relative standard error (Cramer-Rao); bias and spread of the coefficient, relative to the truth; "
    "coverage: share of the printed intervals that contain the truth; found: share of records in which the term is "
    "reported as present. +- is the Monte-Carlo standard error."
)
DRAWN = say("Relative standard error by the length of the record. The horizontal line is the accuracy that is wanted.")
BOUNDED = say("Least relative standard errors (1 sigma, Cramer-Rao bound) of the parameters.")


def expected_values(model: Model) -> dict[str, tuple[str, str]]:
    """Each parameter's value, and the unit of data sheets that it is in."""
    found = {}
    for t in model:
        name, unit = name_of(t, model), t.signal.sheet[t.row.power]
        found[name] = (f"{t.to(unit):.4g}", unit)
        for parameter, value in zip(t.row.parameters, t.shape, strict=True):
            found[f"{name} {title_of(parameter)}"] = (f"{value:.4g}", parameter.unit)
    return found


def _percent(error: float) -> str:
    """A relative standard error."""
    return "> 100 %" if error >= 1 else words.percent(error, 2) or "-"


@partial(
    ModelledForm,
    say("plan"),
    say("Plan for"),
    say("how long to record"),
    PLANNED,
    lambda plan: join(
        ", ", (f"{plan.rate:.8g} Hz", say("a ramp of unknown size is allowed for") if plan.ramp else say("no ramp"))
    ),
)
def plan_form(plan: RecordingPlan, _: Modelled | None) -> Iterator[Part]:
    """The accuracy of each coefficient by the length of the record."""
    wanted = say("for {accuracy}", accuracy=_percent(plan.accuracy))
    heads = (
        Column("", "symbol"), Column(say("expected")), Column(say("unit"), "unit"),
        *(Column(words.duration(d), form=_percent) for d in plan.durations), Column(wanted),
    )  # fmt: skip
    values = expected_values(plan.model)
    kinds = [("", plan.errors, plan.needed)]
    if not np.array_equal(plan.errors, plan.searched, equal_nan=True):  # not every term is there
        kinds = [(KNOWN, plan.errors, plan.needed), (SEARCHED, plan.searched, plan.searched_needed)]
    for title, errors, needed in kinds:
        rows = []
        for name, row, least in zip(plan.names, errors.tolist(), needed.tolist(), strict=True):
            length: str = say("> 100 years") if math.isfinite(least) else say("never")
            if least < 100 * 365.25 * 86400:
                length = words.duration(float(f"{least:.2g}"))
            rows.append([name, *values.get(name, ("", "")), *row, length])
        yield Table(heads, rows, title)
    label = say("relative standard errors by length of the record")
    yield Drawing(lambda: _plot_plans([plan], None, 0.95), label, DRAWN)


def _plot_plans(values: Sequence[RecordingPlan | RecordingPlans], _: Fit | None, __: float) -> Plot:
    plans: list[tuple[str, RecordingPlan]] = []
    for value in values:
        if isinstance(value, RecordingPlan):
            plans.append(("", value))
        else:
            plans += [(c.name, c.result) for c in value if isinstance(c.result, RecordingPlan)]
    return figures.plot_plans(plans)


@partial(
    ModelledForm,
    say("check"),
    say("Check of the identification:"),
    say("simulated records, identified"),
    CHECKED,
    lambda check: say_count(
        check.records,
        "{count} record of {samples} at {rate:.8g} Hz ({length}), intervals at {level}",
        "{count} records of {samples} at {rate:.8g} Hz ({length}), intervals at {level}",
        samples=say_count(check.size, "{count} sample", "{count} samples"),
        rate=check.rate,
        length=words.duration(check.size / check.rate),
        level=words.percent(check.level),
    ),
)
def check_form(check: SelfCheck, _: Modelled | None) -> Iterator[Part]:
    """What the identification finds of known noise."""
    values = expected_values(check.model)
    rows = [
        [c.symbol, *(values.get(c.symbol, ("", "")) if c.truth else (say("absent"), "")),
         c.bound, c.bias, c.spread, c.coverage, c.found]
        for c in check.terms
    ]  # fmt: skip
    measured = (say("bias of the estimate"), say("spread"), say("coverage"), say("found"))
    heads = (
        Column("", "symbol"), Column(say("truth")), Column(say("unit"), "unit"), Column(say("bound"), form=_percent),
        *(Column(heading, form=_with_error) for heading in measured),
    )  # fmt: skip
    yield Table(heads, rows)
    share = _with_error(check.unexplained)
    yield Note(say("records whose model is reported not to explain them: {share}", share=share))
    yield from (Note(note) for note in check.notes)


def _with_error(measured: tuple[float, float]) -> str:
    """A share with its error in percent, to the digits that the error leaves."""
    value, error = measured
    if math.isnan(value):
        return "-"
    places = max(0, min(3, 1 - math.floor(math.log10(100 * error)))) if error > 0 else 1
    return f"{100 * value:.{places}f} +- {100 * error:.{places}f} %"


PLAN = View(plan_form.one_face, _plot_plans, lambda plan, _: plan.rows())
PLANS = View(plan_form.job_face, _plot_plans, job_rows)
CHECK = View(check_form.one_face, None, lambda check, _: check.rows())
CHECKS = View(check_form.job_face, None, job_rows)


@view(
    None,
    lambda bound, _: (
        ["parameter", "relative_error"],
        [*map(list, zip(bound.names, bound.errors.tolist(), strict=True))],
    ),
)
def bound_view(bound: Bound, _: float) -> Face:
    """Least standard errors of the parameters of a model."""
    values = expected_values(bound.model)
    rows = [[name, *values.get(name, ("", "")), bound[name]] for name in bound.names]
    about = say_count(
        bound.size,
        "{count} sample at {rate:.8g} Hz ({length})",
        "{count} samples at {rate:.8g} Hz ({length})",
        rate=bound.rate,
        length=words.duration(bound.size / bound.rate),
    )
    heads = Column("", "symbol"), Column(say("value")), Column(say("unit"), "unit"), Column(say("error"), form=_percent)
    parts: list[Part] = [Table(heads, rows)]
    if bound.ramp is not None:
        allowed = say(
            "a ramp of unknown size is allowed for; its standard error is {error:.3g} {unit}",
            error=bound.ramp,
            unit=bound.model.signal.si[1],
        )
        parts.append(Note(allowed))
    title, brand = say("Bound: {model}", model=str(bound.model)), say("Cramer-Rao bound of noise coefficients")
    return one_sheet(title, brand, say("bound"), parts, about=(about,), how=(Note(BOUNDED),))
