"""How the uses of a noise model are shown: plans, checks, bounds, state spaces, what a statistic makes of it."""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from allanite.core.curve import Curve
from allanite.core.fit import Fit
from allanite.core.model import Model, coefficient_factor
from allanite.interpretation.glossary import named_words
from allanite.phrases.phrase import join, say, say_count
from allanite.planning.bound import Bound, name_of
from allanite.planning.plan import Properties, RecordingPlan
from allanite.planning.selfcheck import SelfCheck
from allanite.reporting import figures, words
from allanite.reporting.digits import upper_limit
from allanite.reporting.first import DETAILS, Answer, First
from allanite.reporting.sheet import Code, Column, Drawing, Face, Note, Part, Plot, Sheet, Table, header_of, one_sheet
from allanite.reporting.text import spread
from allanite.statespace import StateSpace
from allanite.statespace.build import MEASUREMENTS
from allanite.statistics import statistic_named
from allanite.study.modelled import ModelJob, Modelled, RecordingPlans, StateSpaces
from allanite.terms import TERMS

from . import Rows, View, view
from .jobs import job_face, source_of, warnings
from .papers import about


class ModelledForm(NamedTuple):
    """How one kind of result is shown: name of a nameless one, title and brand of the page, a key, and its parts."""

    name: str
    title: str
    brand: str
    key: str
    about: Callable[[Any], str]
    parts: Callable[[Any, Modelled | None], Iterable[Part]]

    def one_face(self, result: Any, _: float) -> Face:
        """The face of a single result."""
        title, parts = join(" ", (self.title, str(result.model))), self.parts(result, None)
        return one_sheet(title, self.brand, self.name, parts, about=(self.about(result),), **self._legend())

    def job_face(self, job: ModelJob, _: float) -> Face:
        """The face of the results of all channels."""
        given = job.settings.given()
        header = header_of(job.provenance, job.notes, say(", method {method}", method=job.recipe.method))
        if given:
            header = [(say("noise"), str(given)), *header_of(job.provenance, ())[1:]]
        names = join(" ", (self.title, job.settings.name or str(given or source_of(job)))), self.brand
        limits = [Note(say("limit exceeded: {limit}", limit=text), "alert", where="page") for text in job.exceeded]
        sheets = []
        for channel in job:
            about = [] if channel.record is None else [words.about(channel.record), *channel.record.history]
            about += [] if channel.result is None else [self.about(channel.result)]
            advice = channel.fit.advice if channel.fit else ()
            parts = [*warnings(channel), *(Note(note, "remark") for note in advice)]
            if channel.missing:
                parts.append(Note(say("not taken into account: {terms}", terms=channel.missing)))
            if channel.result is not None:
                parts += self.parts(channel.result, channel)
            sheets.append(Sheet(channel.name or self.name, about, parts))
        return job_face(job, names, sheets, limits, header=header, **self._legend())

    def views(self, plot: Callable[[Sequence[Any], Fit | None, float], Plot] | None = None) -> tuple[View, View]:
        """The views of a single result, and of those of all channels."""
        return View(self.one_face, plot, lambda result, _: result.rows()), View(self.job_face, plot, _job_rows)

    def _legend(self) -> dict[str, list[Part]]:
        return {"close": [Note(self.key, "quiet", where="text")], "how": [Note(self.key)]}


def _job_rows(job: ModelJob, _: float) -> Rows:
    """The rows of all channels, each with the name of its channel before it."""
    tables = [(c.name, *c.result.rows()) for c in job.channels if c.result is not None]
    return ["channel", *tables[0][1]], [[name, *row] for name, _, rows in tables for row in rows]


