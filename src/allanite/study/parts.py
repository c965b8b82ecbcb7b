"""A file that does not fit into memory: one pass, of which only sums are kept."""

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.core.arrays import IntArray
from allanite.core.kinds import KINDS
from allanite.core.plain import Header
from allanite.core.ranges import demand_pieces
from allanite.core.record import Record
from allanite.core.validity import Finding
from allanite.parallel.processes import ahead, later
from allanite.phrases.phrase import say, spelled
from allanite.prepare import inspector, window
from allanite.prepare.inspector import FEWEST_SAMPLES, Inspector
from allanite.prepare.stillness import of_one_body
from allanite.prepare.transform import blocks_words, mark_motion, samples_in
from allanite.readers.parts import PartsReader, growing, needed, opened, size_in_words, whole_findings
from allanite.readers.sandbox.source import digest_of

from .job import provenance_of
from .keeper import Inspected, Keeper, demand_sums
from .recipe import READING, Recipe

Keeping = Callable[[Record, int], Keeper]
"""What keeps the samples of a channel that begins like a record, of so many samples."""


def in_parts(source: Any, recipe: Recipe, limit: int | None = None) -> "Passing | None":
    """A file that does not fit into memory, or these bytes of it, to be read in parts; None for everything else."""
    if isinstance(source, Passing):
        return source
    reader = opened(source, recipe.memory, recipe.to_dict(READING), limit)
    if reader is None:
        return None
    demand_sums(recipe)
    return Passing(reader)


