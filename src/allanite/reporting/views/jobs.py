"""Common parts of the views of jobs: where the numbers come from, notes on channels, remarks of the first screen."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any, TypeGuard

from allanite.core.arrays import mean_and_deviation
from allanite.core.limits import FAIL, NOT_DECIDED, PASS
from allanite.core.names import sources_of, told_apart
from allanite.core.record import Record
from allanite.core.residuals import Statement
from allanite.core.syntax import toml
from allanite.core.units import convert
from allanite.core.validity import APPROXIMATE, EXPLAINED, MOTION, UNEXPLAINED, Finding
from allanite.phrases.phrase import join, say, say_count
from allanite.reporting import words
from allanite.reporting.first import ABOVE, Remark, channels_named, kinds, merged, shown, told_of
from allanite.reporting.sheet import Face, Note, Part, Sheet, header_of
from allanite.study.job import Job
from allanite.study.results import Channel, Noise

OUTCOME_WORDS = {PASS: say("pass"), FAIL: say("fail"), NOT_DECIDED: say("not decided"), "": ""}
"""What a limit says of a coefficient."""

LEVELS: dict[str, Any] = {EXPLAINED: "good", APPROXIMATE: "fair", UNEXPLAINED: "alert"}
"""Level of the note by the grade of a model."""

REFUSED = "no result: "  # how the note on a refusal begins in English


def source_of(job: Job[Any]) -> str:
    """The names of the files, for a title."""
    return ", ".join(told_apart(sources_of(job.provenance))) or say("data in memory")


def job_face(
    job: Job[Any], names: tuple[str, str], sheets: Sequence[Sheet], parts: Iterable[Part] = (), **more: Any
) -> Face:
    """The face of a job: title and brand, findings and other parts, sheets, how it came about; `more` fields."""
    title, brand = names
    once, kept = split_common(sheets)
    face = Face(
        title, brand, kept, header_of(job.provenance, job.notes),
        parts=[*(Note(str(finding), "warning") for finding in job.findings), *once, *parts],
        choices=toml(job.choices()), provenance=job.provenance, notes=job.notes,
    )  # fmt: skip
    return replace(face, **more)


def split_common(sheets: Sequence[Sheet]) -> tuple[list[Part], list[Sheet]]:
    """Warnings that several sheets have in common, with the names of the channels, and the sheets without them."""
    where: dict[Note, list[str]] = {}
    for sheet in sheets:
        for note in dict.fromkeys(part for part in sheet.parts if _warns(part)):
            where.setdefault(note, []).append(sheet.name)
    common = {note: names for note, names in where.items() if len(names) > 1}
    once: list[Part] = []
    for note, names in common.items():
        which = say("all channels") if len(names) == len(sheets) else say("channels {names}", names=", ".join(names))
        once.append(replace(note, text=say("{channels}: {warning}", channels=which, warning=note.text)))
    rest: dict[Part, list[Part]] = {note: [ABOVE] * note.text.startswith(REFUSED) for note in common}
    kept = ([own for p in sheet.parts for own in (rest.get(p, [p]) if _warns(p) else [p])] for sheet in sheets)
    return once, [replace(sheet, parts=parts) for sheet, parts in zip(sheets, kept, strict=True)]


def _warns(part: Part) -> TypeGuard[Note]:
    return isinstance(part, Note) and part.level in ("alert", "warning") and not part.points


def channel_sheet(
    channel: Any, parts: Iterable[Part], verdicts: Sequence[str] = (), level: str = "", of: str = ""
) -> Sheet:
    """The sheet of a channel: its record, warnings and parts."""
    record = channel.record
    about = (words.about(record), *record.history)
    return Sheet(record.name, about, (*warnings(channel, of), *parts), verdicts, level)


def statement_note(statement: Statement, before: str = "") -> Iterator[Note]:
    """How well a model explains a record: the grade with its reasons; nothing where it was not tested."""
    if statement.grade:
        yield Note(join(": ", filter(None, (before, statement.head))), LEVELS[statement.grade], points=statement.points)


def warnings(channel: Any, of: str = "") -> Iterator[Part]:
    """The grade of the noise of a channel, its warnings, and why there is no result."""
    noise: Noise | None = getattr(channel, "noise", None)
    if noise is not None:
        yield from statement_note(noise.statement, of)
    told = () if noise is None else noise.doubts
    yield from (Note(alert, "warning") for alert in channel.alerts if alert not in told)
    if channel.refusal:
        yield Note(say("no result: {reason}", reason=channel.refusal), "alert")


def remark_notes(remarks: Iterable[Remark]) -> Iterator[Note]:
    """Remarks in full on a page: each one that is grave, and the others in a box."""
    made = [(remark, shown(replace(remark, command=""))) for remark in remarks]
    texts = [(r.grave, text if r.command in text else shown(r)) for r, text in made]
    yield from (Note(text, "alert", "page") for grave, text in texts if grave)
    mild = [text for grave, text in texts if not grave]
    yield from [Note("", "fair", "page", mild)] if mild else []


MILD = ("quantized", "heavy tails", "outliers", "lines", "shared")
"""Findings that change numbers little, or that the fit takes into account: they are told last."""

CAUSES = ("terms", *MOTION, "level")  # findings that explain a misfit, those of the largest effect first
ACCOUNTED = ("gaps",)  # findings that explain no misfit: the fit joins the samples on either side of a gap


def doubts(channels: Sequence[Any]) -> Iterator[Remark]:
    """A line for each channel without a result; those with causes of one kind and one command share it."""
    for channel in channels:
        if channel.refusal:
            name = channel.record.name or say("channel")
            yield Remark.of(join(" ", (name, say("NO RESULT"))), channel.refusal, grave=True)
    told = [
        replace(_cause(c.noise, c.quality.warnings), about=c.record.name or say("channel"))
        for c in channels
        if not c.refusal and c.noise is not None and not c.noise.explained
    ]
    for alike in kinds(told):
        named = channels_named([(why.about, str(why.clauses[0])) for why in alike], len(channels))
        what = say_count(len(alike), "{channel} DOES NOT FIT", "{channel} DO NOT FIT", channel=named)
        yield replace(alike[0], about=what)


def _cause(noise: Noise, warnings: Iterable[Finding]) -> Remark:
    """The likeliest cause why no model explains a channel, and what to type."""
    leftover = noise.residuals.findings if noise.residuals is not None else ()
    every = (f for f in (*noise.fit.findings, *leftover, *warnings) if f.name not in ACCOUNTED)
    told = [(f, Remark.about_finding("", f, grave=True)) for f in every]
    likeliest = min((pair for pair in told if pair[0].fatal or pair[1].command), key=_rank, default=None)
    why = noise.statement.points or (noise.statement.head,)
    return likeliest[1] if likeliest else Remark("", why, "allanite deviation FILE", grave=True)


def _rank(told: tuple[Finding, Remark]) -> tuple[bool, int]:
    """How far down a finding stands among those that explain a misfit."""
    finding, remark = told
    # first those that no command cures, and those whose command has values and can be typed as it is
    slight = finding.name == "level" and not finding.fatal
    known = len(CAUSES) if slight or finding.name not in CAUSES else CAUSES.index(finding.name)
    return bool(remark.command) and not any(map(str.isdigit, remark.command)), known


def alerts(study: Job[Any]) -> Iterator[Remark]:
    """What of the data makes numbers uncertain: of the file, of its channels, of all together."""
    yield from (Remark.about_finding("", finding) for finding in study.findings)
    channels = study.channels
    yield from told_of([(c.record.name, f) for c in channels if not c.refusal for f in warned(c)], len(channels))
    shared = getattr(study, "shared", None)
    yield from (Remark.about_finding("", finding) for finding in (shared.findings if shared is not None else ()))


def warned(channel: Any) -> Sequence[Finding]:
    """The findings about the data of a channel that its model does not settle."""
    findings: Sequence[Finding] = getattr(channel, "warnings", channel.quality.warnings)
    return findings


def without_repeats(first: Iterable[Remark], others: Iterable[Remark]) -> list[Remark]:
    """Remarks, and those of the others that say anything else."""
    told = list(first)
    texts = {str(remark.clauses[0]) for remark in told}
    return [*told, *(remark for remark in others if str(remark.clauses[0]) not in texts)]


def weighed(remarks: Iterable[Remark]) -> list[Remark]:
    """Those first that say that numbers are wrong."""
    return sorted(remarks, key=lambda remark: remark.name in MILD)


def reservations(channels: Sequence[Channel]) -> Iterator[Remark]:
    """Why a model that explains a channel does so with a reservation."""
    noises = [(c.record.name, c.noise) for c in channels if c.explained and c.noise is not None]
    every = [(name, (*n.fit.findings, *(n.residuals.findings if n.residuals else ()))) for name, n in noises]
    yield from told_of([(name, finding) for name, findings in every for finding in findings], len(channels))
    fits = [(c.record.name, c.fit) for c in channels if c.explained and c.fit and not c.record.signal.inertial]
    claimed = {name: ",".join([*(e.symbol for e in fit if e.claimed), "GM2"]) for name, fit in fits}
    loops = [(name, part.words) for name, fit in fits for part in fit.components if part.loop]
    yield from merged(
        Remark.of(name, say("{resonance}, as broad as that of a control loop, is a term on request ({option})",
                            resonance=part, option=f"--terms {claimed[name]}"))
        for name, part in loops
    )  # fmt: skip


def mean_and_spread(record: Record) -> tuple[float, float]:
    """Mean and standard deviation of a record, in the unit of data sheets."""
    factor = record.rate_factor * convert(1.0, record.signal.si[0], record.signal.sheet[0])
    mean, deviation = mean_and_deviation(record.steps)
    return mean * factor, deviation * abs(factor)
