"""Check for resampling: samples repeated periodically, or fast noise whose power is modulated periodically."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy

from allanite.core.arrays import FloatArray
from allanite.core.plain import Header
from allanite.core.record import Record
from allanite.core.validity import Finding, Quality
from allanite.phrases.phrase import join, percent, say

from .held import held_of, held_words
from .view import MINUTE, View

LONGEST = 1 << 18  # number of samples checked, in the middle of the record
FEWEST_RESAMPLED = 4096  # second differences in which a modulation is looked for
FINE = 0.002  # step of the samples over their fast noise up to which neighbours are hardly ever equal
FILLED = 0.005  # share of samples filled in above which it matters

DEPTH = 0.08
"""Relative modulation of the power of the fast noise above which a record is called resampled; interpolation gives
0.3.
"""

FIRST = 32  # bins of the periodogram below which there is only a changing noise level
WIDE, NARROW = 20, 0.7  # bins around a line, and the share of their power that it has in the five at its top

CONSEQUENCE = say(
    "successive samples are not independent, and the results at the shortest averaging times reflect the resampling"
)
REMEDY = say("analyze the original output of the sensor, at its own rate")


def resampled(view: View) -> Finding | None:
    """A sensor whose output was held or interpolated at another rate."""
    # Hold: samples repeat periodically. Linear interpolation: the power of the fast noise depends on the position of
    # the new sample between two original ones and is modulated at the difference of the rates. Single pulses that are
    # counted repeat with a pattern of their own.
    if view.pulses:
        return None
    return _held(view) or _interpolated(view) or _filled(view)


def _held(view: View) -> Finding | None:
    hold = held_of(view.record)
    return None if hold is None else Finding("resampled", held_words(view.rate, hold), CONSEQUENCE, REMEDY)


def interpolated_together(records: Sequence[Record | Header], qualities: Sequence[Quality]) -> list[Quality]:
    """The findings of channels without an interpolation that other channels of the same sensor do not show."""
    # a logger interpolates all of them at one rate; what modulates the noise of one alone is in the sensor
    told = list(qualities)
    for i, (record, quality) in enumerate(zip(records, qualities, strict=True)):
        if "resampled" in quality.names and isinstance(record, Record):
            own = _modulation(View(record))
            alike = [r for r in records if isinstance(r, Record) and r.signal.name == record.signal.name]
            others = [_modulation(View(r)) for r in alike if r is not record]
            if own is not None and not all(m is None or m.stands(m.place(own.beat)) for m in others):
                told[i] = Quality(tuple(f for f in quality.findings if f.name != "resampled"))
    return told


class Modulation(NamedTuple):
    """The periodogram of the power of the fast noise, normalized to its mean, at a sampling rate; the noise itself."""

    spectrum: FloatArray
    size: int
    rate: float
    bends: FloatArray

    @property
    def at(self) -> int:
        """Place of the strongest line."""
        return FIRST + int(self.spectrum[FIRST:].argmax())

    @property
    def beat(self) -> float:
        """Its frequency, Hz."""
        return self.at * self.rate / self.size

    def place(self, frequency: float) -> int:
        """Place of the strongest line near a frequency in Hz."""
        near = max(FIRST, round(frequency * self.size / self.rate) - 1)
        return near + int(self.spectrum[near : near + 3].argmax())

    def depth(self, at: int) -> float:
        """Relative amplitude of a line: the window spreads it, so that it has at most A^2 size / 6 in one bin."""
        return math.sqrt(6 * float(self.spectrum[at]) / self.size)

    def stands(self, at: int) -> bool:
        """Whether there is a narrow line, as interpolation at a constant rate makes one; bursts make a hump."""
        around = float(np.median(self.spectrum[max(FIRST, at - 200) : at + 200]))
        near = np.clip(self.spectrum[max(FIRST, at - WIDE) : at + WIDE + 1] - around, 0, None)
        narrow = self.spectrum[at - 2 : at + 3].sum() >= NARROW * near.sum()
        return bool(narrow and self.spectrum[at] >= 30 * around and self.depth(at) >= DEPTH)


def _modulation(view: View) -> Modulation | None:
    middle = max(0, (view.bent - LONGEST) // 2)
    bends, inside = view.bends(middle, min(middle + LONGEST, view.bent)), np.ones(min(view.bent, LONGEST), np.bool_)
    over = view.over - middle  # a gap has no part in the modulation
    inside[over[(over >= 0) & (over < inside.size)]] = False
    if inside.sum() < FEWEST_RESAMPLED or not view.fast:
        return None
    most = 6 * math.sqrt(6) * view.fast
    power = np.square(np.clip(bends, -most, most, out=bends))
    power /= float(power.mean(where=inside))
    power -= 1
    power[~inside] = 0.0
    return Modulation(_lines(power), power.size, view.rate, bends)


def _interpolated(view: View) -> Finding | None:
    # a sinusoid that is rounded coarsely modulates its rounding errors; interpolated samples are on no such grid
    modulation = None if view.rounding.coarse else _modulation(view)
    if modulation is None or not modulation.stands(modulation.at):
        return None
    depth, beat = modulation.depth(modulation.at), modulation.beat
    # two sinusoids beat as well, in proportion to their power: its share in narrow lines
    narrow = _lines(modulation.bends)
    size = max(narrow.size // 64, 16)
    blocks = narrow[: narrow.size // size * size].reshape(-1, size)
    high = np.where(blocks > 20 * np.median(blocks, axis=1, keepdims=True), blocks, 0.0)
    if depth < 3 * float(high.sum() / narrow.sum()):
        return None
    what = say("the power of the fast noise is modulated at {beat:.5g} Hz by {share}: the samples were interpolated, "
               "from {rate:.6g} Hz or another rate that differs by a multiple of {beat:.5g} Hz",
               beat=beat, share=percent(depth), rate=view.rate - beat)  # fmt: skip
    return Finding("resampled", what, CONSEQUENCE, REMEDY)


def _filled(view: View) -> Finding | None:
    """Samples that the logger has put in the place of lost ones."""
    held, between = filled(view)
    if not held and not between:
        return None
    parts = (
        say("{share} of the samples repeat the one before", share=percent(held)) if held else "",
        say("{share} lie midway between their neighbours to the last digit", share=percent(between)) if between else "",
    )
    # what a sample weighs in a long sum: (1 + p)/(1 - p) where it is repeated, 1 + 1.5 p where it is interpolated
    excess = math.sqrt((1 + held) / (1 - held) * (1 + 1.5 * between)) - 1
    return Finding("filled in",
        join(", ", [part for part in parts if part]),
        say("missing samples were filled in: N is too large by about {excess} if the noise is white",
            excess=percent(excess)),
        say("log nothing in their place: gaps are accounted for"),
    )  # fmt: skip


def filled(view: View) -> tuple[float, float]:
    """Shares of the samples that repeat the one before, and that lie midway between their neighbours."""
    # Only of finely resolved samples, of which hardly any do so by chance.
    least, (_, step, *most) = MINUTE * view.fast, view.sweep
    fewest = view.bent - sum(view.limited) - view.over.size
    if not view.fast or step > FINE * view.fast or max(most) <= FILLED * fewest:
        return 0.0, 0.0
    inside = np.logical_and.reduce([view.steps[1:-1] != edge for edge in view.extremes])  # clipped ones repeat, too
    inside[view.over] = False
    repeated = np.abs(np.diff(view.steps)[:-1]) < step / 2
    midway = np.abs(view.bends(0, view.bent)) < max(step / 2, least)
    counts = (np.count_nonzero(which & inside) for which in (repeated, midway & ~repeated))
    count = max(int(np.count_nonzero(inside)), 1)
    held, between = (float(many / count) if many > FILLED * count else 0.0 for many in counts)
    return held, between


def _lines(values: FloatArray) -> FloatArray:
    """Periodogram with a Hann window, normalized to 1 for white noise of variance 1."""
    window = np.hanning(values.size)
    line = scipy.fft.rfft(values * window)
    return np.asarray((np.square(line.real) + np.square(line.imag)) / float(window @ window))
