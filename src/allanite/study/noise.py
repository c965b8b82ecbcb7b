"""The noise of a channel, identified in the same way for every job, and whether the model explains the record."""

import math
from dataclasses import replace
from functools import partial

from allanite.core.fit import REJECTED, Fit
from allanite.core.limits import Stored, Widened
from allanite.core.ranges import demand_pieces
from allanite.core.record import Record
from allanite.core.threads import one_thread
from allanite.core.validity import APPROXIMATE, EXPLAINED, UNEXPLAINED, Band, Finding
from allanite.identification.checks.contradiction import MeasuredCurve, contradictions, held, measured, not_rounding
from allanite.identification.checks.residuals import residuals
from allanite.identification.checks.whitening import levelled
from allanite.identification.front import Started, started
from allanite.identification.methods import METHODS, symbols_of
from allanite.identification.search.identify import explaining
from allanite.phrases.phrase import join, say, spelled
from allanite.prepare.outliers import marked, outliers
from allanite.terms import TERMS, WHITE

from .keeper import Inspected
from .recipe import Recipe
from .results import Noise

REQUESTED = (("GM2",),)
"""Terms that only a request adds, tried where the automatic ones do not describe a record, to be named to the user."""


def graded(noise: Noise, record: Record) -> Noise:
    """The noise, with coefficients marked as not valid if the record, or its curve, contradicts them."""
    residuals = noise.residuals
    if residuals is None:
        return noise
    fit, noise = replace(noise.fit, checked=residuals.grade), replace(noise, leftover=Stored(residuals))
    if noise.validity == UNEXPLAINED:
        return replace(noise, fit=fit.invalid(REJECTED))
    curve = measured(fit, record)
    for symbol, reason in contradictions(fit, curve).items():
        fit = fit.invalid(reason, (symbol,))
    if any(finding.name == "correlation" for finding in residuals.findings):
        angle = [e.symbol for e in fit if e.claimed and TERMS[e.symbol].edge]
        fit = fit.invalid(say("the residuals are not white: the noise rises with frequency in another way"), angle)
    if any(finding.name == "heavy tails" for finding in residuals.findings):
        fit = widened(fit, math.sqrt(1 + residuals["kurtosis"].value / 2))
    whole = measured(fit, record)
    between = measured(fit, levelled(record, fit.steps)) if fit.steps else whole
    fit = _valid_until(fit, whole, between)
    for symbol, reason in not_rounding(fit, record).items():  # which has the spectrum of angle noise, but another cause
        fit = fit.invalid(reason, (symbol,))
    return replace(noise, fit=fit)


def _valid_until(fit: Fit, whole: MeasuredCurve, between: MeasuredCurve) -> Fit:
    """The fit, with the averaging time up to which the measured curve shows it.

    It is not valid where the curve shows it at none, and that between the steps does not either.
    """
    until = held(fit, whole)
    if until == 0 and between is not whole:
        until = held(fit, between)
    if until == 0:
        nowhere = say("the deviation of these terms is that of the record at no averaging time")
        claimed = [e.symbol for e in fit if e.claimed]
        others = [e.symbol for e in fit if e.symbol not in claimed and e.status != "not valid"]
        fit = fit.invalid(nowhere, claimed).invalid(REJECTED, others)
    if fit.scope is not None:
        fit = replace(fit, scope=replace(fit.scope, until=until))
    return fit


def widened(fit: Fit, factor: float) -> Fit:
    """The fit with wider limits of the fast noise."""
    # The mean square of n independent residuals with an excess kurtosis k has the variance (2 + k) / n instead of 2 /
    # n; of slow noise, an average of many of them, the tails are no longer heavy.
    each = [
        replace(e, limits=limits, profile=limits, standard_error=e.standard_error and factor * e.standard_error)
        if e.claimed and e.value is not None and e.limits and TERMS[e.symbol].slope <= WHITE
        and (limits := Widened(e.limits, e.value, factor))
        else e
        for e in fit
    ]  # fmt: skip
    return replace(fit, estimates=tuple(each))


def noise_of(record: Record, recipe: Recipe, *, terms: str | None = None, band: Band | None = None, lines: bool = True,
             moved: bool = False) -> Noise:  # fmt: skip
    """Identify the noise of a channel with the choices of the recipe, or with these `terms`, `band` and `lines`."""
    recipe = replace(recipe, terms=terms or recipe.terms, band=band or recipe.band)
    return _judged(begun(record, recipe, lines=lines).fit(), record, recipe, moved=moved)


