"""From a record and the channels recorded with it to a regression."""

import math
from collections.abc import Sequence

import numpy as np

from allanite.extending import (  # isort: skip
    SHORTEST, TERMS, DataError, FloatArray, Likelihood, Model, Record, Recording, Term, UsageError, join, public, say,
    say_count, spelled)  # fmt: skip

from .design import Design, choose, collinearity, design, folds
from .mixture import Gain, about_line, mixture
from .regression import Regression
from .settings import CompensationSettings, FitSettings

MIN_RESIDUAL = 1e-11  # residual, relative to the record, at which only rounding errors remain

USUAL = FitSettings()


@public
def compensate(
    record: Record, along: Recording | Record, regressors: Sequence[str] = (), *, degree: int = 1,
    lags: Sequence[float] = (), derivative_of: Sequence[str] = (), trend: bool = True, settings: FitSettings = USUAL,
) -> Regression:  # fmt: skip
    """Estimate the part of a record that depends on other channels: temperature, displacement, flux or any other.

    The rate is a constant, a sum of coefficients times regressors, and noise of the terms Q, N, B and K, which is
    identified jointly with the coefficients by the restricted likelihood. Coefficients are generalized least-squares
    estimates, averaged over the possible slow noise; ordinary least squares finds a nonexistent effect in half of
    the records with a drifting temperature. Regressors named explicitly, and their lags, are kept; powers up to
    `degree` are added only if cross-validation improves.

    Parameters
    ----------
    record : Record
    along : Recording or Record
        The channels, with the record's sample times; `compensation.aligned` resamples them.
    regressors : sequence of str
        Channels whose samples, minus their means, are regressors.
    degree : int
        Highest power to try.
    lags : sequence of float
        Lags at which the regressors enter, too, s.
    derivative_of : sequence of str
        Channels whose time derivative is a regressor.
    trend : bool
        Estimate a linear drift beside the regressors; it is not removed. Without it a rate ramp R would be taken for
        the effect of a regressor that rises or falls.
    settings : FitSettings
        Noise terms, window of rates, blocks, gaps.

    Returns
    -------
    Regression

    Raises
    ------
    UsageError
        A regressor is missing, or an option is impossible.
    DataError
        A regressor is constant, a linear combination of others or has other sample times; samples are missing; there
        are too few effective samples for the number of regressors.

    References
    ----------
    D. A. Harville, J. Am. Stat. Assoc. 72 (1977) 320 (restricted likelihood); D. A. Belsley, E. Kuh, R. E. Welsch,
    Regression Diagnostics (Wiley 1980) (condition number).

    Examples
    --------
    >>> import allanite as al
    >>> rng = np.random.default_rng(1)
    >>> temp = al.Record(20 + 5 * np.sin(np.arange(3600) / 600), rate=1.0, unit="degC", name="temp")
    >>> noise = al.simulate(al.N(0.1, "deg/sqrt(h)"), 3600, 1.0, rng=rng)
    >>> gyro = noise.with_values(noise.values + 1e-5 * temp.values, "warmed")
    >>> found = compensate(gyro, temp, ["temp"])
    >>> found["temp"].low < 1e-5 < found["temp"].high, found.significant
    (True, True)
    >>> found.apply(gyro, al.Recording((temp,))).history[-1]
    'corrected: regression on temp'
    """
    if isinstance(regressors, str) or isinstance(derivative_of, str):
        raise UsageError("regressors and derivative_of are sequences of names, for example ['temp']")
    beside = along if isinstance(along, Recording) else Recording((along,))
    if record.size < SHORTEST:
        raise DataError(say_count(record.size, "{name!r} has {count} sample; a regression needs at least {least}",
                                  "{name!r} has {count} samples; a regression needs at least {least}", name=record.name,
                                  least=SHORTEST))  # fmt: skip
    wanted = CompensationSettings(tuple(regressors), degree, tuple(lags), tuple(derivative_of), trend, fit=settings)
    whole = design(record, beside, wanted)
    residuals = whole.y - whole.X @ _plain(whole)
    size, rest = (max(float(np.ptp(y[a:b])) for a, b in whole.stretches) for y in (whole.y, residuals))
    if size == 0:
        raise DataError(say("{name!r} is constant (always {value:g} SI): check the sensor", name=record.name,
                            value=float(whole.y[whole.stretches[0][0]])))  # fmt: skip
    if rest < MIN_RESIDUAL * size:
        raise DataError(say("{regressors} explain {name!r} completely: no noise remains. Is the record, or something "
                            "derived from it, among the regressors?", name=record.name,
                            regressors=join(", ",
                                            [join("", ("'", whole.labels[i], "'")) for i in whole.taken])))  # fmt: skip
    terms = settings.symbols
    theta, _ = whole.likelihood(terms).minimise(np.ones(len(terms), dtype=bool))
    blocks = folds(whole, theta, terms, settings.blocks)
    if len(blocks) < 3:
        notes = (say("the record is too short for cross-validation: every column is kept"),)
        return _regression(record, whole, list(range(len(whole.regressors))), settings, notes=notes)
    kept = list(range(len(whole.regressors))) if settings.every else choose(whole, blocks)
    # mean squares of the held-back blocks, less a trend alone, and less all columns
    ramp = [i for i in kept if i in whole.trend]
    before, after = (sum(fold.misfit(columns, plain=True) for fold in blocks) for columns in (ramp, kept))
    return _regression(record, whole, kept, settings, held=Gain(before / whole.count, after / whole.count, 0.0))


