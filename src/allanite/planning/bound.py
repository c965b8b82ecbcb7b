"""The Cramer-Rao bound of the coefficients of a model, without simulation."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import ClassVar

import numpy as np

from allanite.core.aliases import public, size_and_rate
from allanite.core.arrays import FloatArray
from allanite.core.errors import UsageError
from allanite.core.limits import demand_stored_square, quantile
from allanite.core.model import Model, ModelLike, Term, usable_model
from allanite.core.names import demand_name
from allanite.core.plain import Value
from allanite.identification.checks.whitening import deviations
from allanite.identification.likelihood.likelihood import Likelihood
from allanite.identification.likelihood.spectrum import SINGLE, BinnedSpectrum, edges_of
from allanite.identification.likelihood.whittle import column, directions_of
from allanite.phrases.phrase import join
from allanite.prepare.gaps import whole
from allanite.terms import TERMS, NoiseTerm, ramp_coefficients

STEP = 1.001  # factor on the shape of a term by which its expected power, or its waveform, is differentiated
RESOLVED = 1e-13  # eigenvalue of the scaled information, at least: below it are the rounding errors of the sums
AUTO = "".join(symbol for symbol, row in TERMS.items() if row.automatic)  # the default terms of `identify`


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
    limits : dict of str to float
        95 % upper limits, SI, of the terms that are looked for and that the model lacks.

    Examples
    --------
    >>> from allanite import N
    >>> bound(N(0.1, "deg/sqrt(h)"), 20_001, 100.0)["N"]
    0.005
    """

    _alike = ("names errors",)
    _checks: ClassVar = {"errors": demand_stored_square}

    model: Model
    size: int
    rate: float
    names: tuple[str, ...]
    errors: FloatArray
    ramp: float | None
    limits: dict[str, float] = field(default_factory=dict)

    def __getitem__(self, name: str) -> float:
        """Relative standard error of one parameter."""
        demand_name("parameter", name, self.names)
        return float(self.errors[self.names.index(name)])

    def _summary(self) -> str:
        errors = (f"{name} {100 * error:.2g} %" for name, error in zip(self.names, self.errors, strict=True))
        return f"of {self.size} samples at {self.rate:g} Hz: {', '.join(errors)}"


@public
def bound(
    model: ModelLike, size: int | None = None, rate: float | None = None, *, duration: float | str | None = None,
    ramp: bool | None = None, terms: str = "known",
) -> Bound:  # fmt: skip
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
    noise = [t for t in model if t.row.waveform is None and t.value]
    if not noise:
        raise UsageError(f"{model} has no noise; without noise everything is known exactly")
    beside = _beside(model, terms)
    unknown = (model.drifts or any(t.row.waveform is not None for t in beside)) if ramp is None else ramp
    likelihood, theta = _expected(noise, [t for t in beside if t.row.waveform is None], n, rate, ramp=unknown)
    errors = _errors(likelihood.information(theta))
    relative = dict(zip(_names(noise, model), errors, strict=False))
    ramp_size = ramp_error(noise, n, rate, _edge(likelihood, theta)) if unknown else None
    relative |= dict(_deterministic(model, noise, ramp_size, n, rate))
    slope = None if ramp_size is None else ramp_size * rate
    # the square of an absent coefficient of unit size has twice the relative error of the coefficient
    absent = [t.symbol for t in beside if t.row.waveform is None]
    limits = dict(zip(absent, np.sqrt(2 * quantile(0.95) * errors[errors.size - len(absent) :]).tolist(), strict=True))
    if slope is not None:
        limits |= {t.symbol: quantile(0.95) * slope for t in beside if t.row.waveform is not None}
    return Bound(model, n, rate, tuple(relative), np.array(list(relative.values())), slope, limits)


