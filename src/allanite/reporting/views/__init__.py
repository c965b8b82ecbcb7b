"""How each result is shown: one file a result, with a function that is marked `view`, and one line in the table."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any, cast

from allanite.core.errors import UsageError
from allanite.plugins import Registry

if TYPE_CHECKING:
    from allanite.core.fit import Fit
    from allanite.reporting.first import First
    from allanite.reporting.sheet import Face, Plot

Rows = tuple[Sequence[str], list[list[Any]]]


@dataclass(frozen=True)
class View:
    """The forms of a result."""

    face: "Callable[[Any, float], Face]"  # what the terminal, the page and a notebook show
    # the figure for print, of one value or of several that are drawn together
    plot: "Callable[[Sequence[Any], Fit | None, float], Plot] | None" = None
    rows: Callable[[Any, float], Rows] | None = None  # the numbers for a CSV file, unrounded
    # the same of what was found in each channel, where `rows` are the curves
    coefficients: Callable[[Any, float], Rows] | None = None
    # the first screen of a terminal; without it the beginning of the face
    first: "Callable[[Any, float], First] | None" = None

    def through(self, part: Callable[[Any], Any]) -> "View":
        """The view of values that are shown by what `part` makes of each."""

        def of(form: Any) -> Any:
            return form and (lambda value, level: form(part(value), level))

        plot = self.plot
        draw = plot and (lambda values, fit, level: plot([part(value) for value in values], fit, level))
        return View(of(self.face), draw, of(self.rows), of(self.coefficients), of(self.first))


def view(
    plot: "Callable[[Sequence[Any], Fit | None, float], Plot] | None" = None,
    rows: Callable[[Any, float], Rows] | None = None,
    coefficients: Callable[[Any, float], Rows] | None = None,
    first: "Callable[[Any, float], First] | None" = None,
) -> "Callable[[Callable[[Any, float], Face]], View]":
    """Marks the function that makes the face of a result: it becomes its `View`, which has these, too."""
    return lambda face: View(face, plot, rows, coefficients, first)


_OWN = {
    "Study": "analysis.study_view", "Channel": "analysis.channel_view", "Batch": "batch.batch_view",
    "Lot": "lot.lot_view", "Meaning": "expectation.meaning_view", "Survey": "survey.survey_view",
    "Record": "analysis.record_view", "Recording": "analysis.record_view", "Curve": "values.value_view",
    "Spectrum": "values.value_view", "Surface": "values.value_view", "Comparison": "comparison.comparison_view",
    "ClaimCheck": "claims.check_view", "ClaimedNoise": "claims.claim_view", "Pool": "comparison.pool_view",
    "Fit": "fit.fit_view", "Readings": "values.readings_view", "Residuals": "fit.residuals_view",
    "Model": "expectation.MODEL", "Term": "expectation.MODEL", "Expectation": "expectation.expectation_view",
    "Expectations": "expectation.expectations_view", "BudgetStudy": "budget.study_view",
    "Budget": "budget.budget_view", "CompensationStudy": "compensation.study_view",
    "Compensated": "compensation.channel_view", "Regression": "compensation.regression_view",
    "RecordingPlan": "planning.PLAN", "RecordingPlans": "planning.PLANS", "SelfCheck": "planning.CHECK",
    "SelfChecks": "planning.CHECKS", "Bound": "planning.bound_view", "Properties": "planning.properties_view",
    "StateSpace": "planning.SPACE", "StateSpaces": "planning.SPACES", "Drift": "drift.drift_view",
    "Export": "export.export_view", "Imported": "explanation.imported_view", "Word": "explanation.word_view",
    "Explanation": "explanation.explanation_view", "DataSheet": "datasheet.sheet_view",
    "SheetComparison": "datasheet.comparison_view",
    "Simulation": "expectation.simulation_view", "RateStudy": "rate.study_view",
    "Closeup": "rate_experiment.closeup_view", "Experiment": "rate_experiment.experiment_view",
    "Ranking": "rate.ranking_view", "RateEstimate": "rate.estimate_view", "AngleStudy": "angle.study_view",
    "Harmonics": "angle.result_view", "Calibration": "angle.result_view", "AnglePlan": "angle.plan_view",
    "Scan": "angle.scan_view", "VerticalStudy": "vertical.study_view", "VerticalDesign": "vertical.design_view",
    "Optimum": "vertical.OPTIMUM", "Reproduction": "papers.paper_view", "ScenarioErrors": "vertical.scenarios_view",
}  # fmt: skip
"""Type of a result: where its `View` is. They are imported when first asked for."""

_FIRST = {"Study": "channels.first_of"}
"""Type of a result: where its first screen is made without the figures and tables of its view."""

VIEWS = Registry[str | View](_OWN, "allanite.views", kind=View)  # the same, and the views of plug-ins


def view_of(value: Any) -> View:
    """The view of a result."""
    name = type(value).__name__
    if not has_view(value):
        raise UsageError(f"a {name} cannot be shown: compute a result first, e.g. al.plot(al.deviation(record))")
    return _imported(VIEWS[name])


def first_of(value: Any, level: float) -> "First":
    """The first screen of a result: its own, or what its face begins with."""
    from allanite.reporting.first import condensed

    own = _FIRST.get(type(value).__name__)
    if own is not None:
        return cast("First", _attribute(own)(value, level))
    view = view_of(value)
    return view.first(value, level) if view.first else condensed(view.face(value, level), drawn=view.plot is not None)


def has_view(value: Any) -> bool:
    """Whether it is a result that can be shown."""
    return type(value).__name__ in VIEWS


def import_type(name: str) -> None:
    """Import the type of a result, by its view; where the name is that of no result, the parts of all results."""
    for row in [VIEWS[name]] if name in VIEWS else VIEWS.values():
        _imported(row)


def _imported(row: str | View) -> View:
    if isinstance(row, View):
        return row
    return cast(View, _attribute(row))


def _attribute(place: str) -> Any:
    module, _, attribute = place.partition(".")
    return getattr(import_module(f"{__name__}.{module}"), attribute)


def level_of(value: Any, level: float | None = None) -> float:
    """The confidence level: as given, that of the result's recipe, or 0.95."""
    if level is not None:
        return level
    own = getattr(getattr(value, "recipe", value), "level", None)
    return own if isinstance(own, float) else 0.95
