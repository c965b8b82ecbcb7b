"""Compensation of files: every channel fitted on other channels, and the effect on it and on another file."""

import os
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Any

import numpy as np

from allanite.extending import (  # isort: skip
    SHORTEST, Curve, DataError, Finding, FloatArray, Header, Inspected, Job, Noise, Progress, Quality, Recipe, Record,
    Recording, RecordResult, Source, deviation, inspect, join, noise_of, open_recording, public, run_together, say,
    stretches, trim)  # fmt: skip

from .fit import compensate
from .mixture import Gain
from .regression import Regression, gain_on, load
from .regressor import aligned
from .settings import CompensationSettings


@dataclass(frozen=True, eq=False, repr=False)
class Compensated(RecordResult):
    """A channel before and after its correction; `refusal` says why there is none."""

    regression: Regression | None = None
    corrected: Record | Header | None = None
    before: Curve | None = None
    after: Curve | None = None
    noise: Noise | None = None  # of the uncorrected record, assumed by the intervals of `before`
    gain: Gain | None = None  # on a record that was not used for the fit
    alerts: tuple[str, ...] = ()
    refusal: str = ""

    @property
    def rates(self) -> tuple[FloatArray, FloatArray] | None:
        """Rate before and after, SI; None without a correction, or without samples, which are not stored."""
        if not (isinstance(self.record, Record) and isinstance(self.corrected, Record)):
            return None
        return self.record.rate_values, self.corrected.rate_values


@dataclass(frozen=True, eq=False, repr=False)
class CompensationStudy(Job[Compensated]):
    """The channels that were fitted, and in `applied` those of another file that were corrected."""

    _channel = Compensated

    applied: tuple[Compensated, ...]
    settings: CompensationSettings

    @property
    def regressions(self) -> tuple[Regression, ...]:
        """All that there are."""
        return tuple(channel.regression for channel in self.channels if channel.regression is not None)

    @property
    def corrected(self) -> Recording:
        """The corrected records, of the other file if there is one."""
        kept = tuple(c.corrected for c in self.applied or self.channels if isinstance(c.corrected, Record))
        if not kept:
            raise DataError("no channel was corrected: there is nothing to write")
        return Recording(kept)

    def choices(self) -> dict[str, Any]:
        """The recipe and the settings that were actually used, as plain data."""
        other = self.provenance.get("applied to")
        return super().choices() | self.settings.choices() | ({"apply_to": other} if other else {})


@dataclass(frozen=True)
class _Source:
    """The inertial channels of a file, and the regressors under the names that the user gave them."""

    signals: Recording
    along: Recording
    named: Mapping[str, str]

    @property
    def findings(self) -> tuple[Finding, ...]:
        """About the clocks of both."""
        return tuple(dict.fromkeys((*self.signals.findings, *self.along.findings)))

    def columns(self, keys: tuple[str, ...]) -> list[str]:
        """The names of channels in the file."""
        return [self.named[key] for key in keys]


@public
def compensate_file(
    source: Source, recipe: Recipe | None = None, settings: CompensationSettings | None = None, *,
    apply_to: str | os.PathLike[str] | None = None, progress: Progress | None = None,
) -> CompensationStudy:  # fmt: skip
    """Fit every inertial channel of a file on other channels, and apply the regressions.

    Parameters
    ----------
    source : path
    recipe : Recipe, optional
        How files are read, and how the noise is identified.
    settings : CompensationSettings
        The regressors, or a saved regression.
    apply_to : path, optional
        Another file of the same channels, which is not used for the fit.
    progress : callable, optional
        Called with a description of the current step and the fraction completed.

    Raises
    ------
    DataError
        A file cannot be read, or no channel can be fitted.
    UsageError
        No regressor is named, or it is not in the file.
    """
    recipe, settings = recipe or Recipe(), settings or CompensationSettings()
    if settings.fit.terms != "auto":
        recipe = replace(recipe, terms=settings.fit.terms)
    settings = replace(settings, fit=replace(settings.fit, terms=recipe.terms))
    saved = {} if settings.use is None else {r.name: r for r in load(settings.use)}
    wanted = (r.channel for regression in saved.values() for r in regression.regressors if not r.is_trend)
    keys = tuple(dict.fromkeys((*settings.regressors, *settings.derivative_of, *wanted)))
    if progress is not None:
        progress("reading", 0.0)
    here = _open(source, recipe, settings, keys)

    def fitted(record: Record) -> Regression:
        return compensate(record, here.along, here.columns(settings.regressors), degree=settings.degree,
                          lags=settings.lags, derivative_of=here.columns(settings.derivative_of), trend=settings.trend,
                          settings=settings.fit)  # fmt: skip

    parts = 1 if apply_to is None else 2
    study: CompensationStudy = _each(partial(CompensationStudy, applied=(), settings=settings), here, saved or fitted,
                                     recipe, demand=True, progress=_part(progress, 0, parts))  # fmt: skip
    if settings.beside is not None:
        beside = {"regressors": here.along.source, "sha256 regressors": here.along.digest}
        study = replace(study, provenance=study.provenance | beside)
    if apply_to is None:
        return study
    other = _open(apply_to, recipe, replace(settings, beside=None), keys)
    known = {regression.name: regression for regression in study.regressions}
    findings = (replace(f, what=join(": ", (other.signals.source, f.what))) for f in other.findings)
    notes = dict.fromkeys((*study.notes, *other.signals.notes, *other.along.notes))
    return replace(study, applied=_each(lambda channels, *_: channels,
                                        other, known, recipe, progress=_part(progress, 1, parts)),
                   findings=(*study.findings, *findings), notes=tuple(notes), provenance=study.provenance
                   | {"applied to": os.fspath(apply_to), "sha256 applied to": other.signals.digest})  # fmt: skip