def _expected(
    noise: Sequence[Term], beside: Sequence[Term], n: int, rate: float, *, ramp: bool
) -> tuple[Likelihood, FloatArray]:
    """The likelihood of a record that is not there yet, and theta: 1 for each term, 0 for what stands beside them."""
    # Behind the column of a term come those of the changes with the logarithm of each of its parameters, halved: the
    # other columns are of squares of coefficients, whose errors are halved.
    edges, none = edges_of(n), np.zeros(0)
    first, nothing = edges[:-1], np.zeros(edges.size - 1)
    spectrum = BinnedSpectrum(n, rate, first, np.diff(edges), nothing, nothing, first, nothing,
                              nothing, ramp_coefficients(np.arange(1.0, min(SINGLE, n - 1) + 1), n), 0.0, whole(n), 1.0,
                              none)  # fmt: skip
    UU, Uc = directions_of(spectrum, ramp)
    flat = np.arange(UU.shape[1]) >= 2

    def power(t: Term) -> FloatArray:
        """Expected power of a term in the bins, and behind them the variance along each direction."""
        row = t.sampled(rate)
        return t.power(rate) * np.append(column(row, spectrum), np.where(flat, 0.0, 2 * (row.edge + row.ends)))

    columns, theta = [], []
    for t in noise:
        moved = ((i, x * STEP, x / STEP) for i, x in enumerate(t.shape))
        shapes = [[replace(t, shape=(*t.shape[:i], x, *t.shape[i + 1 :])) for x in both] for i, *both in moved]
        columns += [power(t), *((power(more) - power(less)) / (4 * math.log(STEP)) for more, less in shapes)]
        theta += [1.0] + [0.0] * len(shapes)
    columns += [power(t) for t in beside]
    S, W = np.split(np.column_stack(columns), [first.size])
    return Likelihood(S, nothing, spectrum.told, UU, Uc, W, flat), np.array(theta + [0.0] * len(beside))


def _edge(likelihood: Likelihood, theta: FloatArray) -> float:
    """Variance of the odd half of both ends, given the coefficients above the lowest ones."""
    variance = float(likelihood.W[1] @ theta)
    told = likelihood.UU[SINGLE:, 1, 1] / likelihood.expectation(theta)[SINGLE:]
    return variance / (1 + variance * float(told.sum()))


def _errors(information: FloatArray) -> FloatArray:
    """Relative standard errors of coefficients, half of those of their squares; infinite where nothing tells of one."""
    scale = np.sqrt(np.diag(information))
    size = np.where(scale > 0, scale, 1.0)
    values, vectors = np.linalg.eigh(np.where(scale * scale[:, None] > 0, information / size / size[:, None],
                                              np.eye(size.size)))  # fmt: skip
    known = values > RESOLVED
    variance = (vectors[:, known] ** 2 / values[known]).sum(axis=1)
    lost = (vectors[:, ~known] ** 2).sum(axis=1) > 1e-12
    return np.where(lost | (scale == 0), math.inf, np.sqrt(variance) / (2 * size))


def _beside(model: Model, terms: str) -> list[Term]:
    """The terms that `terms` represents and the model lacks, of size 1."""
    symbols = {"known": "", "auto": AUTO}.get(terms, terms)
    if any(symbol not in TERMS or TERMS[symbol].parameters for symbol in symbols):
        raise UsageError(f"terms must be 'known', 'auto' or symbols such as {AUTO!r}, not {terms!r}")
    known = {t.symbol for t in model}
    return [Term(symbol, 1.0, model.signal) for symbol in symbols if symbol not in known]


def _names(noise: list[Term], model: Model) -> list[str]:
    return [name for t in noise for name in (name_of(t, model), *(join(" ", (name_of(t, model), p.title))
                                                                  for p in t.row.parameters))]  # fmt: skip


def name_of(t: Term, model: Model) -> str:
    """The symbol of a term; with its shape where the symbol stands several times in the model."""
    if sum(other.symbol == t.symbol for other in model) == 1:
        return t.symbol
    return f"{t.symbol}({t.shape[0]:.4g} {t.row.parameters[0].unit})"


