"""Checks of residuals: whether they are white, Gaussian and stationary; jumps and bursts (popcorn noise)."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy
from numpy.typing import NDArray

from allanite.core.aliases import public
from allanite.core.arrays import FloatArray, IntArray, complete
from allanite.core.errors import DataError
from allanite.core.fit import Fit
from allanite.core.model import Model
from allanite.core.record import SHORTEST, Record
from allanite.core.residuals import Check, Residuals
from allanite.core.units import Signal, convert
from allanite.core.validity import Finding
from allanite.identification.likelihood.spectrum import easy_size
from allanite.phrases.phrase import between, join, say
from allanite.prepare.gaps import whole
from allanite.prepare.outliers import treated

from .goodness import reasons
from .whitening import deviations, levelled, memory, whitened

FINEST_BLOCK, MAX_BLOCKS = 8, 1 << 17
"""Number of samples per block, and the number of blocks above which blocks become longer."""

SHORTEST_WINDOW, LONGEST_WINDOW, WINDOW_GROWTH = 4, 1 / 16, math.sqrt(2)
"""Windows: blocks in the shortest, share of the record of the longest, ratio of successive lengths."""

FEWEST_BLOCKS = 512  # number of blocks needed to detect tails

TAILED_DEVIATE = 2.9
"""Normal deviate of the excess kurtosis for detection: the maximum over windows exceeds it in 1 of 500 records."""

CHANCE_OF_JUMP = 0.012
"""The same for the expected number of larger scores; windows overlap, so that it is not a probability."""

QUIET = 0.25  # share of the record that a stretch without jumps must have to be suggested as a window
DENSE = 16  # Windows that begin within the length of one
MEDIAN = 0.4549  # median of the square of a normal deviate
JUMP_DEVIATE = 3.5  # standard deviations from which a score is counted as a jump


HARMLESS_SHARE = 0.05  # share of the variance of the scores below which jumps do not affect the coefficients


@dataclass(frozen=True, eq=False)
class Jumps:
    """Scores of the windows of one length in a series."""

    # `size` of the series and `length` of the windows are in samples; `jump` is the largest, SI, in the window whose
    # middle is the sample `largest`. `weight` is the significance over the threshold, 1 and above is reported. `at` are
    # the middles of the windows with significant jumps, `share` is the part of the variance of the scores due to jumps.
    size: int
    length: int
    jump: float
    largest: int
    weight: float
    at: IntArray
    share: float


def jumps(u: NDArray[np.float32], model: Model, rate: float) -> Jumps | None:
    """The windows that detect jumps best in a whitened series; None if it is too short, or the shortest are best."""
    # The shortest windows detect outliers and heavy tails of single samples best, not lasting jumps.
    block = max(FINEST_BLOCK, -(-u.size // MAX_BLOCKS))
    blocks = easy_size(u.size // block)
    if blocks < FEWEST_BLOCKS:
        return None
    # sums over blocks of the record weighed by the inverse of its covariance
    means = (u[: blocks * block].reshape(blocks, block) @ np.full(block, 1 / block, dtype=np.float32)).astype(
        np.float64
    )
    k, deviation = deviations(model, whole(u.size), rate)
    c = scipy.fft.dct(means, norm="ortho", overwrite_x=True)
    c[0] = 0.0
    c[1:] *= np.interp(np.arange(1, blocks), k, 1 / deviation)
    total = np.concatenate(([0.0], np.cumsum(block * scipy.fft.idct(c, norm="ortho", overwrite_x=True))))
    count = int(math.log(blocks * LONGEST_WINDOW / SHORTEST_WINDOW, WINDOW_GROWTH)) + 1
    lengths = [round(SHORTEST_WINDOW * WINDOW_GROWTH**i) for i in range(count)]
    chances = 2 * sum(blocks / length for length in lengths)
    weights = [_weight(total, length, chances) for length in lengths]
    best = max(range(count), key=weights.__getitem__)
    return _scored(total, lengths[best], block, weights[best]) if best else None


def _scores(total: FloatArray, length: int) -> FloatArray:
    """The scores of windows of a length in blocks, a sixteenth of it apart, from the running total."""
    step = max(1, length // DENSE)
    return total[length::step] - total[:-length:step]


def _weight(total: FloatArray, length: int, chances: float) -> float:
    """The significance of their excess kurtosis and of the largest, whichever is greater."""
    square = _scores(total, length) ** 2
    variance = float(square.mean())
    kurtosis = float(square @ square) / square.size / variance**2 - 3
    largest = math.sqrt(float(square.max()) / variance)
    chance = chances * largest * math.exp(-(largest**2) / 2) / math.sqrt(2 * math.pi)
    deviate = _normal(kurtosis, 1.2 * total.size / length)
    return max(deviate / TAILED_DEVIATE, math.log(max(chance, 1e-300)) / math.log(CHANCE_OF_JUMP))


def _scored(total: FloatArray, length: int, block: int, weight: float) -> Jumps:
    """What windows of a length say of jumps."""
    step, score = max(1, length // DENSE), _scores(total, length)
    square = score**2
    most = int(square.argmax())
    quiet = float(np.median(square)) / MEDIAN  # bursts increase the variance, but hardly this
    at = np.flatnonzero(square > JUMP_DEVIATE**2 * quiet)
    # middles of the runs that stand out; those no more than a length apart are one
    runs = np.split(at, np.flatnonzero(np.diff(at) > length // step) + 1)
    middles = np.array([(run[0] + run[-1]) // 2 for run in runs if run.size], dtype=at.dtype)
    return Jumps(
        size=(total.size - 1) * block, length=length * block, jump=float(score[most]) / quiet,
        largest=(2 * most * step + length) * block // 2, weight=weight,
        share=1 - quiet / float(square.mean()), at=(step * middles + length // 2) * block,
    )  # fmt: skip


def _normal(kurtosis: float, n: float) -> float:
    """Excess kurtosis of n normal deviates as one normal deviate (F. J. Anscombe, W. J. Glynn, Biometrika 70, 227)."""
    variance = 24 * n * (n - 2) * (n - 3) / ((n + 1) ** 2 * (n + 3) * (n + 5))
    x = (kurtosis + 6 / (n + 1)) / math.sqrt(variance)
    skewness = (
        6 * (n * n - 5 * n + 2) / ((n + 7) * (n + 9)) * math.sqrt(6 * (n + 3) * (n + 5) / (n * (n - 2) * (n - 3)))
    )
    A = 6 + 8 / skewness * (2 / skewness + math.sqrt(1 + 4 / skewness**2))
    return float((1 - 2 / (9 * A) - np.cbrt((1 - 2 / A) / (1 + x * math.sqrt(2 / (A - 4))))) / math.sqrt(2 / (9 * A)))


def popcorn(burst: Jumps | None, signal: Signal, seconds: Callable[[IntArray], FloatArray]) -> list[Finding]:
    """The finding about jumps; `seconds` gives the times of samples of the series."""
    if burst is None or burst.weight < 1 or burst.share < HARMLESS_SHARE:
        return []
    unit = signal.sheet[0]
    ends = seconds(np.concatenate(([0], burst.at, [burst.size])))
    middle, half = float(seconds(np.array([burst.largest]))[0]), float(burst.length / 2 * ends[-1] / burst.size)
    free = np.diff(ends)
    longest = int(free.argmax())
    first = math.ceil(ends[longest] + (2 * half if longest else 0))
    last = math.floor(ends[longest + 1] - (2 * half if longest < free.size - 1 else 0))
    remedy = say("look for a bad contact or a failing component; the measured Allan deviation itself is valid")
    if last - first >= QUIET * ends[-1]:
        part = say("a part without them: {selection}", selection=between(first, last))
        remedy = join("; ", (remedy, part))
    size = abs(convert(burst.jump, signal.unit, unit))
    count = max(burst.at.size, 1)
    what = say("the bias jumps: the largest burst, {size:.3g} {unit}, is at {middle:.4g} s, and there are {count} "
               "of about {length:.2g} s in {duration:.4g} s",
               size=size, unit=unit, middle=middle, count=count, length=2 * half, duration=ends[-1])  # fmt: skip
    harm = say("popcorn noise is not one of the terms: it contributes to B, K and GM, and their intervals are too "
               "narrow")  # fmt: skip
    return [Finding("popcorn", what, harm, remedy, (max(0.0, middle - half), middle + half), fatal=True)]


LAGS = 20  # largest lag, in samples, of the autocorrelation
PARTS = 8  # number of parts of the record whose levels are compared
CHUNK = 1 << 15  # residuals that are summed at a time, in double precision

SHOWN, QUANTILES = 400, 100_000
"""Number of stretches whose extremes are kept for figures, and of residuals used for quantiles."""


@public
def residuals(record: Record, fit: Fit, *, outliers: str = "mark") -> Residuals:
    """Compute the residuals of a fit, and test whether they are white, Gaussian and stationary.

    Parameters
    ----------
    record : Record
    fit : Fit
        Fit of this record.
    outliers : {"mark", "keep"}
        How the fit treated outliers.

    Returns
    -------
    Residuals
        With tests of the autocorrelation at lags of up to 20 samples (Ljung and Box 1978), of the excess kurtosis, and
        of the power in halves and in eighths of the record; and with findings about the likely reason if the model does
        not explain the record.

    Raises
    ------
    UsageError
        The model has no noise, or is one of another signal.

    Examples
    --------
    >>> from allanite import N, identify, simulate
    >>> record = simulate(N(0.1, "deg/sqrt(h)"), 20_000, 100.0, rng=np.random.default_rng(1))
    >>> left = residuals(record, identify(record))
    >>> left.explained, [check.name for check in left.checks]
    (True, ['correlation', 'kurtosis', 'halves', 'eighths'])
    """
    record = levelled(treated(record, outliers), fit.steps)
    # the selected model sets absent terms to zero: the residuals of a weak random walk would correlate
    model = Model((*fit.averaged.model, *(line.term for line in fit.lines))) if fit.nodes else fit.model
    return checked(whitened(record, fit.complete(model), fit.scope), record, fit, outliers)


def checked(u: NDArray[np.float32], record: Record, fit: Fit, outliers: str) -> Residuals:
    """The residuals of a record from its whitened series; see `residuals`."""
    settled = _inside(u, memory(fit.model, record.size, record.rate))
    series = u if settled is None else u[settled]
    n = series.size
    if n < SHORTEST:
        none = np.empty(0)
        return Residuals(record.name, record.rate, record.size, fit.goodness, (), (), *([none] * 8))
    parts, stretches = (np.linspace(0, n, k + 1).astype(np.int64) for k in (PARTS, min(SHOWN, n // 8)))

    def seconds(at: IntArray) -> FloatArray:
        return np.asarray((at if settled is None else settled[np.minimum(at, n - 1)]) / record.rate)

    checks, correlation, power, error = _checks(series, parts, record.name)
    expected, observed = _quantiles(series)
    # other slow effects, or a changing level, have tails of their own
    slow = {finding.name for finding in fit.findings} - {"steps"}  # a burst has steps at its ends
    steady = not slow and all(check.passed for check in checks if check.name in ("halves", "eighths"))
    jumping = popcorn(jumps(series, fit.model, record.rate), record.signal, seconds) if steady else []
    return Residuals(
        name=record.name, rate=record.rate, size=record.size, goodness=fit.goodness, checks=checks,
        findings=(
            *fit.findings,
            *reasons(record, fit, checks, (power, record.cut + seconds(parts)), kept=outliers == "keep"),
            *jumping,
        ),
        correlation=correlation, level=np.sqrt(power), level_error=error,
        time=seconds((stretches[:-1] + stretches[1:]) // 2),
        low=np.minimum.reduceat(series, stretches[:-1]).astype(np.float64),
        high=np.maximum.reduceat(series, stretches[:-1]).astype(np.float64), expected=expected, observed=observed,
    )  # fmt: skip


def _checks(
    u: NDArray[np.float32], parts: IntArray, name: str
) -> tuple[tuple[Check, ...], FloatArray, FloatArray, FloatArray]:
    """The checks, the autocorrelation, and the power of each part with the standard error of its RMS."""
    count = np.diff(parts)
    sums = np.array([_sums(u, a, b) for a, b in pairwise(parts.tolist())])
    if not sums[:, 0].any():
        raise DataError(say("{channel!r} never changes: there is no noise to identify", channel=name))
    power, fourth = sums[:, 0] / count, sums[:, 1] / count
    correlation = sums[:, 2:].sum(axis=0) / sums[:, 0].sum()
    # variance of u^2 relative to its mean, 2 for Gaussian residuals; correlation increases that of a mean
    spread = (fourth / power**2 - 1) * (1 + 2 * float(correlation @ correlation))
    # sum of squared autocorrelations: chi-square, as the terms are fitted to far more frequencies than 20 lags
    h, size = np.arange(1, LAGS + 1), u.size
    box = float(scipy.special.chdtrc(LAGS, float(size * (size + 2.0) * (correlation**2 / (size - h)).sum())))
    largest = float(correlation[np.abs(correlation).argmax()])
    # mean fourth power over squared power, part by part, so that a changing level makes no tails
    n = int(count.sum())
    kurtosis = float((fourth / power**2) @ count / n) - 3 + 6 * count.size / n
    tails = _two_sided(kurtosis * math.sqrt(n / 24))
    checks = (
        Check("correlation", say("autocorrelation"), largest, box, say("largest of lags 1 to {lag}", lag=LAGS)),
        Check(
            "kurtosis", say("excess kurtosis"), kurtosis, tails, say("0 for Gaussian noise, positive for heavy tails")
        ),
        *_stationarity(power, spread, count),
    )
    return checks, correlation, power, np.sqrt(power * spread / count) / 2


def _inside(u: NDArray[np.float32], margin: int) -> IntArray | None:
    """Valid residuals at least `margin` samples from an end or a gap; None if all are."""
    if not margin and complete(u):
        return None
    finite = np.flatnonzero(np.isfinite(u))
    joints = np.concatenate(([0], np.flatnonzero(np.diff(finite) > 1) + 1, [finite.size]))
    near = np.zeros(finite.size + 1, dtype=np.int64)
    np.add.at(near, np.maximum(joints - margin, 0), 1)
    np.add.at(near, np.minimum(joints + margin, finite.size), -1)
    return np.asarray(finite[np.cumsum(near[:-1]) == 0])


def _sums(u: NDArray[np.float32], first: int, last: int) -> list[float]:
    """Sums over a part of u^2, u^4, and of products at lags of 1, 2 .. 20 samples."""
    fourth, products = 0.0, np.zeros(1 + LAGS)
    for a in range(first, last, CHUNK):
        b = min(a + CHUNK, last)
        v = np.zeros(b - a + LAGS)  # beyond the end of the record there is nothing
        v[: u.size - a] = u[a : b + LAGS]
        square = v[: b - a] ** 2
        fourth += float(square @ square)
        products += np.correlate(v, v[: b - a])
    return [float(products[0]), fourth, *products[1:].tolist()]


def _two_sided(z: float) -> float:
    """Two-sided p-value of a standard normal deviate."""
    return float(scipy.special.erfc(abs(z) / math.sqrt(2)))


def _stationarity(power: FloatArray, spread: FloatArray, count: IntArray) -> tuple[Check, Check]:
    """The power of the halves, and of the eighths."""
    half, scatter = PARTS // 2, float(np.mean(spread))
    first, second = (float(np.average(power[p], weights=count[p])) for p in (slice(half), slice(half, None)))
    p = _two_sided(math.log(second / first) / math.sqrt(scatter * 4 / float(count.sum())))
    logs = np.log(power)
    largest = math.sqrt(float(power.max() / power.min()))
    chance = float(scipy.special.chdtrc(PARTS - 1, float((np.square(logs - logs.mean()) * count).sum() / scatter)))
    return (
        Check(
            "halves", say("RMS of the halves"), math.sqrt(second / first), p, say("second over first (stationarity)")
        ),
        Check("eighths", say("RMS of the eighths"), largest, chance, say("largest over smallest (stationarity)")),
    )


def _quantiles(u: NDArray[np.float32]) -> tuple[FloatArray, FloatArray]:
    """Normal quantiles and those of a sample of the residuals, denser in the tails."""
    part = np.sort(u[:: max(1, u.size // QUANTILES)]).astype(np.float64)
    reach = 4.2
    expected = np.linspace(-reach, reach, 201)
    share = scipy.special.ndtr(expected)
    held = (share * part.size > 0.5) & ((1 - share) * part.size > 0.5)
    at = np.clip((share[held] * part.size - 0.5).round().astype(np.int64), 0, part.size - 1)
    return expected[held], part[at]
