"""Several sources: opened, named, and their channels paired."""

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

from allanite.core.errors import UsageError
from allanite.core.finding import Finding
from allanite.core.names import told_apart
from allanite.core.plain import Value
from allanite.core.record import Record, Recording
from allanite.phrases.phrase import join, say
from allanite.phrases.wording import spelled
from allanite.study.channels import Inspected, Progress, Source, each_channel, open_recording
from allanite.study.job import Job
from allanite.study.provenance import provenance_of
from allanite.study.recipe import Recipe

Result = TypeVar("Result")


@dataclass(frozen=True, eq=False)
class SourceSet:
    """Recordings that are taken together.

    `names` say what is compared, `channels` which records belong together, `notes` what was assumed in pairing them.
    """

    recordings: tuple[Recording, ...]
    names: tuple[str, ...]
    channels: Sequence[tuple[str, tuple[Record, ...]]]
    notes: tuple[str, ...] = ()

    @property
    def findings(self) -> tuple[Finding, ...]:
        """About each recording as a whole, with its name where there are several."""
        if len(self.recordings) == 1:
            return self.recordings[0].findings
        named = zip(self.names, self.recordings, strict=True)
        return tuple(
            replace(found, what=join(": ", (name, found.what))) for name, one in named for found in one.findings
        )


def run_together(
    kind: Callable[..., Result],
    sources: SourceSet,
    recipe: Recipe,
    work: Callable[[Inspected], Any],
    refused: Callable[[Inspected, str], Any],
    *,
    doing: str = "comparing",
    progress: Progress | None = None,
) -> Result:
    """Do the work on each channel of several recordings, as `allanite.study.channels.run` on those of one.

    `kind` makes the result of the fields of `Together`.
    """
    findings = sources.findings
    results = each_channel(
        sources.channels, work, refused, findings=findings, doing=doing, demand=True, progress=progress
    )
    notes = dict.fromkeys((*(note for one in sources.recordings for note in one.notes), *sources.notes))
    return kind(results, recipe, findings, tuple(notes), provenance_of(*sources.recordings), sources.names)


def open_sources(
    sources: Sequence[Source | Job[Any]],
    recipe: Recipe,
    *,
    against: Sequence[str] | None = None,
    progress: Progress | None = None,
) -> SourceSet:
    """Open each source and pair the channels; those of the last one may be named, and are then taken in order."""
    last = recipe if against is None else replace(recipe, channels=tuple(against))
    recipes = [*[recipe] * (len(sources) - 1), last]
    recordings = tuple(open_source(source, r, progress) for source, r in zip(sources, recipes, strict=True))
    channels, notes = pair_channels(recordings, ordered=against is not None)
    return SourceSet(recordings, name_sources(*sources), channels, notes)


def open_source(source: Source | Job[Any], recipe: Recipe, progress: Progress | None = None) -> Recording:
    """The recording of whatever holds one, as far as the recipe selects it."""
    if isinstance(source, Job):
        made = source.provenance.get("source", ""), source.provenance.get("sha256", "")
        records = tuple(c.record for c in source.channels if isinstance(c.record, Record))
        if len(records) < len(source.channels):
            raise UsageError("a stored study has no samples; compare its file instead")
        source = Recording(records, *made, source.notes, source.findings)
    if isinstance(source, Value) and not isinstance(source, (Recording, Record)):
        raise UsageError(f"a {type(source).__name__} cannot be compared; give records, recordings, studies or paths")
    return open_recording(source, recipe, progress=progress)


def name_sources(*sources: Source | Job[Any]) -> tuple[str, ...]:
    """The names of files or records where these differ; otherwise "before" and "after", or numbers."""
    paths = [os.fspath(source) for source in sources if isinstance(source, (str, os.PathLike))]
    if len(set(paths)) == len(sources):
        return told_apart(paths)

    def own(source: Source | Job[Any]) -> str:
        if isinstance(source, (str, os.PathLike)):
            return os.path.basename(source)
        if isinstance(source, Recording):
            return source[0].name if len(source) == 1 else ""
        return str(getattr(source, "name", ""))

    names = [own(source) for source in sources]
    if all(names) and len(set(names)) == len(names):
        return tuple(names)
    if len(sources) == 2:
        return say("before"), say("after")
    return tuple(say("run {number}", number=i + 1) for i in range(len(sources)))


def pair_channels(
    recordings: Sequence[Recording], *, ordered: bool = False
) -> tuple[list[tuple[str, tuple[Record, ...]]], tuple[str, ...]]:
    """The records of each channel, by name or in order, and notes about that."""
    names = [recording.channels for recording in recordings]
    common = [name for name in names[0] if all(name in others for others in names)]
    if ordered or not common:
        return _in_order(recordings, "their numbers differ" if ordered else "the recordings have no channel in common")
    alone = ", ".join(sorted(set().union(*names) - set(common)))
    both = say("not in both recordings, and not compared: {channels}", channels=alone)
    every = say("not in all recordings, and not compared: {channels}", channels=alone)
    missing = both if len(recordings) == 2 else every
    return [(name, tuple(recording[name] for recording in recordings)) for name in common], (missing,) * bool(alone)


def _in_order(
    recordings: Sequence[Recording], why: str
) -> tuple[list[tuple[str, tuple[Record, ...]]], tuple[str, ...]]:
    """The channels one after the other; where that is not possible, an error says why it had to be."""
    counts = {len(recording) for recording in recordings}
    if len(counts) > 1 or (len(recordings) > 2 and len(recordings[0]) > 1):
        shown = "; ".join(", ".join(recording.channels) for recording in recordings)
        raise UsageError(
            f"the channels cannot be paired ({shown}): {why}; select the same number of each "
            f"({spelled('--channels, --against', 'channels, against')})"
        )
    matched = list(zip(*recordings, strict=True))
    named = [list(dict.fromkeys(r.name for r in records if r.name)) for records in matched]
    notes = tuple(
        say("channel {first} is compared with {others}", first=first, others=", ".join(rest))
        for first, *rest in filter(None, named)
        if rest
    )
    return [(name_both(*records), records) for records in matched], notes


def name_both(*records: Any) -> str:
    """One name for records or fits that are compared."""
    return " / ".join(dict.fromkeys(record.name for record in records if record.name))
