"""Checks of what a model leaves of a record: is it white, Gaussian, steady, and if not, why."""

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from allanite.core.arrays import FloatArray, IntArray
from allanite.core.finding import Finding
from allanite.core.fit import Fit
from allanite.core.record import SHORTEST, Record
from allanite.core.residuals import Check, Residuals
from allanite.prepare.outliers import outliers as outlying
from allanite.prepare.outliers import treated
from allanite.prepare.rounding import fast_noise, rounding

from .popcorn import jumps, popcorn
from .whitening import memory, whitened

LAGS = 20
"""Samples up to which residuals are asked whether they know of each other."""

PARTS = 8
"""Parts of the record whose levels are compared."""

CHUNK = 1 << 15
"""Residuals that are summed at a time, in double precision."""

UNSTEADY, TAILED, KIN = 1.05, 0.1, 0.02
"""Ratio of levels, excess kurtosis and correlation from which a check that fails matters."""

LOUD = 1.2
"""Ratio of levels from which it matters beside a spectrum that is not explained."""

DIFFERENT = 1.5
"""Ratio of levels of the noise from which one set of coefficients is none of either part's."""

SHOWN, QUANTILES = 400, 100_000
"""Stretches of which the extremes are kept for the eye; residuals of which quantiles are taken."""


def residuals(record: Record, fit: Fit, *, outliers: str = "mark") -> Residuals:
    """What the fit's model leaves of the record, and whether that is white, Gaussian and steady.

    Parameters
    ----------
    record : Record
    fit : Fit
        Of this record.
    outliers : {"mark", "keep"}
        What the fit did with them.

    Returns
    -------
    Residuals
        With a check of the correlations of residuals up to 20 samples apart (Ljung and Box 1978), of their excess
        kurtosis, and of their power in halves and in eighths of the record; and with findings that name the likely
        reason, if the model does not explain the record.

    Raises
    ------
    UsageError
        The model has no noise, or is one of another signal.

    Examples
    --------
    >>> from allanite.core.model import N
    >>> from allanite.identification import identify
    >>> from allanite.simulation.record import simulate
    >>> record = simulate(N(0.1, "deg/sqrt(h)"), 20_000, 100.0, rng=np.random.default_rng(1))
    >>> left = residuals(record, identify(record))
    >>> left.explained, [check.name for check in left.checks]
    (True, ['correlation', 'kurtosis', 'halves', 'eighths'])
    """
    record = treated(record, outliers)
    return checked(whitened(record, fit.model, fit.scope), record, fit, outliers)


