"""Checks of the whole record: motion, of one axis or of the whole body, a changing noise level, lines."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import scipy

from allanite.core.arrays import BoolArray, FloatArray, stretches
from allanite.core.plain import Header
from allanite.core.record import SHORTEST, Record, Recording
from allanite.core.validity import Finding, Quality
from allanite.phrases.phrase import between, join, longest_without, percent, say, spelled
from allanite.statistics.differences import OADEV
from allanite.statistics.estimator import estimated

from .resampled import interpolated_together
from .view import LEVEL_PARTS, View
from .window import trim


def of_one_body(records: Sequence[Record | Header], qualities: Sequence[Quality]) -> tuple[Quality, ...]:
    """The findings of each channel of a recording, together with those of the other channels of the same body."""
    # Motion in one inertial channel is reported for every other one, and if it refuses one channel, it refuses all. A
    # changing noise level is reported for the others, too, but refuses none. The static stretch suggested is common to
    # all of them.
    carried = [i for i, record in enumerate(records) if record.signal.inertial]
    qualities = interpolated_together(records, qualities)
    told = list(qualities)
    if len(carried) < 2:
        return tuple(told)
    changes = [(records[i].name, change) for i in carried if (change := _named("level", qualities[i]))]
    for i, quality in zip(carried, _moved(carried, records, qualities), strict=True):
        told[i] = quality
        if changes and not (_named("level", qualities[i]) or qualities[i].refusal):
            (name, first), *others = changes
            what = say("on the same body, {channel}: {level}", channel=name or say("another channel"), level=first.what)
            if others:
                names = ", ".join(other for other, _ in others)
                what = join("; ", (what, say("so does that of {channels}", channels=names)))
            why = say("a disturbance of one axis may also affect the others")
            also = Finding("body level", what, why, first.remedy, first.place)
            told[i] = Quality((*quality.findings, also))
    return tuple(told)


def _named(name: str, quality: Quality) -> Finding | None:
    return next((finding for finding in quality.findings if finding.name == name), None)


def _moved(carried: list[int], records: Sequence[Record | Header], qualities: Sequence[Quality]) -> list[Quality]:
    """The findings of the channels on the same body, with the motion of the others."""
    motions = {i: motion for i in carried if (motion := _named("moving", qualities[i]))}
    if not motions:
        return [qualities[i] for i in carried]
    # the refused axis that moves first
    worst = min(motions, key=lambda i: (not motions[i].fatal, motions[i].place or (0.0, 0.0), i))
    cure = still_words([records[i] for i in carried]) or motions[worst].remedy
    option = spelled("--channels", "channels=...")
    told = replace(
        motions[worst], name="body moved",
        what=say("the body moved: {channel} {motion}",
                 channel=records[worst].name or say("a channel"), motion=motions[worst].what),
        remedy=say("{remedy}; leave out channels that are not part of this body ({option})",
                   remedy=cure, option=option),
    )  # fmt: skip
    result = []
    for i in carried:
        own = [replace(f, remedy=cure) if f.name == "moving" else f for f in qualities[i].findings]
        also = i != worst and (i not in motions or (told.fatal and not motions[i].fatal))
        result.append(Quality((told, *own) if also else tuple(own)))
    return result


MOVING = 20.0
"""RMS about the record's median, relative to that within the quietest tenth, above which a block is called moving."""

SUDDEN = 10.0  # step between the means of two blocks, relative to the same, above which it is motion; a drift has none

USUAL = 8.0 / 0.319
"""The same relative to the quarter point of all steps: eight standard deviations, if they are normal."""

TOO_BUSY = 0.02  # share of moving blocks above which the record cannot support an analysis

AT_REST = say("noise can be determined only from a static recording")

USEFUL = 10.0  # length of a static stretch, s, below which it is not proposed: a moving body stands still that long
THERE = 0.5  # share of the samples of a static stretch that must be there
TRIED = 3  # runs between motions that are tried for a static stretch, those with most samples
TOGETHER = 8  # segments that are transformed together
UNEQUAL = 1.44  # ratio of powers, beyond chance, above which parts are called different

NEITHER = say("one set of coefficients describes neither part")


def moving(view: View) -> Finding | None:
    """Blocks of a second whose RMS about the median is more than 20 times that of the quietest tenth; see `busy`."""
    loud = busy(view)
    if not in_motion(loud):
        return None
    first = int(loud.argmax()) * view.span
    return Finding("moving",
        say("moves from {first:.4g} s (RMS over {times:g} times that of the quietest tenth in {share} of the blocks)",
            first=view.seconds(first), times=MOVING, share=percent(float(loud.mean()))),
        AT_REST, still_words([view.record]),
        (view.seconds(first), view.seconds((loud.size - int(loud[::-1].argmax())) * view.span)),
        fatal=bool(loud.mean() > TOO_BUSY),
    )  # fmt: skip


