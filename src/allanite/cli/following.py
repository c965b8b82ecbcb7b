"""Angle sensors in service: what comes of a live source is taken in by a recursive filter until it ends."""

import math
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from dataclasses import replace
from typing import Any

from allanite.applications.angle import Calibration, Gimbals
from allanite.applications.angle.service import Service
from allanite.applications.angle.solve import quantile
from allanite.core.arrays import FloatArray
from allanite.core.errors import DataError
from allanite.core.record import Recording
from allanite.phrases.phrase import join, say, say_count
from allanite.readers.live import BreakError, Feed, arrivals, opened
from allanite.readers.sandbox.source import NamedPath, digest_of
from allanite.readers.spool import TAIL, Spool
from allanite.reporting.words import ARCSEC
from allanite.study.settings import WatchChoices

from .streams import complain, stopping

EVERY = 1.0  # seconds after which the rows that came are taken in
REPORTS = 10.0  # seconds between reports, unless others are given


@contextmanager
def follow(target: str, choices: dict[str, Any], settings: WatchChoices,
           service: Service, read: Callable[[Any, dict[str, Any]], tuple[Recording, FloatArray, Gimbals]], *,
           quiet: bool) -> Iterator[tuple[Calibration, Recording]]:  # fmt: skip
    """The estimate when the source ends, or is ended; and how its rows were read. After an error its lines stay."""
    data, reported = None, -math.inf
    feed = Feed(tap := opened(target, settings.baud))
    with closing(feed), closing(Spool(target, sent=tap.live)) as spool:
        try:
            for rows in _rows_of(target, feed, spool, settings):
                try:
                    data, z, gimbals = read(rows, choices)
                    service.add(z, gimbals)
                except DataError as error:
                    complain(str(error))
                    continue
                if choices["latitude"] is None and choices["h_polar"] is None:  # that of the first rows holds for all
                    choices["latitude"] = math.degrees(gimbals.h_polar[0])
                if not quiet and time.monotonic() >= reported + (settings.every or REPORTS):
                    reported = time.monotonic()
                    complain(_report(service, choices["level"] or 0.95))
            if data is None:
                raise DataError(say("{target!r} sent no samples", target=target))
            yield service.result(), replace(data, digest=digest_of(spool.path))
        except BaseException:
            if path := spool.stays():
                complain(say("the lines that came are kept in {path!r}", path=path))
            raise


def _rows_of(target: str, feed: Feed, spool: Spool, settings: WatchChoices) -> Iterator[NamedPath]:
    """Files of the rows that came, one after the other, the last row of each in the next, too."""
    taken, looked = 0, time.monotonic()
    with stopping() as stopped:
        for pieces, last in arrivals(feed, settings.duration, settings.idle, stopped):
            for piece in pieces:
                if isinstance(piece, BreakError):
                    spool.once |= piece.kind == "rotated"
                    if words := piece.words(target):
                        complain(words)
            if full := spool.keep(pieces, last=last):
                complain(full)
            over, rows = last or bool(full), spool.rows - taken
            if rows and (over or time.monotonic() >= looked + EVERY or rows >= TAIL // 4):
                with spool.recent(max(2, rows + 1)) as (path, _):
                    yield path
                taken, looked = spool.rows, time.monotonic()
            if over:
                return


def _report(service: Service, level: float) -> str:
    """The harmonics that are significant so far, with their limits, and the findings."""
    count = say_count(service.count, "{count} sample", "{count} samples")
    if service.waiting:
        return count
    words, result = [], service.result()
    for h in result:
        for order in filter(h.found, h.orders):
            at = h.orders.index(order)
            half = quantile(level, h.freedom) * h.amplitude_error[at] / ARCSEC
            value = f"{h.amplitude[at] / ARCSEC:.3g}" + (f" ± {half:.2g}" if result.solution.complete else "")
            words.append(say("harmonic {order} of {angle}: {amplitude} arcsec", order=order, angle=h.name,
                             amplitude=value))  # fmt: skip
    return join("; ", (count, *words, *(f.what for f in result.solution.findings)))
