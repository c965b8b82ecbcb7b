"""Several sources: opened, named, their channels paired and prepared for a joint likelihood."""

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, TypeVar

import numpy as np

from allanite.core.errors import DataError, UsageError
from allanite.core.fit import Component, Fit
from allanite.core.names import told_apart
from allanite.core.plain import Value
from allanite.core.record import Record, Recording
from allanite.core.validity import Finding, graded
from allanite.identification.methods import symbols_of
from allanite.identification.search.identify import MOST_ASKED
from allanite.phrases.phrase import join, say, spelled
from allanite.prepare.outliers import marked, outliers
from allanite.study.channels import Inspected, Progress, Source, open_recording, run_together
from allanite.study.job import Job
from allanite.study.noise import noise_of, without_lines
from allanite.study.recipe import Recipe
from allanite.study.results import Noise
from allanite.terms import TERMS

from .common_likelihood import Joint, Shape, common_band, demand_one_kind, joint

Result = TypeVar("Result")
Paired = list[tuple[str, tuple[Record, ...]]]  # the name of each channel, and its records


@dataclass(frozen=True, eq=False)
class SourceSet:
    """Recordings that are taken together."""

    # `names` say what is compared, `channels` which records belong together, `notes` what was assumed in pairing them.
    recordings: tuple[Recording, ...]
    names: tuple[str, ...]
    channels: Sequence[tuple[str, tuple[Record, ...]]]
    notes: tuple[str, ...] = ()

    @property
    def findings(self) -> tuple[Finding, ...]:
        """About each recording as a whole, with its name where there are several."""
        if len(self.recordings) == 1:
            return self.recordings[0].findings
        named = [(name, f) for name, r in zip(self.names, self.recordings, strict=True) for f in r.findings]
        return tuple(replace(finding, what=join(": ", (name, finding.what))) for name, finding in named)


def run_sources(kind: Callable[..., Result], sources: SourceSet, recipe: Recipe,
                work: Callable[[Inspected], Any], refused: Callable[[Inspected, str], Any], *, doing: str = "comparing",
                progress: Progress | None = None) -> Result:  # fmt: skip
    """Do the work on each channel of several recordings, as `allanite.study.channels.run` on those of one."""
    # `kind` makes the result of the fields of `Together`.
    return run_together(partial(kind, names=sources.names), sources.recordings, recipe, work,
                        refused, channels=sources.channels, findings=sources.findings, notes=sources.notes, doing=doing,
                        progress=progress)  # fmt: skip


def open_sources(sources: Sequence[Source | Job[Any]], recipe: Recipe, *, against: Sequence[str] | None = None,
                 progress: Progress | None = None) -> SourceSet:  # fmt: skip
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


def pair_channels(recordings: Sequence[Recording], *, ordered: bool = False) -> tuple[Paired, tuple[str, ...]]:
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


def _in_order(recordings: Sequence[Recording], why: str) -> tuple[Paired, tuple[str, ...]]:
    """The channels one after the other; where that is not possible, an error says why it had to be."""
    counts = {len(recording) for recording in recordings}
    if len(counts) > 1 or (len(recordings) > 2 and len(recordings[0]) > 1):
        shown = "; ".join(", ".join(recording.channels) for recording in recordings)
        raise UsageError(f"the channels cannot be paired ({shown}): {why}; select the same number of each "
                         f"({spelled('--channels, --against', 'channels, against')})")  # fmt: skip
    matched = list(zip(*recordings, strict=True))
    named = [list(dict.fromkeys(r.name for r in records if r.name)) for records in matched]
    several = ((first, ", ".join(rest)) for first, *rest in filter(None, named) if rest)
    notes = (say("channel {first} is compared with {others}", first=first, others=others) for first, others in several)
    return [(name_both(*records), records) for records in matched], tuple(notes)


def name_both(*records: Any) -> str:
    """One name for records or fits that are compared."""
    return " / ".join(dict.fromkeys(record.name for record in records if record.name))


@dataclass(frozen=True, eq=False)
class Joined:
    """The joint likelihood of records, the noise of each, and what was done to them."""

    # `records` are without their outliers.
    joint: Joint
    noises: tuple[Noise, ...]
    notes: tuple[str, ...]
    records: tuple[Record, ...]

    @property
    def fits(self) -> tuple[Fit, ...]:
        """The fit of each record."""
        return tuple(noise.fit for noise in self.noises)

    @property
    def judged(self) -> dict[str, Any]:
        """Fields of a `ComparedChannel`: the common band, and the fits with how well each explains its record."""
        grades = tuple(graded(noise.validity, noise.fit.scope) for noise in self.noises)
        explained = tuple(noise.explained for noise in self.noises)
        return {"band": self.joint.band, "fits": self.fits, "explained": explained, "grades": grades}

    @property
    def alerts(self) -> tuple[str, ...]:
        """What must stand beside the numbers: models that do not explain their records, and what was done."""
        each = ((i, doubt) for i, noise in enumerate(self.noises, 1) for doubt in noise.doubts)
        doubts = (say("record {number}: {doubt}; a difference in what the model omits may appear as a change of one of "
                      "its terms", number=i, doubt=doubt) for i, doubt in each)  # fmt: skip
        return (*doubts, *self.notes)