def _regression(
    record: Record, whole: Design, kept: list[int], settings: FitSettings, *, held: Gain | None = None,
    notes: tuple[str, ...] = (),
) -> Regression:  # fmt: skip
    part = whole.only(kept)
    first = _plain(part)
    # the bins of the spectrum lose digits where an effect is many thousand times the noise: most of it is removed
    likelihood = part.likelihood(settings.symbols, y=part.y - part.X @ first)
    theta, mean, coefficients = mixture(likelihood, settings.symbols)
    condition, inflation, alike = collinearity(part, likelihood, theta, settings.symbols)
    inside = _inside(part, likelihood, theta, coefficients.values + first)
    effective = _effective(part, likelihood, theta)
    if effective < settings.least * len(part.taken):
        raise DataError(
            say_count(len(part.taken), "the noise of {name!r} has {effective:.3g} effective samples, as a whole "
                      "or where the regressors vary: too few for {count} regressor, each of which needs {least:g}. Use "
                      "fewer regressors, record for longer, or require fewer samples per regressor with {option}",
                      "the noise of {name!r} has {effective:.3g} effective samples, as a whole or where the regressors "
                      "vary: too few for {count} regressors, each of which needs {least:g}. Use fewer regressors, "
                      "record for longer, or require fewer samples per regressor with {option}", name=record.name,
                      effective=effective, least=settings.least, option=spelled("--least", "FitSettings(least=...)"))
        )  # fmt: skip
    sizes = zip(settings.symbols, mean, strict=True)
    noise = [Term(s, math.sqrt(v) * record.rate ** -TERMS[s].power, record.signal) for s, v in sizes if v > 0]
    return Regression(record.signal, record.name, part.regressors, coefficients.scaled(1 / part.size, first),
                      chosen=tuple(bool(o) and not settings.every for o in part.optional),
                      candidates=int(whole.optional.sum()), inflation=inflation, condition=condition,
                      noise=Model(tuple(noise)), effective=effective, inside=inside, held=held,
                      notes=(*part.notes, *notes, *alike))  # fmt: skip


def _plain(part: Design) -> FloatArray:
    """Ordinary least squares, each stretch about its own mean."""
    Z, z = (_centred(part, of) for of in (part.X, part.y))
    return np.asarray(np.linalg.lstsq(Z, z, rcond=None)[0])


def _centred(part: Design, of: FloatArray) -> FloatArray:
    """Each stretch about its own mean."""
    return np.concatenate([of[a:b] - of[a:b].mean(axis=0) for a, b in part.stretches])


def _inside(part: Design, likelihood: Likelihood, theta: FloatArray, values: FloatArray) -> Gain:
    """Mean squares of the fitted record, about a line beside a trend; without dependence the fit takes tr(V X'X)."""
    taken = part.taken
    flat = np.flatnonzero(likelihood.flat)[taken]
    V = likelihood.directions(theta)[1][np.ix_(flat, flat)]
    trend = _centred(part, part.X[:, part.trend])
    X, y = (about_line(_centred(part, of), trend) for of in (part.X[:, taken], part.y))
    residuals = y - X @ values[taken]
    sums = float(y @ y), float(residuals @ residuals), float(np.trace(V @ X.T @ X))
    return Gain(*(total / part.count for total in sums))


def _effective(part: Design, likelihood: Likelihood, theta: FloatArray) -> float:
    """Effective samples: degrees of freedom of the noise as a whole, or where the regressors vary if these are more."""
    # The variance of the noise has (sum m)^2 / sum m^2 of them, m being its spectrum: as many as there are samples for
    # white noise, two or three for a random walk. The coefficient of a column x has the variance 1 / A, with A the sum
    # of x_k^2 / m_k. With C the covariance of ln theta that the record leaves, A has 2 / Var(ln A): of a random walk as
    # many as there are coefficients that it rules.
    m, used = likelihood.expectation(theta), theta > 0
    whole = float(likelihood.count @ m) ** 2 / float(likelihood.count @ m**2)
    share = likelihood.S[:, used] * theta[used] / m[:, None]
    C = np.linalg.pinv(likelihood.information(theta)[np.ix_(used, used)] * np.outer(theta[used], theta[used]))
    flat = np.flatnonzero(likelihood.flat)[part.taken]
    weight = np.einsum("kii->ik", likelihood.UU[:, flat][:, :, flat]) / m
    g = weight @ share / weight.sum(axis=1, keepdims=True)
    return max(whole, float((2 / np.einsum("ri,ij,rj->r", g, C, g)).min(initial=part.count)))
