"""The loop over channels for a file that does not fit into memory: one pass, of which only sums are kept."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from allanite.core.arrays import FloatArray, IntArray
from allanite.core.choices import needing_all
from allanite.core.errors import DataError, UsageError
from allanite.core.finding import Quality
from allanite.core.header import Header
from allanite.core.record import Record, Recording
from allanite.phrases.phrase import say
from allanite.phrases.wording import spelled
from allanite.readers.ahead import Later, ahead
from allanite.readers.memory import size_in_words
from allanite.readers.parts import PartsReader, opened, whole_findings
from allanite.readers.sandbox.source import digest_of

from .channels import Progress, Source, demand_result
from .gathering import WHOLE, Gathering
from .inspection import BLOCK, Inspection
from .provenance import provenance_of
from .recipe import READING, Recipe

Result = TypeVar("Result")


@dataclass(frozen=True, eq=False)
class Passed:
    """A channel of which the last part was read: its header, quality, and what was gathered."""

    header: Header
    quality: Quality
    gathered: Any


@contextmanager
def in_parts(source: Source, recipe: Recipe) -> Iterator[PartsReader | None]:
    """The reader in parts of a file that does not fit into memory; None for everything else.

    Raises
    ------
    UsageError
        It does not fit, and its format or a choice of the recipe needs the whole record.
    """
    if isinstance(source, (Record, Recording)):
        yield None
        return
    with opened(source, recipe.memory, recipe.to_dict(READING)) as reader:
        if reader is not None:
            _demand_choices(recipe)
        yield reader


def _demand_choices(recipe: Recipe) -> None:
    """Refuse what needs the whole record."""
    for row, value in needing_all(recipe):
        wrong = f" {value!r}: only {', '.join(map(repr, row.parts))}" if row.parts else ": omit it"
        raise UsageError(
            f"{WHOLE} no {spelled(row.options[0], row.name)}{wrong}, or allow more memory with "
            f"{spelled('--memory', 'memory=')}",
            choice=row.name,
        )


def run_in_parts(  # noqa: PLR0917 - as `run`
    kind: Callable[..., Result],
    reader: PartsReader,
    recipe: Recipe,
    gather: Callable[[Record], Gathering],
    work: Callable[[Passed], Any],
    refused: Callable[[Passed, str], Any],
    *,
    notes: tuple[str, ...] = (),
    progress: Progress | None = None,
) -> Result:
    """Read a file once, and make the result of each channel from what was gathered; the counterpart of `run`.

    Parameters
    ----------
    kind, progress
        As for `run`.
    gather : Record -> Gathering
        What takes the samples of a channel that begins like the record.
    work, refused
        As for `each_channel`.
    notes : tuple of str
        Assumptions of this job.
    """
    digest = Later(lambda: digest_of(reader.file))
    channels = [_Channel(head, gather(head), reader.rows, recipe) for head in reader.heads]
    tell = progress or (lambda what, fraction: None)
    for share, samples in ahead(_looked(reader, channels)):
        for channel, (lost, parts) in zip(channels, samples, strict=True):
            channel.take(lost, parts)
        tell(f"reading, {100 * share:.0f} %", 0.97 * share)
    beat = reader.clock.beat()
    findings = whole_findings(reader)
    fatal = Quality(findings).refusal
    passed = [_passed(channel, beat.rate, beat.start, reader.clock.history) for channel in channels]
    made = [_made(one, fatal or one.quality.refusal, work, refused) for one in passed]
    demand_result([head.name for head in reader.heads], made)
    said = (*reader.sense.notes(beat), *_notes(reader, recipe), *notes)
    provenance = provenance_of() | {"source": reader.name, "sha256": digest()}
    tell("done", 1.0)
    return kind(tuple(made), recipe, findings, said, provenance)


def _made(passed: Passed, why: str, work: Callable[[Passed], Any], refused: Callable[[Passed, str], Any]) -> Any:
    """The result of a channel, or why there is none."""
    if why:
        return refused(passed, why)
    try:
        return work(passed)
    except DataError as error:
        return refused(passed, str(error))


class _Channel:
    """One channel while it is read: its window, inspection, and what gathers it."""

    def __init__(self, head: Record, gathering: Gathering, size: int, recipe: Recipe) -> None:
        self.head, self.gathering = head, gathering
        self.inspection = Inspection(head, size, recipe.outliers)
        self.place = 0
        begin, end = recipe.start or 0.0, recipe.until
        self.begin = round(begin * head.rate)
        self.end = None if end is None else round(end * head.rate)
        if begin < 0 or (end is not None and end <= begin):
            raise UsageError(f"the window from {begin:.10g} s to {end} s is empty or starts before the record")
        self._last: NDArray[Any] | None = None

    def steps(self, lost: int, values: NDArray[Any]) -> tuple[int, FloatArray, IntArray]:
        """Missing samples, the steps in the window, and its outliers."""
        if self.head.kind == "angle":
            gone = np.full(1, np.nan) if lost else None
            before = gone if gone is not None else self._last
            self._last = values[-1:].copy()
            values = np.diff(values if before is None else np.concatenate((before, values)))
        steps = np.ascontiguousarray(values, dtype=np.float64)
        self.place += lost
        low = min(max(self.begin - self.place, 0), steps.size)
        high = steps.size if self.end is None else min(max(self.end - self.place, low), steps.size)
        until = self.place if self.end is None else min(self.place, self.end)
        inside = max(0, until - max(self.place - lost, self.begin))
        place, self.place = self.place, self.place + steps.size
        part = steps[low:high]
        self.inspection.lost += inside
        return inside, part, self.inspection.look(part, place + low) if part.size else np.empty(0, np.int64)

    def take(self, lost: int, part: tuple[FloatArray, IntArray]) -> None:
        """Gather samples."""
        if lost:
            self.gathering.skip(lost)
        if part[0].size:
            self.gathering.push(*part)

    @property
    def size(self) -> int:
        """Number of samples of the window so far, missing ones included."""
        return max(0, (self.place if self.end is None else min(self.end, self.place)) - self.begin)

    @property
    def kind(self) -> str:
        """What a sample is: counts with gaps are increments."""
        return "increment" if self.head.kind == "count" and self.inspection.lost else self.head.kind


def _looked(
    reader: PartsReader, channels: list[_Channel]
) -> Iterator[tuple[float, list[tuple[int, tuple[FloatArray, IntArray]]]]]:
    """The share that has been read, and the samples of each channel with their outliers."""
    for lost, columns in ahead(reader.pieces()):
        samples = [channel.steps(lost, values) for channel, values in zip(channels, columns, strict=True)]
        yield min(1.0, reader.clock.rows / reader.rows), [(gone, (part, at)) for gone, part, at in samples]


def _passed(channel: _Channel, rate: float, start: float | None, history: tuple[str, ...]) -> Passed:
    """A channel with its header and quality, at the sampling rate of the whole."""
    head, inspection = channel.head, channel.inspection
    cut = () if channel.begin == 0 and channel.end is None else (_cut(channel, rate),)
    start = None if start is None and not channel.begin else (start or 0.0) + channel.begin / rate
    header = Header(head.name, rate, channel.size, head.unit, channel.kind, head.scale, start,
                    (*history, *cut, *inspection.history, say("read in parts")), head.signal)  # fmt: skip
    return Passed(header, inspection.quality(rate, channel.size), channel.gathering)


def _cut(channel: _Channel, rate: float) -> str:
    start, end = channel.begin / rate, (channel.begin + channel.size) / rate
    return say("cut from {start:g} s to {end:g} s", start=start, end=end)


def _notes(reader: PartsReader, recipe: Recipe) -> tuple[str, ...]:
    """That the file was read in parts, and what was looked at."""
    return (
        say(
            "the file was read in parts: as a whole the record may take {need} of memory, of which {limit} may be "
            "used ({option})",
            need=size_in_words(reader.need), limit=size_in_words(reader.limit),
            option=spelled("--memory", "memory"),
        ),
        say(
            "every sample was checked for gaps, outliers, stuck and clipped values; other properties were checked in "
            "blocks of {size} samples spread over the record",
            size=BLOCK,
        ),
        say(
            "not done, since it needs all samples at once: removal of sinusoids, tests of the residuals, correlations "
            "between channels, drift with other columns"
        ),
    )  # fmt: skip