def _deterministic(
    model: Model, noise: list[Term], ramp: float | None, n: int, rate: float
) -> Iterator[tuple[str, float]]:
    """Relative errors of warm-ups, of a ramp, and of sinusoids' amplitudes and frequencies, beside the noise."""
    for t in model:
        if t.row.transient:
            yield from zip(_names([t], model), transient_errors(t, noise, n, rate), strict=True)
        elif t.row.periodic:
            frequency, duration = t.shape[0], n / rate
            folded = abs(frequency - rate * round(frequency / rate))  # sampling folds it
            amplitude = abs(t.value * np.sinc(frequency / rate))
            errors = math.inf, math.inf
            if folded * duration >= 1 and amplitude:  # else there is no whole period
                random = Model(tuple(part for part in model if part.row.waveform is None))
                density = float(random.spectrum(np.array([folded]), 1 / rate)[0])
                relative = math.sqrt(2 * density / duration) / amplitude
                errors = relative, math.sqrt(6 * density / duration**3) / (math.pi * amplitude * frequency)
            yield from zip(_names([t], model)[:2], errors, strict=True)
        elif ramp is not None and t.row.waveform is not None:
            yield name_of(t, model), ramp / abs(t.value * rate**t.row.power) if t.value else math.inf


MIXING_NODES = 200  # nodes of Gauss's rule for the covariance of two coefficients


def ramp_error(noise: Sequence[Term], n: int, rate: float, edge: float) -> float:
    """Standard error of a ramp beside known noise and an unknown bias, in the unit of the rate per sample."""
    # `edge` is the variance of what quantization does at both ends of the record, as far as higher coefficients leave
    # it; those up to `SINGLE` tell of a ramp, whose power falls as k^-4.
    k = np.arange(1.0, min(SINGLE, n - 1) + 1)
    end = np.sqrt(2 / n) * np.cos(np.pi / (2 * n) * k) * (k % 2)  # the odd half of both ends
    covariance = edge * np.outer(end, end)
    for t in noise:
        row = t.sampled(rate)
        covariance += t.power(rate) * (np.diag(row.dct(k, n)) + mixing(row, k.size, n))
    size, ramp = np.sqrt(np.diag(covariance)), ramp_coefficients(k, n)
    return float((ramp / size @ np.linalg.solve(covariance / np.outer(size, size), ramp / size)) ** -0.5)


@cache
def _mixing_rule() -> tuple[FloatArray, FloatArray]:
    """Nodes and weights of Gauss's rule from 0 to 1."""
    nodes, weights = np.polynomial.legendre.leggauss(MIXING_NODES)
    return (nodes + 1) / 2, weights / 2


def mixing(row: NoiseTerm, block: int, n: int) -> FloatArray:
    """Covariance of the coefficients 1 .. block of n rates, except for its diagonal, shape (block, block)."""
    # With c(h) = D''(h) / 2 the covariance of rates, ``2 n int_0^1 A_kl(u) c(n u) du`` for k, l of equal parity, where
    #     A_kl(u) = (2 / pi) (k sin(pi k u) - l sin(pi l u)) / (l^2 - k^2)
    # is the correlation of the two cosines at the distance u. It is zero for white noise and for random walks.
    v, weight = _mixing_rule()
    u = v**2  # a logarithm at u = 0 becomes smooth
    k = np.arange(1.0, block + 1)
    waves = k * (np.sin(math.pi * np.outer(u, k)).T @ (2 * v * weight * row.derivative(2, n * u)))
    apart = k[None, :] ** 2 - k[:, None] ** 2
    both = (np.subtract.outer(k, k) % 2 == 0) & (apart != 0)
    return np.where(both, n * 2 / math.pi * (waves[:, None] - waves[None, :]) / np.where(both, apart, 1.0), 0.0)


def transient_errors(t: Term, noise: Sequence[Term], n: int, rate: float) -> tuple[float, ...]:
    """Relative standard errors of size and time constant beside known noise and an unknown bias."""
    from scipy.fft import dct

    at, deviation = deviations(Model(tuple(noise)), whole(n), rate)
    scale = np.interp(np.arange(1.0, n), at, deviation)

    def seen(factor: float) -> FloatArray:
        wave = replace(t, shape=(t.shape[0] * factor,)).sampled(rate).waveform
        assert wave is not None  # noqa: S101 - a warm-up has one
        return np.asarray(t.value * dct(wave(n), norm="ortho")[1:] / scale)

    slopes = np.stack((seen(1.0), (seen(STEP) - seen(1 / STEP)) / (2 * math.log(STEP))))
    information = slopes @ slopes.T
    if not np.linalg.det(information) > 0:
        return math.inf, math.inf
    size, time = np.sqrt(np.diag(np.linalg.inv(information))).tolist()
    return size, time
