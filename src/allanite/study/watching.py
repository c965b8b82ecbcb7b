"""Watching a live stream: its lines are kept in a file, of which a report is the analysis so far."""

import math
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace

from allanite.core.choices import choices_of, described
from allanite.core.errors import AllaniteError, DataError, UsageError
from allanite.core.kinds import KINDS, signal_of_kind
from allanite.core.readings import minimum_title
from allanite.core.record import SHORTEST, Record, Recording
from allanite.core.validity import Finding
from allanite.phrases.phrase import duration, join, percent, say, spelled
from allanite.planning.plan import further
from allanite.prepare.quality import checked
from allanite.prepare.readings import clipped, outliers, stuck
from allanite.prepare.transform import mark_motion, motion, motion_found
from allanite.readers import read
from allanite.readers.live import BreakError, Feed, arrivals, opened
from allanite.readers.parts import allowed, needed, size_in_words
from allanite.readers.sandbox.source import digest_of
from allanite.readers.spool import ENOUGH, TAIL, Spool

from .analysis import analyze, demand_shown
from .parts import Passing
from .recipe import READING, Recipe
from .results import Study
from .settings import WatchChoices

RECENT = 64.0  # seconds at the end that are looked at
GROWTH = 1.05  # of the record, after which it is looked at, or analyzed, again
REPORTS = 10.0, 3600.0  # seconds between reports, at least and at most
LOOKS = 1.0, 60.0  # seconds between looks, at least and at most; less than `RECENT`, so that no row is missed
BUDGET = 1_000_000_000  # bytes that the analysis of all samples may take for a report, unless others are given
SHARE = 10.0  # the time without a report, or a look, is at least so many times that of the last one
LONGEST = 366 * 86400.0  # seconds that a stream lasts at most, by which choices are judged before it begins

AT_ONCE = ("moving", "outliers", "stuck", "clipped", "missing samples")
"""Findings that are said as soon as they are made in the last minute."""

CHECKS = stuck, clipped, outliers
"""The checks that make them, beside motion and the clock."""


@described
@dataclass(frozen=True)
class WatchSettings(WatchChoices):
    """How to watch: seconds between reports, to the end, and without data until the end; baud rate; accuracy wanted."""

    # `duration` and `idle` are infinite by default: it is the user who ends. The lines that come are kept in the new
    # file `record`, if it is given; it is no choice of the page, which names no files to write.
    record: str | None = None
    force: bool = False  # overwrite it


@dataclass
class Task:
    """Something that is done again and again, as the record grows."""

    work: Callable[[], Iterator[str]]
    least: float  # seconds between two times; at most where the record grows slowly
    most: float
    last: float
    rows: int = 0

    def due(self, now: float, rows: int) -> bool:
        """Whether it is to be done now, with so many rows."""
        wait = self.least if rows >= GROWTH * self.rows else self.most
        return rows >= ENOUGH and rows > self.rows and now - self.last >= wait

    def done(self, begun: float, now: float, rows: int) -> None:
        """It was done with so many rows, and takes a small share of the time."""
        self.last, self.rows = begun + max(0.0, SHARE * (now - begun) - self.least), rows


