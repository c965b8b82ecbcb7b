"""A file that does not fit into memory: one pass, of which only sums are kept."""

from collections.abc import Callable, Iterable, Iterator, Sequence
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
from allanite.readers.parts import PartsReader, opened, size_in_words, whole_findings
from allanite.readers.sandbox.source import digest_of

from .job import provenance_of
from .keeper import Inspected, Keeper, demand_sums
from .recipe import READING, Recipe

Keeping = Callable[[Record, int], Keeper]
"""What keeps the samples of a channel that begins like a record, of so many samples."""


def in_parts(source: Any, recipe: Recipe, limit: int | None = None) -> PartsReader | None:
    """The reader in parts of a file that does not fit into memory, or these bytes of it; None for everything else."""
    reader = opened(source, recipe.memory, recipe.to_dict(READING), limit)
    if reader is not None:
        demand_sums(recipe)
    return reader


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

    def blocks(self, parts: Iterable[tuple[int, list[NDArray[Any]]]]) -> Iterator[inspector.Piece]:
        """Blocks of the window, by their place in it."""
        first, end = self.span
        pieces = inspector.placed(parts)
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


def passed(
    reader: PartsReader, recipe: Recipe, keeping: Keeping, progress: Callable[[str, float], None] | None
) -> tuple[list[Inspected], tuple[Finding, ...], tuple[str, ...], dict[str, str]]:
    """Read a file once: its channels with what was kept of each, findings, notes and provenance."""
    digest = later(lambda: digest_of(reader.file))
    ready = Preparation(reader.heads, reader.rows, recipe)
    heads = [replace(head, rate=ready.rate) for head in reader.heads]
    channels = [_Channel(head, keeping(head, ready.size), ready.size, recipe.outliers) for head in heads]
    for share, place, looked in ahead(_looked(reader, ready, channels)):
        for channel, (block, at) in zip(channels, looked, strict=True):
            channel.take(place, block, at)
        if progress is not None:
            progress(f"reading, {100 * share:.0f} %", 0.97 * share)
    beat = reader.clock.beat()
    rate, rows = beat.rate / ready.m, reader.clock.size
    done = (*reader.clock.history, *ready.history(rate, rows // ready.m))
    inspected = [channel.inspected(rate, beat.start, done, ready) for channel in channels]
    records = [channel.inspector.only or whole.first for channel, whole in zip(channels, inspected, strict=True)]
    told = of_one_body(records, [channel.quality for channel in inspected])
    made = [replace(channel, qualities=(quality,)) for channel, quality in zip(inspected, told, strict=True)]
    notes = (*reader.sense.notes(beat), *_notes(reader))
    return made, whole_findings(reader), notes, provenance_of() | {"source": reader.name, "sha256": digest.result()}


def _looked(
    reader: PartsReader, ready: Preparation, channels: Sequence[_Channel]
) -> Iterator[tuple[float, int, list[tuple[Record, IntArray]]]]:
    """The share that has been read, and a block of each channel with its place and outliers."""

    def look(place: int, columns: list[NDArray[Any]], size: int, *, alone: bool) -> Any:
        each = zip(channels, ready.records(place, columns, size), strict=True)
        return reader.share, place, [channel.look(block, alone=alone) for channel, block in each]

    held: tuple[int, list[NDArray[Any]], int] | None = None
    many = False
    for place, columns in ready.blocks(ahead(reader.pieces())):
        length, full = len(columns[0]), inspector.BLOCK
        if held is not None and length < FEWEST_SAMPLES and place == held[0] + full:  # too short to be looked at alone
            both = [np.concatenate((a[:full], b)) for a, b in zip(held[1], columns, strict=True)]
            held = held[0], both, full + length
            continue
        if held is not None:
            many = True
            yield look(*held, alone=False)
        held = place, columns, full
    if held is not None:
        yield look(*held, alone=not many)


def _notes(reader: PartsReader) -> tuple[str, ...]:
    """That the file was read in parts, and what was looked at."""
    return (
        say("the file was read in parts: as a whole the record may take {need} of memory, of which {limit} may be "
            "used ({option})", need=size_in_words(reader.need), limit=size_in_words(reader.limit),
            option=spelled("--memory", "memory")),
        say("every sample was checked for gaps, outliers, stuck and clipped values; other properties were checked in "
            "blocks of {size} samples spread over the record", size=inspector.BLOCK),
        say("not done, since it needs all samples at once: removal of sinusoids, tests of the residuals, correlations "
            "between channels, drift with other columns"),
    )  # fmt: skip
