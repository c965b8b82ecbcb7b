"""The loop over channels: read, trim, mark outliers, check, refuse, report progress, and record the provenance.

Every analysis of a recording uses it, so that the same file gets the same findings in each of them.
"""

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any, ClassVar, Generic, Self, TypeVar, get_args

from allanite.core.encoding import read as read_plain
from allanite.core.encoding import write
from allanite.core.errors import DataError, UsageError
from allanite.core.finding import Finding, Quality
from allanite.core.language import join, say
from allanite.core.plain import VERSION, Value, demand_type, stored_fields
from allanite.core.ranges import demand_pieces
from allanite.core.record import Record, Recording
from allanite.prepare.body import of_one_body
from allanite.prepare.quality import inspect
from allanite.prepare.transform import averaged, mark_outliers
from allanite.prepare.window import excluded, quiet_window, trim
from allanite.readers import read
from allanite.readers.parts import demand_memory
from allanite.readers.sandbox.progress import told

from .drift import drift_findings
from .inspected import Inspected as Inspected  # noqa: PLC0414 - of this module too, for the jobs
from .provenance import provenance_of
from .recipe import IDENTIFYING, READING, SELECTING, Recipe
from .shares import how_many, shared

Source = Recording | Record | str | os.PathLike[str]
Progress = Callable[[str, float], None]
Result = TypeVar("Result")

Opener = Callable[[str, Mapping[str, Any], Callable[[], Recording]], Recording]
"""(path, choices of the reader, function that reads it) -> the recording."""

_opener: ContextVar[Opener | None] = ContextVar("_opener", default=None)


@contextmanager
def opened_by(opener: Opener) -> Iterator[None]:
    """Within this context files are read by `opener`, which may keep what it has read for the next job."""
    token = _opener.set(opener)
    try:
        yield
    finally:
        _opener.reset(token)


@dataclass(frozen=True, eq=False, repr=False)
class Job(Value, Generic[Result]):
    """Result of a job: one result per channel, and how it was obtained.

    A subclass defines the type of its channels in `_channel`; its own fields are written and read with the others.

    Attributes
    ----------
    channels : tuple
        One result per channel, in the order of the file; each has its `record`, and a `refusal` if there is no result.
    recipe : Recipe
    findings : tuple of Finding
        Findings about the file as a whole: its clock.
    notes : tuple of str
        Assumptions made when reading.
    provenance : dict
        Version and input files.
    """

    _channel: ClassVar[type[Any]]

    channels: tuple[Result, ...]
    recipe: Recipe
    findings: tuple[Finding, ...]
    notes: tuple[str, ...]
    provenance: dict[str, str]

    def __getitem__(self, key: str | int) -> Result:
        if isinstance(key, int):
            return self.channels[key]
        for name, channel in zip(self._names, self.channels, strict=True):
            if name == key:
                return channel
        raise UsageError(f"no channel {key!r}; channels: {', '.join(self._names)}")

    def __iter__(self) -> Iterator[Result]:
        return iter(self.channels)

    @property
    def _names(self) -> list[str]:
        """Names of the channels: their own, or those of their records."""
        channels: tuple[Any, ...] = self.channels
        return [channel.name if hasattr(channel, "name") else channel.record.name for channel in channels]

    @property
    def rejected(self) -> tuple[str, ...]:
        """Names of the channels without a result, or whose noise no model explains."""
        pairs = zip(self._names, self.channels, strict=True)
        return tuple(name for name, channel in pairs if channel.refusal or not self._explained(channel))  # type: ignore[attr-defined]

    def _explained(self, channel: Any) -> bool:
        """Whether no model is known to be inadequate for the noise of a channel, if it was identified."""
        return channel.noise is None or bool(channel.noise.explained)

    def choices(self) -> dict[str, Any]:
        """The recipe that was actually used, as plain data."""
        return self.recipe.to_dict((*READING, *SELECTING, *IDENTIFYING))

    def to_dict(self, level: float | None = None) -> dict[str, Any]:
        """Plain data, with limits at `level`, by default that of the recipe."""
        level = self.recipe.level if level is None else level

        def written(channel: Any) -> dict[str, Any]:
            found: dict[str, Any] = channel.to_dict(level)
            return found

        return {
            "allanite": VERSION,
            "type": type(self).__name__,
            "channels": shared(written, self.channels, count=how_many(len(self.channels))),
            "findings": [finding.to_dict() for finding in self.findings],
            "recipe": self.choices(),
            "notes": list(self.notes),
            "provenance": self.provenance,
        } | {name: write(getattr(self, name), hint, level) for name, hint in stored_fields(type(self), Job)}

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> Self:
        """The value written by `to_dict`; limits are known for the stored level only, and records have no samples."""
        demand_type(data, cls.__name__)
        known = {f.name for f in fields(Recipe)}
        return cls(
            tuple(cls._channel.from_dict(channel) for channel in data["channels"]),
            Recipe.from_dict({key: value for key, value in data["recipe"].items() if key in known and cls._keeps(key)}),
            tuple(Finding.from_dict(finding) for finding in data["findings"]),
            tuple(data["notes"]),
            dict(data["provenance"]),
            **{name: read_plain(data[name], hint) for name, hint in stored_fields(cls, Job)},
        )

    @classmethod
    def _keeps(cls, key: str) -> bool:
        """Whether a key of the stored recipe belongs to the recipe, not to settings of the same name."""
        hints = [hint for name, hint in stored_fields(cls, Job) if name == "settings"]
        kinds = [kind for hint in hints for kind in get_args(hint) or (hint,) if is_dataclass(kind)]
        return key not in {f.name for kind in kinds for f in fields(kind)}

    def _summary(self) -> str:
        source = self.provenance.get("source") or "data in memory"
        return f"{source!r}: {', '.join(name or 'channel' for name in self._names)}"


