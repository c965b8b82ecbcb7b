"""What a fit says besides its numbers: the frequencies for which it holds, and which models could take its place."""

from typing import Any

import numpy as np

from allanite.core.arrays import BoolArray
from allanite.core.estimate import Estimate
from allanite.core.titles import title_of
from allanite.core.validity import LowPass, Scope
from allanite.phrases.phrase import say
from allanite.terms import TERMS

from .cells import WELL_KNOWN, surroundings
from .filters import FILTERS
from .model_selection import DISTINGUISHABLE, SLOW, Found, lacking
from .tuning import limits

CONFIDENT = 3.84
"""Rise of 2 L at the 95 % limits of a cut-off."""

CHANGED = 0.2
"""Relative difference of the level outside a band from that inside, above which it has a cause."""

STANDS_OUT = 1.5
"""Peak over mean power outside a band above which a frequency is mentioned."""


def scope_of(found: Found, choice: str, asked: tuple[float, float] | None = None) -> Scope:
    """The scope of a fit; `asked` is a band that was given."""
    # the gain of the filter, with what is added, where the fit reads; elsewhere what was observed, smoothed
    seen, used, part = found.seen, found.used, found.shaped
    ratio = seen.power / found.expected_power
    around = surroundings(ratio * seen.count).sum(axis=1) / surroundings(seen.count).sum(axis=1)
    known = np.where(seen.count > WELL_KNOWN, ratio, around)
    level = np.where(used, found.part.passed + found.part.added / found.expected_power, known)
    # the limits of the frequencies used, Hz; 0 and half the sampling rate if nothing is excluded
    first, last = np.flatnonzero(used)[[0, -1]]
    low = float(seen.frequency(seen.first[first])) if first else 0.0
    high = seen.first[last] + seen.count[last] - 0.5
    band = asked or (low, seen.rate / 2 if last == used.size - 1 else float(seen.frequency(high)))
    low_pass = None
    if part.filter is not None:
        row, rate, ends = part.filter.row, seen.rate, limits(part, part.filter, CONFIDENT)
        low_pass = LowPass(row, FILTERS[row].title, part.filter.cutoff * rate, ends[0] * rate, ends[1] * rate, rate)
    return Scope(
        choice=choice,
        band=band,
        masks=_masks(found, asked),
        filter=low_pass,
        misfit=found.part.misfit,
        within=found.largest_misfit if found.part.misfit else 0.0,
        frequency=seen.frequency(seen.first + (seen.count - 1) / 2),
        level=level,
        remarks=_outside(found, band) if choice == "auto" else (),
    )


def _masks(found: Found, asked: tuple[float, float] | None) -> tuple[tuple[float, float], ...]:
    """Runs of bins that are not read between the ends, or in the band that was asked for, Hz."""
    seen, there = found.seen, np.flatnonzero(found.used if asked is None else found.seen.within(asked))
    out = ~found.used
    out[: there[0]] = out[there[-1] :] = False
    ends = np.flatnonzero(np.diff(np.concatenate(([0], out.astype(np.int8), [0])))).reshape(-1, 2)
    return tuple(
        (float(seen.frequency(seen.first[a] - 0.5)), float(seen.frequency(seen.first[b - 1] + seen.count[b - 1] - 0.5)))
        for a, b in ends
    )


def _outside(found: Found, band: tuple[float, float]) -> tuple[str, ...]:
    """Behaviour of the spectrum beyond the ends of the band, by its own levels: no model holds there."""
    used, frequency = found.used, found.seen.first
    first, last = map(int, np.flatnonzero(used)[[0, -1]])
    below, above = used & (frequency < 2 * frequency[first]), used & (frequency > frequency[last] / 2)
    ends = (
        (say("below {frequency:.3g} Hz", frequency=band[0]), slice(0, first), below, say("drift or motion")),
        (say("above {frequency:.3g} Hz", frequency=band[1]), slice(last + 1, None), above,
         say("vibration or interference")),
    )  # fmt: skip
    return tuple(_beyond(where, found, part, inside, cause) for where, part, inside, cause in ends if used[part].size)


def _beyond(where: str, found: Found, part: slice, inside: BoolArray, cause: str) -> str:
    """The median level of an excluded part, over that of the octave next to it, and its highest peak."""
    power, seen = found.seen.power[part], found.seen
    octave = float(np.median(seen.power[inside]))
    ratio, highest = float(np.median(power)) / octave, int(power.argmax())
    odd: dict[str, Any] = {"where": where, "cause": cause, "ratio": ratio}
    peak = float(power[highest]) / octave
    if seen.count[part][highest] > WELL_KNOWN and peak > STANDS_OUT * max(ratio, 1.0):
        odd |= {"peak": peak, "frequency": float(seen.frequency(seen.first[part][highest]))}
        return say(
            "{where} the median power is {ratio:.2g} times that of the octave next to it, and {peak:.2g} times at "
            "{frequency:.3g} Hz: {cause}",
            **odd,
        )
    if ratio > 1 + CHANGED:
        return say("{where} the median power is {ratio:.2g} times that of the octave next to it: {cause}", **odd)
    return say("{where} the median power is {ratio:.2g} times that of the octave next to it", **odd)


def notes_of(estimates: dict[str, Estimate], found: Found) -> list[str]:
    """What Gauss-Markov noise is, and which terms of the best model others could replace."""
    time = found.chosen.constants[0] if len(found.chosen.constants) == 1 else SLOW
    notes = []
    if time < SLOW:
        notes = [
            say(
                "the Gauss-Markov noise has a time constant of {count:.2g} samples: noise that a filter or a vibration "
                "correlates, no drift of the bias",
                count=time,
            )
        ]
    notes += [
        say(
            "{term} ({symbol}) is in the best model, but other terms could take its place: a longer record would "
            "decide",
            term=title_of(s, estimates[s].signal),
            symbol=s,
        )
        for s, free in zip(found.noise, found.chosen.free, strict=True)
        if free and s in estimates and estimates[s].status == "absent"
    ]
    return notes + _ambiguous(found)


def _ambiguous(found: Found) -> list[str]:
    """How well Gauss-Markov noise instead of flicker, or the reverse, would describe the record."""
    if found.search is None or found.markov is None or found.flicker is None:
        return []
    if not set(found.search.symbols) <= {TERMS[symbol].substitute for symbol in found.noise}:
        return []
    gain = found.flicker.aic - found.markov.aic
    size, time = f"{-gain:+.1f}", found.markov.constants[0] / found.seen.rate
    if found.chosen is found.markov:
        return [
            say("Gauss-Markov noise with a time constant of {time:.2g} s describes the record better than flicker does",
                time=time)
        ]  # fmt: skip
    if abs(gain) < DISTINGUISHABLE:
        return [
            say(
                "Gauss-Markov noise with a time constant of {time:.2g} s instead of flicker would describe the record "
                "equally well: they cannot be distinguished (AIC {gain})",
                time=time, gain=size,
            )
        ]  # fmt: skip
    needed = gain + lacking(found.plain, found.markov, found.part)
    if gain < 0 or needed <= gain:  # it is not missed, or it does not explain the record
        return []
    return [
        say(
            "Gauss-Markov noise with a time constant of {time:.2g} s would describe the record better (AIC {gain}; it "
            "is claimed from -{needed:.0f} on): a longer record would decide",
            time=time, gain=size, needed=needed,
        )
    ]  # fmt: skip
