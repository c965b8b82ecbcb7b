"""Checks of the whole record: motion, a noise level that changes, lines, and curves that no five terms can make."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from allanite.core.arrays import BoolArray, FloatArray
from allanite.core.finding import Finding
from allanite.core.record import SHORTEST, Record, Recording
from allanite.core.wording import percent
from allanite.statistics.differences import OADEV
from allanite.statistics.estimator import integrated, windows

from .view import View, stretches
from .window import trim

MOVING = 20.0
"""Rms about the record's median, over that of its quietest tenth, from which a block is called moving."""

TOO_BUSY = 0.02
"""Share of moving blocks above which the record cannot support the job."""

AT_REST = "noise can only be told from a sensor at rest"

PARTS = 8
"""Parts of a record whose noise levels are compared."""

UNEQUAL = 1.3
"""Ratio of power from which parts are called different, beyond what chance does."""


def moving(view: View) -> Finding | None:
    """Blocks of a second whose rms about the record's median is more than 20 times that of the quietest tenth."""
    loud = busy(view)
    if not in_motion(loud):
        return None
    first = int(loud.argmax()) * view.span
    return Finding(
        "moving",
        f"moves from {view.seconds(first):.4g} s (rms over {MOVING:g} times that of the quietest tenth in "
        f"{percent(float(loud.mean()))} of the blocks)",
        AT_REST,
        still_words([view.record]),
        (view.seconds(first), view.seconds((loud.size - int(loud[::-1].argmax())) * view.span)),
        fatal=bool(loud.mean() > TOO_BUSY),
    )


def busy(view: View) -> BoolArray:
    """Blocks in which the record moves."""
    rms = _block_rms(view)
    return np.asarray(rms > MOVING * max(float(np.quantile(rms, 0.1)), view.fast))


def in_motion(loud: BoolArray) -> bool:
    """Whether so many blocks are busy that the record moves."""
    return bool(loud.sum() >= max(2, 0.002 * loud.size))


def still_words(records: Sequence[Record]) -> str:
    """The options that cut out the longest still stretch of these records."""
    found = still_stretch(records)
    if found is None:
        return "no stretch of it is still: record again with the sensor at rest"
    start, end = found
    return "the longest still stretch: " + (f"--from {start:g} " if start > 0 else "") + f"--until {end:g}"


def still_stretch(records: Sequence[Record]) -> tuple[float, float] | None:
    """A stretch in which none of these records, which share a clock, moves by the test of `moving`.

    The longest run without a busy block is looked at by itself, where the quietest tenth is another, until the test
    finds nothing. In whole seconds of the recording; None where too little is left.
    """
    first = records[0]
    start, end = 0, first.size
    while end - start >= SHORTEST:
        parts = trim(Recording(tuple(records)), start / first.rate, end / first.rate)
        still = np.ones(end - start, dtype=np.bool_)
        for view in map(View, parts):
            loud = busy(view)
            if in_motion(loud):
                still[_places(view, loud)] = False
        runs = stretches(still)
        if still.all() or not runs.size:
            return (_seconds(first, start), _seconds(first, end)) if runs.size else None
        low, high = (start + int(i) for i in runs[np.diff(runs, axis=1)[:, 0].argmax()])
        start, end = (
            round((whole - first.cut) * first.rate)
            for whole in (math.ceil(_seconds(first, low)), math.floor(_seconds(first, high)))
        )
    return None


def _seconds(record: Record, index: int) -> float:
    """Time of a reading in the recording; the whole second where it is the reading nearest to one."""
    at = record.cut + index / record.rate
    return float(round(at)) if abs(at - round(at)) <= 0.5 / record.rate else at


def _places(view: View, loud: BoolArray) -> NDArray[np.intp]:
    """Readings of the record that lie in busy blocks."""
    inside = np.flatnonzero(np.repeat(loud, view.span))
    return inside if view.left is None else view.left[inside]


def _block_rms(view: View) -> FloatArray:
    """Rms of each block about the record's median."""
    centre = float(np.median(view.blocks.mean(axis=1)))
    return np.asarray(np.sqrt(np.square(view.blocks - centre, dtype=np.float64).mean(axis=1)))


def level(view: View) -> Finding | None:
    """Fast noise that is not the same in all of eight parts of the record."""
    bends = view.bends.copy() if view.outliers.at.size else view.bends
    bends[_beside_outliers(view)] = np.nan
    size = bends.size // PARTS
    power = np.array([np.nanmean(np.square(bends[i * size : (i + 1) * size])) for i in range(PARTS)])
    # second differences of white noise: 35/18 readings make one degree of freedom; outliers and vibration make it less
    error = math.sqrt(2 * 35 / 18 / size)
    ratio = power / np.median(power)
    loud = ratio > UNEQUAL * (1 + 6 * error)
    quiet = ratio < 1 / (UNEQUAL * (1 + 6 * error))
    if not (loud.any() or quiet.any()):
        return None
    odd = stretches(loud if loud.any() else quiet)[0] * size
    lowest, highest = math.sqrt(ratio.min()), math.sqrt(ratio.max())
    return Finding(
        "level",
        f"the noise level changes: {highest / lowest:.3g} times between parts, it differs from "
        f"{view.seconds(odd[0]):.4g} s to {view.seconds(odd[1]):.4g} s",
        "one set of coefficients describes neither part",
        "analyse the parts apart (--from, --until)",
        (view.seconds(odd[0]), view.seconds(odd[1])),
    )