def checked(u: NDArray[np.float32], record: Record, fit: Fit, outliers: str) -> Residuals:
    """The residuals of a record, once its whitened series is known; see `residuals`."""
    there = _inside(u, memory(fit.model, record.size, record.rate))
    series = u if there is None else u[there]
    n = series.size
    if n < SHORTEST:
        none = np.empty(0)
        return Residuals(record.name, record.rate, record.size, fit.goodness, (), (), *([none] * 8))
    parts, stretches = (np.linspace(0, n, k + 1).astype(np.int64) for k in (PARTS, min(SHOWN, n // 8)))

    def seconds(at: IntArray) -> FloatArray:
        return np.asarray((at if there is None else there[np.minimum(at, n - 1)]) / record.rate)

    checks, correlation, power, error = _checks(series, parts)
    expected, observed = _quantiles(series)
    # what else is slow, or a level that changes, makes tails of its own
    steady = not fit.findings and all(check.passed for check in checks if check.name in ("halves", "eighths"))
    jumping = popcorn(jumps(series, fit.model, record.rate), record.signal, seconds) if steady else []
    return Residuals(
        name=record.name,
        rate=record.rate,
        size=record.size,
        goodness=fit.goodness,
        checks=checks,
        findings=(
            *fit.findings,
            *_reasons(record, fit, checks, (power, record.cut + seconds(parts)), kept=outliers == "keep"),
            *jumping,
        ),
        correlation=correlation,
        level=np.sqrt(power),
        level_error=error,
        time=seconds((stretches[:-1] + stretches[1:]) // 2),
        low=np.minimum.reduceat(series, stretches[:-1]).astype(np.float64),
        high=np.maximum.reduceat(series, stretches[:-1]).astype(np.float64),
        expected=expected,
        observed=observed,
    )


def _checks(u: NDArray[np.float32], parts: IntArray) -> tuple[tuple[Check, ...], FloatArray, FloatArray, FloatArray]:
    """The checks, the correlations, and the power of each part with the standard error of its rms."""
    count = np.diff(parts)
    sums = np.array([_sums(u, a, b) for a, b in pairwise(parts.tolist())])
    power, fourth = sums[:, 0] / count, sums[:, 1] / count
    correlation = sums[:, 2:].sum(axis=0) / sums[:, 0].sum()
    # variance of u^2 relative to its mean, 2 for Gaussian ones; correlation makes that of a mean larger
    spread = (fourth / power**2 - 1) * (1 + 2 * float(correlation @ correlation))
    checks = (
        _ljung_box(correlation, u.size),
        _kurtosis(fourth / power**2, count),
        _halves(power, spread, count),
        _eighths(power, spread, count),
    )
    return checks, correlation, power, np.sqrt(power * spread / count) / 2


def _inside(u: NDArray[np.float32], margin: int) -> IntArray | None:
    """Residuals that are there, and at least `margin` samples from an end or a gap; None if all are."""
    if not margin and np.isfinite(u.sum(dtype=np.float64)):
        return None
    there = np.flatnonzero(np.isfinite(u))
    joints = np.concatenate(([0], np.flatnonzero(np.diff(there) > 1) + 1, [there.size]))
    near = np.zeros(there.size + 1, dtype=np.int64)
    np.add.at(near, np.maximum(joints - margin, 0), 1)
    np.add.at(near, np.minimum(joints + margin, there.size), -1)
    return np.asarray(there[np.cumsum(near[:-1]) == 0])


def _sums(u: NDArray[np.float32], first: int, last: int) -> list[float]:
    """Sums over a part of u^2, u^4, and of products with what follows 1, 2 .. 20 samples later."""
    total = np.zeros(2 + LAGS)
    for a in range(first, last, CHUNK):
        b = min(a + CHUNK, last)
        v = u[a : b + LAGS].astype(np.float64)
        now = v[: b - a]
        square = now * now
        total[0] += square.sum()
        total[1] += square @ square
        for h in range(1, LAGS + 1):
            later = v[h : h + now.size]
            total[1 + h] += now[: later.size] @ later
    return list(total)


def _ljung_box(r: FloatArray, n: int) -> Check:
    """Sum of squared correlations: chi-square, for the terms are fitted to far more frequencies than 20 lags see."""
    from scipy.special import chdtrc

    h = np.arange(1, LAGS + 1)
    statistic = float(n * (n + 2.0) * (r**2 / (n - h)).sum())
    largest = float(r[np.abs(r).argmax()])
    p = float(chdtrc(LAGS, statistic))
    return Check("correlation", "correlation of neighbours", largest, p, f"largest up to {LAGS} samples apart")


def _kurtosis(ratio: FloatArray, count: IntArray) -> Check:
    """Mean fourth power over squared power, part by part, so that a level that changes makes no tails."""
    n = int(count.sum())
    value = float(ratio @ count / n) - 3 + 6 * count.size / n
    p = _two_sided(value * math.sqrt(n / 24))
    return Check("kurtosis", "excess kurtosis", value, p, "0 for Gaussian noise, above for heavy tails")


def _two_sided(z: float) -> float:
    """Probability that a standard normal deviate is larger in size."""
    from scipy.special import erfc

    return float(erfc(abs(z) / math.sqrt(2)))


def _halves(power: FloatArray, spread: FloatArray, count: IntArray) -> Check:
    half = PARTS // 2
    first, second = (float(np.average(power[p], weights=count[p])) for p in (slice(half), slice(half, None)))
    error = math.sqrt(float(np.mean(spread)) * 4 / float(count.sum()))
    p = _two_sided(math.log(second / first) / error)
    return Check("halves", "level of the halves", math.sqrt(second / first), p, "rms, second over first")


def _eighths(power: FloatArray, spread: FloatArray, count: IntArray) -> Check:
    from scipy.special import chdtrc

    logs = np.log(power)
    statistic = float((np.square(logs - logs.mean()) * count).sum() / np.mean(spread))
    ratio = math.sqrt(float(power.max() / power.min()))
    return Check(
        "eighths", "level of the eighths", ratio, float(chdtrc(PARTS - 1, statistic)), "rms, largest over least"
    )


def _quantiles(u: NDArray[np.float32]) -> tuple[FloatArray, FloatArray]:
    """Normal quantiles and those of a sample of the residuals, closer together in the tails."""
    from scipy.special import ndtr

    part = np.sort(u[:: max(1, u.size // QUANTILES)]).astype(np.float64)
    reach = 4.2
    expected = np.linspace(-reach, reach, 201)
    share = ndtr(expected)
    held = (share * part.size > 0.5) & ((1 - share) * part.size > 0.5)
    at = np.clip((share[held] * part.size - 0.5).round().astype(np.int64), 0, part.size - 1)
    return expected[held], part[at]


def _reasons(
    record: Record, fit: Fit, checks: tuple[Check, ...], level: tuple[FloatArray, FloatArray], *, kept: bool
) -> list[Finding]:
    """What is likely wrong beside the spectrum, which `Goodness.reasons` explain."""
    spectral = fit.goodness is not None and not fit.goodness.explained
    if not spectral and all(check.passed for check in checks):
        return []
    coarse = _undithered(record)
    if coarse is not None:
        return [coarse]
    near, tails, halves, eighths = checks
    found = []
    ratio = max(halves.value, 1 / halves.value, eighths.value)
    if not (halves.passed and eighths.passed) and ratio > (LOUD if spectral else UNSTEADY):
        found.append(_unsteady(eighths, *level))
    # where the spectrum is wrong neighbours correlate, and a line has tails of its own; rounding makes light ones
    if not spectral and not tails.passed and tails.value > TAILED:
        found.append(_tailed(tails, curable=kept and outlying(record).at.size > 0))
    whole = fit.scope is None or fit.scope.whole
    if whole and not spectral and not near.passed and abs(near.value) > KIN:
        found.append(_kin(near, fit))
    return found


def _undithered(record: Record) -> Finding | None:
    """The readings are steps of a quantizer that nothing dithers."""
    steps = record.steps[np.isfinite(record.steps)]
    middle = max(0, (steps.size - 200_000) // 2)
    part = np.asarray(steps[middle : middle + 200_000], dtype=np.float64)
    found = rounding(steps, fast_noise(np.diff(part, 2)))
    if not found.sparse:
        return None
    size = found.step * (record.scale or 1.0)
    return Finding(
        "no dither",
        f"quantization is not white here: {found.counted}steps of {size:.4g} {record.unit} (LSB), and the fast noise "
        f"is {found.noise:.2g} step",
        "the rounding error follows the signal, and N and Q are not meaningful",
        "use a finer output of the sensor, or add dither before rounding",
        fatal=True,
    )


def _unsteady(check: Check, power: FloatArray, time: FloatArray) -> Finding:
    level = np.sqrt(power / np.median(power))
    odd = int(np.abs(np.log(level)).argmax())
    loud = level > math.sqrt(level.max() * level.min())
    first, last = int(loud.argmax()), loud.size - int(loud[::-1].argmax())
    different = check.value > DIFFERENT
    return Finding(
        "level",
        f"the noise level changes {check.value:.3g} times between eighths of the record, and is highest from "
        f"{time[first]:.6g} s to {time[last]:.6g} s",
        "one set of coefficients describes neither part" if different else "the coefficients are those of the average",
        "analyse the parts separately (--from, --until)",
        (float(time[odd]), float(time[odd + 1])),
        fatal=different,
    )


def _tailed(check: Check, *, curable: bool) -> Finding:
    return Finding(
        "heavy tails",
        f"the residuals have heavy tails (excess kurtosis {check.value:.3g}): outliers, bursts, or noise that comes "
        "and goes",
        "the coefficients hold, but their intervals are too narrow",
        "leave out the outliers (--outliers mark)" if curable else "",
    )


def _kin(check: Check, fit: Fit) -> Finding:
    tried = fit.scope is not None and fit.scope.choice == "auto"
    return Finding(
        "correlation",
        f"the residuals are not white: neighbours correlate by {check.value:.2g}",
        "the model misses something fast, and its intervals are too narrow",
        "" if tried else "let the fit look for a filter and for the frequencies that the terms explain (--band auto)",
        fatal=abs(check.value) > 5 * KIN,
    )
