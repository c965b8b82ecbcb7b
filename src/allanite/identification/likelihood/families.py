"""Which terms describe a spectrum, flicker or Gauss-Markov noise among them: the search, and what it found.

A Gauss-Markov term is linear in the square of its effective value but not in its time constant T. L is profiled over T
on a grid and then refined; in the subsets and the limits, T takes the values that the likelihood leaves open.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from allanite.core.arrays import BoolArray, FloatArray
from allanite.core.errors import UsageError
from allanite.core.fit import EXPLAINED
from allanite.core.plain import Portable
from allanite.core.record import Record
from allanite.identification.checks.goodness import goodness
from allanite.terms import TERMS

from .likelihood import Likelihood
from .portion import Portion, portion
from .selection import PENALTY, Profiles, Subset, select, subsets
from .whittle import Spectrum, spectrum

SHORTEST, LONGEST = 3.0, 0.1
"""Time constants that can be told from white noise and from a random walk: samples, and share of the record."""

SLOW = 30.0
"""Samples above which a time constant is that of a wandering bias; a shorter one is a filter's, or the sampling's."""

PER_DECADE = 4
"""Time constants a decade in the first search."""

EVIDENCE = 12.0
"""What a Gauss-Markov term must gain in 2 L: for its size, for a time constant that was searched for, and for the doubt
that what is flicker everywhere else is none here: so it displaces true flicker in about 1 % of records."""

CLOSE = 2.0
"""Refining the time constant gains less than this in 2 L beyond the grid."""

OPEN = 6.6
"""Time constants that lose less than this in 2 L take part in the limits of the terms (the 99 % point)."""

STARTS = 3
"""Pairs of time constants from which the best pair is sought."""

NEAR = 3
"""Time constants on either side of the best that take part."""


@dataclass(frozen=True, eq=False)
class Search(Portable):
    """The likelihood as a function of the time constant of Gauss-Markov noise, the last column of it, in samples.

    `may` says which terms may stand beside it, shape (p,), `shortest` is the least time constant, `symbol` the term;
    `asked` whether it was asked for.
    """

    likelihood: Likelihood
    part: Portion
    may: BoolArray
    shortest: float = SHORTEST
    symbol: str = "GM"
    asked: bool = False

    def column(self, T: float, part: Portion | None = None) -> FloatArray:
        """Expected power of the term in the bins that are read, or in another portion."""
        shaped = TERMS[self.symbol].shaped
        assert shaped is not None  # noqa: S101 - `look` has seen to it
        return (part or self.part).column(shaped((T,), 1.0))

    def at(self, T: float) -> Likelihood:
        """The likelihood with a time constant."""
        return self.likelihood.with_column(-1, self.column(T))

    def least(self, T: float, free: BoolArray | None = None) -> Subset:
        """The minimum at a time constant, all terms free that may be."""
        likelihood, free = self.at(T), self.may if free is None else free
        return Subset(likelihood, free, *likelihood.minimise(free), (T,))

    @property
    def span(self) -> tuple[float, float]:
        """The least and the greatest time constant."""
        return self.shortest, max(LONGEST * self.part.seen.size, 2 * self.shortest)

    @cached_property
    def grid(self) -> FloatArray:
        """Time constants of the first search."""
        low, high = self.span
        return np.geomspace(low, high, max(2, round(PER_DECADE * math.log10(high / low))))

    @cached_property
    def coarse(self) -> Subset:
        """The best of the grid."""
        return min((self.least(float(T)) for T in self.grid), key=lambda subset: subset.value)

    def refined(self, around: float, free: BoolArray | None = None) -> Subset:
        """The best near a value of the grid."""
        from scipy.optimize import minimize_scalar

        step, (low, high) = 10 ** (1 / PER_DECADE), self.span
        best = minimize_scalar(
            lambda x: self.least(math.exp(x), free).value, method="bounded", options={"xatol": 0.01},
            bounds=(math.log(max(low, around / step)), math.log(min(high, around * step))),
        )  # fmt: skip
        return self.least(math.exp(float(best.x)), free)

    def best(self, penalty: FloatArray, beat: float = math.inf) -> Subset | None:
        """The best subset with the term; None if none can have a score below `beat`."""
        # at least one other term is there
        if 2 * self.coarse.value + float(penalty[-1]) > beat + CLOSE:
            return None
        fine = self.refined(self.coarse.constants[0])
        first = select(subsets(fine.likelihood, must=self.always, may=self.may, constants=fine.constants), penalty)
        found = self.refined(fine.constants[0], first.free)
        return found if found.theta[-1] > 0 else None

    @cached_property
    def must(self) -> BoolArray:
        """The term alone."""
        return np.asarray(np.arange(self.may.size) == self.may.size - 1)

    @property
    def always(self) -> BoolArray:
        """The term, and what is never left out."""
        return self.must | self.part.must

    def slope(self, subset: Subset) -> FloatArray:
        """Change of the expected power with ln T, shape (bins,)."""
        (T,) = subset.constants
        up, down = self.column(1.01 * T), self.column(T / 1.01)
        return np.asarray(subset.theta[-1] * (up - down) / (2 * math.log(1.01)))

    def limits(self, best: Subset, drop: float) -> tuple[float, float]:
        """Time constants at which 2 L has risen by `drop`, the others following; at most those of the search."""
        from scipy.optimize import brentq

        (T,) = best.constants
        ends = []
        for end in (min(1.0, T / 2), max(float(self.part.seen.size), 2 * T)):

            def excess(x: float) -> float:
                return 2 * (self.least(math.exp(x), best.free).value - best.value) - drop

            open_ = excess(math.log(end)) <= 0
            ends.append(end if open_ else math.exp(brentq(excess, math.log(T), math.log(end), xtol=1e-3)))
        return ends[0], ends[1]

    def around(self, best: Subset) -> list[Subset]:
        """Subsets with the term at the time constants that the likelihood leaves open; the best one's come last."""
        (T,) = best.constants
        low, high = self.limits(best, OPEN)
        open_ = (*np.geomspace(low, T, NEAR + 1)[:-1], *np.geomspace(high, T, NEAR + 1))
        each = ((self.at(float(k)), (float(k),)) for k in open_)
        return [s for part, k in each for s in subsets(part, must=self.always, may=self.may, constants=k)]

    def pair(self) -> Subset:
        """The best with two such terms and no flicker."""
        from scipy.optimize import minimize

        free = np.append(self.may, True)

        def least(x: FloatArray) -> Subset:
            first, second = np.exp(x)
            both = self.at(float(first)).with_more(self.column(float(second)))
            return Subset(both, free, *both.minimise(free), (float(first), float(second)))

        grid = np.log(self.grid)
        pairs = [np.array([a, b]) for i, a in enumerate(grid) for b in grid[i + 1 :]]
        corners = np.array([[0.0, 0.0], [0.3, 0.0], [0.0, 0.3]])
        tries = []
        for start in sorted(pairs, key=lambda x: least(x).value)[:STARTS]:
            options = {"initial_simplex": start + corners, "xatol": 0.02, "fatol": 0.01}
            tries.append(minimize(lambda x: least(x).value, start, method="Nelder-Mead", options=options))
        return least(min(tries, key=lambda found: float(found.fun)).x)


