"""What a figure shows: curves with their fits, and their numbers in the unit that people read."""

import math
from collections.abc import Sequence
from pathlib import PurePath
from typing import Any, NamedTuple

import numpy as np

from allanite.core.arrays import FloatArray, IntArray
from allanite.core.curve import Curve
from allanite.core.display_units import readable_unit
from allanite.core.errors import UndrawnError, UsageError
from allanite.core.fit import Fit
from allanite.core.model import Model, Term, model_of
from allanite.core.readings import Readings
from allanite.core.units import convert, unit_of
from allanite.phrases.phrase import join
from allanite.reporting import words
from allanite.reporting.digits import digits, printed_unit
from allanite.statistics import expected, statistic_named

from .drawing import MODEL

MAX_CURVE_POINTS = 400  # points of a curve that are drawn: more are not seen, but weigh

ZEROS_RANGE = 1000.0
"""Range in which the expected curve of a sinusoid is drawn, which is zero at multiples of its period."""


class CurvePanel(NamedTuple):
    """A curve and what explains it."""

    name: str
    curve: Curve
    fit: Fit | None
    readings: Readings | None = None  # with its minimum
    facts: str = ""  # its file, rate and length
    wanted: Sequence[str] = ()  # units that were asked for
    model: Model | None = None  # whose expectation the curve is: it has no fit then
    brief: bool = False  # whether labels have no intervals

    @property
    def drawn(self) -> Model | None:
        """The model whose terms are drawn; None if there is none, or it explains nothing."""
        return printed_model(self.fit) if self.fit is not None else self.model

    def whole(self, tau: FloatArray) -> FloatArray:
        """The deviation expected under the model that is drawn, with the warm-up that was found; see `expected`."""
        if self.drawn is None:
            return np.full_like(tau, np.nan)
        return self.expected(self.drawn if self.fit is None else self.fit.complete(self.drawn), tau)

    @property
    def unit(self) -> str:
        """The unit that is shown."""
        dimension = unit_of(self.curve.unit).dimension
        fitting = (unit for unit in self.wanted if unit_of(unit).dimension == dimension)
        return next(fitting, "") or readable_unit(self.curve.unit)

    def expected(self, model: Model | Term, tau: FloatArray) -> FloatArray:
        """The deviation expected under a model or term, in the unit that is shown; NaN where it does not hold."""
        scope = None if self.fit is None else self.fit.scope
        holds = True if scope is None else scope.holds(tau)
        curve, row, factor = self.curve, statistic_named(self.curve.statistic), unit_of(self.unit).factor
        scaled = not any(t.row.per_sample or t.row.transient for t in model_of(model))
        if row.differences and not row.summed and not row.power and scaled:
            variance = expected(model, row.name, tau)
            return np.where(holds, np.sqrt(np.where(variance > 0, variance, np.nan)) / factor, np.nan)
        try:
            at = curve.tau[thinned(curve.tau.size)]
            variance = expected(model, row.name, at, rate=curve.rate or None, size=curve.size or None)
        except UsageError:  # a maximum, or what depends on the record beyond the model
            return np.full_like(tau, np.nan)
        with np.errstate(divide="ignore"):
            between = np.interp(np.log(tau), np.log(at), np.log(variance), np.nan, np.nan)
        return np.where(holds, np.exp(between / 2) / factor, np.nan)

    def shown(self, values: FloatArray) -> FloatArray:
        """Values of the curve in the unit that is shown."""
        return values * convert(1.0, self.curve.unit, self.unit)


def printed_model(fit: Fit) -> Model | None:
    """The terms whose coefficients are printed, without those of which only a limit is known; None if there is none."""
    limited = {e.symbol for e in fit if e.value is None} - {e.symbol for e in fit if e.value is not None}
    kept = tuple(term for term in fit.valid or () if term.symbol not in limited)
    return Model(kept) if kept else None


MAX_HINTS = 120  # points of a curve whose values are shown under the cursor


def samples(panel: CurvePanel, level: float) -> dict[float, str]:
    """Points of a curve by averaging time, as the table of its numbers has them, with what the model expects there."""
    drawn = points(panel, level)
    expected, nothing = panel.whole(drawn.tau), np.full(drawn.tau.size, np.nan)
    low, high = (nothing if limit is None else limit for limit in (drawn.low, drawn.high))
    made, unit = dict[float, str](), printed_unit(panel.unit)
    for i in np.unique(np.rint(np.linspace(0, drawn.tau.size - 1, min(drawn.tau.size, MAX_HINTS))).astype(np.int64)):
        model, half = float(expected[i]), (high[i] - low[i]) / 2
        near = digits(model, model - half, model + half)
        parts = [f"{digits(drawn.deviation[i], low[i], high[i]).pretty()} {unit}"]
        parts += [join(" ", (MODEL, near.value + near.power))] if math.isfinite(model) else []
        made[float(drawn.tau[i])] = join("; ", parts)
    return made


