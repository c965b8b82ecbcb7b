"""The loop over channels: read, trim, mark outliers, check, refuse, report progress, and record the provenance.

Every analysis of a recording uses it, so that the same file gets the same findings in each of them.
"""

import os
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, TypeVar, cast

from allanite.core.errors import DataError
from allanite.core.ranges import demand_pieces
from allanite.core.record import Record, Recording, Samples, Sampling, as_source
from allanite.core.threads import one_thread
from allanite.core.validity import Finding, Quality
from allanite.identification.front import Started, finished
from allanite.parallel.processors import how_many, imported, shared
from allanite.phrases.phrase import join, percent, say
from allanite.prepare.drift import follows
from allanite.prepare.held import as_sensed
from allanite.prepare.quality import inspect
from allanite.prepare.stillness import of_one_body
from allanite.prepare.transform import averaged, mark_motion, mark_outliers
from allanite.prepare.window import excluded, quiet_window, trim
from allanite.readers import read
from allanite.readers.options import FrameLike
from allanite.readers.parts import allowed, at_a_time, demand_memory

from .job import provenance_of
from .keeper import Inspected as Inspected  # noqa: PLC0414 - of this module too, for the jobs
from .parts import Keeping, in_parts
from .recipe import READING, Recipe, command_of


def drift_findings(recording: Recording, recipe: Recipe, names: Sequence[str]) -> tuple[Finding, ...]:
    """A finding for each additional column that the drift of some channels follows."""
    findings = []
    for other in recording.others:
        by_name = ((name, follows(recording[name], other)) for name in names)
        shares = {name: following.share for name, following in by_name if following and following.clear}
        if shares:
            largest = max(shares.values())
            findings.append(Finding(
                "drift",
                say("the drift of {channels} follows {column}, up to {share} of the variance of block means",
                    channels=", ".join(shares), column=other.name, share=percent(largest)),
                say("B, K and R partly represent the sensitivity to it"),
                say("remove it: {command}", command=command_of(
                    recipe, "allanite", "compensate", recording.source, last=("--regressors", other.name))),
            ))  # fmt: skip
    return tuple(findings)


Source = Recording | Samples | FrameLike | str | os.PathLike[str]
Progress = Callable[[str, float], None]
Begin = Callable[[Inspected], Started]

SEARCHING = 0.7  # share of a job in which identifications are begun

Result = TypeVar("Result")


def open_recording(
    source: Source, recipe: Recipe, *, along: Sequence[str] = (), progress: Progress | None = None, fits: bool = False
) -> Recording:
    """The part of a recording selected by the recipe, with the columns `along` last; `fits`: memory suffices."""
    whole = whole_recording(source, recipe, along=along, progress=progress, fits=fits)
    if recipe.average is not None:
        whole = averaged(whole, recipe.average)
    whole = excluded(whole, demand_pieces(recipe.exclude) if recipe.exclude else ())
    whole = trim(whole, recipe.start, recipe.until)
    part = whole if recipe.quiet_window is None else quiet_window(whole, recipe.quiet_window)
    own = part.records[: len(part.records) - len(along)]
    kept = mark_motion(own) if recipe.motion == "mark" else own
    part = part if kept is own else replace(part, records=(*kept, *part.records[len(own) :]))
    if not along:  # which have the times of the logger
        part = as_sensed(part)
    if recipe.outliers != "mark":
        return part
    own = part.records[: len(part.records) - len(along)]
    return replace(part, records=(*map(mark_outliers, own), *part.records[len(own) :]))


def whole_recording(
    source: Source, recipe: Recipe, *, along: Sequence[str] = (), otherwise: Sequence[str] = (),
    progress: Progress | None = None, fits: bool = False,
) -> Recording:  # fmt: skip
    """A recording before anything is selected; `otherwise` is that of `read`, the rest as for `open_recording`."""
    if isinstance(source, Record | Recording):
        return source if isinstance(source, Recording) else Recording((source,))
    if not isinstance(source, str | os.PathLike | FrameLike):
        samples = as_source(source, "analyze", cast(Sampling, recipe.to_dict(READING)))
        return samples if isinstance(samples, Recording) else Recording((samples,))
    tell = progress or (lambda what, fraction: None)
    tell("reading", 0.0)
    options = recipe.to_dict(READING) | {"along": tuple(along) or None, "otherwise": otherwise}
    if not fits:
        demand_memory(source, recipe.memory, recipe.to_dict(READING))
    # less of a job than is completed when its first channel begins
    return read(source, **options, progress=lambda share: tell(f"reading, {100 * share:.0f} %", 0.04 * share))


