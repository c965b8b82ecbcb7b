"""Identification by likelihood: which terms a record holds, how large they are, and how sure that is."""

import math
from collections.abc import Callable
from functools import cache

import numpy as np

from allanite.errors import DataError
from allanite.fit import WEAK, Estimate, Fit
from allanite.gaps import refusal
from allanite.model import Model, Term
from allanite.record import Record
from allanite.terms import TERMS

from .goodness import goodness
from .likelihood import FloatArray
from .selection import Profiles, Subset, select, standard_error, subsets
from .whittle import Spectrum, likelihood, spectrum

Limits = Callable[[float], tuple[float, float]]


def whittle(record: Record, symbols: str, band: tuple[float, float] | None = None) -> Fit:
    """Identify terms by the binned DCT-II Whittle likelihood.

    Selection of noise terms by 2 L + 4 per term over all subsets, with the ramp integrated out; profile intervals;
    upper limits for what is absent; the signed ramp by generalised least squares, averaged over what hides it.

    Parameters
    ----------
    record : Record
    symbols : str
        Keys of `TERMS`.
    band : (low, high), optional
        Frequencies to be used, Hz.
    """
    why = refusal(record)
    if why:
        raise DataError(f"{record.name or 'the record'}: {why}")
    noise = [symbol for symbol in symbols if TERMS[symbol].waveform is None]
    ramps = [symbol for symbol in symbols if TERMS[symbol].waveform is not None]
    seen = spectrum(record, detrend=bool(ramps))
    whole = likelihood(seen, symbols)
    used = np.ones(seen.first.size, dtype=bool) if band is None else seen.within(band)
    part = whole.only(used)
    fitted = subsets(part)
    chosen, profiles, scale = select(fitted), Profiles(part, fitted), _Scale(record, seen)
    estimates = {s: _noise_estimate(s, i, (profiles, chosen), scale) for i, s in enumerate(noise)}
    estimates |= {s: _ramp_estimate(s, profiles, noise, scale) for s in ramps}
    return Fit(
        estimates=tuple(estimates[s] for s in symbols),
        method="whittle",
        signal=record.signal,
        name=record.name,
        model=_model(estimates, dict(zip(noise, chosen.theta.tolist(), strict=True)), scale),
        goodness=goodness(seen, part, chosen.theta, used),
        notes=tuple(_unclear(estimates, noise, chosen)),
    )


class _Scale:
    """From theta, in the record's unit and per sample, to coefficients in SI."""

    def __init__(self, record: Record, seen: Spectrum) -> None:
        self.signal, self.rate, self.factor, self.slope = record.signal, seen.rate, seen.unit_factor, seen.slope

    def coefficient(self, symbol: str, theta: float) -> float:
        return self.coefficient_of(symbol, math.sqrt(max(theta, 0.0)))

    def coefficient_of(self, symbol: str, eta: float) -> float:
        return eta * self.factor * math.pow(self.rate, -TERMS[symbol].power)


def _noise_estimate(symbol: str, which: int, found: tuple[Profiles, Subset], scale: _Scale) -> Estimate:
    profiles, chosen = found

    @cache
    def limits(level: float) -> tuple[float, float]:
        low, high = profiles.limits(which, level)
        return scale.coefficient(symbol, low), scale.coefficient(symbol, high)

    @cache
    def upper(level: float) -> float:
        return scale.coefficient(symbol, profiles.upper(which, level))

    if not (chosen.free[which] and profiles.excludes_zero(which) and limits(0.95)[0] > 0):
        return _absent(symbol, scale, upper, limits)
    theta = float(chosen.theta[which])
    value = scale.coefficient(symbol, theta)
    relative = standard_error(profiles.likelihood, chosen, which) / (2 * theta)
    status = "identified" if relative <= WEAK else "weak"
    return Estimate(symbol, scale.signal, value, value * relative, status, upper(0.95), "whittle", limits, limits)


def _absent(symbol: str, scale: _Scale, upper: Callable[[float], float], profile: Limits) -> Estimate:
    highest = upper(0.95) if math.isfinite(upper(0.95)) else None
    return Estimate(
        symbol, scale.signal, None, None, "absent", highest, "whittle", lambda level: (0.0, upper(level)), profile
    )


def _ramp_estimate(symbol: str, profiles: Profiles, noise: list[str], scale: _Scale) -> Estimate:
    """The signed ramp: normal for given noise, averaged over what the noise of the longest memory may be.

    That noise is what hides a ramp, and is known from a few coefficients only: averaging gives the wide tails of
    Student's t, and holds where the noise was not seen at all.
    """
    part = profiles.likelihood
    if not part.flat.any():  # the band leaves out the frequencies where a ramp lives
        return _absent(symbol, scale, lambda level: math.inf, lambda level: (-math.inf, math.inf))
    slowest = max(range(len(noise)), key=lambda i: TERMS[noise[i]].slope)
    thetas, weight = profiles.weighted(slowest)
    found = [part.directions(theta)[:2] for theta in thetas]
    centre = np.array([eta[-1] for eta, _ in found]) + scale.slope
    spread = np.sqrt([V[-1, -1] for _, V in found])
    mean = float(weight @ centre)
    error = scale.coefficient_of(symbol, math.sqrt(float(weight @ (spread**2 + (centre - mean) ** 2))))
    value = scale.coefficient_of(symbol, mean)

    @cache
    def quantile(p: float) -> float:
        return scale.coefficient_of(symbol, _mixture_quantile(p, centre, spread, weight))

    def limits(level: float) -> tuple[float, float]:
        return quantile((1 - level) / 2), quantile((1 + level) / 2)

    def upper(level: float) -> float:
        return max(abs(v) for v in limits(2 * level - 1))

    low, high = limits(0.95)
    if low <= 0 <= high:
        return _absent(symbol, scale, upper, limits)
    status = "identified" if error <= WEAK * abs(value) else "weak"
    return Estimate(symbol, scale.signal, value, error, status, upper(0.95), "whittle", limits, limits)


def _mixture_quantile(p: float, centre: FloatArray, spread: FloatArray, weight: FloatArray) -> float:
    """Quantile of a mixture of normal distributions, by bisection."""
    from scipy.special import ndtr

    low, high = float((centre - 40 * spread).min()), float((centre + 40 * spread).max())
    for _ in range(60):
        middle = (low + high) / 2
        below = weight @ ndtr((middle - centre) / spread) < p
        low, high = (middle, high) if below else (low, middle)
    return (low + high) / 2


def _model(estimates: dict[str, Estimate], theta: dict[str, float], scale: _Scale) -> Model:
    """What describes the record best: the selected noise terms, claimed or not, and the ramp if it is claimed."""
    terms = [Term(s, scale.coefficient(s, value), scale.signal) for s, value in theta.items() if value > 0]
    terms += [Term(s, e.value, scale.signal) for s, e in estimates.items() if s not in theta and e.value is not None]
    return Model(tuple(terms))


def _unclear(estimates: dict[str, Estimate], noise: list[str], chosen: Subset) -> list[str]:
    """Terms that describe the record best but are not claimed: others could take their place."""
    doubtful = [s for s, there in zip(noise, chosen.free, strict=True) if there and not estimates[s].claimed]
    return [
        f"{TERMS[s].title} ({s}) is in the model that describes the record best, but other terms could take its place: "
        "a longer record would tell"
        for s in doubtful
    ]
