"""A record without the sinusoids in it."""

import numpy as np

from allanite.fit import Line
from allanite.record import Record

from .families import Found
from .lines import levels, suspected, waves_of


def without_lines(record: Record, found: Found, band: tuple[float, float] | None) -> tuple[tuple[Line, ...], Record]:
    """The sinusoids of a record whose noise was looked at, and the rest of it; the record itself if there are none."""
    seen = found.seen
    m = np.full(seen.power.size, np.nan)
    m[found.used] = found.chosen.likelihood.expectation(found.chosen.theta)
    level = levels(seen, np.where(np.isfinite(m), m, seen.power))
    if not suspected(seen, level, found.used):
        return (), record
    rates = record.rate_values / seen.unit_factor
    mean = float(np.nanmean(rates))
    low, high = (0.0, record.rate / 2) if band is None else band
    waves, left = waves_of(rates - mean, seen, level, (low / record.rate, high / record.rate))
    if not waves:
        return (), record
    scale = [seen.unit_factor / float(np.sinc(wave.frequency)) for wave in waves]
    lines = tuple(
        Line(wave.frequency * record.rate, wave.amplitude * s, wave.error * s, wave.phase, record.signal)
        for wave, s in zip(waves, scale, strict=True)
    )
    rest = Record((left + mean) * seen.unit_factor, record.rate, record.signal.unit, name=record.name)
    return tuple(sorted(lines, key=lambda line: line.frequency)), rest