PLANNED = say(
    "Least relative standard errors (1 sigma, Cramer-Rao bound) of the coefficients by length of the record, and the "
    "95 % upper limits to expect of absent terms. A term is called identified up to 25 %; above 40 % it is hardly "
    "seen. The default method reaches the bound where it is below about 12 %."
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


def expected_values(model: Model, channel: Modelled | None = None) -> dict[str, tuple[str, str]]:
    """Each parameter's value, an identified one as analyze shows it, and its unit of data sheets."""
    expected, known = {}, {e.symbol: e for e in (channel.fit if channel else None) or ()}
    for t in model:
        name, unit = name_of(t, model), t.signal.sheet[t.row.power]
        shown = f"{t.to(unit):.4g}" if name not in known else words.brief(known[name], 0.95)
        expected[name] = shown, unit
        for parameter, value in zip(t.row.parameters, t.shape, strict=True):
            expected[f"{name} {parameter.title}"] = (f"{value:.4g}", parameter.unit)
    return expected


def _percent(error: float) -> str:
    """A relative standard error."""
    return "> 100 %" if error >= 1 else words.percent(error, 2) or "-"


def _plan_about(plan: RecordingPlan) -> str:
    ramp = say("a ramp of unknown size is allowed for") if plan.ramp else say("no ramp")
    return join(", ", (f"{plan.rate:.8g} Hz", ramp))


def _plan_parts(plan: RecordingPlan, channel: Modelled | None) -> Iterator[Part]:
    """The accuracy of each coefficient by the length of the record."""
    wanted = say("for {accuracy}", accuracy=_percent(plan.accuracy))
    heads = (Column("", "symbol"), Column(say("expected")), Column(say("unit"), "unit"),
        *(Column(words.duration(d)) for d in plan.durations), Column(wanted))  # fmt: skip
    values, signal = expected_values(plan.model, channel), plan.model.signal
    kinds = [(SEARCHED if plan.absent else "", plan.searched, plan.searched_needed)]
    kinds += [(KNOWN, plan.errors, plan.needed)] if plan.absent else []
    for title, errors, needed in kinds:
        rows = list[list[str]]()
        for name, row, least in zip(plan.names, errors.tolist(), needed.tolist(), strict=True):
            length: str = say("> 100 years") if math.isfinite(least) else say("never")
            if least < 100 * 365.25 * 86400:
                length = words.duration(float(f"{least:.2g}"))
            rows.append([name, *values.get(name, ("", "")), *map(_percent, row), length])
        for symbol, limits in zip(plan.absent, plan.limits.tolist(), strict=True) if title != KNOWN else ():
            unit = signal.sheet[TERMS[symbol].power]
            sizes = (limit / coefficient_factor(symbol, unit, signal) for limit in limits)
            cells = [f"< {upper_limit(size).plain()[0]}" if math.isfinite(size) else "-" for size in sizes]
            rows.append([symbol, say("absent"), unit, *cells, ""])
        yield Table(heads, rows, title, details=title == KNOWN)
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


def _check_about(check: SelfCheck) -> str:
    return say_count(
        check.records,
        "{count} record of {samples} at {rate:.8g} Hz ({length}), intervals at {level}",
        "{count} records of {samples} at {rate:.8g} Hz ({length}), intervals at {level}",
        samples=say_count(check.size, "{count} sample", "{count} samples"), rate=check.rate,
        length=words.duration(check.size / check.rate), level=words.percent(check.level),
    )  # fmt: skip


def _check_parts(check: SelfCheck, channel: Modelled | None) -> Iterator[Part]:
    """What the identification finds of known noise."""
    values = expected_values(check.model, channel)
    rows = [[c.symbol, *(values.get(c.symbol, ("", "")) if c.truth else (say("absent"), "")), c.bound, c.bias, c.spread,
        c.coverage, c.found] for c in check.terms]  # fmt: skip
    measured = (say("bias of the estimate"), say("spread"), say("coverage"), say("found"))
    heads = (Column("", "symbol"), Column(say("truth")), Column(say("unit"), "unit"),
        Column(say("bound"), form=_percent), *(Column(heading, form=_with_error) for heading in measured))  # fmt: skip
    yield Table(heads, rows)
    share = _with_error(check.unexplained)
    yield Note(say("records whose model is reported not to explain them: {share}", share=share))
    yield from (Note(note) for note in check.notes)


def _with_error(measured: tuple[float, float]) -> str:
    """A share with its error in percent, to the digits that the error leaves."""
    value, error = measured
    if math.isnan(value):
        return "-"
    if not error > 0:
        return f"{100 * value:.3g} %"
    places = max(0, min(3, 1 - math.floor(math.log10(100 * error))))
    return f"{100 * value:.{places}f} +- {100 * error:.{places}f} %"


PLAN, PLANS = ModelledForm(name=say("plan"), title=say("Plan for"), brand=say("how long to record"), key=PLANNED,
    about=_plan_about, parts=_plan_parts).views(_plot_plans)  # fmt: skip
CHECK, CHECKS = ModelledForm(
    name=say("check"), title=say("Check of the identification:"), brand=say("simulated records, identified"),
    key=CHECKED, about=_check_about, parts=_check_parts,
).views()  # fmt: skip


@view(rows=lambda bound, _: (["parameter", "relative_error"], [[name, bound[name]] for name in bound.names]))
def bound_view(bound: Bound, _: float) -> Face:
    """Least standard errors of the parameters of a model."""
    values = expected_values(bound.model)
    rows = [[name, *values.get(name, ("", "")), bound[name]] for name in bound.names]
    about = say_count(
        bound.size, "{count} sample at {rate:.8g} Hz ({length})", "{count} samples at {rate:.8g} Hz ({length})",
        rate=bound.rate, length=words.duration(bound.size / bound.rate),
    )  # fmt: skip
    heads = Column("", "symbol"), Column(say("value")), Column(say("unit"), "unit"), Column(say("error"), form=_percent)
    parts: list[Part] = [Table(heads, rows)]
    if bound.ramp is not None:
        allowed = say(
            "a ramp of unknown size is allowed for; its standard error is {error:.3g} {unit}", error=bound.ramp,
            unit=bound.model.signal.si[1],
        )  # fmt: skip
        parts.append(Note(allowed))
    title, brand = say("Bound: {model}", model=str(bound.model)), say("Cramer-Rao bound of noise coefficients")
    return one_sheet(title, brand, say("bound"), parts, about=(about,), how=(Note(BOUNDED),))


BRAND = say("bias and degrees of freedom of a statistic")
RATIO = say("Allan variance over the expected variance of the statistic")
HADAMARD = say("Hadamard variance over the expected variance of the statistic")
FREEDOM = say("equivalent degrees of freedom")
EXACT = say("exact for each noise alone; the relative standard deviation of the variance is sqrt(2 / edf)")

MAX_TIMES = 8  # averaging times of a first screen


def first_of_properties(value: Properties, _: float) -> First:
    """Degrees of freedom by averaging time, and the range of the ratio to the Allan variance."""
    rows, terms = value.rows()[1], len(value.symbols)
    ratios = [ratio for row in rows for ratio in row[2 : 2 + terms]]
    span = say("{ratio}: {low:.3f} to {high:.3f}", ratio=_ratio(value), low=min(ratios), high=max(ratios))
    heads = (Column("tau", form=".6g"), *(Column(symbol, form=".4g") for symbol in value.symbols))
    kept = [rows[i] for i in spread(len(rows), MAX_TIMES)]
    table = Table(heads, [[row[1], *row[2 + terms :]] for row in kept])
    word = named_words().get(value.statistic)
    sample = say("{what}, {n} samples, by tau in sampling intervals:", what=FREEDOM, n=value.size)
    answer: list[Answer] = [*([word.meaning, word.formula] if word else ()), sample, table, span]
    return First(statistic_named(value.statistic).title, "", answer, after=[*about(value.statistic), DETAILS])


def _ratio(value: Properties) -> str:
    return RATIO if statistic_named(value.statistic).order == 2 else HADAMARD


@view(rows=lambda value, _: value.rows(), first=first_of_properties)
def properties_view(value: Properties, _: float) -> Face:
    """Bias and degrees of freedom by averaging time."""
    statistic = statistic_named(value.statistic)
    size = say("a record of {n} samples; tau in sampling intervals", n=value.size)
    terms = len(value.symbols)
    rows = value.rows()[1]
    ratios = (Column(symbol, form=".3f") for symbol in value.symbols)
    freedom = (Column(symbol, form=".4g") for symbol in value.symbols)
    at = (Column("m"), Column("tau", form=".6g"))
    parts: list[Part] = [
        Table((*at, *ratios), [row[: 2 + terms] for row in rows], _ratio(value)),
        Table((*at, *freedom), [[*row[:2], *row[2 + terms :]] for row in rows], FREEDOM), Note(EXACT, "quiet"),
        Note(say("source: {source}", source=statistic.reference), "quiet"),
    ]  # fmt: skip
    return one_sheet(statistic.title, BRAND, statistic.title, parts, about=(size,))


EQUATIONS = say("matrices in SI units: x' = Phi x + w, sample = H x + v")
KEY = say(
    "Phi is the transition over one interval, Qd the covariance of w, R the variance of v, P0 the covariance of the "
    "states at the start. The table shows the diagonals."
)
SPACE_DRAWN = say(
    "Allan deviation of the state space, of the model, and as measured; below, the state space over the model."
)


def _space_parts(space: StateSpace, channel: Modelled | None) -> Iterator[Part]:
    """What it leaves out, its states, and its matrices."""
    low, high = space.tau
    within = say(
        "Allan deviation within {ripple:.2g} % of the model's from {low:g} to {high:g} s", ripple=100 * space.ripple,
        low=low, high=high,
    )  # fmt: skip
    yield Note(join("; ", (within, MEASUREMENTS[space.measurement].meaning)))
    yield from (Note(note) for note in space.notes)
    scope = channel.fit.scope if channel is not None and channel.fit is not None else None
    if scope is not None and scope.filter is not None:
        yield Note(say(
            "the low-pass filter is not among the states: samples closer together than {time:.2g} s are correlated",
            time=1 / scope.filter.cutoff,
        ))  # fmt: skip
    headings, rows = space.rows()
    numbers = (Column(heading, form=".6g") for heading in headings[2:])
    heads = (Column(""), Column(say("state"), "name"), Column(say("unit"), "unit"), *numbers)
    yield Table(heads, [[i, *row] for i, row in enumerate(rows, 1)])
    label = say("Allan deviation of the state space and of the model")
    yield Drawing(lambda: _plot([channel or space], None, 0.95), label, SPACE_DRAWN)
    matrices = {label: getattr(space, label) for label in ("Phi", "Qd", "H", "R", "P0")}
    yield Code("\n".join(_matrix(label, matrix) for label, matrix in matrices.items() if len(matrix)), EQUATIONS)


def _matrix(label: str, matrix: np.ndarray) -> str:
    """As Python, JSON and MATLAB-like programs read it, to the last digit."""
    cells = [[repr(float(v)) if v else "0" for v in row] for row in matrix]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    rows = (", ".join(cell.rjust(w) for cell, w in zip(row, widths, strict=True)) for row in cells)
    return f"{label} = [[" + f"],\n{' ' * (len(label) + 4)}[".join(rows) + "]]"


def _plot(values: Sequence[Any], _: Fit | None, level: float) -> Plot:
    """A state space, perhaps with measured curves after it; or those of all channels, each with its own curve."""
    spaces: list[tuple[str, StateSpace, list[Curve]]] = []
    for value in values:
        if isinstance(value, Curve):
            spaces[-1][2].append(value)
        elif isinstance(value, StateSpaces | Modelled):
            channels = value.channels if isinstance(value, StateSpaces) else (value,)
            known = [(c.name, c.result, [c.curve] if c.curve else []) for c in channels]
            spaces += [(name, space, curves) for name, space, curves in known if isinstance(space, StateSpace)]
        else:
            spaces.append(("", value, []))
    return figures.plot_state_spaces(spaces, level=level)


SPACE, SPACES = ModelledForm(
    name=say("model"), title=say("State space of"), brand=say("state space of an inertial sensor's noise"), key=KEY,
    about=lambda space: join("; ", (f"{space.rate:.8g} Hz", str(space.model))), parts=_space_parts,
).views(_plot)  # fmt: skip