def open_recording(
    source: Source, recipe: Recipe, *, along: Sequence[str] = (), progress: Progress | None = None
) -> Recording:
    """The part of a recording selected by the recipe.

    Parameters
    ----------
    source : Recording, Record or path, which is read with the recipe's options
    along : sequence of str
        Other columns of the file to read as the last channels; their outliers are not marked.
    progress : callable, optional, as for `each_channel`

    Raises
    ------
    DataError
        The file cannot be read, or its clock is unusable.
    UsageError
        An option is wrong, or a required one is missing.
    """
    with told(_reading(progress)):
        whole = _whole(source, recipe, along)
    if recipe.average is not None:
        whole = averaged(whole, recipe.average)
    whole = excluded(whole, demand_pieces(recipe.exclude) if recipe.exclude else ())
    whole = trim(whole, recipe.start, recipe.until)
    part = whole if recipe.quiet_window is None else quiet_window(whole, recipe.quiet_window)
    if recipe.outliers != "mark":
        return part
    own = part.records[: len(part.records) - len(along)]
    return replace(part, records=(*map(mark_outliers, own), *part.records[len(own) :]))


def _reading(progress: Progress | None) -> Callable[[float], None] | None:
    """Progress while a file is read: less of a job than is completed when its first channel begins."""
    if progress is not None:
        progress("reading", 0.0)
    return progress and (lambda share: progress(f"reading, {100 * share:.0f} %", 0.04 * share))


def _whole(source: Source, recipe: Recipe, along: Sequence[str]) -> Recording:
    if isinstance(source, Recording):
        return source
    if isinstance(source, Record):
        return Recording((source,))
    options = recipe.to_dict(READING) | ({"along": tuple(along)} if along else {})

    def whole() -> Recording:
        demand_memory(source, recipe.memory, recipe.to_dict(READING))
        return read(source, **options)

    opener = _opener.get()
    return whole() if opener is None else opener(os.fspath(source), options, whole)


