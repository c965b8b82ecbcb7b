"""The part of a spectrum used by a fit, with the assumed filter and the weight of each bin."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np

from allanite.core.arrays import BoolArray, FloatArray
from allanite.core.plain import Portable
from allanite.terms import TERMS, WHITE

from .cells import CELLS, cell_of
from .filters import FILTERS
from .likelihood import Likelihood
from .spectrum import BinnedSpectrum
from .whittle import likelihood, table_column, with_warm_up

if TYPE_CHECKING:
    from .resonances import Excess

LOWEST = 1e-9
"""Gain of a bin in the stop band, at least."""

HIDDEN = 0.6
"""Share of half the sampling rate below which the end of a band hides angle noise."""


@dataclass(frozen=True)
class Tuned:
    """A row of `FILTERS` with its cut-off, cycles per sample."""

    row: str
    cutoff: float

    def gain(self, seen: BinnedSpectrum) -> FloatArray:
        """Mean power that it lets pass in each bin, shape (bins,)."""
        nodes, weights, starts = seen.nodes
        power = FILTERS[self.row].gain(nodes / (2 * seen.size), self.cutoff)
        mean = np.add.reduceat(weights * power, starts) / seen.count
        return np.maximum(mean, LOWEST)  # rounding leaves no zero to divide by


@dataclass(frozen=True, eq=False)
class Portion(Portable):
    """What of a spectrum is read, and how.

    Attributes
    ----------
    seen : BinnedSpectrum
    noise, ramps : sequence of str
        Terms of noise in the order of the likelihood's columns, and deterministic ones.
    used : bool array, shape (bins,)
    filter : Tuned, optional
        In front of the samples.
    trust : array, shape (bins,), optional
        Share of the coefficients of each bin that count.
    misfit : float
        Allowed for by `trust`: RMS over cells of the spectrum, as a share of the power.
    warm : float, optional
        Time constant of a warm-up, in samples, whose size is left open.
    excess : Excess, optional
        Resonances, whose power is added to that of the terms.
    vouched : bool
        Whether the terms were asked for: angle noise among them needs no evidence beside its likelihood.
    shape : tuple of float
        Of the last terms, if it is known, where a filter is tuned.
    """

    seen: BinnedSpectrum
    noise: tuple[str, ...]
    ramps: tuple[str, ...]
    used: BoolArray
    filter: Tuned | None = None
    trust: FloatArray | None = None
    misfit: float = 0.0
    warm: float | None = None
    excess: "Excess | None" = None
    shape: tuple[float, ...] = ()
    vouched: bool = False

    @cached_property
    def whole(self) -> Likelihood:
        """The likelihood of all bins without a filter."""
        found = likelihood(self.seen, [*self.noise, *self.ramps])
        if self.warm is None:
            return found
        return with_warm_up(found, self.seen, np.ones_like(self.used), self.warm)

    @cached_property
    def unfiltered(self) -> Likelihood:
        """The likelihood of what is read, without a filter and with full trust."""
        return self.whole.only(self.used)

    @cached_property
    def passed(self) -> FloatArray:
        """Gain of the filter in each bin, 1 without one, shape (bins,)."""
        return np.ones(self.used.size) if self.filter is None else self.filter.gain(self.seen)

    @cached_property
    def added(self) -> FloatArray:
        """Power that is no part of the terms: of resonances, and of a rounding behind a filter, shape (bins,).

        Without a filter the rounding of a rate is white noise like any other; a filter lowers that of the sensor only.
        """
        rounding = self.seen.rounding * (1 - self.passed)
        return rounding if self.excess is None else rounding + self.excess.power

    @cached_property
    def likelihood(self) -> Likelihood:
        """The likelihood of what is read."""
        found = self.unfiltered
        if self.filter is not None:
            count = self.seen.count
            mean, edges = float(self.passed @ count / count.sum()), FILTERS[self.filter.row].edges(self.filter.cutoff)
            white = np.array([TERMS[symbol].slope == WHITE and not TERMS[symbol].parameters for symbol in self.noise])
            found = found.behind(self.passed[self.used], mean, edges * white)
        if self.added.any():
            found = replace(found, added=self.added[self.used])
        for share in (self.trust, None if self.excess is None else self.excess.trust(self.together)):
            found = found if share is None else found.trusted(share[self.used])
        return found

    def known(self, shape: tuple[float, ...]) -> Likelihood:
        """The likelihood where the shape of the last terms is known; without one, as it is."""
        return self.likelihood.with_last(self.columns(shape)) if shape else self.likelihood

    @property
    def shapely(self) -> tuple[str, ...]:
        """The terms with a shape; they come last."""
        return tuple(symbol for symbol in self.noise if TERMS[symbol].parameters)

    def columns(self, shape: tuple[float, ...]) -> FloatArray:
        """Expected power of the terms with a shape in the bins that are read, shape (bins, terms)."""
        left = iter(shape)
        each = [(s, tuple(islice(left, len(TERMS[s].parameters)))) for s in self.shapely]
        return np.column_stack([(table_column(s, self.seen, own) * self.passed)[self.used] for s, own in each])

    def but(self, used: BoolArray | None = None, filter: Tuned | None = None) -> "Portion":  # noqa: A002
        """The same spectrum, read elsewhere or behind a filter, with full trust."""
        found = replace(self, used=self.used if used is None else used, filter=filter, trust=None, misfit=0.0)
        return self._lent(found)

    def doubted(self, misfit: float) -> "Portion":
        """The same with less trust in many coefficients, as if each cell had a misfit of its own of that size."""
        return self._lent(replace(self, trust=1 / (1 + misfit**2 * self.together / 2), misfit=misfit))

    @cached_property
    def together(self) -> FloatArray:
        """Coefficients that are read in the cell of each bin, shape (bins,)."""
        cell = cell_of(self.seen, self.used)
        return np.asarray(np.bincount(cell[self.used], self.seen.count[self.used], CELLS)[cell])

    def _lent(self, other: "Portion") -> "Portion":
        """Another portion with what it has in common with this one: the columns stay what they are."""
        other.__dict__["whole"] = self.whole
        if other.used is self.used:
            other.__dict__["unfiltered"] = self.unfiltered
        return other

    def shaped(self, shape: tuple[float, ...]) -> "Portion":
        """The same where the shape of the last terms is known."""
        return self._lent(replace(self, shape=shape))

    def among(self, noise: tuple[str, ...]) -> "Portion":
        """The same with other terms of noise."""
        return self if noise == self.noise else replace(self, noise=noise)


def portion(seen: BinnedSpectrum, symbols: Sequence[str], used: BoolArray) -> Portion:
    """All terms of a spectrum in the bins that are used."""
    ramps = tuple(symbol for symbol in symbols if TERMS[symbol].waveform is not None)
    return Portion(seen, tuple(symbol for symbol in symbols if symbol not in ramps), ramps, used)
