"""Jumps and bursts in the residuals of a record: popcorn noise, whose spectrum can look like that of Gaussian noise.

A bias that jumps for some time is best detected by a window of that length, if the noise of each frequency is weighted
by its inverse: the score of a window is the generalized least-squares estimate of a jump of that duration. Scores of
Gaussian noise are Gaussian; those of popcorn noise have heavy tails, or a significantly large maximum.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from allanite.core.arrays import FloatArray, IntArray
from allanite.core.model import Model
from allanite.core.units import Signal, convert
from allanite.core.validity import Finding
from allanite.phrases.phrase import between, join, say
from allanite.prepare.gaps import whole

from .whitening import deviations

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
    # middle is the sample `largest`. `deviate` is the kurtosis as a normal deviate, `chance` the reference for the
    # largest score, `at` the middles of the windows with significant jumps, `share` the part of the variance of the
    # scores due to jumps.
    size: int
    length: int
    jump: float
    largest: int
    deviate: float
    chance: float
    at: IntArray
    share: float

    @property
    def weight(self) -> float:
        """Significance relative to the threshold; 1 and above is reported."""
        return max(self.deviate / TAILED_DEVIATE, math.log(max(self.chance, 1e-300)) / math.log(CHANCE_OF_JUMP))


def jumps(u: NDArray[np.float32], model: Model, rate: float) -> Jumps | None:
    """The windows that detect jumps best in a whitened series; None if it is too short, or the shortest are best."""
    # The shortest windows detect outliers and heavy tails of single samples best, not lasting jumps.
    from scipy.fft import dct, idct

    block = max(FINEST_BLOCK, -(-u.size // MAX_BLOCKS))
    blocks = u.size // block
    if blocks < FEWEST_BLOCKS:
        return None
    # sums over blocks of the record weighed by the inverse of its covariance
    means = (u[: blocks * block].reshape(blocks, block) @ np.full(block, 1 / block, dtype=np.float32)).astype(
        np.float64
    )
    k, deviation = deviations(model, whole(u.size), rate)
    c = dct(means, norm="ortho", overwrite_x=True)
    c[0] = 0.0
    c[1:] *= np.interp(np.arange(1, blocks), k, 1 / deviation)
    total = np.concatenate(([0.0], np.cumsum(block * idct(c, norm="ortho", overwrite_x=True))))
    count = int(math.log(blocks * LONGEST_WINDOW / SHORTEST_WINDOW, WINDOW_GROWTH)) + 1
    lengths = [round(SHORTEST_WINDOW * WINDOW_GROWTH**i) for i in range(count)]
    chances = 2 * sum(blocks / length for length in lengths)
    candidates = [_scored(total, length, block, chances) for length in lengths]
    best = max(candidates, key=lambda one: one.weight)
    return None if best is candidates[0] else best


def _scored(total: FloatArray, length: int, block: int, chances: float) -> Jumps:
    """The scores of windows of a length in blocks, a sixteenth of it apart, from the running total."""
    step = max(1, length // DENSE)
    score = total[length::step] - total[:-length:step]
    square = score * score
    variance = float(square.mean())
    kurtosis = float(square @ square) / square.size / variance**2 - 3
    most = int(square.argmax())
    largest = math.sqrt(float(square[most]) / variance)
    density = math.exp(-(largest**2) / 2) / math.sqrt(2 * math.pi)
    quiet = float(np.median(square)) / MEDIAN  # bursts increase the variance, but hardly this
    at = np.flatnonzero(square > JUMP_DEVIATE**2 * quiet)
    # middles of the runs that stand out; those no more than a length apart are one
    runs = np.split(at, np.flatnonzero(np.diff(at) > length // step) + 1)
    middles = np.array([(run[0] + run[-1]) // 2 for run in runs if run.size], dtype=at.dtype)
    return Jumps(
        size=(total.size - 1) * block, length=length * block, jump=float(score[most]) / quiet,
        largest=(2 * most * step + length) * block // 2, deviate=_normal(kurtosis, 1.2 * total.size / length),
        chance=chances * largest * density, share=1 - quiet / variance, at=(step * middles + length // 2) * block,
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