@dataclass(frozen=True, eq=False)
class Found(Portable):
    """What describes the part of a spectrum that is read: the subset `chosen`.

    `noise` are the symbols of the columns of the likelihood, `every` the subsets without a Gauss-Markov term that was
    not asked for; `plain` and `markov` are the best without and with one. `elsewhere` gives subsets under other
    suppositions, a filter's cut-off, that take part in the limits.
    """

    part: Portion
    noise: list[str]
    every: list[Subset]
    chosen: Subset
    search: Search | None
    plain: Subset
    markov: Subset | None
    elsewhere: Callable[["Found"], list[Subset]] | None = None

    @property
    def seen(self) -> Spectrum:
        """The spectrum."""
        return self.part.seen

    @property
    def used(self) -> BoolArray:
        """Bins that were read, shape (bins,)."""
        return self.part.used

    @property
    def base(self) -> Portion:
        """The portion without a Gauss-Markov term that nobody asked for."""
        rival = self.search is not None and not self.search.asked
        return self.part.among(self.part.noise[:-1]) if rival else self.part

    @cached_property
    def fitted(self) -> list[Subset]:
        """Subsets that take part in the limits, the last one with every term that could take another's place."""
        around = self.search.around(self.markov) if self.search and self.markov and self.counts else []
        return [*(self.elsewhere(self) if self.elsewhere else []), *self.every, *around] or [self.chosen]

    @property
    def counts(self) -> bool:
        """Whether the Gauss-Markov term takes part in the limits: chosen, or asked for."""
        return self.chosen is self.markov or (self.search is not None and self.search.asked)

    @property
    def everything(self) -> Subset:
        """The subset in which no term is left out that could take another's place."""
        return self.fitted[-1]

    @cached_property
    def profiles(self) -> Profiles:
        """Limits of the terms."""
        return Profiles(self.fitted, self.chosen, self.everything)

    @cached_property
    def slope(self) -> FloatArray | None:
        """How the expected power changes with the time constant, if there is one."""
        return self.search.slope(self.chosen) if self.search and self.chosen.constants else None

    @property
    def flicker(self) -> Subset | None:
        """The best without a Gauss-Markov term, if flicker is in it."""
        which = flicker_in(self.noise)
        return self.plain if which is not None and self.plain.theta[which] > 0 else None

    def rivals(self) -> list[Subset]:
        """The best of each family: flicker, Gauss-Markov, both, two Gauss-Markov."""
        if self.search is None:
            return []
        penalty = penalties(len(self.noise))
        both = replace(self.search, may=np.ones(len(self.noise), dtype=bool), shortest=SHORTEST)
        found = [self.flicker, self.markov or self.search.best(penalty), both.best(penalty), self.search.pair()]
        there = [subset for subset in found if subset is not None]
        complete = [s for s in there if not s.constants or (s.theta[len(self.noise) - 1 :] > 0).all()]
        flicker = flicker_in(self.noise)
        # both without flicker is Gauss-Markov alone once more
        return [s for s in complete if s is not found[2] or (flicker is not None and s.theta[flicker] > 0)]