def join_records(records: Sequence[Record], recipe: Recipe) -> Joined:
    """The joint likelihood of records of one kind of sensor."""
    # Outliers are omitted, and sinusoids removed as the fits found them. Where one record has a term with a shape it is
    # asked of all, and compared with one shape.
    demand_one_kind(records)
    _demand_different(records)
    notes: list[str] = []
    if recipe.outliers is None:
        outlying = [(record, outliers(record)) for record in records]
        omitted = ((i, some.words(record)) for i, (record, some) in enumerate(outlying, 1) if some.at.size)
        notes = [say("record {number}: {outliers}: excluded from the comparison", number=i, outliers=text)
                 for i, text in omitted]  # fmt: skip
        records = [marked(record, some) for record, some in outlying]
    noises, shown = _identify_alike(records, replace(recipe, outliers="keep"))
    fits = [noise.fit for noise in noises]
    shapes = _common_shapes(fits)
    quiet = [without_lines(record, fit) for record, fit in zip(records, fits, strict=True)]
    lines = [", ".join(f"{line.frequency:.6g}" for line in fit.lines) for fit in fits]
    notes += [say("record {number}: sinusoids were removed, at {frequencies} Hz", number=i, frequencies=text)
              for i, text in enumerate(lines, 1) if text]  # fmt: skip
    resonances = [join(", ", [part.words for part in _resonances(fit)]) for fit in fits]
    notes += [say("record {number}: left out of the comparison: {resonances}", number=i, resonances=text)
              for i, text in enumerate(resonances, 1) if text]  # fmt: skip
    both = joint(quiet, shown, asked_band(recipe), shapes=shapes, scopes=[fit.scope for fit in fits])
    shaped = ((symbol, both.term(symbol, 1.0).shape_words) for symbol in shapes)
    notes += [say("{term} has one shape in the common model: {shape}", term=s, shape=text) for s, text in shaped]
    return Joined(both, noises, tuple(notes), tuple(records))


def _common_shapes(fits: Sequence[Fit]) -> dict[str, Shape]:
    """The shape of each term that has one in any of the fits, the geometric mean of theirs."""
    noise = [e for fit in fits for e in fit if e.shape and TERMS[e.symbol].waveform is None]
    each = {symbol: [e.shape for e in noise if e.symbol == symbol] for symbol in dict.fromkeys(e.symbol for e in noise)}
    return {symbol: tuple(np.exp(np.log(shapes).mean(axis=0)).tolist()) for symbol, shapes in each.items()}


def _demand_different(records: Sequence[Record]) -> None:
    for j, record in enumerate(records):
        for i, other in enumerate(records[:j]):
            if np.array_equal(other.values, record.values, equal_nan=True):
                alike = say("records {first} and {second} have identical samples; there is nothing to compare",
                            first=i + 1, second=j + 1)  # fmt: skip
                raise DataError(alike)


def asked_band(recipe: Recipe) -> tuple[float, float] | None:
    """The band that was given, Hz."""
    return None if isinstance(recipe.band, str) else recipe.band


def _identify_alike(records: Sequence[Record], recipe: Recipe) -> tuple[tuple[Noise, ...], tuple[str, ...]]:
    """The noise of each record, of the same terms, in the common band where that omits a part of one."""
    low, high = common_band(records, asked_band(recipe))
    cut = any(r.rate / 2 > high * (1 + 1e-9) or 0.75 / r.duration <= low for r in records)
    band = (low * (1 - 1e-9), high * (1 + 1e-9)) if cut else None
    symbols = [s for s in symbols_of(recipe.terms) if TERMS[s].scatters]
    noises = tuple(noise_of(record, recipe, band=band) for record in records)
    shown = tuple(dict.fromkeys((*symbols, *(e.symbol for noise in noises for e in noise.fit))))
    shaped = [s for s in shown if TERMS[s].parameters]
    if recipe.terms == "auto" and len(shaped) < MOST_ASKED and _loop([noise.fit for noise in noises]):
        asked = (*shown, "GM2")
        alike = tuple(noise_of(record, recipe, terms=",".join(asked), band=band) for record in records)
        if all(noise.explained for noise in alike):
            return alike, asked
    if len(shown) > len(symbols):
        noises = tuple(noise_of(record, recipe, terms=",".join(shown), band=band) for record in records)
    return noises, shown


def _loop(fits: Sequence[Fit]) -> bool:
    """Whether the only resonance of a record is as broad as that of a control loop, and no record has several."""
    each = [_resonances(fit) for fit in fits]
    return max(map(len, each)) == 1 and any(part.loop for parts in each for part in parts)


def _resonances(fit: Fit) -> list[Component]:
    return [part for part in fit.components if part.name == "resonance" and part.claimed]
