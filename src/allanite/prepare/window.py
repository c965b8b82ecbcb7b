"""Selecting a part of a record."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from allanite.core.aliases import public
from allanite.core.errors import DataError, UsageError
from allanite.core.record import Record, Recording
from allanite.phrases.phrase import say


@public
def trim(recording: Recording, start: float | None = None, until: float | None = None) -> Recording:
    """The part of a recording from `start` to `until`, in seconds after its first sample.

    Raises
    ------
    UsageError
        The window is empty, or does not lie within the recording.

    Examples
    --------
    >>> record = Record(np.arange(10.0), rate=2.0, unit="deg/s", name="z")
    >>> trim(Recording((record,)), 1.0, 3.0)["z"].values.tolist()
    [2.0, 3.0, 4.0, 5.0]
    """
    if start is None and until is None:
        return recording

    def cut(record: Record) -> Record:
        begin, end = start or 0.0, record.duration if until is None else until
        first, last = span(record.name, record.duration, record.rate, begin, end)
        extra = len(record.values) - record.size
        origin = (record.start or 0.0) + first / record.rate
        what = cut_words(record.cut + begin, record.cut + end)
        part = record.with_values(record.values[first : last + extra], what, start=origin)
        return replace(part, cut=record.cut + first / record.rate)

    return of_each(recording, cut)


def of_each(recording: Recording, change: Callable[[Record], Record]) -> Recording:
    """The recording with a function applied to each of its channels, and to the other columns."""
    records, others = (tuple(map(change, some)) for some in (recording.records, recording.others))
    return replace(recording, records=records, others=others)


def span(name: str, duration: float, rate: float, start: float, end: float) -> tuple[int, int]:
    """The first sample of a window in a record of this duration, and the one after the last."""
    if not 0 <= start < end:
        raise UsageError(
            f"the window from {start:.10g} s to {end:.10g} s is empty, or not in {name!r}, from 0 s to {duration:.6g} s"
        )
    if end > duration * (1 + 1e-9):
        raise UsageError(f"the window ends at {end:.10g} s, but {name!r} is {duration:.6g} s long")
    first, last = round(start * rate), round(end * rate)
    if last - first < 2:
        raise DataError(say("the window from {start:.10g} s to {end:.10g} s contains {count} samples of {channel!r}",
                            start=start, end=end, count=last - first, channel=name))  # fmt: skip
    return first, last


def excluded(recording: Recording, pieces: Sequence[tuple[float, float]]) -> Recording:
    """The recording without these pieces, in seconds after its first sample: their samples are missing."""
    if not pieces:
        return recording

    def without(record: Record) -> Record:
        values = np.array(record.values, dtype=np.float64)
        points = len(values) - record.size
        for first, last in excluded_samples(record.name, record.duration, record.rate, pieces):
            # an angle at the ends of a piece belongs to the intervals beside it
            values[first + points : last] = np.nan
        return record.with_values(values, excluded_words(pieces), start=record.start)

    return of_each(recording, without)


def excluded_samples(
    name: str, duration: float, rate: float, pieces: Sequence[tuple[float, float]]
) -> list[tuple[int, int]]:
    """The first sample of each piece, and the one after the last, in a record of this duration."""
    for start, end in pieces:
        if end > duration * (1 + 1e-9):
            raise UsageError(
                f"the piece from {start:.10g} s to {end:.10g} s ends after {name!r}, which is {duration:.6g} s long"
            )
    return [(round(start * rate), round(end * rate)) for start, end in pieces]


def cut_words(start: float, end: float) -> str:
    """History entry of a window, in seconds after the first sample of the recording."""
    return say("cut from {start:g} s to {end:g} s", start=start, end=end)


def excluded_words(pieces: Sequence[tuple[float, float]]) -> str:
    """History entry of pieces that are left out."""
    return say("excluded: {spans}", spans=", ".join(f"{start:g} s to {end:g} s" for start, end in pieces))


@public
def quiet_window(recording: Recording, length: float) -> Recording:
    """The most stationary window of `length` seconds, with the least fast noise and motion in the worst channel.

    The power of each channel about its mean, in blocks of a second, is compared
    with that of its own quietest stretch; the window with the best worst channel is chosen.

    Raises
    ------
    UsageError
        The recording is shorter than `length`.
    """
    record = recording[0]
    span = max(1, round(record.rate))
    blocks = record.size // span
    wanted = math.ceil(length * record.rate / span) if math.isfinite(length) else 0
    if not 1 <= wanted <= blocks:
        raise UsageError(f"a quiet window of {length:g} s does not fit into a recording of {record.duration:.6g} s")
    worst = np.zeros(blocks - wanted + 1)
    for channel in recording:
        pieces = np.asarray(channel.steps[: blocks * span], dtype=np.float64).reshape(blocks, span)
        means = np.nan_to_num(pieces.mean(axis=1))
        steps = np.abs(np.diff(means, prepend=means[:1]))  # to the mean of the block before
        power = np.nan_to_num(pieces.var(axis=1), nan=np.inf) + steps**2
        sums = np.convolve(power, np.ones(wanted), "valid")
        worst = np.maximum(worst, sums / sums.min() if 0 < sums.min() < np.inf else sums)
    first = int(worst.argmin()) * span / record.rate
    return trim(recording, first, min(first + length, record.duration))