class DrawnPoints(NamedTuple):
    """The points that are drawn; no limits where the noise is not known."""

    tau: FloatArray
    deviation: FloatArray
    edf: FloatArray | None
    low: FloatArray | None
    high: FloatArray | None


def points(panel: CurvePanel, level: float) -> DrawnPoints:
    """The curve in the unit that is shown, thinned to what the eye resolves."""
    curve = panel.curve
    keep = thinned(curve.tau.size)
    tau, deviation = curve.tau[keep], panel.shown(curve.deviation[keep])
    if curve.law is None:
        return DrawnPoints(tau, deviation, None, None, None)
    low, high = (panel.shown(limit[keep]) for limit in curve.interval(level))
    return DrawnPoints(tau, deviation, curve.edf[keep], low, high)


def thinned(count: int) -> IntArray:
    """Indices of the points that are drawn: of many, evenly in the logarithm."""
    if count <= MAX_CURVE_POINTS:
        return np.arange(count)
    return np.unique(np.rint(np.geomspace(1, count, MAX_CURVE_POINTS)).astype(np.int64)) - 1


def positive(values: FloatArray, name: str) -> FloatArray:
    """What a logarithmic axis shows of the curve of a channel; UsageError if that is nothing."""
    visible = values[np.isfinite(values) & (values > 0)]
    if not visible.size:
        raise UsageError(f"the curve of {name!r} is zero everywhere: logarithmic axes cannot show it")
    return visible


def span(panel: CurvePanel) -> tuple[tuple[float, float], tuple[float, float]]:
    """Range of both axes: room below the curve for the lines of the terms, above for the band."""
    curve = panel.curve
    visible = positive(panel.shown(curve.deviation), panel.name)
    below = 8.0 if panel.drawn is not None else 2.5
    low, high = float(visible.min()) / below, float(visible.max())
    if panel.model is not None and any(t.row.periodic for t in panel.model):
        low = max(low, high / ZEROS_RANGE)
    # the upper limits of the last points are far off, and not worth the room
    return around(curve.tau), (low, high * 2.5)


def around(tau: FloatArray) -> tuple[float, float]:
    """Ends of a logarithmic axis of these averaging times, of which there may be a single one."""
    return float(tau.min()) / 1.8, float(tau.max()) * 1.8


def panels_of(value: Any, fit: Fit | None = None, *, demand: bool = True) -> list[CurvePanel]:
    """What is drawn of a Curve, Fit, Channel or Study, or of a sequence of them."""
    panels = _panels(value, fit)
    if demand and not panels:
        raise UndrawnError("there is no curve to draw; give a Curve, a Study, or a Fit that carries its curve")
    return panels


def _panels(value: Any, fit: Fit | None) -> list[CurvePanel]:
    if isinstance(value, Curve):
        return [CurvePanel(value.name, value, fit, facts=facts_of(value))]
    if isinstance(value, Fit):
        return _panels(value.curve, value)
    if hasattr(value, "channels") and hasattr(value, "recipe"):  # a Study
        file = PurePath(value.provenance.get("source", "")).name
        return [p._replace(facts=", ".join(filter(None, (file, p.facts))), wanted=value.recipe.to or ())
            for p in _panels(value.channels, None)]  # fmt: skip
    if hasattr(value, "curve") and hasattr(value, "quality"):  # a Channel
        return [panel._replace(readings=value.readings) for panel in _panels(value.curve, value.fit)]
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [panel for item in value for panel in _panels(item, fit)]
    if value is None:
        return []
    raise UsageError(f"a {type(value).__name__} cannot be drawn; give a Curve, a Fit, or a Study")


def facts_of(curve: Curve) -> str:
    """Sampling rate and length of the record of a curve."""
    length = words.duration(curve.size / curve.rate) if curve.size else ""
    return ", ".join(filter(None, (f"{curve.rate:.6g} Hz" if curve.rate else "", length)))


def columns_of(panels: Sequence[CurvePanel]) -> list[list[CurvePanel]]:
    """Panels side by side by unit; a long single column is broken in two."""
    by_unit: dict[str, list[CurvePanel]] = {}
    for panel in panels:
        by_unit.setdefault(panel.unit, []).append(panel)
    columns = list(by_unit.values())
    if len(columns) > 1 or len(panels) < 5:
        return columns
    half = math.ceil(len(panels) / 2)
    return [columns[0][:half], columns[0][half:]]
