"""Watching for a week: processor time of `watch` of six channels at 200 Hz, by how long it has watched.

The code that watches is driven by a source and a clock of its own, which goes as fast as it can: a second of it brings
200 lines. Reports and looks take no time by that clock, so that none is put off. Counted is the processor time of all
but the source. The samples are white noise and a random walk, with time stamps.
"""

from table import begin, section

import time
from collections.abc import Callable, Iterator
from contextlib import closing
from functools import wraps
from types import SimpleNamespace
from typing import Any

import numpy as np
import pyarrow as pa
from pyarrow import csv

import allanite as al
from allanite.readers.spool import Spool
from allanite.study import watching
from allanite.study.watching import Watch, WatchSettings

RATE, CHANNELS = 200, 6
PERIOD_S = 600  # seconds of which the samples are made at a time
HOURS = (1, 3, 6, 12, 24, 48, 96, 168)  # after which a row is written
WORK = {"lines": (Spool, "add"), "looks": (Watch, "_look"), "reports": (Watch, "_news")}


class Source:
    """Sends the lines of a second whenever it is asked, and tells the time."""

    def __init__(self, seconds: float, told: Callable[[float], None]) -> None:
        self.now, self.seconds, self.told, self.made = 0.0, seconds, told, 0.0
        self.rng, self.bias = np.random.default_rng(1), np.zeros(CHANNELS)
        self.lines: Iterator[bytes] = iter(())

    def take(self, _: float) -> bytes:
        """The lines of the next second."""
        begun = time.process_time()
        data = next(self.lines, b"")
        if not data:
            self.lines = self.period()
            data = next(self.lines)
        self.now += 1.0
        self.made += time.process_time() - begun
        if self.now in {3600.0 * hours for hours in HOURS} or self.now >= self.seconds:
            self.told(self.now / 3600)
        return data

    def period(self) -> Iterator[bytes]:
        """The lines of ten minutes, second by second."""
        n = PERIOD_S * RATE
        steps = self.rng.normal(0.0, 1e-4, (n, CHANNELS))
        walk = self.bias + np.cumsum(steps, axis=0)
        self.bias = walk[-1]
        values = np.round(walk + self.rng.normal(size=(n, CHANNELS)), 5)
        t = np.round(self.now + np.arange(n) / RATE, 3)
        sink = pa.BufferOutputStream()
        table = pa.table([t, *values.T], names=[str(i) for i in range(CHANNELS + 1)])
        csv.write_csv(table, sink, csv.WriteOptions(include_header=False))
        lines = sink.getvalue().to_pybytes().splitlines(keepends=True)
        return iter([b"".join(lines[i : i + RATE]) for i in range(0, n, RATE)])

    def close(self) -> list[bytes]:
        """Nothing is left."""
        return []


class Meter:
    """Processor time of each kind of work, and how often it was done."""

    def __init__(self) -> None:
        self.taken: dict[str, float] = {}
        self.times: dict[str, int] = {}

    def measured(self, owner: Any, name: str, what: Callable[[], str]) -> None:
        """Measure a method, a generator until its end."""
        plain = getattr(owner, name)

        @wraps(plain)
        def method(*args: Any) -> Any:
            begun = time.process_time()
            made = plain(*args)
            made = list(made) if made is not None else made
            self.taken[what()] = self.taken.get(what(), 0.0) + time.process_time() - begun
            self.times[what()] = self.times.get(what(), 0) + 1
            return made

        setattr(owner, name, method)


def watched(hours: float) -> list[list[str]]:
    """Rows: hours, GB of lines, reports and minutes of processor of each kind of work, and of all."""
    meter, rows = Meter(), list[list[str]]()
    recipe, settings = al.Recipe(unit="deg/h", time="1"), WatchSettings(duration=3600 * hours)
    watch = Watch("port", recipe, settings)

    def kind(name: str) -> Callable[[], str]:
        return lambda: "sums" if name == "reports" and watch.passing is not None else name

    for name, (owner, method) in WORK.items():
        meter.measured(owner, method, kind(name))

    def row(hour: float) -> None:
        count, taken = meter.times.get, meter.taken.get
        parts = [taken(name, 0.0) / 60 for name in ("lines", "looks", "reports", "sums")]
        whole = (time.process_time() - begun - source.made) / 60
        assert watch.spool is not None  # noqa: S101 - it sends
        counts = (str(count(name, 0)) for name in ("looks", "reports", "sums"))
        minutes = (f"{part:.2f}" for part in (*parts, whole))
        rows.append([f"{hour:g}", f"{watch.spool.came / 1e9:.2f}", *counts, *minutes])
        print("|".join(rows[-1]), flush=True)

    begun = time.process_time()
    source = Source(3600 * hours, row)
    clock = SimpleNamespace(monotonic=lambda: source.now, sleep=lambda _: None)
    vars(watching).update(time=clock, opened=lambda *_: SimpleNamespace(live=True), Feed=lambda _: source)
    watch._begun = 0.0  # by the clock of the source
    with closing(watch):
        for _ in watch.events():
            pass
        ended = time.process_time()
        watch.study()
        print(f"the end: {time.process_time() - ended:.1f} s")
    return rows


def main() -> None:
    run = begin(__doc__, hours=24.0)
    headings = ["hours", "GB of lines", "looks", "reports", "of sums", "lines [min]", "looks [min]", "reports [min]",
                "of sums [min]", "all [min]"]  # fmt: skip
    body = section("Processor time since the beginning", headings, watched(run.asked.hours))
    run.publish("Watching", ["seed: 1"], body)


if __name__ == "__main__":
    main()
