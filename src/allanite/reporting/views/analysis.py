"""How a study is shown."""

from collections.abc import Iterator, Sequence
from pathlib import PurePath
from typing import TYPE_CHECKING, Any

from allanite.core.fit import Fit
from allanite.core.units import readable_unit
from allanite.identification.front import METHODS
from allanite.reporting import words
from allanite.reporting.sheet import Column, Drawing, Face, Note, Part, Sheet, Table, columns, header_of, toml
from allanite.study.analysis import Channel, Study
from allanite.study.recipe import Recipe

from . import View
from .fit import definitions, goodness_parts, terms_table
from .survey import curve_rows, numbers_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

EXPLAINED = {
    "whittle": (
        "The rate record is transformed by the orthonormal discrete cosine transform (DCT-II), which removes "
        "the constant bias and does not leak where the two ends of the record differ. Each squared "
        "coefficient scatters, as a chi-square with one degree of freedom, about the power that the terms "
        "lead one to expect: the squares of the noise coefficients, each times the known spectrum of its "
        "term. The noise coefficients that make the record most likely (Whittle likelihood), none below zero, "
        "are the estimates; a ramp is estimated along with them, with its sign.",
        "A noise term is called found only where it lowers twice the negative log-likelihood by more than 4 "
        "and its interval excludes zero, so that about one record in twenty shows a term that is not there. "
        "The intervals are profile intervals: the values of a coefficient that the data do not contradict, "
        "whatever the other coefficients are and whichever of the other terms are there. A term that was not "
        "found has a one-sided 95 % upper limit instead of a value.",
    ),
    "gls": (
        "The squares of the noise coefficients, none below zero, are fitted to the variance at octaves of the "
        "averaging time up to a quarter of the record, with the covariance that the fitted model itself gives the "
        "points (generalised least squares, iterated). A term is called found where the quadratic form rises by more "
        "than 4 without it. Standard errors come from the same covariance and suppose Gaussian errors.",
    ),
}
"""How a method works, in a few sentences; without them its title is enough."""

CURVE_ALONE = "The curve is an estimate by itself and is drawn for the eye: no coefficient was read off it."
READ = "The coefficients were read off a curve, {statistic}: the notes say from which points."
LIMITS = (
    "The limits of the curve are chi-square limits with the exact equivalent degrees of freedom under the model that "
    "was found."
)
SHARED = (
    "Correlation of what the models leave: sample by sample, and of means over 64 stretches of the record. By chance "
    "the second stays within +-0.25 nineteen times in twenty."
)


def _face(study: Study, level: float) -> Face:
    name = PurePath(study.provenance.get("source", "")).name or "data in memory"
    fitted = any(channel.fit for channel in study.channels)
    return Face(
        f"Noise of {name}",
        "noise coefficients of an inertial sensor",
        [_sheet(channel, level) for channel in study.channels],
        header_of(study.provenance, study.notes, f", method {study.recipe.method}" if fitted else ""),
        parts=[Note(str(finding), "alert") for finding in study.findings],
        close=[*_shared(study), *_statuses(study)],
        how=list(_how(study)),
        choices=toml(study.choices()),
        provenance=study.provenance,
        notes=study.notes,
    )


def _sheet(channel: Channel, level: float) -> Sheet:
    doubt = channel.fit is None or not channel.explained
    verdicts = (words.verdict(channel, level),) if channel.fit or channel.refusal else ()
    about = (words.about(channel.record), *channel.record.history)
    return Sheet(channel.record.name, about, tuple(_parts(channel, level)), verdicts, doubt)


def _parts(channel: Channel, level: float) -> Iterator[Part]:
    yield from (Note(alert, "alert") for alert in words.alerts(channel))
    if channel.refusal:
        yield Note(f"no result: {channel.refusal}", "alert")
    if channel.fit is None:
        facts = words.fitness(channel)
        yield from [Note(facts)] if facts else []
        return
    yield from (Note(note) for note in channel.fit.notes)
    if channel.verdict and channel.explained:
        yield Note(channel.verdict, "good")
    yield terms_table(channel.fit, level)
    if channel.curve is not None:
        caption = (
            f"Deviation by averaging time with its {words.percent(level)} confidence band, the model, and each term of "
            "it alone."
        )
        yield Drawing(lambda: _plot([channel], None, level), "deviation by averaging time", caption)
    yield from goodness_parts(channel.fit, channel.residuals)
    if channel.curve is not None:
        shown = channel.curve.to(readable_unit(channel.curve.unit))
        yield numbers_table(shown, level, "the curve in numbers", where="page")


def _shared(study: Study) -> Iterator[Part]:
    if study.shared is None:
        return
    yield from (Note(str(finding), "alert") for finding in study.shared.findings)
    rows = [[a, b, f"{fast:+.3f}", f"{slow:+.2f}"] for a, b, fast, slow in study.shared.rows()[1]]
    yield Table(
        columns("channel", "and", "fast", "slow", left=2), rows, "what the channels share", key=SHARED, where="page"
    )


def _statuses(study: Study) -> Iterator[Part]:
    met = {e.status for c in study.channels for e in c.fit or ()}
    for status, meaning in words.STATUS.items():
        if status in met:
            yield Note(f"{status}: {meaning}", "quiet", where="text")


def _how(study: Study) -> Iterator[Part]:
    recipe, fits = study.recipe, [channel.fit for channel in study.channels if channel.fit]
    row = METHODS.get(recipe.method)
    if row is not None:
        yield Note(f"Method: {recipe.method}, {row.title}; measured: {row.efficiency}.")
    yield from (Note(paragraph) for paragraph in EXPLAINED.get(recipe.method, ()))
    yield Note(_curve_explained(recipe))
    met = {e.status for fit in fits for e in fit}
    rows = [[status, meaning] for status, meaning in words.STATUS.items() if status in met]
    yield Table((Column("status", "status"), Column("meaning", "text")), rows)
    yield definitions(fits)


def _curve_explained(recipe: Recipe) -> str:
    row = METHODS.get(recipe.method)
    if row is None or not row.statistic:
        return f"{CURVE_ALONE} {LIMITS}"
    statistic = recipe.statistic if recipe.statistic in row.allowed else row.statistic
    return f"{READ.format(statistic=statistic)} {LIMITS}"


def _plot(values: Sequence[Any], fit: Fit | None, level: float) -> "Figure":
    from allanite.reporting.figures.curves import plot_panels
    from allanite.reporting.figures.panels import panels_of

    return plot_panels(panels_of(list(values), fit), level=level)


def _rows(study: Study, level: float) -> tuple[Sequence[str], list[list[Any]]]:
    curves = [c.curve.to(readable_unit(c.curve.unit)) for c in study.channels if c.curve is not None]
    return curve_rows(curves, level)


def _channel_face(channel: Channel, level: float) -> Face:
    sheet = _sheet(channel, level)
    return Face(channel.record.name or "channel", "noise coefficients of an inertial sensor", (sheet,))


STUDY = View(_face, _plot, _rows)
CHANNEL = View(_channel_face, _plot)