def _beside_outliers(view: View) -> NDArray[np.intp]:
    """Second differences that hold an outlier."""
    at = view.outliers.at if view.left is None else np.searchsorted(view.left, view.outliers.at)
    held = np.unique(np.subtract.outer(at, np.arange(3)))
    return np.asarray(held[(held >= 0) & (held < view.bends.size)], dtype=np.intp)


def lines(view: View) -> Finding | None:
    """Peaks of the averaged periodogram above the median of the octave around them."""
    frequency, power, segments = _periodogram(view)
    if frequency.size < 64:
        return None
    from scipy.special import gammaincinv

    around = _octave_medians(power)
    threshold = 1.25 * float(gammaincinv(segments, 1 - 1e-4 / power.size)) / segments
    peaks = stretches(power > threshold * around)
    peaks = peaks[peaks[:, 0] >= 6]
    if not peaks.size:
        return None
    excess = np.array([float((power[a:b] - around[a:b]).sum()) for a, b in peaks])
    tops = [float(frequency[a + int(power[a:b].argmax())]) for a, b in peaks]
    share = float(excess.sum() / power.sum())
    named = ", ".join(f"{f:.3g}" for f in _strongest(tops, excess))
    return Finding(
        "lines",
        f"lines at {named} Hz hold {percent(share)} of the power",
        "vibration or sway makes humps on the curve that no noise term describes",
        "isolate the sensor",
    )


def _strongest(tops: list[float], excess: FloatArray, most: int = 5) -> list[float]:
    """Frequencies of the most powerful peaks, ascending; of those within a twentieth of each other only one."""
    chosen: list[float] = []
    for i in np.argsort(excess)[::-1]:
        if all(abs(tops[i] / f - 1) > 0.05 for f in chosen):
            chosen.append(tops[i])
    return sorted(chosen[:most])


def _periodogram(view: View) -> tuple[FloatArray, FloatArray, int]:
    """Frequencies (Hz), mean periodogram of Hann-windowed segments, and their number."""
    from scipy.fft import rfft

    y = view.steps
    length = 1 << int(np.clip(math.log2(max(y.size // 8, 2)), 1, 14))
    segments = min(y.size // length, 64)
    starts = np.linspace(0, y.size - length, segments).astype(int)
    window = np.hanning(length)
    total = np.zeros(length // 2 + 1)
    for start in starts:
        piece = y[start : start + length] - float(y[start : start + length].mean())
        total += np.abs(rfft(piece * window)) ** 2
    return np.arange(1, length // 2) * view.rate / length, total[1 : length // 2] / segments, segments


def _octave_medians(power: FloatArray) -> FloatArray:
    """Median of the octave around each bin: at half-octave centres, joined by straight lines in the logarithms."""
    centres = 2 ** np.arange(2.5, math.log2(power.size), 0.5)
    levels = [np.median(power[int(c / 1.42) : max(int(c * 1.42), int(c / 1.42) + 5)]) for c in centres]
    floor = np.maximum(np.array(levels), 1e-300)
    return np.asarray(np.exp(np.interp(np.log(np.arange(1, power.size + 1)), np.log(centres), np.log(floor))))


def slope(view: View) -> Finding | None:
    """A curve that falls more steeply after it fell less steeply: sums of power laws never do.

    Slopes over two octaves, where the record has a hundred windows and more.
    """
    record = view.record
    # between gaps only: the longest windows lie within the longest stretch
    size = int(np.diff(np.concatenate(([0], view.joints, [view.steps.size]))).max())
    factors = 2 ** np.arange(max(1, int(math.log2(max(size / 100, 1)))))
    if factors.size < 5:
        return None
    variance = windows(OADEV, integrated(record, OADEV.order), factors).variance
    sigma = np.log2(np.maximum(np.sqrt(variance), 1e-300))
    slopes = (sigma[2:] - sigma[:-2]) / 2
    error = np.sqrt(1.5 * factors[2:] / size)
    before = np.maximum.accumulate(slopes)
    drop = before - slopes
    significant = drop > 0.35 + 8 * error
    if not significant.any():
        return None
    last = int(np.flatnonzero(significant)[-1])
    tau = factors[last + 1] / record.rate
    return Finding(
        "slope",
        f"slope near {slopes[last]:.1f} at {tau:.3g} s, {before[last]:+.1f} before: no five-term model does that",
        "N is not meaningful here",
        "look for motion or vibration; choose a quieter window (--quiet-window)",
        (0.0, record.duration),
    )
