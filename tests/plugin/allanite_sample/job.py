"""A result, and the job that makes it of every channel: its least and its greatest sample."""

from collections.abc import Callable
from dataclasses import dataclass

from allanite.core.plain import Header, Value
from allanite.study.channels import Inspected, Source, run
from allanite.study.job import Job
from allanite.study.recipe import Recipe


@dataclass(frozen=True, repr=False)
class Extent(Value):
    """The least and the greatest sample of a channel."""

    record: Header
    low: float = 0.0
    high: float = 0.0
    alerts: tuple[str, ...] = ()
    refusal: str = ""


@dataclass(frozen=True, eq=False, repr=False)
class Extents(Job[Extent]):
    """Those of all channels."""

    _channel = Extent


def extents(source: Source, recipe: Recipe, progress: Callable[[str, float], None] | None = None) -> Extents:
    """The least and the greatest sample of every channel."""

    def work(seen: Inspected) -> Extent:
        values = seen.record.values
        return Extent(seen.record.header, float(min(values)), float(max(values)), seen.alerts)

    def refused(seen: Inspected, why: str) -> Extent:
        return Extent(seen.record.header, refusal=why)

    return run(Extents, source, recipe, work, refused, progress=progress)
