"""The quality of a channel that is read in blocks: that of the record if there is one block, else of its parts.

A piece is the place of its first sample and the samples of each channel; samples between two pieces are missing. The
functions take an iterator of pieces and give one, so that they follow each other as those of `transform` and `window`.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.core.arrays import IntArray
from allanite.core.kinds import KINDS
from allanite.core.record import Record
from allanite.core.validity import Finding, Quality
from allanite.phrases.phrase import join, percent, say, windowing

from .outliers import Outliers, marked, outliers
from .quality import constant, inspect
from .readings import clipped, outlying, stuck
from .stillness import NEITHER, TOO_BUSY, UNEQUAL, busy, in_motion
from .view import View

Piece = tuple[int, list[NDArray[Any]]]  # place of the first sample, and the samples of each channel


def placed(pieces: Iterable[tuple[int, list[NDArray[Any]]]]) -> Iterator[Piece]:
    """Pieces by their place instead of the number of missing samples before them."""
    place = 0
    for lost, columns in pieces:
        yield place + lost, columns
        place += lost + len(columns[0])


def blocks(pieces: Iterable[Piece], size: int, points: int = 0) -> Iterator[Piece]:
    """Blocks of `size` samples, which begin at its multiples however the record was cut; missing samples are NaN."""
    # With `points`, 1, a block ends with the first sample of the next one, from which the last step is taken. The last
    # block ends with the record; where all samples of a block are missing, there is none.
    begin, parts, full = 0, list[Piece](), size + points
    for first, some in pieces:
        place, columns = first, some
        while length := max(map(len, columns)):
            if place >= begin + full:
                if parts:
                    yield begin, _joined(parts, full)
                begin, parts = place // size * size, []
            room = begin + full - place
            parts.append((place - begin, [values[:room] for values in columns]))
            if length < room:
                break
            yield begin, _joined(parts, full)
            place, columns = place + room - points, [values[room - points :] for values in columns]
            begin, parts = begin + size, []
    if parts:
        yield begin, _joined(parts, parts[-1][0] + max(map(len, parts[-1][1])))


def _joined(parts: list[Piece], size: int) -> list[NDArray[Any]]:
    """The samples of each channel; integers stay integers if none are missing."""
    if sum(len(columns[0]) for _, columns in parts) == size:
        of_channels = zip(*(columns for _, columns in parts), strict=True)
        return [values[0] if len(values) == 1 else np.concatenate(values) for values in of_channels]
    joined = [np.full(size, np.nan) for _ in parts[0][1]]
    for place, columns in parts:
        for whole, values in zip(joined, columns, strict=True):
            whole[place : place + len(values)] = values
    return joined


def averaged(pieces: Iterable[Piece], kinds: Sequence[str], m: int, size: int) -> Iterator[Piece]:
    """Means of `m` samples, as `transform.block_means` takes them; `size` is the number that is looked at at once."""
    for place, columns in blocks(pieces, m * max(1, size // m)):
        yield place // m, [means(values, kind, m) for values, kind in zip(columns, kinds, strict=True)]


def means(values: NDArray[Any], kind: str, m: int) -> NDArray[Any]:
    """Means of `m` samples each: of increments and counts sums, of an angle every m-th point."""
    if kind == "angle":
        return values[::m]
    each = values[: len(values) // m * m].reshape(-1, m)
    return np.asarray(each.sum(axis=1) if KINDS[kind][0] else each.mean(axis=1))


def excluded(pieces: Iterable[Piece], kinds: Sequence[str], spans: Sequence[tuple[int, int]]) -> Iterator[Piece]:
    """The pieces without the samples of these spans; points of an angle at their ends belong to the steps beside."""
    for place, columns in pieces:
        kept = []
        for values, kind in zip(columns, kinds, strict=True):
            cuts = [(max(first + KINDS[kind][1] - place, 0), last - place) for first, last in spans]
            inside = [(low, high) for low, high in cuts if low < min(high, len(values))]
            samples = np.array(values, dtype=np.float64) if inside else values
            for low, high in inside:
                samples[low:high] = np.nan
            kept.append(samples)
        yield place, kept


def window(pieces: Iterable[Piece], first: int, end: int | None) -> Iterator[Piece]:
    """The samples from `first` on, up to before `end`, whose places count from there."""
    for place, columns in pieces:
        low, high = max(first - place, 0), None if end is None else max(end - place, 0)
        inside = [values[low:high] for values in columns]
        if any(map(len, inside)):
            yield place + low - first, inside


BLOCK = 1 << 20  # samples of a block
FEWEST_SAMPLES = 64  # samples in which anything is looked for

OWN = {"short", "gaps", "outliers", "heavy tails", "stuck", "clipped", "too little left", "too short", "constant"}
"""Findings of a block that are not those of the record, or are found in every block."""

NONE = np.empty(0, np.int64)


class Inspector:
    """Looks at a channel block by block; a record that is one block is inspected as it is in memory."""

    # In a longer one extremes, stuck values and outliers are looked for in every block, everything else in some.

    def __init__(self, size: int, choice: str | None) -> None:
        self.size, self.choice = size, choice
        self.only: Record | None = None
        self.like: Record | None = None
        self.seen: dict[str, tuple[Finding, int, bool]] = {}
        self.blocks = self.filled = self.checked = self.lost = self.loud = self.seconds = 0
        self.outliers = Outliers(NONE, 0.0)
        self.place = (0.0, 0.0)
        self.extent = (math.inf, -math.inf)
        self.levels: list[tuple[float, float, int]] = []

    def look(self, block: Record, *, alone: bool) -> tuple[Record, IntArray]:
        """Look at a block, whose `cut` is its place: the block without marked outliers, and the places of outliers."""
        # `alone` says that it is the whole record. Outliers that are marked, or kept, have no places.
        known = self.choice == "keep" or np.isfinite(block.values).sum() < FEWEST_SAMPLES
        spikes = Outliers(NONE, 0.0) if known else outliers(block, None if alone else self.size)
        kept = marked(block, spikes) if self.choice == "mark" else block
        self.like = self.like or block
        many, before = spikes.at.size, self.outliers
        if many:
            first, last = block.cut + spikes.at[[0, -1]] / block.rate
            self.place = (self.place[0] if before.at.size else float(first), float(last + 1 / block.rate))
        self.outliers = Outliers(
            np.broadcast_to(np.int64(0), before.at.size + many), max(before.limit, spikes.limit),
            max(before.largest, spikes.largest), before.heavy + spikes.heavy,
        )  # fmt: skip
        if alone:
            self.only = kept
        else:
            self._look(kept)
        return kept, NONE if self.choice else spikes.at

    def quality(self, rate: float, size: int) -> Quality:
        """All findings, at the sampling rate and length of the whole."""
        if self.only is not None:
            return inspect(replace(self.only, rate=rate))
        fatal = self._fatal()
        if fatal is not None:
            return Quality((fatal,))
        findings = []
        if self.lost:
            what = say("{lost} of {size} samples are missing ({share})", lost=self.lost, size=size,
                       share=percent(self.lost / size))  # fmt: skip
            why = say("gaps are not filled: windows with missing samples are omitted")
            findings.append(Finding("gaps", what, why))
        if self.like is not None:
            heavy = outlying(self.like, replace(self.outliers, at=NONE), self.size)
            far = None if self.choice == "mark" else outlying(self._first(), replace(self.outliers, heavy=0), self.size)
            findings += [each for each in (heavy, far and replace(far, place=self.place)) if each]
        for finding, count, every in self.seen.values():
            where = say("in {count} of {many} blocks of {size} samples that were inspected, first", count=count,
                        many=self.filled if every else self.checked, size=BLOCK)  # fmt: skip
            findings.append(replace(finding, what=join(": ", (where, finding.what)), place=None))
        return Quality((*findings, *self._level()))

    @property
    def history(self) -> tuple[str, ...]:
        """History entry of marking the outliers."""
        if self.choice != "mark" or not self.outliers.at.size:
            return ()
        return (say("{outliers}: marked as missing", outliers=self.outliers.words(self._first())),)

    def _first(self) -> Record:
        """A record that begins at the first outlier."""
        assert self.like is not None  # noqa: S101 - there was a block
        return replace(self.like, cut=self.place[0])

    def _look(self, block: Record) -> None:
        number, self.blocks = self.blocks, self.blocks + 1
        if block.out_of_range:
            self._keep(Finding("range", block.out_of_range, fatal=True), every=True)
            return
        view = View(block)
        self.lost += block.size - view.steps.size
        if view.steps.size < FEWEST_SAMPLES:
            return
        self.filled += 1
        low, high = view.extremes
        self.extent = (min(self.extent[0], float(low)), max(self.extent[1], float(high)))
        self._keep(stuck(view), every=True)
        self._keep(clipped(view) if low < high else None, every=True)
        # all checks are made of the first eight blocks, then of four of every octave
        if (number < 8 or number % (1 << (number.bit_length() - 3)) == 0) and low < high:
            # all checks of a block, and what blocks are compared by
            self.checked += 1
            self.levels.append((view.record.cut, view.fast, view.steps.size))
            loud = busy(view)
            self.loud += int(loud.sum()) if in_motion(loud) else 0
            self.seconds += loud.size
            for finding in inspect(view.record).findings:
                if finding.name not in OWN:
                    self._keep(replace(finding, fatal=False), every=False)

    def _keep(self, one: Finding | None, *, every: bool) -> None:
        if one is not None:
            first, count, _ = self.seen.get(one.name, (one, 0, every))
            self.seen[one.name] = (first, count + 1, every)

    def _fatal(self) -> Finding | None:
        """Why the record is refused: it has no samples, impossible ones, never changes, or moves for too long."""
        low, high = self.extent
        if "range" in self.seen:
            return self.seen["range"][0]
        if not self.filled:
            what = say("no block has {count} samples that are finite", count=FEWEST_SAMPLES)
            return Finding("not finite", what, remedy=say("check the column and the reader's options"), fatal=True)
        if not low < high:
            return constant(low)
        if self.loud <= TOO_BUSY * self.seconds:
            return None
        first = self.seen["moving"][0]
        what = say("{motion}; so do {share} of the blocks of a second that were inspected", motion=first.what,
                   share=percent(self.loud / self.seconds))  # fmt: skip
        return replace(first, what=what, fatal=True)

    def _level(self) -> list[Finding]:
        """Fast noise whose level differs between blocks, if it does not within one."""
        power = np.array([fast**2 for _, fast, _ in self.levels])
        if "level" in self.seen or power.size < 2 or not power.all():
            return []
        error = np.sqrt([2 * 35 / 18 / size for *_, size in self.levels])
        if not (power > UNEQUAL * (1 + 6 * error) * np.median(power)).any():
            return []
        at = int(power.argmax())
        what = say("the noise level changes by a factor of {ratio:.3g} between blocks; it is highest from {start:.4g} "
                   "s on", ratio=math.sqrt(power.max() / power.min()), start=self.levels[at][0])  # fmt: skip
        return [Finding("level", what, NEITHER, say("analyze the parts separately ({choice})", choice=windowing()))]
