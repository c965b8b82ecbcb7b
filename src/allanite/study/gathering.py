"""What is kept of a channel that is read in parts: the sums of curves, of the identification, and of a spectrum."""

from copy import deepcopy
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from allanite.core.arrays import FloatArray, IntArray
from allanite.core.curve import Curve, Law
from allanite.core.errors import UsageError
from allanite.core.fit import Fit
from allanite.core.plain import Portable
from allanite.core.record import Record
from allanite.phrases.phrase import say
from allanite.phrases.wording import spelled
from allanite.statistics.spectra.raw_spectrum import Raw
from allanite.statistics.spectra.welch import Periodograms
from allanite.stream.accumulator import Accumulator, streamable
from allanite.stream.curve import grid

from .recipe import Recipe

WHOLE = "a record that is read in parts has"
"""How messages about what needs the whole record begin."""


NEAR = 1e-3
"""Relative difference of averaging times that are the same; the sampling rate is known only at the end."""

STRIDES = say(
    "the variances are exact: up to 15 samples from all windows, at m = q 2^k, q = 8 .. 15, from those that start "
    "every 2^k samples, which costs at most 1 % of the accuracy"
)
"""The note about the curves."""


class Gathering(Protocol):
    """Takes the steps of a channel, of which those `at` some places are outliers."""

    def push(self, steps: FloatArray, at: IntArray) -> None:
        """Add steps that follow the last ones."""

    def skip(self, samples: int) -> None:
        """Go on after missing samples."""


class Streams:
    """Accumulators of some statistics, and of the identification, from which outliers may be excluded."""

    def __init__(self, head: Record, statistics: tuple[str, ...], choice: str | None) -> None:
        for name in statistics:
            if name not in streamable():
                raise UsageError(
                    f"{WHOLE} no {name!r}: choose one of {', '.join(streamable())}, or allow more memory with "
                    f"{spelled('--memory', 'memory=')}"
                )
        kind = "increment" if head.integrated else head.kind
        self.choice = choice
        self.every = [
            Accumulator(head.rate, head.unit, kind, scale=head.scale, name=head.name, statistic=name)
            for name in dict.fromkeys(statistics)
        ]
        self.clean: Accumulator | None = None

    def push(self, steps: FloatArray, at: IntArray) -> None:
        """Add steps that follow the last ones; those `at` some places are outliers."""
        marked = steps
        if at.size:
            marked = steps.copy()
            marked[at] = np.nan
            if self.choice is None and self.clean is None:
                self.clean = deepcopy(self.every[0])
        for stream in self.every:
            stream.push(marked if self.choice == "mark" else steps)
        if self.clean is not None:
            self.clean.push(marked)

    def skip(self, samples: int) -> None:
        """Go on after missing samples."""
        for stream in (*self.every, *([self.clean] if self.clean else [])):
            stream.skip(samples)

    def fit(self, rate: float, recipe: Recipe) -> Fit:
        """The noise, without the outliers unless they are kept."""
        return self._at(self.clean or self.every[0], rate).fit(recipe.terms, band=recipe.band)

    def curves(self, rate: float, noise: Fit | None) -> list[Curve]:
        """The curve of each statistic."""
        return [self._at(stream, rate).curve(noise) for stream in self.every]

    @staticmethod
    def _at(stream: Accumulator, rate: float) -> Accumulator:
        """The stream with the sampling rate that is known at the end."""
        stream.like = replace(stream.like, rate=rate)
        return stream


class Spectra:
    """The periodograms of a channel, and an accumulator if the noise is to be identified."""

    def __init__(self, head: Record, sums: Periodograms, choice: str | None, *, fitted: bool) -> None:
        self.head, self.sums, self.choice = head, sums, choice
        self.streams = Streams(head, ("oadev",), choice) if fitted else None

    def push(self, steps: FloatArray, at: IntArray) -> None:
        """Add steps that follow the last ones; those `at` some places are outliers."""
        if self.streams is not None:
            self.streams.push(steps, at)
        if self.choice == "mark" and at.size:
            steps = steps.copy()
            steps[at] = np.nan
        self.sums.push(steps)

    def skip(self, samples: int) -> None:
        """Go on after missing samples."""
        self.sums.end()
        if self.streams is not None:
            self.streams.skip(samples)

    def fit(self, rate: float, recipe: Recipe) -> Fit:
        """The noise, without the outliers unless they are kept."""
        assert self.streams is not None  # noqa: S101 - asked for only if it is fitted
        return self.streams.fit(rate, recipe)

    def raw(self, rate: float) -> Raw:
        """The densities."""
        return self.sums.raw(rate, replace(self.head, rate=rate).rate_factor)


@dataclass(frozen=True, eq=False)
class Some(Portable):
    """The law of some points of a curve."""

    law: Law
    at: IntArray

    def __call__(self, level: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Degrees of freedom and limits over the variance; see `Curve`."""
        edf, low, high = self.law(level)
        return edf[self.at], low[self.at], high[self.at]


def chosen(curve: Curve, taus: str | tuple[float, ...], m: tuple[int, ...] | None = None) -> Curve:
    """The points of a curve that are asked for.

    Raises
    ------
    UsageError
        One of them is not in the grid of a stream; the message names the nearest.
    """
    at = _places(curve, taus, m)
    parts = {name: getattr(curve, name)[at] for name in ("m", "tau", "variance", "count", "factor")}
    return replace(curve, **parts, law=None if curve.law is None else Some(curve.law, at))


def demand_grid(taus: str | tuple[float, ...], m: tuple[int, ...] | None, rate: float) -> None:
    """Refuse, before the file is read, averaging times that a record read in parts does not have."""
    if m is None and isinstance(taus, str):
        if taus not in ("log", "octave"):
            wanted = spelled("--taus", "taus=")
            raise UsageError(f"{WHOLE} the averaging times of {wanted} log or octave, or some of these, not {taus!r}")
        return
    q, level = grid()
    known = np.unique(q << level)
    for one in m or ():
        if one not in known:
            raise UsageError(_not_there(one, known, ""))
    for tau in () if m is not None else map(float, taus):
        factor = round(tau * rate)
        if factor not in known or abs(factor / rate - tau) > NEAR * tau:
            raise UsageError(_not_there(tau, known / rate, " s"))


def _places(curve: Curve, taus: str | tuple[float, ...], m: tuple[int, ...] | None) -> IntArray:
    if m is None and isinstance(taus, str):
        some = np.ones(curve.m.size, bool) if taus == "log" else (curve.m & (curve.m - 1)) == 0
        return np.flatnonzero(some)
    factors = m if m is not None else tuple(round(tau * curve.rate) for tau in map(float, taus))
    for one in factors:
        if one not in curve.m:
            raise UsageError(_not_there(one, curve.m, ""))
    return np.flatnonzero(np.isin(curve.m, factors))


def _not_there(one: float, known: IntArray | FloatArray, unit: str) -> str:
    near = known[np.argsort(np.abs(known - one))[:2]]
    return (
        f"{WHOLE} no averaging {'time' if unit else 'factor'} {one:g}{unit}; its averaging factors are 1 to 15 and 8 "
        f"to 15 times a power of 2, the nearest {' and '.join(f'{value:.9g}{unit}' for value in np.sort(near))}"
    )