def each_channel(  # noqa: PLR0913 - each has a default but those that make the job
    channels: Sequence[tuple[str, tuple[Record, ...]]], work: Callable[[Inspected], Result],
    refused: Callable[[Inspected, str], Result], *, findings: Sequence[Finding] = (),
    look: Callable[[Record], Quality] = inspect, begin: Begin | None = None, doing: str = "analyzing",
    demand: bool = False, alone: bool = False, progress: Progress | None = None,
) -> tuple[Result, ...]:  # fmt: skip
    """Inspect every channel, a name with its records, and process those that can support the job.

    `work` may raise DataError, from which `refused` makes the result of the channel; a fatal one of the `findings`
    about the files refuses every channel. `look` checks a record, `begin` begins an identification that ends when that
    of all was begun (`begun_in`), `doing` stands before the name in messages of `progress`. With `demand` it is a
    DataError if no channel can be processed; its code is the name of the finding that refuses the first one. With
    `alone` no two are processed at once, as where memory is short.
    """
    tell = progress or (lambda what, fraction: None)
    fatal = Quality(tuple(findings)).refusal
    every = [record for _, records in channels for record in records]
    count = 1 if alone else how_many(len(channels), max((record.size for record in every), default=0))
    beside = frozenset(record.signal.name for record in every if count > 1)
    together = begin if len(channels) > 1 else None

    def tells(since: float, until: float) -> Callable[[int], None]:
        step = (until - since) / (len(channels) + 0.3)
        return lambda i: tell(f"{doing} {channels[i][0]}", since + step * (i + 0.3))

    def inspected(named: tuple[str, tuple[Record, ...]]) -> tuple[Inspected, Started | None]:
        channel = Inspected(*named, tuple(map(look, named[1])), beside=beside)
        return channel, _begun(channel, together, fatal)

    imported(progress)
    with one_thread():
        begun = shared(inspected, channels, count=count, known=every, begun=tells(0.0, SEARCHING) if together else None)
        checked = _finishing(_on_bodies([channel for channel, _ in begun]), [search for _, search in begun])
        results = shared(lambda one: _result(one, work, refused, fatal), checked, count=count, known=every,
                         begun=tells(SEARCHING if together else 0.0, 1.0))  # fmt: skip
    if demand:
        _demand_result(checked, results)
    tell("done", 1.0)
    return tuple(results)


def _begun(channel: Inspected, begin: Begin | None, fatal: str) -> Started | None:
    """The identification of a channel, None where it is not begun before its result is asked for."""
    if begin is None or fatal or any(quality.refusal for quality in channel.qualities):
        return None
    try:
        return begin(channel)
    except DataError:  # which it raises once more when its result is asked for
        return None


def _finishing(channels: Sequence[Inspected], begun: Sequence[Started | None]) -> list[Inspected]:
    """The channels with their identifications to be finished: they may have a filter in common."""
    known = {i: search for i, search in enumerate(begun)
             if search is not None and not any(quality.refusal for quality in channels[i].qualities)}  # fmt: skip
    finish = dict(zip(known, finished(list(known.values())), strict=True))
    return [replace(channel, finish=finish.get(i)) for i, channel in enumerate(channels)]


def _on_bodies(channels: Sequence[Inspected]) -> Sequence[Inspected]:
    """The channels with the findings of the others of the same recording, since these are mounted on one body."""
    count = {len(channel.records) for channel in channels}
    if len(channels) < 2 or len(count) > 1:
        return channels
    bodies = (([s.records[k] for s in channels], [s.qualities[k] for s in channels]) for k in range(count.pop()))
    told = zip(*(of_one_body(records, qualities) for records, qualities in bodies), strict=True)
    return [replace(channel, qualities=qualities) for channel, qualities in zip(channels, told, strict=True)]


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


