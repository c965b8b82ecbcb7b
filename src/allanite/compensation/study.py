"""Compensation of files: every channel fitted on the channels beside it, what it gained here, and on another file."""

import os
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from allanite.compensation import Gain, Handling, Regression, aligned, compensate, gain_on, load
from allanite.core.curve import Curve
from allanite.core.errors import DataError, UsageError
from allanite.core.model import Model
from allanite.core.record import SHORTEST, Record, Recording
from allanite.identification import identify
from allanite.prepare import inspect, quiet_window, trim
from allanite.readers import read
from allanite.statistics import deviation
from allanite.study.analysis import READING, Recipe, provenance_of

PathLike = str | os.PathLike[str]
Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class CompensationChoices:
    """What is fitted on what, as plain data.

    Attributes
    ----------
    regressors, degree, lags, rate_of, trend
        As of `compensate`.
    handling : Handling
    beside : path or None
        File that holds the regressors; the same file if left out.
    interpolate : bool
        Bring regressors of another time base onto the record's.
    use : path or None
        A saved regression, which is taken instead of a new fit.
    """

    regressors: tuple[str, ...] = ()
    degree: int = 1
    lags: tuple[float, ...] = ()
    rate_of: tuple[str, ...] = ()
    trend: bool = False
    handling: Handling = field(default_factory=Handling)
    beside: str | None = None
    interpolate: bool = False
    use: str | None = None

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {k: list(v) if isinstance(v, tuple) else v for k, v in asdict(self).items() if v is not None}


