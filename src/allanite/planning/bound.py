"""The Cramer-Rao bound of the coefficients of a model, without simulation."""

import math
import operator
from collections.abc import Iterator
from dataclasses import dataclass
from functools import reduce

import numpy as np

from allanite.core.aliases import public, size_and_rate
from allanite.core.arrays import FloatArray
from allanite.core.errors import UsageError
from allanite.core.model import Model, ModelLike, Term, usable_model
from allanite.core.plain import Value
from allanite.phrases.phrase import join
from allanite.terms import TERMS
from allanite.terms.row import Parameter

from .information import CoefficientGrid, Information, InformationPart, shape_parts
from .transient import transient_errors

MOST = 2**53
"""Samples, at most: more are not told from each other in floating point."""

AUTO = "".join(symbol for symbol, row in TERMS.items() if row.automatic)
"""The default terms of `identify`."""


@dataclass(frozen=True, eq=False, repr=False)
class Bound(Value):
    """Smallest possible relative standard errors of a model's parameters for a record of `size` samples at `rate` Hz.

    Attributes
    ----------
    names : tuple of str
        The symbol of a term for its coefficient; with the parameter for a time constant or frequency.
    errors : array, shape (p,)
        Relative standard errors (1 sigma), infinite if the record carries no information.
    ramp : float or None
        Standard error of the rate ramp, SI; None if it is known that there is none.

    Examples
    --------
    >>> from allanite import N
    >>> bound(N(0.1, "deg/sqrt(h)"), 20_001, 100.0)["N"]
    0.005
    """

    _alike = ("names errors",)

    model: Model
    size: int
    rate: float
    names: tuple[str, ...]
    errors: FloatArray
    ramp: float | None

    def __getitem__(self, name: str) -> float:
        """Relative standard error of one parameter."""
        if name not in self.names:
            raise UsageError(f"there is no bound of {name!r}; parameters: {', '.join(self.names)}")
        return float(self.errors[self.names.index(name)])

    def _summary(self) -> str:
        errors = (f"{name} {100 * error:.2g} %" for name, error in zip(self.names, self.errors, strict=True))
        return f"of {self.size} samples at {self.rate:g} Hz: {', '.join(errors)}"


@public
def bound(
    model: ModelLike,
    size: int | None = None,
    rate: float | None = None,
    *,
    duration: float | None = None,
    ramp: bool | None = None,
    terms: str = "known",
) -> Bound:
    """The Cramer-Rao bound of a model's coefficients.

    Parameters
    ----------
    model : Model, Term or Fit
    size : int
        Number of samples, at least 8; or `duration`, s.
    rate : float
        Sampling rate, Hz.
    ramp : bool, optional
        Whether to assume a ramp of unknown size; by default, if the model has one.
    terms : str
        Prior knowledge about the terms. "known": which of them are present. "auto": none, as if `identify` looks for
        all five; a string of symbols, such as "QNB": that there are no others than these and those of the model.

    Returns
    -------
    Bound

    Raises
    ------
    UsageError
        The model has no noise, or the record is too short or longer than 2^53 samples.

    Notes
    -----
    The standard errors of the coefficients, not of their squares. They are accurate if they are small; a term whose
    bound is above about 40 % can hardly be detected. A time constant of Gauss-Markov noise is unknown as well, and
    a sinusoid has unknown amplitude, phase and frequency. The size of an absent term is not known to be zero if it
    is looked for: `terms` accounts for this, as if the size could also be negative, which gives an upper bound.

    Examples
    --------
    >>> from allanite import N
    >>> noise = N(0.1, "deg/sqrt(h)")
    >>> [round(bound(noise, 500, 1.0, terms=terms)["N"], 3) for terms in ("known", "auto")]
    [0.032, 0.073]
    """
    model = usable_model(model)
    n, rate = size_and_rate(size, rate, duration)
    if n < 8:
        raise UsageError(f"a bound needs at least 8 samples, not {n}")
    if n > MOST:
        raise UsageError(f"{n:.3g} samples are too many for a bound; at most {MOST:.3g} are possible")
    noise = [t for t in model if t.row.waveform is None and t.value]
    if not noise:
        raise UsageError(f"{model} has no noise; without noise everything is known exactly")
    beside = _beside(model, terms)
    unknown = (model.drifts or any(t.row.waveform is not None for t in beside)) if ramp is None else ramp
    grid = CoefficientGrid(n)
    own = [InformationPart.of(t, rate, grid) for t in noise]
    parts = [part for t, itself in zip(noise, own, strict=True) for part in (itself, *shape_parts(t, rate, grid))]
    others = [InformationPart.of(t, rate, grid) for t in beside if t.row.waveform is None]
    found = Information(grid, reduce(operator.add, own), ramp=unknown)
    # relative standard errors of the coefficients: half of those of their squares
    information = found.matrix([*parts, *others])
    scale = np.sqrt(np.diag(information))
    scaled = information / np.where(scale > 0, scale, math.nan) / np.where(scale > 0, scale, math.nan)[:, None]
    values, vectors = np.linalg.eigh(np.where(np.isfinite(scaled), scaled, np.eye(scale.size)))
    known = values > 1e-13  # below that are the rounding errors of the sums
    variance = (vectors[:, known] ** 2 / values[known]).sum(axis=1)
    lost = (vectors[:, ~known] ** 2).sum(axis=1) > 1e-12
    errors = np.where(lost | (scale == 0), math.inf, np.sqrt(variance) / np.where(scale > 0, 2 * scale, 1.0))[
        : len(parts)
    ]
    relative = dict(zip(_names(noise, model), errors, strict=True))
    ramp_error = found.ramp if unknown else None
    relative |= dict(_deterministic(model, noise, ramp_error, n, rate))
    slope = None if ramp_error is None else ramp_error * rate
    return Bound(model, n, rate, tuple(relative), np.array(list(relative.values())), slope)


