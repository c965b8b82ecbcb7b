"""Results as the page shows them, and the menus of the page, read off the tables."""

import math
import shlex
from typing import Any

import numpy as np

from allanite.cli import jobs
from allanite.core.choices import FLAG, SPAN, ChoiceRow, choices_of
from allanite.core.curve import Curve
from allanite.core.errors import UsageError
from allanite.core.kinds import KIND_WORDS, KINDS
from allanite.core.model import Model, Term, coefficient_factor
from allanite.core.record import Record
from allanite.core.units import SIGNALS
from allanite.exporting.choice import POLICIES
from allanite.exporting.exports import EXPORTS
from allanite.exporting.fields import How
from allanite.identification.methods import METHODS
from allanite.interpretation.devices import DEVICES
from allanite.phrases.phrase import say
from allanite.reporting import words
from allanite.reporting.digits import printed_unit
from allanite.reporting.figures.panels import CurvePanel, points
from allanite.reporting.html import pieces
from allanite.reporting.language import LANGUAGES, speaking, tr
from allanite.reporting.views import level_of, view_of
from allanite.statistics import STATISTICS, deviation
from allanite.study.recipe import Recipe
from allanite.terms import TERMS

from .requests import accepted

MODEL_POINTS = 200  # points of the curves of a model


def described(value: Any, lang: str) -> dict[str, Any]:
    """The sheets of a result as HTML, as in the report, and where its findings are."""
    with speaking(lang):
        face = view_of(value).face(value, level_of(value))
        html, sheets = pieces(face)
        channels = list(getattr(value, "channels", ()))
        made = []
        for i, (sheet, text) in enumerate(zip(face.sheets, sheets, strict=True)):
            quality = getattr(channels[i], "quality", None) if len(channels) == len(sheets) else None
            findings = [_finding(finding) for finding in quality.findings] if quality is not None else []
            made.append({"name": tr(sheet.name), "html": text, "findings": findings})
        return {"title": tr(face.title), "facts": [tr(fact) for fact in face.facts],
                "notes": [tr(note) for note in face.notes], "html": html, "channels": made,
                "findings": [_finding(finding) for finding in getattr(value, "findings", ())]}  # fmt: skip


def _finding(finding: Any) -> dict[str, Any]:
    place = finding.place
    return {"name": finding.name, "text": tr(str(finding)), "level": "alert" if finding.fatal else "fair",
            "at": None if place is None else [place[0], place[1]]}  # fmt: skip


def drawn(panel: CurvePanel, level: float, lang: str) -> dict[str, Any]:
    """The points of a curve with its band, its model, and each term of that, in the unit that is shown."""
    shown = points(panel, level)
    tau = np.geomspace(float(shown.tau[0]), float(shown.tau[-1]), MODEL_POINTS)
    model = panel.drawn
    with speaking(lang):
        return {
            "name": panel.name, "statistic": panel.curve.statistic,
            "title": tr(STATISTICS[panel.curve.statistic].title),
            "unit": printed_unit(panel.unit), "level": level, "interval": tr(words.interval(level)),
            "tau": listed(shown.tau), "deviation": listed(shown.deviation),
            "low": None if shown.low is None else listed(shown.low),
            "high": None if shown.high is None else listed(shown.high),
            "validity": panel.fit.validity if panel.fit is not None else "",
            "model": None if model is None else {"tau": listed(tau), "deviation": listed(panel.whole(tau))},
            "terms": [] if model is None else [_term(panel, term, tau, level) for term in model],
            "guides": _guides(panel, tau),
        }  # fmt: skip


def _term(panel: CurvePanel, term: Term, tau: Any, level: float) -> dict[str, Any]:
    unit = term.signal.sheet[term.row.power]
    estimate = next((e for e in panel.fit or () if e.symbol == term.symbol and e.valued), None)
    return {"symbol": term.symbol, "title": tr(words.title(term.symbol, term.signal)), "color": term.row.color,
            "dark": term.row.dark, "value": term.to(unit),
            "unit": printed_unit(unit), "number": "" if estimate is None else tr(words.number(estimate, level)),
            "coefficient": "" if estimate is None else tr(words.in_print(estimate, unit, level)), "tau": listed(tau),
            "deviation": listed(panel.expected(term, tau))}  # fmt: skip


def _guides(panel: CurvePanel, tau: Any) -> list[dict[str, Any]]:
    """The deviation of each term of one slope with a coefficient of 1 in the unit of data sheets."""
    signal = panel.fit.signal if panel.fit is not None else None
    if signal is None:
        return []
    guides, bare = [], panel._replace(fit=None)  # a guide holds at any averaging time
    for row in TERMS.values():
        if row.parameters or row.per_sample or row.transient or not row.automatic:
            continue
        unit = signal.sheet[row.power]
        model = Model((Term(row.symbol, coefficient_factor(row.symbol, unit, signal), signal),))
        deviation = bare.expected(model, tau)
        if np.isfinite(deviation).any():
            guides.append(
                {"symbol": row.symbol, "title": tr(words.title(row.symbol, signal)), "color": row.color,
                 "dark": row.dark, "slope": row.slope, "unit": printed_unit(unit), "tau": listed(tau),
                 "deviation": listed(deviation)}
            )  # fmt: skip
    return guides