def begun(record: Record, recipe: Recipe, *, lines: bool = True) -> Started:
    """The search for the noise of a channel with the choices of the recipe; the rest as for `noise_of`."""
    row = METHODS.get(recipe.method)
    read = recipe.statistic if row is not None and row.allowed else None  # the curve that the method fits
    return started(record, method=recipe.method, terms=recipe.terms, statistic=read,
                   band=recipe.band, masks=demand_pieces(recipe.mask, "Hz") if recipe.mask else (),
                   outliers=recipe.outliers or "mark", lines=lines, ranges=recipe.ranges)  # fmt: skip


def begun_in(seen: Inspected, recipe: Recipe) -> Started:
    """The same of a channel in memory or read in parts, for those of a recording to be finished together."""
    return begun(seen.record, recipe) if seen.keeper is None else Started(seen.keeper.search(recipe))


def _judged(fit: Fit, record: Record, recipe: Recipe, *, moved: bool) -> Noise:
    """The noise of a fit, graded, with the terms that only a request adds where these describe the record."""
    if fit.goodness is None:
        return Noise(fit)
    noise = graded(Noise(fit, partial(residuals, record, fit, outliers=recipe.outliers or "mark")), record)
    described = noise.validity != UNEXPLAINED and (noise.fit.scope is None or noise.fit.scope.until is None)
    enough = described or moved or recipe.terms != "auto"
    return noise if enough else _with_remedy(noise, record, recipe)


def _with_remedy(noise: Noise, record: Record, recipe: Recipe) -> Noise:
    """The noise that the automatic terms do not describe, with the finding which terms do, if more of them do."""
    # Those that explain a record beside all automatic terms must do so without the absent ones, as they are then named.
    kept = [e.symbol for e in noise.fit if e.claimed and not e.shape] if noise.fit.valid else []
    rest = without_lines(record if recipe.outliers == "keep" else marked(record, outliers(record)), noise.fit)
    for more in REQUESTED:
        with one_thread():
            fit = explaining(rest, symbols_of([*(kept or symbols_of("auto")), *more]))
        shaped = [e for e in fit or () if e.claimed and e.shape]
        if fit is None or fit.goodness is None or not fit.goodness.explained or len(shaped) < len(more):
            continue
        # a sinusoid that was removed already, broadened: vibration, no noise of the sensor
        oscillations = [e.shape for e in shaped if len(e.shape) == 2]
        if any(abs(f - line.frequency) < 3 * damping * f for f, damping in oscillations for line in noise.fit.lines):
            continue
        named = ",".join([*(e.symbol for e in fit if e.claimed and not e.shape), *more])
        better = noise_of(record, recipe, terms=named)
        if better.validity == EXPLAINED and better.fit.scope and better.fit.scope.whole:
            terms = join(", ", (str(term) for term in better.fit.model if term.shape and term.row.scatters))
            finding = Finding(
                "terms", say("more terms describe the whole record: {terms}", terms=terms),
                say("they are fitted on request only: a control loop, a second relaxation process, or vibration"),
                say("ask for them ({option})", option=spelled(f"--terms {named}", f"terms={named!r}")),
            )  # fmt: skip
            residuals = noise.residuals
            noise = replace(noise, fit=replace(noise.fit, findings=(finding, *noise.fit.findings)))
            told = None if residuals is None else Stored(replace(residuals, findings=(finding, *residuals.findings)))
            return replace(noise, leftover=told)
    return noise


def without_lines(record: Record, fit: Fit) -> Record:
    """A record without the sinusoids that were removed for a fit of it."""
    if not fit.lines:
        return record
    rates = record.rate_values
    for line in fit.lines:
        wave = line.term.sampled(record.rate).waveform
        assert wave is not None  # noqa: S101 - a sinusoid has one
        rates = rates - line.amplitude * wave(record.size)
    return Record(rates, record.rate, record.signal.unit, record.signal.kind, name=record.name)


def noise_in(seen: Inspected, recipe: Recipe) -> Noise:
    """The noise of a channel, in memory or read in parts; parameters and exceptions are those of `noise_of`."""
    # Of a record that is read in parts the curve alone judges the coefficients, so that the model has a reservation.
    fit = (seen.finish or begun_in(seen, recipe).fit)()
    if seen.keeper is None:
        return _judged(fit, seen.record, recipe, moved=seen.quality.moved)
    noise, curve = Noise(fit), seen.keeper.measured(fit)
    if noise.validity == UNEXPLAINED:
        return replace(noise, fit=fit.invalid(REJECTED))
    for symbol, reason in contradictions(fit, curve).items():
        fit = fit.invalid(reason, (symbol,))
    if fit.goodness is not None:
        untested = say("the residuals are not tested where a file is read in parts")
        tested = replace(fit.goodness, remarks=(*fit.goodness.remarks, untested))
        fit = replace(fit, goodness=tested, checked=APPROXIMATE)
    return replace(noise, fit=_valid_until(fit, curve, curve))