@dataclass
class Watch:
    """A stream of channels that is watched."""

    target: str
    recipe: Recipe
    settings: WatchSettings = WatchSettings()
    stopped: Callable[[], bool] = lambda: False
    latest: Study | None = None
    findings: dict[str, Finding] = field(default_factory=dict)
    spool: Spool | None = None
    passing: Passing | None = None
    _said: dict[tuple[str, str], float] = field(default_factory=dict)
    _rate: float = 0.0
    _stamped: bool = False
    _rows: int = -1
    _gone_at: float = 0.0
    _many: dict[str, int] = field(default_factory=dict)  # times that something happened to the source
    _unread: bool = False
    _in_memory: bool = False  # whatever it takes, since it cannot be read in parts

    def __post_init__(self) -> None:
        recipe = self.recipe = replace(self.recipe, motion=self.recipe.motion or "mark")
        longest = min(self.settings.duration, LONGEST)
        for key, samples in (("average", SHORTEST), ("start", 1), ("quiet_window", 1)):
            if samples * (time := getattr(recipe, key) or 0.0) > longest:
                (option, *_), most = choices_of(Recipe)[key].options, duration(longest / samples)
                raise UsageError(f"{spelled(option, key)} is at most {most} in a stream of at most "
                                 f"{duration(longest)}, not {time:g} s", choice=key)  # fmt: skip
        if recipe.to and recipe.unit and "=" not in recipe.unit and recipe.scale is None:
            unit, kinds = str(recipe.unit), [recipe.kind] if recipe.kind else KINDS
            if signals := [*filter(None, (signal_of_kind(unit, kind) for kind in kinds))]:
                demand_shown(recipe, signals)

    def events(self) -> Iterator[str]:
        """Read until the end, and say what happens."""
        tap = opened(self.target, self.settings.baud)
        try:
            spool = self.spool = Spool(self.target, self.settings.record, sent=tap.live, force=self.settings.force)
        except UsageError:
            tap.close()
            raise
        feed, every, now = Feed(tap), self.settings.every, time.monotonic()
        tasks = (Task(self._look, *LOOKS, now),
                 Task(self._news, *(REPORTS if every is None else (every, every)), now))  # fmt: skip
        yield say("watching {target!r}", target=self.target)
        try:
            for pieces, over in arrivals(feed, self.settings.duration, self.settings.idle, self.stopped):
                for piece in pieces:
                    yield from self._broken(piece) if isinstance(piece, BreakError) else ()
                if full := spool.keep(pieces, last=over):
                    remedy = say("free some space, or keep the lines on another disk ({option})",
                                 option=spelled("--record PATH", "record="))  # fmt: skip
                    self.findings["disk"] = Finding("disk", full, remedy=remedy)
                    yield str(self.findings["disk"])
                    break
                now = time.monotonic()
                for task in () if over else tasks:
                    if task.due(now, spool.rows):
                        yield from task.work()
                        task.done(now, time.monotonic(), spool.rows)
        finally:
            spool.keep(feed.close(), last=True)
        self._unread = True  # the analysis of all rows says it, if it is so
        yield from self._look()

    def _news(self) -> Iterator[str]:
        """A report, and before the first one of sums what they are."""
        whole, report = self.passing is None, self.report()
        if whole and self.passing is not None:
            limit = size_in_words(self.passing.reader.limit)
            yield say("an analysis of all samples would take more than {limit} of memory ({option}); from now on curve "
                      "and coefficients are those of sums to which new samples are added", limit=limit,
                      option=spelled("--memory", "memory"))  # fmt: skip
        yield report

    def report(self) -> str:
        """Length, coefficients so far, and when more will be known."""
        try:
            study = self._study()
        except AllaniteError as error:
            if isinstance(error, UsageError) and self.latest is None:
                raise
            return str(error)
        lines = []
        for channel in study:
            record, fit, read = channel.record, channel.fit, channel.readings
            words: list[str] = [say("{channel}: {duration:.4g} s", channel=record.name, duration=record.duration)]
            if fit is None:
                lines.append(join("; ", (*words, channel.refusal)))
                continue
            if read is not None and read.minimum is not None:
                words.append(join(" ", (minimum_title(record.signal), read.lowest_words(study.recipe.level))))
            values = [(e.symbol, e.words(level=study.recipe.level)) for e in fit if e.claimed]
            words += [say("{symbol} = {value}", symbol=symbol, value=value) for symbol, value in values]
            why = channel.noise.rejection if channel.noise is not None else ""
            words += [why] if why else [finding.what for finding in fit.findings]
            usable = fit.usable(unexplained=True)
            for name, rest in further(usable, record.size, record.rate, self.settings.accuracy).items():
                if 0 < rest < math.inf:
                    facts = {"time": duration(float(f"{rest:.2g}")), "share": percent(self.settings.accuracy)}
                    words.append(say("about {time} more until {symbol} is known to {share}", symbol=name, **facts))
            lines.append(join("; ", words))
        return "\n".join(lines)

    def study(self) -> Study:
        """What `analyze` gives of the lines that came."""
        try:
            study = self._study(last=True)
        except AllaniteError as error:
            if self.spool is None or not (path := self.spool.stays()):
                raise
            raise error.within(say("the lines that came, kept in {path!r}, cannot be analyzed", path=path)) from None
        notes, provenance = (*study.notes, say("watched as a stream")), study.provenance
        if self.spool is not None and "sha256" not in provenance:
            provenance = provenance | {"sha256": digest_of(self.spool.path)}
        return replace(study, findings=(*study.findings, *self.findings.values()), notes=notes, provenance=provenance)

    @contextmanager
    def keeping(self, tell: Callable[[str], None]) -> Iterator[None]:
        """Within it the lines that came are kept: after an error for good, unless the source has them."""
        try:
            yield
        except BaseException as error:
            told = not self._rate and isinstance(error, UsageError)
            if not told and self.spool is not None and (path := self.spool.stays()):
                tell(say("the lines that came are kept in {path!r}", path=path))
            raise
        finally:
            self.close()

    def close(self) -> None:
        """Remove the lines that came, unless they are to stay."""
        if self.spool is not None:
            self.spool.close()

    def _study(self, *, last: bool = False) -> Study:
        if self.spool is None or not self.spool.came:
            raise DataError(say("{target!r} sent no samples", target=self.target))
        if not self.spool.rows:
            raise DataError(say("{target!r} sends no rows of numbers; a binary or packed file is for {command}",
                                target=self.target, command=f"'allanite analyze {self.target}'"))  # fmt: skip
        if self.latest is None or self._rows != self.spool.rows or (last and self.passing is not None):
            self.latest, self._rows = self._analyzed(self.spool, last=last), self.spool.rows
        return self.latest

    def _analyzed(self, spool: Spool, *, last: bool) -> Study:
        """The analysis of all samples, or, where it takes more memory than the budget, of sums that are carried on."""
        limit = allowed(self.recipe.memory)
        if not last and self.recipe.memory is None:
            limit = min(limit, BUDGET)
        channels = len(self.latest.channels) if self.latest else spool.width
        try:
            if not self._in_memory and needed(spool.rows * channels) > limit:
                self.passing = self.passing or Passing.of(spool, self.recipe, limit)
                self._in_memory = self.passing is None
                if self.passing is not None:
                    self.passing.reader = replace(self.passing.reader, limit=limit)
                    return analyze(self.passing, self.recipe)
        except AllaniteError as error:  # which the whole file tells, too, or of what needs all samples
            self.passing, self._in_memory = None, isinstance(error, UsageError)
        try:
            return analyze(spool, self.recipe)
        except DataError as error:
            self.passing = None
            with spool.mended(error) as path:
                return analyze(path, self.recipe)

    def _look(self) -> Iterator[str]:
        """Look at the last minute as at a record of its own, and say what is new."""
        try:
            recent = self._recent()
        except AllaniteError as error:
            if not self._rate and isinstance(error, UsageError):  # it has never been read
                raise
            yield from () if self._unread else (say("the last rows cannot be analyzed: {why}", why=str(error)),)
            self._unread = True
            return
        self._unread = False
        with suppress(DataError):
            yield from self._new("", recent.findings)
            records: Sequence[Record] = recent.records
            if self.recipe.motion == "mark" and (moved := motion(records)).any():
                yield from self._new("", [motion_found(records[0], moved)])
                records = mark_motion(records)
            for record in records:
                yield from self._new(record.name, checked(record, CHECKS).findings)

    def _recent(self) -> Recording:
        assert self.spool is not None  # noqa: S101 - it is made before anything is looked at
        try:
            recording, before = self._read(self.spool)
        except DataError as error:
            with self.spool.mended(error):
                recording, before = self._read(self.spool, mended=True)
            self.passing = None
        if not self._rate:
            demand_shown(self.recipe, (record.signal for record in recording))
        self._rate, self._stamped = recording[0].rate, recording[0].start is not None
        placed = tuple(replace(record, cut=before / record.rate) for record in recording)
        return replace(recording, records=placed)

    def _read(self, spool: Spool, *, mended: bool = False) -> tuple[Recording, int]:
        """The last minute, and how many rows are before it."""
        with spool.recent(round(RECENT * self._rate) or TAIL, mended=mended) as (path, before):
            return read(path, **self.recipe.to_dict(READING)), before

    def _new(self, channel: str, findings: Sequence[Finding]) -> Iterator[str]:
        """Sentences about findings that begin after those that were said."""
        for finding in findings:
            if finding.name not in AT_ONCE:
                continue
            begin, end = finding.place or (0.0, 0.0)
            if begin >= self._said.get((channel, finding.name), -math.inf):
                yield join(": ", (channel, str(finding))) if channel else str(finding)
            elif end <= self._said[channel, finding.name]:
                continue
            self._said[channel, finding.name] = end or math.inf

    def _broken(self, what: BreakError) -> Iterator[str]:
        """What happened to the source; the time without one that is gone is a gap, unless it is a file."""
        assert self.spool is not None  # noqa: S101 - it is made before
        self.spool.once |= what.kind == "rotated"
        times = self._many[what.kind] = self._many.get(what.kind, 0) + 1
        now, target = time.monotonic(), self.target
        if what.kind == "gone":
            self._gone_at = now
        if what.kind == "back" and self.spool.sent:
            with suppress(AllaniteError):
                self._rate or self._recent()
            what.lost = round((now - self._gone_at) * self._rate)
        if words := what.words(target):
            yield words
        if self._stamped:
            what.lost = 0  # time stamps tell it themselves
        many = {"gone": ("unplugged", say("{target!r} was gone {times} times", target=target, times=times)),
                "rotated": ("rotated", say("{target!r} became shorter or was replaced {times} times; rows without "
                                           "time stamps were joined without a gap", target=target, times=times)),
                }  # fmt: skip
        if what.kind in many:
            name, again = many[what.kind]
            self.findings[name] = Finding(name, words if times == 1 else again)