@dataclass(frozen=True)
class Preparation:
    """What a recipe does with the samples of a file before they are looked at, at the rate of its first samples."""

    heads: tuple[Record, ...]
    rows: int
    recipe: Recipe

    @cached_property
    def m(self) -> int:
        """Samples of which a mean is taken."""
        time = self.recipe.average
        return 1 if time is None else samples_in(time, self.heads[0].rate)

    @property
    def rate(self) -> float:
        """Sampling rate of the means."""
        return self.heads[0].rate / self.m

    @property
    def kinds(self) -> list[str]:
        """What a sample of each channel is."""
        return [head.kind for head in self.heads]

    @property
    def points(self) -> int:
        """Samples of a block that belong to the next one, too: 1 if steps of an angle are taken."""
        return max(KINDS[kind][1] for kind in self.kinds)

    @cached_property
    def span(self) -> tuple[int, int | None]:
        """The first sample of the window, and the one after the last."""
        start, until = self.recipe.start or 0.0, self.recipe.until
        first, last = window.span("", np.inf, self.rate, start, start + 1e9 if until is None else until)
        return first, None if until is None else last

    @property
    def spans(self) -> tuple[tuple[float, float], ...]:
        """Pieces that are left out, s."""
        return demand_pieces(self.recipe.exclude) if self.recipe.exclude else ()

    @property
    def size(self) -> int:
        """Number of samples of the window, as far as it is known before the file is read."""
        first, end = self.span
        size = self.rows // self.m
        return max(1, (size if end is None else min(end, size)) - first)

    def first_of(self, place: int) -> int:
        """The first sample of the file from which the blocks from a place in the window on are made."""
        whole = self.m * max(1, inspector.BLOCK // self.m) if self.m > 1 else 1
        return (place + self.span[0]) * self.m // whole * whole

    def blocks(self, pieces: Iterable[inspector.Piece]) -> Iterator[inspector.Piece]:
        """Blocks of the window, by their place in it."""
        first, end = self.span
        if self.m > 1:
            pieces = inspector.averaged(pieces, self.kinds, self.m, inspector.BLOCK)
        if self.spans:
            cuts = window.excluded_samples("", np.inf, self.rate, self.spans)
            pieces = inspector.excluded(pieces, self.kinds, cuts)
        if first or end is not None:
            pieces = inspector.window(pieces, first, None if end is None else end + self.points)
        return inspector.blocks(pieces, inspector.BLOCK, self.points)

    def records(self, place: int, columns: Sequence[NDArray[Any]], size: int) -> tuple[Record, ...]:
        """A block of so many samples as records."""
        first, end = self.span
        rest = size if end is None else min(size, end - first - place)
        each = []
        for head, values in zip(self.heads, columns, strict=True):
            kept = values[: rest + KINDS[head.kind][1]]
            kind = "increment" if head.kind == "count" and kept.dtype.kind == "f" else head.kind
            each.append(replace(head, values=kept, rate=self.rate, kind=kind, start=None, history=(),
                                cut=(first + place) / self.rate))  # fmt: skip
        return mark_motion(each) if self.recipe.motion == "mark" else tuple(each)

    def history(self, rate: float, size: int) -> tuple[str, ...]:
        """What was done with a record of this rate and of so many samples; refused if a piece is beyond its end."""
        name, recipe = self.heads[0].name, self.recipe
        duration = size / rate
        done = [blocks_words(self.m, self.rows % self.m)] if self.m > 1 else []
        if self.spans:
            window.excluded_samples(name, duration, rate, self.spans)
            done.append(window.excluded_words(self.spans))
        if recipe.start is not None or recipe.until is not None:
            start, until = recipe.start or 0.0, duration if recipe.until is None else recipe.until
            window.span(name, duration, rate, start, until)
            done.append(window.cut_words(start, until))
        return tuple(done)


class _Channel:
    """One channel while it is read."""

    def __init__(self, head: Record, keeper: Keeper, size: int, choice: str | None) -> None:
        self.head, self.keeper = head, keeper
        self.inspector = Inspector(size, choice)
        self.place, self.kind, self.moved = 0, head.kind, list[str]()

    def look(self, block: Record, *, alone: bool) -> tuple[Record, IntArray]:
        """The block without what is left out, and the places of its outliers."""
        self.moved += block.history
        kept, at = self.inspector.look(block, alone=alone)
        self.kind = kept.kind if kept.kind != self.head.kind else self.kind
        return kept, at

    def inspected(self, rate: float, start: float | None, done: tuple[str, ...], ready: Preparation) -> Inspected:
        """The channel when all was read, at the sampling rate of the whole."""
        head, (first, _) = self.head, ready.span
        self.keeper.at_rate(rate)
        start = start if not first else (start or 0.0) + first / rate
        history = (*done, *self.moved, *self.inspector.history, say("read in parts"))
        header = Header(head.name, rate, self.place, head.unit, self.kind, head.scale, start, history, head.signal)
        return Inspected(head.name, (header,), (self.inspector.quality(rate, self.place),), self.keeper)

    def take(self, place: int, block: Record, at: IntArray) -> None:
        """Keep a block."""
        if place > self.place:
            self.keeper.skip(place - self.place)
        self.keeper.push(np.ascontiguousarray(block.steps, dtype=np.float64), at)
        self.place = place + block.size


@dataclass
class Growth:
    """How far a file that grows was read, in bytes."""

    begin: int = 0


class Passing:
    """A file that is read in parts; with a `growth` it is read on each time that it is passed."""

    def __init__(self, reader: PartsReader, growth: Growth | None = None) -> None:
        self.reader, self.growth = reader, growth
        self.ready: Preparation | None = None
        self.channels: list[_Channel] = []
        # the next sample, the first one of the window that is in no complete block, and the pieces from it on
        self.place = self.open = 0
        self.pieces: list[inspector.Piece] = []

    def __fspath__(self) -> str:
        return self.reader.file

    @classmethod
    def of(cls, spool: os.PathLike[str], recipe: Recipe, limit: int) -> "Passing | None":
        """A text that grows, whose record takes more memory than the limit; None if it is not read in parts."""
        demand_sums(recipe)
        growth = Growth()
        reader = growing(spool, recipe.to_dict(READING), lambda: growth.begin)
        return None if reader is None else cls(replace(reader, limit=limit), growth)

    def passed(
        self, recipe: Recipe, keeping: Keeping, progress: Callable[[str, float], None] | None
    ) -> tuple[list[Inspected], tuple[Finding, ...], tuple[str, ...], dict[str, str]]:
        """Read the file: its channels with what was kept of each, findings, notes and provenance."""
        reader, growth, size = self.reader, self.growth, os.path.getsize(self.reader.file)
        digest = None if growth else later(lambda: digest_of(reader.file))  # of what is complete
        rows = max(reader.rows, reader.clock.rows)
        ready = self.ready = Preparation(reader.heads, rows, recipe)
        if not self.channels:
            heads = [replace(head, rate=ready.rate) for head in reader.heads]
            self.channels = [_Channel(head, keeping(head, ready.size), ready.size, recipe.outliers) for head in heads]
        channels = self.channels
        looked = self._looked(ready)
        for share, place, channels, each in looked if growth else ahead(looked):
            for channel, (block, at) in zip(channels, each, strict=True):
                channel.take(place, block, at)
            if progress is not None:
                progress(f"reading, {100 * share:.0f} %", 0.97 * share)
        if growth is not None:
            growth.begin = size
        beat = reader.clock.beat()
        rate, rows = beat.rate / ready.m, reader.clock.size
        done = (*reader.clock.history, *replace(ready, rows=reader.clock.rows).history(rate, rows // ready.m))
        inspected = [channel.inspected(rate, beat.start, done, ready) for channel in channels]
        records = [channel.inspector.only or whole.first for channel, whole in zip(channels, inspected, strict=True)]
        told = of_one_body(records, [channel.quality for channel in inspected])
        made = [replace(channel, qualities=(quality,)) for channel, quality in zip(inspected, told, strict=True)]
        notes = (*reader.sense.notes(beat), *_notes(reader))
        provenance = provenance_of() | {"source": reader.name}
        if digest is not None:
            provenance["sha256"] = digest.result()
        return made, whole_findings(reader), notes, provenance

    def _looked(self, ready: Preparation) -> Iterator[tuple[float, int, list[_Channel], list[tuple[Record, IntArray]]]]:
        """The share that has been read, and a block of each channel with its place and outliers."""
        # the last block of a file that grows is kept in copies, since there will be more of it
        blocks = ready.blocks(self._going_on() if self.growth else inspector.placed(ahead(self.reader.pieces())))
        for place, columns, size, last in _ended(each for each in blocks if each[0] >= self.open):
            channels = deepcopy(self.channels) if self.growth and last else self.channels
            each = zip(channels, ready.records(place, columns, size), strict=True)
            alone = last and not self.channels[0].inspector.blocks
            yield self.reader.share, place, channels, [channel.look(block, alone=alone) for channel, block in each]
            if not last:
                self.open = place + inspector.BLOCK
                first = ready.first_of(self.open)
                self.pieces = [piece for piece in self.pieces if piece[0] + len(piece[1][0]) > first]

    def _going_on(self) -> Iterator[inspector.Piece]:
        """The pieces that are in no complete block, and those of the rows that came since."""
        yield from tuple(self.pieces)
        for lost, columns in ahead(self.reader.pieces()):
            self.pieces.append((self.place + lost, columns))
            self.place += lost + len(columns[0])
            yield self.pieces[-1]


def _ended(blocks: Iterable[inspector.Piece]) -> Iterator[tuple[int, list[NDArray[Any]], int, bool]]:
    """Blocks with their sizes, and whether each is the last; too short an end is joined to the block before."""
    held: tuple[int, list[NDArray[Any]], int] | None = None
    for place, columns in blocks:
        length, full = len(columns[0]), inspector.BLOCK
        if held is not None and length < FEWEST_SAMPLES and place == held[0] + full:  # too short to be looked at alone
            both = [np.concatenate((a[:full], b)) for a, b in zip(held[1], columns, strict=True)]
            held = held[0], both, full + length
            continue
        if held is not None:
            yield *held, False
        held = place, columns, full
    if held is not None:
        yield *held, True


def _notes(reader: PartsReader) -> tuple[str, ...]:
    """That the file was read in parts, and what was looked at."""
    need = reader.need or needed(reader.clock.rows * len(reader.heads))
    return (
        say("the file was read in parts: as a whole the record may take {need} of memory, of which {limit} may be "
            "used ({option})", need=size_in_words(need), limit=size_in_words(reader.limit),
            option=spelled("--memory", "memory")),
        say("every sample was checked for gaps, outliers, stuck and clipped values; other properties were checked in "
            "blocks of {size} samples spread over the record", size=inspector.BLOCK),
        say("not done, since it needs all samples at once: removal of sinusoids, tests of the residuals, correlations "
            "between channels, drift with other columns"),
    )  # fmt: skip