def _beside(model: Model, terms: str) -> list[Term]:
    """The terms that `terms` represents and the model lacks, of size 1."""
    symbols = {"known": "", "auto": AUTO}.get(terms, terms)
    if any(symbol not in TERMS or TERMS[symbol].parameters for symbol in symbols):
        raise UsageError(f"terms must be 'known', 'auto' or symbols such as {AUTO!r}, not {terms!r}")
    known = {t.symbol for t in model}
    return [Term(symbol, 1.0, model.signal) for symbol in symbols if symbol not in known]


def _names(noise: list[Term], model: Model) -> list[str]:
    return [
        name
        for t in noise
        for name in (name_of(t, model), *(join(" ", (name_of(t, model), parameter_title(p))) for p in t.row.parameters))
    ]


def name_of(t: Term, model: Model) -> str:
    """The symbol of a term; with its shape where the symbol stands several times in the model.

    Examples
    --------
    >>> from allanite import GM
    >>> model = GM(1.0, "deg/h", time_constant=10.0) + GM(1.0, "deg/h", time_constant=99.0)
    >>> [name_of(t, model) for t in model]
    ['GM(10 s)', 'GM(99 s)']
    """
    if sum(other.symbol == t.symbol for other in model) == 1:
        return t.symbol
    return f"{t.symbol}({t.shape[0]:.4g} {t.row.parameters[0].unit})"


def parameter_title(parameter: Parameter) -> str:
    """The name of a parameter of a term's shape, as it is shown."""
    return parameter.title


def _deterministic(
    model: Model, noise: list[Term], ramp: float | None, n: int, rate: float
) -> Iterator[tuple[str, float]]:
    """Relative errors of warm-ups, of a ramp, and of sinusoids' amplitudes and frequencies, beside the noise."""
    for t in model:
        if t.row.transient:
            yield from zip(_names([t], model), transient_errors(t, noise, n, rate), strict=True)
        elif t.row.periodic:
            frequency, duration = t.shape[0], n / rate
            seen = abs(frequency - rate * round(frequency / rate))  # sampling folds it
            amplitude = abs(t.value * np.sinc(frequency / rate))
            errors = math.inf, math.inf
            if seen * duration >= 1 and amplitude:  # else there is no whole period
                random = Model(tuple(part for part in model if part.row.waveform is None))
                density = float(random.spectrum(np.array([seen]), 1 / rate)[0])
                relative = math.sqrt(2 * density / duration) / amplitude
                errors = relative, math.sqrt(6 * density / duration**3) / (math.pi * amplitude * frequency)
            yield from zip(_names([t], model)[:2], errors, strict=True)
        elif ramp is not None and t.row.waveform is not None:
            yield name_of(t, model), ramp / abs(t.value * rate**t.row.power) if t.value else math.inf
