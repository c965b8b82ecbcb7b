"""Watching a live stream: reading, what is known so far and when more will be, and the study at the end."""

import math
import time
from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from allanite.core.curve import Curve
from allanite.core.errors import DataError, UsageError
from allanite.core.finding import Finding, Quality
from allanite.core.fit import Fit
from allanite.core.header import Header
from allanite.phrases.phrase import join, say
from allanite.phrases.wording import percent
from allanite.planning.plan import plan
from allanite.stream.accumulator import Accumulator
from allanite.study.analysis import Channel, Study
from allanite.study.channels import demand_result
from allanite.study.noise import Noise
from allanite.study.provenance import provenance_of
from allanite.study.recipe import Recipe
from allanite.study.settings import WatchChoices

from .lines import Lines, places
from .monitor import Monitor
from .sources import WAIT, Feed, opened

AGAIN = 0.5
"""Seconds between attempts to open a port that is gone."""

JITTER = 1.5
"""Sample intervals between two time stamps from which samples are missing."""


@dataclass(frozen=True)
class WatchSettings(WatchChoices):
    """How to watch: seconds between reports, until the end, and without data until the end; baud rate; accuracy wanted.

    `duration` and `idle` are infinite by default: it is the user who ends.
    """


@dataclass
class Watch:
    r"""A stream of channels that is watched.

    `events` are sentences about what happens, when it happens: motion, a device that is gone or back, a report.

    Examples
    --------
    >>> import tempfile
    >>> rng = np.random.default_rng(1)
    >>> with tempfile.NamedTemporaryFile("w", suffix=".txt") as file:
    ...     _ = file.write("".join(f"{v:.6f}\n" for v in rng.normal(0.0, 2.0, 5000)))
    ...     file.flush()
    ...     watch = Watch(file.name, Recipe(rate=100.0, unit="deg/h"), WatchSettings(idle=0.1))
    ...     for words in watch.events():
    ...         pass
    >>> watch.study()[0].fit["N"].status
    'identified'
    """

    target: str
    recipe: Recipe
    settings: WatchSettings = WatchSettings()
    stopped: Callable[[], bool] = lambda: False
    monitors: dict[str, Monitor] = field(default_factory=dict)
    lines: Lines = field(default_factory=Lines)
    findings: list[Finding] = field(default_factory=list)
    _stamp: float | None = None
    _columns: tuple[dict[str, int], int | None] | None = None

    def __post_init__(self) -> None:
        missing = [name for name in ("rate", "unit") if getattr(self.recipe, name) is None]
        if missing:
            options = " and ".join(f"--{name}" for name in missing)
            raise UsageError(f"a stream does not say its {' and '.join(missing)}: give {options}")
        self._stream("")  # impossible choices are refused now

    def events(self) -> Iterator[str]:
        """Read until the end, and say what happens."""
        feed = Feed(opened(self.target, self.settings.baud))
        yield say("watching {target!r}", target=self.target)
        begun = last = reported = time.monotonic()
        try:
            while not self.stopped():
                try:
                    data = feed.take(WAIT)
                except OSError as error:
                    yield self._gone(str(error))
                    feed = yield from self._again(feed)
                    continue
                now = time.monotonic()
                last = now if data else last
                yield from self._take(data)
                if now - reported >= self.settings.every and self.monitors:
                    reported = now
                    yield self.report()
                if now - begun >= self.settings.duration or now - last >= self.settings.idle:
                    break
        finally:
            rest = feed.close()
        for data in rest:
            yield from self._take(data)

    def report(self) -> str:
        """Size, coefficients so far, and when more will be known."""
        return "\n".join(_reported(name, monitor, self) for name, monitor in self.monitors.items())

    def study(self) -> Study:
        """What `analyze` would give: coefficients and curve of every channel.

        Raises
        ------
        DataError
            No channel has enough samples.
        """
        if not self.monitors:
            raise DataError(say("{target!r} sent no samples", target=self.target))
        channels = tuple(self._channel(monitor) for monitor in self.monitors.values())
        demand_result(tuple(self.monitors), channels)
        made = provenance_of() | {"source": self.target}
        return Study(channels, self.recipe, tuple(self.findings), (), made)

    def fit(self, monitor: Monitor) -> Fit:
        """The coefficients of a channel so far."""
        return monitor.stream.fit(self.recipe.terms, band=self.recipe.band)

    def _channel(self, monitor: Monitor) -> Channel:
        monitor.finish()
        stream = monitor.stream
        like, quality = stream.like, Quality(monitor.findings())
        header = Header(like.name, like.rate, stream.stop - stream.start, like.unit, like.kind, like.scale, None,
                        (say("watched as a stream"),), like.signal)  # fmt: skip
        try:
            fit = self.fit(monitor)
            curve: Curve = stream.curve(fit)
        except DataError as error:
            return Channel(header, quality, refusal=str(error))
        noise = Noise(replace(fit, curve=curve))
        return Channel(header, quality, noise, curves=(curve,)).to(*(self.recipe.to or ()))

    def _stream(self, name: str) -> Accumulator:
        made = self.recipe
        unit, rate = str(made.unit), float(made.rate or 0.0)
        scale = None if made.scale is None else float(made.scale)
        kind = "increment" if made.kind == "angle" else made.kind or "rate"  # a monitor takes differences
        return Accumulator(rate, unit, kind, scale=scale, name=name, statistic=made.statistic)

    def _take(self, data: bytes) -> Iterator[str]:
        rows = self.lines.rows(data) if data else []
        if not rows:
            return
        if self._columns is None:
            self._columns = places(self.lines, self.recipe.channels, self.recipe.time)
            points = self.recipe.kind == "angle"
            self.monitors |= {name: Monitor(self._stream(name), points=points) for name in self._columns[0]}
        table = np.array(rows)
        clock = self._columns[1]
        cuts = [] if clock is None else self._gaps(table[:, clock])
        begin = 0
        for at, lost in [*cuts, (len(table), 0)]:
            for name, column in self._columns[0].items():
                monitor = self.monitors[name]
                found = monitor.push(table[begin:at, column])
                for one in found + (monitor.gap(lost) if lost else []):
                    yield say("{channel}: {reason}", channel=name, reason=str(one))
            begin = at

    def _gaps(self, stamps: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> list[tuple[int, int]]:
        """Rows before which samples are missing, and how many."""
        before = math.nan if self._stamp is None else self._stamp
        steps = np.diff(np.append(before, stamps)) * float(self.recipe.rate or 1.0)
        if np.isfinite(stamps[-1]):
            self._stamp = float(stamps[-1])
        return [(int(i), round(float(steps[i])) - 1) for i in np.flatnonzero(steps > JITTER)]

    def _gone(self, reason: str) -> str:
        self.lines.torn()
        what = say("{target!r} is gone ({reason}); waiting for it", target=self.target, reason=reason)
        self.findings.append(Finding("unplugged", what))
        return what

    def _again(self, feed: Feed) -> Generator[str, None, Feed]:
        """Wait until the source is back; the time without it is a gap."""
        feed.close()
        begun = time.monotonic()
        while not self.stopped() and time.monotonic() - begun < self.settings.idle:
            time.sleep(AGAIN)
            try:
                feed = Feed(opened(self.target, self.settings.baud))
            except DataError:
                continue
            lost = round((time.monotonic() - begun) * float(self.recipe.rate or 0.0))
            for name, monitor in self.monitors.items():
                for one in monitor.gap(lost):
                    yield say("{channel}: {reason}", channel=name, reason=str(one))
            yield say("{target!r} is back; {lost} samples are missing", target=self.target, lost=lost)
            break
        return feed


def _reported(name: str, monitor: Monitor, watch: Watch) -> str:
    stream = monitor.stream
    rate = stream.like.rate
    known = say("{channel}: {duration:.4g} s", channel=name, duration=stream.size / rate)
    try:
        fit = watch.fit(monitor)
        curve = stream.curve()
    except DataError as error:
        return join("; ", (known, str(error)))
    lowest = int(curve.variance.argmin())
    unit = stream.like.signal.sheet[0]
    shown = say("{title} {value:.3g} {unit} at {tau:.3g} s", title=curve.statistic,
                value=curve.to(unit).deviation[lowest], unit=unit, tau=curve.tau[lowest])  # fmt: skip
    claimed = (say("{symbol} = {value}", symbol=e.symbol, value=e.words()) for e in fit if e.claimed)
    return join("; ", (known, shown, *claimed, *_waits(fit, stream.size, rate, watch.settings.accuracy)))


def _waits(fit: Fit, size: int, rate: float, accuracy: float) -> list[str]:
    """How much longer it takes until each coefficient is known to an accuracy, from the Cramer-Rao bound."""
    found = plan(fit.model, rate, durations=(), accuracy=accuracy)
    missing = [(name, float(needed) - size / rate) for name, needed in zip(found.names, found.needed, strict=True)]
    return [
        say("about {time} more until {symbol} is known to {share}", time=lasting(left), symbol=name,
            share=percent(accuracy))
        for name, left in missing
        if 0 < left < math.inf
    ]  # fmt: skip


def lasting(seconds: float) -> str:
    """A length of time with its unit, to two digits.

    Examples
    --------
    >>> lasting(5.3), lasting(840.0), lasting(7200.0)
    ('5.3 s', '14 min', '2 h')
    """
    for size, unit in ((3600.0, "h"), (60.0, "min")):
        if seconds >= 2 * size:
            return f"{float(f'{seconds / size:.2g}'):g} {unit}"
    return f"{seconds:.2g} s"