def _part(progress: Progress | None, part: int, parts: int) -> Progress | None:
    """What tells the progress of one of several parts of the job."""
    return progress and (lambda what, fraction: progress(what, (part + fraction) / parts))


def _open(path: Source, recipe: Recipe, settings: CompensationSettings, keys: tuple[str, ...]) -> _Source:
    """The inertial channels of a file, and the regressors, of the part that the recipe selects."""
    if settings.beside is None:
        both = open_recording(path, recipe, along=keys)
        signals, along = (replace(both, records=r) for r in (both.records[: -len(keys)], both.records[-len(keys) :]))
    else:
        signals = open_recording(path, recipe)
        along = open_recording(settings.beside, Recipe(channels=keys))
    if settings.interpolate:
        along = aligned(along, signals[0])
    elif settings.beside is not None and (recipe.start, recipe.until, recipe.quiet_window) != (None, None, None):
        since = (signals[0].start or 0.0) - (along[0].start or 0.0)
        along = trim(along, since, since + signals[0].duration)
    return _Source(signals, along, dict(zip(keys, along.channels, strict=True)))


def _each(
    kind: Callable[..., Any], source: _Source, regressions: Mapping[str, Regression] | Callable[[Record], Regression],
    recipe: Recipe, *, demand: bool = False, progress: Progress | None,
) -> Any:  # fmt: skip
    """What is made of every channel, corrected by the regression of its name or by one that is fitted to it."""
    # A record that follows a temperature may look as if it moved: whether it does is asked of what the correction
    # leaves.
    held = isinstance(regressions, Mapping)

    @cache
    def regression_of(record: Record) -> Regression:
        if not isinstance(regressions, Mapping):
            return regressions(record)
        if record.name not in regressions:
            raise DataError(say("no regression of this name; names: {names}", names=", ".join(regressions)))
        return regressions[record.name]

    def look(record: Record) -> Quality:
        quality = inspect(record)
        if any(finding.fatal and finding.name == "moving" for finding in quality.findings):
            with suppress(DataError):  # what cannot be corrected stays refused, because it moves
                return inspect(regression_of(record).apply(record, source.along))
        return quality

    def work(seen: Inspected) -> Compensated:
        regression = regression_of(seen.record)
        gain = gain_on(regression, seen.record, source.along) if held else None
        done = _corrected(seen.record, source.along, regression, recipe)
        return replace(done, gain=gain, alerts=(*done.alerts, *seen.alerts))

    return run_together(kind, (source.signals,), recipe, work, lambda seen, why: Compensated(seen.record, refusal=why),
                        findings=source.findings, notes=source.along.notes, look=look,
                        doing="correcting" if held else "fitting", demand=demand, progress=progress)  # fmt: skip


def _corrected(record: Record, along: Recording, regression: Regression, recipe: Recipe) -> Compensated:
    corrected = regression.apply(record, along)
    known = np.isfinite(regression.rate_error(record, along))

    def longest(record: Record) -> Record:
        """The rates of the longest stretch without a loss, in SI."""
        rates = record.rate_values
        edges = stretches(known & np.isfinite(rates))
        a, b = edges[np.diff(edges, axis=1)[:, 0].argmax()] if edges.size else (0, 0)
        kept = rates[a:b] if b - a > 2 else np.zeros(2)
        return Record(kept, record.rate, record.signal.unit, record.signal.kind, name=record.name)

    before, after = longest(record), longest(corrected)
    if before.size < SHORTEST:
        raise DataError(say("no stretch of {least} samples is complete in {name!r} and its regressors", least=SHORTEST,
                            name=record.name))  # fmt: skip
    # what the limits of the uncorrected curve suppose: all that is in it, the dependence as well
    noise, alerts = None, []
    try:
        noise = noise_of(before, recipe)
    except DataError as error:
        alerts.append(say("the intervals of the deviation before assume the noise identified by the fit: {reason}",
                          reason=str(error)))  # fmt: skip
    if noise is not None and noise.doubts:
        alerts.append(say("the intervals of the deviation before are doubtful: no model of these terms explains the "
                          "record before"))  # fmt: skip
    curve = partial(deviation, statistic="oadev", taus="octave")
    curves = curve(before, noise=noise.fit if noise else regression.noise), curve(after, noise=regression.noise)
    return Compensated(record, regression, corrected, *curves, noise, alerts=tuple(alerts))
