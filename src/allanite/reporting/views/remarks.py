"""Remarks of the first screen of a recording: what has no result, what is uncertain, and what to type."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any

from allanite.core.finding import MOTION, Finding
from allanite.phrases.phrase import join, say, say_count
from allanite.reporting.first import Remark, kinds, sharing, told_of
from allanite.study.job import Job
from allanite.study.results import Channel, Noise

MILD = ("quantized", "heavy tails", "outliers", "lines", "shared")
"""Findings that change numbers little, or that the fit takes into account: they are told last."""

CAUSES = ("terms", *MOTION)
"""Findings that explain a misfit, the likeliest first."""

ACCOUNTED = ("gaps",)
"""Findings that explain no misfit: the fit joins the samples on either side of a gap."""


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
        named = sharing([(why.about, str(why.clauses[0])) for why in alike], len(channels))
        what = say_count(len(alike), "{channel} DOES NOT FIT", "{channel} DO NOT FIT", channel=named)
        yield replace(alike[0], about=what)


def _cause(noise: Noise, warnings: Iterable[Finding]) -> Remark:
    """The likeliest cause why no model explains a channel, and what to type."""
    left = noise.residuals.findings if noise.residuals is not None else ()
    every = (f for f in (*noise.fit.findings, *left, *warnings) if f.name not in ACCOUNTED)
    told = [(f, Remark.about_finding("", f, grave=True)) for f in every]
    likeliest = min((pair for pair in told if pair[0].fatal or pair[1].command), key=_rank, default=None)
    why = noise.statement.points or (noise.statement.head,)
    return likeliest[1] if likeliest else Remark("", why, "allanite deviation FILE", grave=True)


def _rank(told: tuple[Finding, Remark]) -> tuple[bool, int]:
    """How far down a finding stands among those that explain a misfit.

    First those that no command cures, and those whose command has values and can be typed as it is.
    """
    finding, remark = told
    known = CAUSES.index(finding.name) if finding.name in CAUSES else len(CAUSES)
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
    found: Sequence[Finding] = getattr(channel, "warnings", channel.quality.warnings)
    return found


def told_once(first: Iterable[Remark], others: Iterable[Remark]) -> list[Remark]:
    """Remarks, and those of the others that say anything else."""
    told = list(first)
    said = {str(remark.clauses[0]) for remark in told}
    return [*told, *(remark for remark in others if str(remark.clauses[0]) not in said)]


def weighed(remarks: Iterable[Remark]) -> list[Remark]:
    """Those first that say that numbers are wrong."""
    return sorted(remarks, key=lambda remark: remark.name in MILD)


def reservations(channels: Sequence[Channel]) -> Iterator[Remark]:
    """Why a model that explains a channel does so with a reservation."""
    noises = [(c.record.name, c.noise) for c in channels if c.explained and c.noise is not None]
    every = [(name, (*n.fit.findings, *(n.residuals.findings if n.residuals else ()))) for name, n in noises]
    yield from told_of([(name, finding) for name, found in every for finding in found], len(channels))