def run(  # noqa: PLR0913 - each has a default but those that make the job
    kind: Callable[..., Result], source: Source, recipe: Recipe, work: Callable[[Inspected], Any],
    refused: Callable[[Inspected, str], Any], *, keeping: Keeping | None = None, begin: Begin | None = None,
    in_parts_too: tuple[str, ...] = (), doing: str = "analyzing", demand: bool = True, progress: Progress | None = None,
) -> Result:  # fmt: skip
    """Open a source, whole or in parts with a `keeping`, and process its channels; `kind` makes the result."""
    # memory is looked at once
    limit = allowed(recipe.memory) if keeping is not None and isinstance(source, str | os.PathLike) else None
    passing = None if keeping is None else in_parts(source, recipe, limit)
    if passing is not None and keeping is not None:
        read, findings, notes, provenance = passing.passed(recipe, keeping, progress)
        fatal = Quality(findings).refusal
        channels = _finishing(read, [_begun(channel, begin, fatal) for channel in read])
        results = tuple(_result(channel, work, refused, fatal) for channel in channels)
        if demand:
            _demand_result(channels, results)
        if progress is not None:
            progress("done", 1.0)
        return kind(results, recipe, findings, (*notes, *in_parts_too), provenance)
    recording = open_recording(source, recipe, progress=progress, fits=keeping is not None)

    def made(results: tuple[Any, ...], recipe: Recipe, findings: tuple[Finding, ...], *rest: Any) -> Result:
        named = [name for name, result in zip(recording.channels, results, strict=True) if not result.refusal]
        return kind(results, recipe, (*findings, *drift_findings(recording, recipe, named)), *rest)

    return run_together(made, (recording,), recipe, work, refused,
                        begin=begin, doing=doing, demand=demand, limit=limit, progress=progress)  # fmt: skip


def run_together(  # noqa: PLR0913 - each has a default but those that make the job
    kind: Callable[..., Result], recordings: Sequence[Recording], recipe: Recipe, work: Callable[[Inspected], Any],
    refused: Callable[[Inspected, str], Any], *, channels: Sequence[tuple[str, tuple[Record, ...]]] | None = None,
    findings: Sequence[Finding] | None = None, notes: Sequence[str] = (), look: Callable[[Record], Quality] = inspect,
    begin: Begin | None = None, doing: str = "analyzing", demand: bool = True, limit: int | None = None,
    progress: Progress | None = None,
) -> Result:  # fmt: skip
    """Process the channels of recordings that are open; `channels` and `findings` are by default all of theirs."""
    first, *others = recordings
    if channels is None:
        channels = [(record.name, (record, *(other[record.name] for other in others))) for record in first]
    told = tuple(f for recording in recordings for f in recording.findings) if findings is None else tuple(findings)
    alone = at_a_time([sum(record.size for record in each) for _, each in channels], recipe.memory, limit)
    results = each_channel(
        channels, work, refused, findings=told, look=look, begin=begin, doing=doing, demand=demand,
        alone=alone is not None, progress=progress,
    )  # fmt: skip
    own = (note for recording in recordings for note in recording.notes)
    assumed = dict.fromkeys((*notes, *own, *([] if alone is None else [alone])))
    return kind(results, recipe, told, tuple(assumed), provenance_of(*recordings))


def _demand_result(channels: Sequence[Inspected], results: Sequence[Any]) -> None:
    """Raise DataError, with the reason of each channel, if none has a result."""
    if all(result.refusal for result in results):
        reasons: dict[str, list[str]] = {}
        for channel, result in zip(channels, results, strict=True):
            reasons.setdefault(result.refusal, []).append(channel.name or "the record")
        each = (say("{channels}: {reason}", channels=", ".join(which), reason=why) for why, which in reasons.items())
        fatal = (f.name for channel in channels for quality in channel.qualities for f in quality.findings if f.fatal)
        raise DataError(join("; ", each), code=next(fatal, ""))
