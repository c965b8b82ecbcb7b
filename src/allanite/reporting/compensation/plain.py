"""A compensation for machines: CSV of the deviations before and after."""

import csv
import io
from collections.abc import Iterator
from typing import Any

from allanite.compensation.study import Compensated, CompensationStudy

COLUMNS = (
    "channel", "of", "tau_s", "m", "before", "before_low", "before_high", "after", "after_low", "after_high", "unit",
    "before_edf", "after_edf",
)  # fmt: skip


def to_csv(study: CompensationStudy) -> str:
    """Overlapping Allan deviations in data-sheet units, with limits at the recipe's level."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(COLUMNS)
    for of, channels in (("fitted", study.fitted), ("applied", study.applied)):
        for channel in channels:
            writer.writerows(_rows(channel, of, study.recipe.level))
    return out.getvalue()


def _rows(channel: Compensated, of: str, level: float) -> Iterator[list[Any]]:
    if channel.before is None or channel.after is None:
        return
    unit = channel.record.signal.sheet[0]
    before, after = channel.before.to(unit), channel.after.to(unit)
    limits = (before.interval(level), after.interval(level))
    for i, tau in enumerate(before.tau.tolist()):
        values = [
            v for c, (low, high) in zip((before, after), limits, strict=True) for v in (c.deviation[i], low[i], high[i])
        ]
        numbers = [float(v) for v in values]
        edf = [float(before.edf[i]), float(after.edf[i])]
        yield [channel.record.name, of, tau, int(before.m[i]), *numbers, unit, *edf]