def busy(view: View) -> BoolArray:
    """Blocks in which the record moves: far from its median, and not only by a drift."""
    means, own = view.blocks
    quiet = max(float(np.quantile(own, 0.1)), view.fast)
    steps = np.abs(np.diff(means))
    jumps = np.flatnonzero(steps > max(SUDDEN * quiet, USUAL * float(np.quantile(steps, 0.25))))
    sudden = own > MOVING * quiet
    sudden[jumps] = sudden[jumps + 1] = True
    far = np.asarray(np.hypot(own, means - np.median(means)) > MOVING * quiet)
    for first, last in stretches(far):
        far[first:last] = sudden[first:last].any()
    return far


def in_motion(loud: BoolArray) -> bool:
    """Whether enough blocks are moving to call the record moving."""
    return bool(loud.sum() >= max(2, 0.002 * loud.size))


def still_words(records: Sequence[Record | Header]) -> str:
    """The choice that selects the longest static stretch of records; empty without common samples in memory."""
    samples = [record for record in records if isinstance(record, Record)]
    if len(samples) < len(records) or len({(record.size, record.rate) for record in samples}) > 1:
        return ""
    stretch = still_stretch(samples)
    if stretch is None or stretch[1] - stretch[0] < USEFUL:
        return say("no stretch of {useful:g} s is static: record again with the sensor at rest", useful=USEFUL)
    start, end = stretch
    return say("the longest static stretch: {selection}", selection=between(start, end))


def still_stretch(records: Sequence[Record]) -> tuple[float, float] | None:
    """A stretch in which none of these records, which have common sample times, moves or changes its noise level."""
    # Both tests, and that samples are there, are repeated on the runs in which they hold, because each has another
    # quietest tenth and other parts. The longest, in whole seconds of the recording; None if too little remains.
    return _still(records, 0, records[0].size)


def _still(records: Sequence[Record], start: int, end: int) -> tuple[float, float] | None:
    first = records[0]
    if end - start < SHORTEST:
        return None
    parts = trim(Recording(tuple(records)), start / first.rate, end / first.rate).records
    known = np.logical_and.reduce([np.isfinite(part.steps) for part in parts])
    if known.sum() < SHORTEST:
        return None
    still = np.ones(end - start, dtype=np.bool_)
    for view in map(View, parts):
        # moving blocks; if there are none, parts with another noise level
        which, size = busy(view), view.span
        if not in_motion(which):
            which, size = _unequal(view)[0], view.bent // LEVEL_PARTS
        inside = np.flatnonzero(np.repeat(which, size))
        still[inside if view.left is None else view.left[inside]] = False
    if still.all() and known.mean() < THERE:
        low, high = max(stretches(~known).tolist(), key=lambda hole: hole[1] - hole[0])
        still[low:high] = False
    if still.all():
        return _seconds(first, start), _seconds(first, end)
    runs = sorted(stretches(still).tolist(), key=lambda run: -int(known[run[0] : run[1]].sum()))
    longest: tuple[float, float] | None = None
    for low, high in runs[:TRIED]:
        seconds = math.ceil(_seconds(first, start + low)), math.floor(_seconds(first, start + high))
        begin, stop = (max(round((whole - first.cut) * first.rate), 0) for whole in seconds)
        if longest is None or (stop - begin) / first.rate > longest[1] - longest[0]:
            stretch = _still(records, begin, stop)
            longest = max(filter(None, (longest, stretch)), key=lambda each: each[1] - each[0], default=None)
    return longest


def _seconds(record: Record, index: int) -> float:
    """Time of a sample in the recording, rounded to a whole second if the sample is the nearest to one."""
    at = record.cut + index / record.rate
    return float(round(at)) if abs(at - round(at)) <= 0.5 / record.rate else at


