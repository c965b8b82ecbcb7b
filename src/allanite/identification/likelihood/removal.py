"""A record without the sinusoids in it."""

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.fit import Line
from allanite.core.record import Record
from allanite.phrases.phrase import say_count
from allanite.prepare.gaps import known_rates

from .lines import levels, suspected, waves_of
from .model_selection import Found
from .scope import behind_filter


def without_lines(record: Record, found: Found, band: tuple[float, float] | None) -> tuple[tuple[Line, ...], Record]:
    """The sinusoids of a record whose noise was looked at, and the rest of it; the record itself if there are none."""
    seen, level = found.seen, _level(found)
    if not suspected(seen, level, found.used):
        return (), record
    # between the lobes of a filter the noise is low, and what is at their tops is no line
    level = _level(behind_filter(found.base))
    if not suspected(seen, level, found.used):
        return (), record
    rates = known_rates(record)
    mean = float(np.nanmean(rates))
    low, high = (0.0, record.rate / 2) if band is None else band
    waves, _ = waves_of(rates - mean, seen, level, (low / record.rate, high / record.rate))
    if not waves:
        return (), record
    scale = [seen.unit_factor / float(np.sinc(wave.frequency)) for wave in waves]
    lines = tuple(
        Line(wave.frequency * record.rate, wave.amplitude * s, wave.error * s, wave.phase, record.signal)
        for wave, s in zip(waves, scale, strict=True)
    )
    # the record without sinusoids; an angle stays one, which knows more of its gaps; counts become increments
    total = np.sum([wave.values(record.size) for wave in waves], axis=0)
    if record.kind == "angle":
        total = np.concatenate(([0.0], np.cumsum(total)))
    return tuple(sorted(lines, key=lambda line: line.frequency)), record.with_values(
        record.values - total,
        say_count(len(waves), "{count} sinusoid removed", "{count} sinusoids removed"),
        start=record.start,
    )


def _level(found: Found) -> FloatArray:
    """The power of the noise in every bin."""
    m = found.seen.power.copy()
    m[found.used] = found.chosen.likelihood.expectation(found.chosen.theta)
    return levels(found.seen, m)
