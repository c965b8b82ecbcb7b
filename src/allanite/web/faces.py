"""Results as the page shows them: words and numbers of the report, and the points of its curves."""

import math
from typing import Any

import numpy as np

from allanite.core.curve import Curve
from allanite.core.errors import UsageError
from allanite.core.model import Model, Term, coefficient_factor
from allanite.reporting import words
from allanite.reporting.digits import printed_unit
from allanite.reporting.figures.panels import CurvePanel, panels_of, points
from allanite.reporting.html import pieces
from allanite.reporting.language import speaking, tr
from allanite.reporting.views import level_of, view_of
from allanite.statistics import STATISTICS
from allanite.terms import TERMS

FINE = 200
"""Points of the curves of a model."""


def described(value: Any, lang: str) -> dict[str, Any]:
    """The sheets of a result as HTML, and where its findings are.

    Words, digits and escapes are those of the report.
    """
    with speaking(lang):
        face = view_of(value).face(value, level_of(value))
        html, sheets = pieces(face)
        channels = list(getattr(value, "channels", ()))
        made = []
        for i, (sheet, text) in enumerate(zip(face.sheets, sheets, strict=True)):
            quality = getattr(channels[i], "quality", None) if len(channels) == len(sheets) else None
            level = sheet.card.level if sheet.card else "alert" if sheet.doubt else "fair" if sheet.fair else ""
            findings = [_finding(finding) for finding in quality.findings] if quality is not None else []
            made.append({"name": tr(sheet.name), "html": text, "findings": findings, "level": level})
        return {
            "title": tr(face.title),
            "facts": [tr(fact) for fact in face.facts],
            "notes": [tr(note) for note in face.notes],
            "html": html,
            "channels": made,
            "findings": [_finding(finding) for finding in getattr(value, "findings", ())],
        }


def _finding(finding: Any) -> dict[str, Any]:
    place = finding.place
    return {
        "name": finding.name,
        "text": tr(str(finding)),
        "level": "alert" if finding.fatal else "fair",
        "at": None if place is None else [place[0], place[1]],
    }


def panel_of(curve: Curve, fit: Any = None) -> CurvePanel:
    """What is drawn of a curve."""
    return panels_of(curve, fit)[0]


def drawn(panel: CurvePanel, level: float, lang: str) -> dict[str, Any]:
    """The points of a curve with its band, its model, and each term of that, in the unit that is shown."""
    shown = points(panel, level)
    tau = np.geomspace(float(shown.tau[0]), float(shown.tau[-1]), FINE)
    model = panel.drawn
    scope = panel.fit.scope if panel.fit is not None else None
    with speaking(lang):
        return {
            "name": panel.name,
            "statistic": panel.curve.statistic,
            "title": tr(STATISTICS[panel.curve.statistic].title),
            "facts": tr(panel.facts),
            "unit": printed_unit(panel.unit),
            "level": level,
            "interval": tr(words.interval(level)),
            "tau": listed(shown.tau),
            "deviation": listed(shown.deviation),
            "low": None if shown.low is None else listed(shown.low),
            "high": None if shown.high is None else listed(shown.high),
            "edf": None if shown.edf is None else listed(shown.edf),
            "supposed": tr(panel.curve.supposed),
            "validity": panel.fit.validity if panel.fit is not None else "",
            "times": None if scope is None else [_plain(time) for time in scope.times],
            "model": None if model is None else {"tau": listed(tau), "deviation": listed(panel.whole(model, tau))},
            "terms": [] if model is None else [_term(panel, term, tau, level) for term in model],
            "guides": _guides(panel, tau),
        }


def _term(panel: CurvePanel, term: Term, tau: Any, level: float) -> dict[str, Any]:
    unit = term.signal.sheet[term.row.power]
    found = next((e for e in panel.fit or () if e.symbol == term.symbol and e.valued), None)
    return {
        "symbol": term.symbol,
        "title": tr(words.title(term.symbol, term.signal)),
        "color": term.row.color,
        "dark": term.row.dark,
        "value": term.to(unit),
        "unit": printed_unit(unit),
        "number": "" if found is None else tr(words.number(found, level)),
        "coefficient": "" if found is None else tr(words.in_print(found, unit, level)),
        "tau": listed(tau),
        "deviation": listed(panel.expected(term, tau)),
    }


def _guides(panel: CurvePanel, tau: Any) -> list[dict[str, Any]]:
    """The deviation of each term of one slope with a coefficient of 1 in the unit of data sheets."""
    signal = panel.fit.signal if panel.fit is not None else None
    if signal is None:
        return []
    found = []
    for row in TERMS.values():
        if row.parameters or row.per_sample or row.transient or not row.automatic:
            continue
        unit = signal.sheet[row.power]
        one = Model((Term(row.symbol, coefficient_factor(row.symbol, unit, signal), signal),))
        deviation = panel.expected(one, tau)
        if np.isfinite(deviation).any():
            found.append(
                {"symbol": row.symbol, "title": tr(words.title(row.symbol, signal)), "color": row.color,
                 "dark": row.dark, "slope": row.slope, "unit": printed_unit(unit), "tau": listed(tau),
                 "deviation": listed(deviation)}
            )  # fmt: skip
    return found


def curve_of(value: Any, channel: str, statistic: str) -> tuple[Curve, Any]:
    """The curve of a channel and its fit; a curve that the result does not have is computed."""
    one = value[channel]
    fit = getattr(one, "fit", None)
    curves = [*getattr(one, "curves", ()), *(v for v in getattr(one, "values", ()) if isinstance(v, Curve))]
    for curve in curves:
        if curve.statistic == statistic:
            return curve, fit
    from allanite.core.record import Record
    from allanite.statistics import deviation

    if not isinstance(one.record, Record):
        raise UsageError(f"the samples of {channel!r} are not in memory: compute {statistic!r} as a job of its own")
    return deviation(one.record, statistic, taus="log", noise=fit or "auto"), fit


def listed(values: Any) -> list[float | None]:
    """Numbers for JSON: what is not finite is null."""
    return [_plain(v) for v in np.asarray(values, dtype=np.float64).tolist()]


def _plain(value: float) -> float | None:
    return value if math.isfinite(value) else None