@dataclass(frozen=True, eq=False)
class Compensated:
    """A channel before and after its correction; `refusal` says why there is none.

    `error` is what was taken off (rate, SI), `gain` what it brought on a record that was not fitted.
    """

    record: Record
    regression: Regression | None = None
    corrected: Record | None = None
    error: np.ndarray[Any, np.dtype[np.float64]] | None = None
    before: Curve | None = None
    after: Curve | None = None
    gain: Gain | None = None
    notes: tuple[str, ...] = ()
    refusal: str = ""

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data; the regression stands once, with the channel it was fitted on."""
        return {
            "name": self.record.name,
            "rate": self.record.rate,
            "size": self.record.size,
            "history": list((self.corrected or self.record).history),
            "before": None if self.before is None else self.before.to_dict(level),
            "after": None if self.after is None else self.after.to_dict(level),
            "gain": None if self.gain is None else self.gain.to_dict() | {"met": self.gain.met},
            "notes": list(self.notes),
            "refusal": self.refusal,
        }


@dataclass(frozen=True, eq=False)
class CompensationStudy:
    """What was fitted, and what came of it here and elsewhere."""

    fitted: tuple[Compensated, ...]
    applied: tuple[Compensated, ...]
    recipe: Recipe
    choices: CompensationChoices
    notes: tuple[str, ...]
    provenance: dict[str, str]

    @property
    def regressions(self) -> tuple[Regression, ...]:
        """All that there are."""
        return tuple(channel.regression for channel in self.fitted if channel.regression is not None)

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        level = self.recipe.level
        return {
            "allanite": 1,
            "type": "CompensationStudy",
            "regressions": [regression.to_dict(level) for regression in self.regressions],
            "fitted": [channel.to_dict(level) for channel in self.fitted],
            "applied": [channel.to_dict(level) for channel in self.applied],
            "choices": self.choices.to_dict(),
            "recipe": self.recipe.to_dict(),
            "notes": list(self.notes),
            "provenance": self.provenance,
        }


def compensate_file(
    source: PathLike,
    recipe: Recipe | None = None,
    choices: CompensationChoices | None = None,
    *,
    apply_to: PathLike | None = None,
    progress: Progress | None = None,
) -> CompensationStudy:
    """Fit every inertial channel of a file on the channels beside it, and apply what was found.

    Parameters
    ----------
    source : path
    recipe : Recipe, optional
        How files are read.
    choices : CompensationChoices, optional
        The regressors, or a saved regression; at least one must be named.
    apply_to : path, optional
        Another file of the same channels, on which nothing is fitted.
    progress : callable, optional
        Called with what is being done and the fraction that is finished.

    Raises
    ------
    DataError
        A file cannot be read, or no channel can be fitted.
    UsageError
        No regressor is named, or it is not in the file.
    """
    recipe, choices = recipe or Recipe(), choices or CompensationChoices()
    tell = progress or (lambda what, fraction: None)
    tell("reading", 0.0)
    saved = {} if choices.use is None else {r.name: r for r in load(choices.use)}
    keys = _keys(choices, saved)
    whole, along = _read(source, recipe, choices, keys)
    named = dict(zip(keys, along.channels, strict=True))
    fitted = []
    for i, record in enumerate(whole):
        tell(f"fitting {record.name}", (i + 0.3) / (len(whole) + 0.6))
        fitted.append(_used(record, along, saved) if saved else _fitted(record, along, choices, named))
    if all(channel.refusal for channel in fitted):
        raise DataError("; ".join(f"{channel.record.name or 'the record'}: {channel.refusal}" for channel in fitted))
    applied: list[Compensated] = []
    if apply_to is not None:
        tell("applying", 0.9)
        there = {c.record.name: c.regression for c in fitted if c.regression is not None}
        other, beside = _read(apply_to, recipe, replace(choices, beside=None), keys)
        applied = [_used(record, beside, there) for record in other]
    tell("done", 1.0)
    provenance = provenance_of(whole) | ({} if apply_to is None else {"applied to": os.fspath(apply_to)})
    return CompensationStudy(tuple(fitted), tuple(applied), recipe, choices, whole.notes, provenance)


def _keys(choices: CompensationChoices, saved: dict[str, Regression]) -> tuple[str, ...]:
    """What the user calls the channels that are regressors."""
    if saved:
        wanted = (r.channel for regression in saved.values() for r in regression.regressors if not r.is_trend)
        return tuple(dict.fromkeys(wanted))
    keys = tuple(dict.fromkeys((*choices.regressors, *choices.rate_of)))
    if not keys:
        raise UsageError("name what the rate may depend on (--regressors temp, --rate-of temp), or --use a saved fit")
    return keys


def _read(
    path: PathLike, recipe: Recipe, choices: CompensationChoices, keys: tuple[str, ...]
) -> tuple[Recording, Recording]:
    """The inertial channels of a file, and the regressors, of the part that the recipe wants."""
    options = {key: getattr(recipe, key) for key in READING}
    if choices.beside is not None:
        signals, along = _part(read(path, **options), recipe), read(choices.beside, channels=keys)
    else:
        both = _part(read(path, along=keys, **options), recipe)
        signals, along = (
            replace(both, records=part) for part in (both.records[: -len(keys)], both.records[-len(keys) :])
        )
    return signals, aligned(along, signals[0]) if choices.interpolate else along


def _part(recording: Recording, recipe: Recipe) -> Recording:
    cut = trim(recording, recipe.start, recipe.until)
    return cut if recipe.quiet_window is None else quiet_window(cut, recipe.quiet_window)


def _fitted(record: Record, along: Recording, choices: CompensationChoices, named: dict[str, str]) -> Compensated:
    alerts = tuple(str(finding) for finding in inspect(record).warnings)
    try:
        regression = compensate(
            record,
            along,
            [named[key] for key in choices.regressors],
            degree=choices.degree,
            lags=choices.lags,
            rate_of=[named[key] for key in choices.rate_of],
            trend=choices.trend,
            handling=choices.handling,
        )
    except DataError as error:
        return Compensated(record, refusal=str(error))
    return replace(_corrected(record, along, regression), notes=alerts)


def _used(record: Record, along: Recording, there: dict[str, Regression]) -> Compensated:
    """A channel that was not fitted, corrected by the regression of its name."""
    if record.name not in there:
        return Compensated(record, refusal=f"no regression of this name; there are {', '.join(there)}")
    regression = there[record.name]
    try:
        gain = gain_on(regression, record, along)
        return replace(_corrected(record, along, regression), gain=gain)
    except DataError as error:
        return Compensated(record, refusal=str(error))


def _corrected(record: Record, along: Recording, regression: Regression) -> Compensated:
    error = regression.rate_error(record, along)
    corrected = regression.apply(record, along)
    before, after = (_longest(part, np.isfinite(error)) for part in (record, corrected))
    if before.size < SHORTEST:
        raise DataError(f"no stretch of {SHORTEST} readings without a loss is in {record.name!r} and its regressors")
    curves = (
        deviation(before, "oadev", taus="octave", noise=_noise(before, regression.noise)),
        deviation(after, "oadev", taus="octave", noise=regression.noise),
    )
    return Compensated(record, regression, corrected, error, *curves)


def _longest(record: Record, fine: np.ndarray[Any, np.dtype[np.bool_]]) -> Record:
    """The rates of the longest stretch without a loss, in SI."""
    rates = record.rate_values
    padded = np.concatenate(([False], fine & np.isfinite(rates), [False]))
    edges = np.flatnonzero(padded[1:] != padded[:-1]).reshape(-1, 2)
    if not edges.size:
        return Record(np.zeros(2), record.rate, record.signal.unit, name=record.name)
    a, b = edges[np.diff(edges, axis=1)[:, 0].argmax()]
    kept = rates[a:b] if b - a > 2 else np.zeros(2)
    return Record(kept, record.rate, record.signal.unit, name=record.name)


def _noise(record: Record, otherwise: Model) -> Model:
    """What the limits of the uncorrected curve suppose: all that is in it, the dependence as well."""
    try:
        return identify(record).model
    except DataError:
        return otherwise
