"""The frequencies for which a model holds, as a value with texts."""

from typing import Any

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.language import say
from allanite.core.scope import LowPass, Scope

from .cells import cell_of, surroundings
from .families import Found
from .filters import FILTERS
from .tuning import limits

CONFIDENT = 3.84
"""Rise of 2 L at the 95 % limits of a cut-off."""

WELL_KNOWN = 50
"""Coefficients of a bin whose power needs no smoothing."""

CHANGED = 0.2
"""Relative deviation of the spectrum from the model outside a band above which it is mentioned."""

STANDS_OUT = 1.5
"""Peak over mean power outside a band above which a frequency is mentioned."""


def scope_of(found: Found, choice: str, asked: tuple[float, float] | None = None) -> Scope:
    """The scope of a fit; `asked` is a band that was given."""
    seen, level = found.seen, _levels(found)
    band = asked or _band(found)
    return Scope(
        choice=choice,
        band=band,
        masks=_masks(found, asked),
        filter=_filter(found),
        misfit=found.part.misfit,
        within=largest_misfit(found) if found.part.misfit else 0.0,
        frequency=seen.frequency(seen.first + (seen.count - 1) / 2),
        level=level,
        remarks=_outside(found, band, level) if choice == "auto" else (),
    )


def _band(found: Found) -> tuple[float, float]:
    """The limits of the frequencies used, Hz; 0 and half the sampling rate if nothing is excluded."""
    seen, (first, last) = found.seen, np.flatnonzero(found.used)[[0, -1]]
    low = float(seen.frequency(seen.first[first])) if first else 0.0
    high = seen.first[last] + seen.count[last] - 0.5
    return low, seen.rate / 2 if last == found.used.size - 1 else float(seen.frequency(high))


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


def _filter(found: Found) -> LowPass | None:
    part, rate = found.shaped, found.seen.rate
    if part.filter is None:
        return None
    low, high = limits(part, part.filter, CONFIDENT)
    row, cutoff = part.filter.row, part.filter.cutoff
    return LowPass(row, FILTERS[row].title, cutoff * rate, low * rate, high * rate, rate)


def expected_power(found: Found) -> FloatArray:
    """Power of the terms in every bin, without a filter, shape (bins,)."""
    part, likelihood = found.part, found.chosen.likelihood
    m = (likelihood.expectation(found.chosen.theta) - likelihood.added) / part.passed[found.used]
    if found.used.all():
        return m
    rest = found.part.but(used=np.ones_like(found.used))
    columns = rest.whole.S
    if found.chosen.constants:
        columns = _with_shapes(found, columns)
    return np.asarray(columns @ found.chosen.theta)


def _with_shapes(found: Found, columns: FloatArray) -> FloatArray:
    """All bins' columns with the time constant that was found."""
    assert found.search is not None  # noqa: S101 - there is a time constant
    everywhere = found.part.but(used=np.ones_like(found.used))
    shaped = columns.copy()
    shaped[:, found.chosen.theta.size - 1] = found.search.column(found.chosen.constants, everywhere)
    return shaped


def _levels(found: Found) -> FloatArray:
    """The gain of the filter, with what is added, where the fit reads; elsewhere what was observed, smoothed."""
    ratio = found.seen.power / expected_power(found)
    around = surroundings(ratio * found.seen.count).sum(axis=1) / surroundings(found.seen.count).sum(axis=1)
    known = np.where(found.seen.count > WELL_KNOWN, ratio, around)
    return np.where(found.used, found.part.passed + found.part.added / expected_power(found), known)


def largest_misfit(found: Found) -> float:
    """The largest misfit of a cell beyond twice its standard error, as a share of the power."""
    seen, used = found.seen, found.used
    cell = cell_of(seen, used)[used]
    m = found.chosen.likelihood.expectation(found.chosen.theta)
    nu = np.bincount(cell, seen.count[used])
    total = np.bincount(cell, seen.count[used] * seen.power[used] / m)
    held = nu > WELL_KNOWN
    beyond = np.abs(total[held] / nu[held] - 1) - 2 * np.sqrt(2 / nu[held])
    return max(float(beyond.max(initial=0.0)), found.part.misfit)


def _outside(found: Found, band: tuple[float, float], level: FloatArray) -> tuple[str, ...]:
    """Behaviour of the spectrum beyond the ends of the band."""
    there = np.flatnonzero(found.used)
    first, last = int(there[0]), int(there[-1])
    said = []
    if first:
        said.append(
            _beyond(
                say("below {frequency:.3g} Hz", frequency=band[0]),
                found,
                level,
                slice(0, first),
                say("drift or motion"),
            )
        )
    if last < level.size - 1:
        what = say("vibration or interference")
        said.append(
            _beyond(say("above {frequency:.3g} Hz", frequency=band[1]), found, level, slice(last + 1, None), what)
        )
    return tuple(said)


def _beyond(where: str, found: Found, level: FloatArray, part: slice, cause: str) -> str:
    """Behaviour of the spectrum in an excluded part."""
    level, first = level[part], found.seen.first[part]
    ratio, highest = float(np.exp(np.log(level).mean())), int(level.argmax())
    if ratio < 1 - CHANGED:
        return say("{where} the power is {ratio:.2g} times that of the model: a filter", where=where, ratio=ratio)
    odd: dict[str, Any] = {"where": where, "cause": cause, "ratio": ratio, "less": 100 * CHANGED}
    if level[highest] > STANDS_OUT * max(ratio, 1.0):
        odd |= {"peak": float(level[highest]), "frequency": float(found.seen.frequency(first[highest]))}
        if ratio > 1 + CHANGED:
            return say(
                "{where} the power is {ratio:.2g} times that of the model, {peak:.2g} times at {frequency:.3g} Hz: "
                "{cause}",
                **odd,
            )
        return say(
            "{where} the spectrum deviates from the model by less than {less:.0f} % on average, but has {peak:.2g} "
            "times its power at {frequency:.3g} Hz: {cause}",
            **odd,
        )
    if ratio > 1 + CHANGED:
        return say("{where} the power is {ratio:.2g} times that of the model: {cause}", **odd)
    return say("{where} the spectrum deviates from the model by less than {less:.0f} % on average", **odd)