def flicker_in(symbols: Sequence[str]) -> int | None:
    """The place of the term that a Gauss-Markov term may stand in for; None if it is not there."""
    return next((i for i, symbol in enumerate(symbols) if TERMS[symbol].substitute), None)


def penalties(p: int) -> FloatArray:
    """What each term must gain in 2 L to be selected, a Gauss-Markov term the last of them, shape (p,)."""
    penalty = np.full(p, PENALTY)
    penalty[-1] = EVIDENCE
    return penalty


def look(record: Record, symbols: Sequence[str], band: tuple[float, float] | None, *, rival: bool) -> Found:
    """Fit every subset of the terms; with Gauss-Markov noise among them, or as a `rival` of flicker: see `whittle`."""
    ramps = [symbol for symbol in symbols if TERMS[symbol].waveform is not None]
    seen = spectrum(record, detrend=bool(ramps))
    used = np.ones(seen.first.size, dtype=bool) if band is None else seen.within(band)
    return fitted(portion(seen, symbols, used), rival=rival)


def fitted(part: Portion, *, rival: bool) -> Found:
    """Fit every subset of the terms of a portion; see `look`."""
    asked = [symbol for symbol in part.noise if TERMS[symbol].parameters]
    noise = [symbol for symbol in part.noise if symbol not in asked]
    if len(asked) > 1 or any(len(TERMS[symbol].parameters) > 1 for symbol in asked):
        raise UsageError(f"only one term with one time constant can be looked for at a time, not {', '.join(asked)}")
    flicker = flicker_in(noise)
    if not asked and not (rival and flicker is not None):
        every = subsets(part.likelihood, must=part.must)
        best = select(every)
        return Found(part, noise, every, best, None, best, None)
    markov = asked[0] if asked else TERMS[noise[flicker or 0]].substitute
    return _with_markov(part.among((*noise, markov)), asked=bool(asked))


def _believed(plain: Subset, markov: Subset, part: Portion) -> bool:
    """Whether Gauss-Markov noise that nobody asked for describes the record, and takes no more than flicker's place.

    What no model explains, a filter's roll-off or motion, it describes better than flicker does, but it is not that.
    At a short time constant it stands in for angle random walk too, at a long one for a rate random walk: each of them
    needs as much evidence once more.
    """
    penalty = penalties(len(part.noise))
    other = np.array([not TERMS[symbol].substitute for symbol in part.noise])
    lost = int((other & (plain.theta > 0) & (markov.theta == 0)).sum())
    if lost and markov.score(penalty) + lost * EVIDENCE > plain.score(penalty):
        return False
    return goodness(part.seen, markov.likelihood, markov.theta, part.used).p >= EXPLAINED


def _with_markov(part: Portion, *, asked: bool) -> Found:
    """Subsets with and without a Gauss-Markov term; where it was not asked for, it stands in the place of flicker."""
    noise, penalty = list(part.noise), penalties(len(part.noise))
    may = np.array([asked or not TERMS[symbol].substitute for symbol in noise])
    search = Search(part.likelihood, part, may, SHORTEST if asked else SLOW, noise[-1], asked)
    every = subsets(part.likelihood, must=part.must, may=~search.must) if len(noise) > 1 else []
    plain = select(every, penalty) if every else None
    markov = search.best(penalty, math.inf if asked or plain is None else plain.score(penalty))
    best = min((s for s in (plain, markov) if s is not None), key=lambda s: s.score(penalty), default=None)
    if plain and markov and best is markov and not (asked or _believed(plain, markov, part)):
        best = plain
    if best is None:  # nothing but Gauss-Markov noise was asked for, and there is none
        best = search.coarse
    return Found(part, noise, every, best, search, plain or best, markov)