def curve_of(value: Any, channel: str, statistic: str) -> tuple[Curve, Any]:
    """The curve of a channel and its fit; a curve that the result does not have is computed."""
    result = value[channel]
    fit = getattr(result, "fit", None)
    curves = [*getattr(result, "curves", ()), *(v for v in getattr(result, "values", ()) if isinstance(v, Curve))]
    for curve in curves:
        if curve.statistic == statistic:
            return curve, fit
    if not isinstance(result.record, Record):
        raise UsageError(f"the samples of {channel!r} are not in memory: compute {statistic!r} as a job of its own")
    return deviation(result.record, statistic, taus="log", noise=fit or "auto"), fit


def listed(values: Any) -> list[float | None]:
    """Numbers for JSON: what is not finite is null."""
    return [v if math.isfinite(v) else None for v in np.asarray(values, dtype=np.float64).tolist()]


UNITS = {"gyro": ("deg/s", "rad/s", "deg/h", "mdeg/s", "arcsec/s", "deg", "rad", "arcsec"),
         "accel": ("m/s^2", "g", "mg", "ug", "mGal", "m/s")}  # fmt: skip
"""Units offered first; every unit can be typed."""

EXAMPLES = {
    "mems": (say("three MEMS gyros, 1 h"), "--sensor mems --rate 100 --duration 1h --channels 3"),
    "fog": (say("fiber-optic gyro, 2 h"), "--sensor fog --rate 100 --duration 2h"),
    "disturbed": (
        say("fiber-optic gyro with a disturbance, 1 h"),
        "--sensor fog --rate 100 --duration 1h --noise-profile '0:1, 3000:1, 3001:8, 3500:8, 3501:1, 3600:1'",
    ),
}
"""Options of ``allanite simulate`` for the recordings to play with; "disturbed" has a piece to cut out."""


def simulation(name: str, path: str) -> list[str]:
    """The words of the command line that writes an example."""
    return ["simulate", path, *shlex.split(EXAMPLES[name][1]), "--quiet", "--force"]


VALUES: dict[str, Any] = {"axis": list(POLICIES), "cover": ["yes", "no"]}  # words that a choice of an export takes

OTHER_SENSOR = {"name": "models", "control": "list", "options": ["--model"], "rare": False, "values": None,
                "hint": "N 100 ug/sqrt(Hz), K 10 ug/sqrt(h)"}  # fmt: skip
"""The control of the noise of a sensor without a file."""


def _control(name: str, row: ChoiceRow) -> dict[str, Any]:
    """How a choice of an export is entered; the rare ones are those that every target has a value for."""
    span = row.kind is SPAN
    return {"name": name, "control": row.kind.control, "options": row.options, "values": VALUES.get(name),
            "rare": not span and row.kind is not FLAG, "hint": "1,1000" if span else ""}  # fmt: skip


def tables(lang: str) -> dict[str, Any]:
    """Everything that a menu shows, in a language."""
    gyro = SIGNALS[0]
    with speaking(lang):
        return {
            "statistics": [{"name": row.name, "title": tr(row.title)} for row in STATISTICS.values()],
            "terms": [
                {"symbol": s, "title": tr(words.title(s, gyro)), "color": row.color, "dark": row.dark,
                 "slope": row.slope if math.isfinite(row.slope) else None, "automatic": row.automatic}
                for s, row in TERMS.items()
            ],
            "methods": [{"name": name, "title": tr(row.title)} for name, row in METHODS.items()],
            "units": {sensor: list(units) for sensor, units in UNITS.items()},
            "kinds": [{"name": k, "title": tr(KIND_WORDS[k]), "meaning": tr(row[2])} for k, row in KINDS.items()],
            "exports": [{"name": name, "title": tr(row.title)} for name, row in EXPORTS.items()],
            "devices": list(DEVICES),
            "examples": [{"name": name, "title": tr(title)} for name, (title, _) in EXAMPLES.items()],
            "languages": [{"code": code, "name": name} for code, name in LANGUAGES.items()],
            "outliers": [{"name": "", "title": tr(say("exclude from the fit only"))},
                         {"name": "mark", "title": tr(say("exclude everywhere"))},
                         {"name": "keep", "title": tr(say("use everywhere"))}],
            "verbs": jobs(),
            "options": {verb: {name: row.text for name, row in accepted(verb).items()} for verb in jobs()},
            "how": [_control(name, row) for name, row in choices_of(How).items()] + [OTHER_SENSOR],
            "choices": [{"name": name, "group": row.group, "control": row.kind.control, "options": row.options}
                        for name, row in choices_of(Recipe).items()],
        }  # fmt: skip
