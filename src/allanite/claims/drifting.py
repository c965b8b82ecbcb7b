"""From the noise of the axes to the drift that it causes."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import PurePath
from typing import Any

import numpy as np

from allanite.core.aliases import public
from allanite.core.errors import DataError, UsageError
from allanite.core.estimate import Estimate
from allanite.core.model import Term
from allanite.core.record import Record, Recording
from allanite.exporting.choice import Source, axes_of, bounded
from allanite.exporting.content import Axis
from allanite.exporting.export import alerts_of
from allanite.exporting.fields import How, usable
from allanite.exporting.imported import load
from allanite.phrases.phrase import say, spelled
from allanite.study.analysis import analyze
from allanite.study.job import provenance_of
from allanite.study.recipe import Recipe
from allanite.study.results import Study
from allanite.terms import TERMS, WHITE

from .drift import SCALE, TURN_ON, Drift, DriftAxis, DriftCause
from .drift_settings import DriftSettings


@public
def drift(source: Source | Record | Recording | str | PurePath | None = None, settings: DriftSettings | None = None, *,
          recipe: Recipe | None = None, **choices: Any) -> Drift:  # fmt: skip
    """Predict how far heading, attitude, velocity and position drift with time without aid, from the noise.

    Each is a standard deviation, in closed form from the structure function of every noise term; nothing is simulated.
    The bias is the mean over a calibration at rest before, whose own error is part of the drift.

    Parameters
    ----------
    source : Study, Channel, Fit, Model, Term, ClaimedNoise, Record, Recording, path, or a sequence of these
        The noise of gyros, accelerometers or both; of several axes the worst at each time counts. None if only
        `require` is asked.
    settings : DriftSettings, optional
    recipe : Recipe, optional
        How recordings are read and their noise is identified.
    **choices
        Fields of `DriftSettings`: ``drift(fit, times=(60, 600), turn_on=("10 deg/h",))``.

    Returns
    -------
    Drift

    Raises
    ------
    UsageError
        There is neither a source nor a requirement, or a choice is wrong.
    DataError
        A file cannot be read, no model explains the records, or none is of a gyro or an accelerometer.

    Notes
    -----
    With the integral x of the error of a rate and D(t) = E[(x(s + t) - x(s))^2], an angle errs by
    e(t) = x(t) - x(0) - (t/T) (x(0) - x(-T)) after a calibration of T, whose variance is
    (1 + t/T) D(t) - (t/T) D(t + T) + (t/T) (1 + t/T) D(T). Strapdown, a tilt turns gravity g into the acceleration g e:
    velocity and position err by its integrals, and by those of the accelerometer's noise.

    Examples
    --------
    >>> from allanite import Model
    >>> found = drift(Model("N 0.3 deg/sqrt(h)"), times=(3600,), calibration=0)
    >>> found["heading"].to("deg").round(4).tolist()
    [0.3]
    """
    settings = replace(settings or DriftSettings(), **choices)
    sources = list(source) if isinstance(source, (list, tuple)) else [] if source is None else [source]
    return drift_of([_read(source, recipe or Recipe()) for source in sources], settings)


def _read(source: Any, recipe: Recipe) -> Any:
    """A source; recordings are analyzed."""
    if isinstance(source, Record | Recording):
        return analyze(source, recipe)
    return load([str(source)], recipe, ())[0] if isinstance(source, (str, PurePath)) else source


def drift_of(sources: Sequence[Any], settings: DriftSettings) -> Drift:
    """The drift from sources that have been read."""
    if not sources:
        if not settings.require:
            model = spelled("--model, --sensor or --datasheet", "a model")
            required = spelled("--require '1 deg in 10 min'", "require=['1 deg in 10 min']")
            raise UsageError(f"give the noise: a recording, a result of analyze in JSON, or {model}; without it, what "
                             f"it may be: {required}")  # fmt: skip
        return Drift((), settings, provenance=provenance_of())
    drift_axes = list(axes_of([getattr(source, "models", source) for source in sources]))
    inertial = [bounded(axis, asked=settings.from_curve) for axis in drift_axes if axis.fit.signal.inertial]
    if drift_axes and not inertial:
        names = ", ".join(f"{axis.label!r} ({axis.sensor})" for axis in drift_axes)
        raise DataError(f"heading, velocity and position drift with gyros and accelerometers, not with {names}")
    kept = usable(inertial, How(unexplained=settings.unexplained))
    axes = tuple(axis for axis in (_axis(axis, settings) for axis in kept) if axis.causes)
    if not axes:
        names = ", ".join(axis.label for axis in kept)
        raise DataError(say("nothing in the noise of {names} makes it drift: all coefficients are 0, or it is a "
                            "warm-up, which depends on when it was switched on", names=names))  # fmt: skip
    studies = [study for study in sources if isinstance(study, Study)]
    omitted = [axis for axis in inertial if axis not in kept]
    alerts = alerts_of([replace(axis, alerts=()) for axis in kept], omitted, [])
    notes = [*alerts_of([replace(axis, doubt="") for axis in kept], [], studies), *_unknown(kept)]
    rejected = dict.fromkeys([*(axis.name for axis in omitted),
                              *(name for study in studies for name in study.rejected)])  # fmt: skip
    recipe, provenance = (studies[0].choices(), studies[0].provenance) if studies else ({}, provenance_of())
    return Drift(axes, settings, tuple(alerts), tuple(notes), tuple(rejected), recipe, provenance)


def _unknown(axes: Sequence[Axis]) -> Iterator[str]:
    """The terms that are not part of the drift, with the channels: of no value and no limit, or a warm-up."""
    reasons: dict[str, list[str]] = {}
    for axis in axes:
        for e in axis.fit:
            row = TERMS[e.symbol]
            if (e.value is None and not e.upper and not row.slope < WHITE) or (e.value and row.transient):
                reasons.setdefault(f"{e.symbol} {e.words()}", []).append(axis.label)
    for words, names in reasons.items():
        yield say("{names}: not taken into account: {terms}", names=", ".join(names), terms=words)


def _axis(axis: Axis, settings: DriftSettings) -> DriftAxis:
    """What makes an axis drift: its terms, sinusoids, and constant errors."""
    from scipy.linalg import block_diag

    places = [(i, cause) for i, e in enumerate(axis.fit) if (cause := _cause(axis, e, settings)) is not None]
    causes = [cause for _, cause in places]
    rows = [i for i, cause in places if not cause.limit]
    lines = [DriftCause("Sine", line.term) for line in axis.fit.lines]
    together = None
    if axis.fit.correlation is not None:
        known = axis.fit.correlation[np.ix_(rows, rows)]
        together = block_diag(np.where(np.isfinite(known), known, np.eye(len(rows))), np.eye(len(lines)))
    bias, (rate, step) = settings.bias(axis.sensor), settings.scaled(axis.sensor)
    constant = [DriftCause(TURN_ON, bias=bias)] if bias else []
    constant += [DriftCause(SCALE, bias=rate, step=step)] if rate or step else []
    curve = axis.curve or axis.fit.curve
    longest = None if curve is None else float(curve.tau[-1])
    return DriftAxis(axis.sensor, axis.name, (*causes, *lines, *constant), axis.rate, longest, together)


def _cause(axis: Axis, e: Estimate, settings: DriftSettings) -> DriftCause | None:
    """The term of an estimate at its value, or at its upper limit; None of what has neither, or no structure."""
    if e.symbol in {line.term.symbol for line in axis.fit.lines}:
        return None
    usable = e.valued or (settings.unexplained and e.status == "not valid")
    if usable and e.value and not TERMS[e.symbol].transient:
        low, high = np.abs(e.interval(axis.level)) / abs(e.value)
        across = math.prod(e.interval(axis.level)) < 0  # a ramp that may be none
        return DriftCause(e.symbol, Term(e.symbol, e.value, e.signal, e.shape),
                          low=0.0 if across else float(min(low, high)), high=float(max(low, high)))  # fmt: skip
    if e.value is None and e.upper and not e.row.claimed and not e.shape and not TERMS[e.symbol].parameters:
        return DriftCause(e.symbol, Term(e.symbol, e.upper, e.signal), limit=True)
    return None