def level(view: View) -> Finding | None:
    """Fast noise whose level differs between eight parts of the record."""
    uneven, ratio = _unequal(view)
    if not uneven.any():
        return None
    parts = [(view.seconds(a), view.seconds(b)) for a, b in stretches(uneven) * (view.bent // LEVEL_PARTS)]
    first, last = parts[0]
    return Finding("level",
        say("the noise level changes by a factor of {ratio:.3g} between parts; it differs from {start:.4g} s to "
            "{end:.4g} s", ratio=math.sqrt(ratio.max() / ratio.min()), start=first, end=last),
        NEITHER,
        say("analyze the parts separately ({choice})", choice=longest_without(parts, view.ends)),
        (first, last),
    )  # fmt: skip


def _unequal(view: View) -> tuple[BoolArray, FloatArray]:
    """Parts whose noise level differs, louder ones if there are some, and the power of each over the median."""
    size, power = view.bent // LEVEL_PARTS, view.levels
    noisy = power > 0  # others are stuck, or on a straight line
    if not noisy.any():
        return noisy, power
    # second differences of white noise have one degree of freedom per 35/18 samples; outliers and vibration reduce it
    error = math.sqrt(2 * 35 / 18 / size)
    ratio = np.where(noisy, power / np.median(power[noisy]), 1.0)
    loud = ratio > UNEQUAL * (1 + 6 * error)
    return loud if loud.any() else ratio < 1 / (UNEQUAL * (1 + 6 * error)), ratio


def lines(view: View) -> Finding | None:
    """Peaks of the averaged periodogram above the median of the octave around them."""
    frequency, power, segments = _periodogram(view)
    if frequency.size < 64 or not segments:
        return None
    # median of the half octave around each bin, interpolated log-linearly between quarter-octave centres: within an
    # octave of the stop band of a filter the power falls to a tenth and less
    centres = 2 ** np.arange(2.5, math.log2(power.size), 0.25)
    levels = [np.median(power[int(c / 1.19) : max(int(c * 1.19), int(c / 1.19) + 5)]) for c in centres]
    floor = np.maximum(np.array(levels), 1e-300)
    around = np.exp(np.interp(np.log(np.arange(1, power.size + 1)), np.log(centres), np.log(floor)))
    threshold = 1.25 * float(scipy.special.gammaincinv(segments, 1 - 1e-4 / power.size)) / segments
    peaks = stretches(power > threshold * around)
    peaks = peaks[peaks[:, 0] >= 6]
    if not len(peaks):
        return None
    excess = np.array([float((power[a:b] - around[a:b]).sum()) for a, b in peaks])
    tops = np.array([float(frequency[a + int(power[a:b].argmax())]) for a, b in peaks])
    # within a pulse the angle is that of the count, and of the dither that is left of it
    if view.pulses:
        angle = excess / power.sum() * float(view.steps.var()) / (2 * np.sin(np.pi * tops / view.rate)) ** 2
        excess, tops = excess[angle > view.pulses], tops[angle > view.pulses]
        if not tops.size:
            return None
    share = float(excess.sum() / power.sum())
    named = ", ".join(f"{f:.3g}" for f in _strongest(tops, excess))
    return Finding(
        "lines",
        say("spectral lines at {frequencies} Hz contain {share} of the power", frequencies=named, share=percent(share)),
        say("vibration or sway makes humps in the curve that no noise term describes"),
        say("isolate the sensor"),
    )


def _strongest(tops: FloatArray, excess: FloatArray, most: int = 5) -> list[float]:
    """Frequencies of the strongest peaks, ascending; only one of those within a twentieth of each other."""
    chosen: list[float] = []
    for i in np.argsort(excess)[::-1]:
        if all(abs(tops[i] / f - 1) > 0.05 for f in chosen):
            chosen.append(float(tops[i]))
    return sorted(chosen[:most])


def _periodogram(view: View) -> tuple[FloatArray, FloatArray, int]:
    """Frequencies (Hz), mean periodogram of Hann-windowed segments where the level is constant, and their number."""
    y, uneven = view.steps, _unequal(view)[0]
    length = 1 << int(np.clip(math.log2(max(y.size // 8, 2)), 1, 14))
    starts = np.linspace(0, y.size - length, min(y.size // length, 64)).astype(int)
    starts = starts[~(uneven[starts * LEVEL_PARTS // y.size] | uneven[(starts + length - 1) * LEVEL_PARTS // y.size])]
    window = np.hanning(length)
    total = np.zeros(length // 2 + 1)
    for i in range(0, starts.size, TOGETHER):
        pieces = np.stack([y[start : start + length] for start in starts[i : i + TOGETHER]]).astype(np.float64)
        pieces -= pieces.mean(axis=1, keepdims=True)
        pieces *= window
        parts = scipy.fft.rfft(pieces, overwrite_x=True).view(np.float64)  # real and imaginary
        total += np.square(parts, out=parts).sum(axis=0).reshape(-1, 2).sum(axis=1)
    return np.arange(1, length // 2) * view.rate / length, total[1 : length // 2] / max(starts.size, 1), starts.size


def slope(view: View) -> Finding | None:
    """A curve whose slope becomes steeper with averaging time, which sums of power laws never do."""
    # Slopes over two octaves, at averaging times with at least a hundred windows.
    record = view.record
    # between gaps only: the longest windows lie within the longest stretch
    size = int(np.diff(np.concatenate(([0], view.joints, [view.steps.size]))).max())
    factors = 2 ** np.arange(max(1, int(math.log2(max(size / 100, 1)))))
    if factors.size < 5:
        return None
    variance = estimated(record, OADEV, factors)[0].variance
    sigma = np.log2(np.maximum(np.sqrt(variance), 1e-300))
    slopes = (sigma[2:] - sigma[:-2]) / 2
    error = np.sqrt(1.5 * factors[2:] / size)
    before = np.maximum.accumulate(slopes)
    drop = before - slopes
    significant = drop > 0.35 + 8 * error
    if not significant.any():
        return None
    last = int(np.flatnonzero(significant)[-1])
    if 2 ** sigma[last + 1] * factors[last + 1] < math.sqrt(3) * view.pulses:  # Q of a pulse: the count, and dither
        return None
    tau = factors[last + 1] / record.rate
    return Finding("slope",
        say("slope near {slope:.1f} at {tau:.3g} s, {before:+.1f} before: no five-term model has such a curve",
            slope=slopes[last], tau=tau, before=before[last]),
        say("N is not meaningful here"),
        say("look for motion or vibration; choose a quieter window ({option})",
            option=spelled("--quiet-window", "prepare.quiet_window")),
        (0.0, record.duration),
    )  # fmt: skip