def each_channel(
    channels: Sequence[tuple[str, tuple[Record, ...]]],
    work: Callable[[Inspected], Result],
    refused: Callable[[Inspected, str], Result],
    *,
    findings: Sequence[Finding] = (),
    look: Callable[[Record], Quality] = inspect,
    doing: str = "analyzing",
    progress: Progress | None = None,
) -> tuple[Result, ...]:
    """Inspect every channel, and process those that can support the job.

    Parameters
    ----------
    channels : sequence of (name, records)
    work : Inspected -> result
        May raise DataError, which becomes a refusal.
    refused : (Inspected, reason) -> result
        Makes the result of a refused channel.
    findings : sequence of Finding
        Findings about the files as a whole; a fatal one refuses every channel.
    look : Record -> Quality
        Function that checks a record, instead of `inspect`.
    doing : str
        Progress message, placed before the name.
    progress : callable, optional
        Called with a description of the current step and the fraction completed.
    """
    tell = progress or (lambda what, fraction: None)
    fatal = Quality(tuple(findings)).refusal
    every = [record for _, records in channels for record in records]
    count = how_many(len(channels), max((record.size for record in every), default=0))

    def inspected(channel: tuple[str, tuple[Record, ...]]) -> Inspected:
        name, records = channel
        return Inspected(name, records, tuple(look(record) for record in records))

    def begun(i: int) -> None:
        tell(f"{doing} {channels[i][0]}", (i + 0.3) / (len(channels) + 0.3))

    seen = _on_bodies(shared(inspected, channels, count=count, known=every))
    results = shared(lambda one: _result(one, work, refused, fatal), seen, count=count, known=every, begun=begun)
    tell("done", 1.0)
    return tuple(results)


def _on_bodies(channels: Sequence[Inspected]) -> Sequence[Inspected]:
    """The channels with the findings of the others of the same recording, since these are mounted on one body."""
    count = {len(seen.records) for seen in channels}
    if len(channels) < 2 or len(count) > 1:
        return channels
    bodies = (([s.records[k] for s in channels], [s.qualities[k] for s in channels]) for k in range(count.pop()))
    told = zip(*(of_one_body(records, qualities) for records, qualities in bodies), strict=True)
    return [replace(seen, qualities=qualities) for seen, qualities in zip(channels, told, strict=True)]


def _result(
    seen: Inspected, work: Callable[[Inspected], Result], refused: Callable[[Inspected, str], Result], fatal: str
) -> Result:
    why = fatal or join("; ", (join("", (which, q.refusal)) for which, q in seen.numbered if q.refusal))
    if why:
        return refused(seen, why)
    try:
        return work(seen)
    except DataError as error:
        return refused(seen, str(error))


def run(
    kind: Callable[..., Result],
    source: Source,
    recipe: Recipe,
    work: Callable[[Inspected], Any],
    refused: Callable[[Inspected, str], Any],
    *,
    doing: str = "analyzing",
    demand: bool = True,
    progress: Progress | None = None,
) -> Result:
    """Open a source and process each of its channels.

    Parameters
    ----------
    kind : callable
        Makes the result of the job from the fields of `Job`.
    source, recipe
        As for `open_recording`.
    work, refused, doing, progress
        As for `each_channel`.
    demand : bool
        Whether it is an error if no channel can be processed.

    Raises
    ------
    DataError
        The file cannot be read, or no channel can be processed.
    UsageError
        An option is wrong, or a required one is missing.
    """
    recording = open_recording(source, recipe, progress=progress)
    channels = [(one.name, (one,)) for one in recording]
    results = each_channel(channels, work, refused, findings=recording.findings, doing=doing, progress=progress)
    if demand:
        demand_result(recording.channels, results)
    named = [name for name, result in zip(recording.channels, results, strict=True) if not result.refusal]
    findings = (*recording.findings, *drift_findings(recording, recipe, named))
    return kind(results, recipe, findings, recording.notes, provenance_of(recording))


def demand_result(names: Sequence[str], results: Sequence[Any]) -> None:
    """Raise DataError, with the reason of each channel, if none has a result."""
    if all(result.refusal for result in results):
        reasons: dict[str, list[str]] = {}
        for name, result in zip(names, results, strict=True):
            reasons.setdefault(result.refusal, []).append(name or "the record")
        raise DataError(
            join(
                "; ",
                (say("{channels}: {reason}", channels=", ".join(which), reason=why) for why, which in reasons.items()),
            )
        )
