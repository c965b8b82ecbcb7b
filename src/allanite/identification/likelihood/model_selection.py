"""Which terms describe a spectrum, including flicker and Gauss-Markov noise."""

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

from .band import Portion, portion
from .cells import WELL_KNOWN, cell_of
from .evidence import EVIDENCE, angle_price, flicker_in, penalties
from .law import AKAIKE, Law, law, traces
from .selection import Subset, ThetaProfile, select, subsets
from .spectrum import BinnedSpectrum, spectrum
from .timeconstant import Search, Shapes
from .tuning import EVIDENCE as FILTERED

SLOW = 30.0
"""Samples above which a time constant is that of bias drift; a shorter one belongs to a filter or the sampling."""

MOST = 2
"""Terms with a shape that are looked for together."""

DISTINGUISHABLE = 2.0
"""Difference of the Akaike criterion below which two models describe a record equally well."""


@dataclass(frozen=True, eq=False)
class Found(Portable):
    """What describes the part of a spectrum that is read: the subset `chosen`.

    `noise` are the symbols of the columns of the likelihood, `every` the subsets without a Gauss-Markov term that was
    not requested; `plain` and `markov` are the best without and with one. `elsewhere` gives subsets under other
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
    def seen(self) -> BinnedSpectrum:
        """The spectrum."""
        return self.part.seen

    @property
    def used(self) -> BoolArray:
        """Bins that were read, shape (bins,)."""
        return self.part.used

    @property
    def shaped(self) -> Portion:
        """The portion, with the shape that was found of the last term."""
        return self.part.shaped(self.chosen.constants)

    @property
    def base(self) -> Portion:
        """The portion without a Gauss-Markov term that was not requested."""
        rival = self.search is not None and not self.search.asked
        return self.part.among(self.part.noise[:-1]) if rival else self.part

    @cached_property
    def fitted(self) -> list[Subset]:
        """Subsets that take part in the limits, the last one with every term that could take another's place."""
        elsewhere = self.elsewhere(self) if self.elsewhere else []
        if self.search is None or self.markov is None:
            return [*elsewhere, *self.every] or [self.chosen]
        if self.counts:
            return [*elsewhere, *self.every, *self.search.around(self.markov)]
        return [*elsewhere, *self.search.around(self.markov), *self.every]

    @cached_property
    def full(self) -> Subset:
        """All terms free that may stand beside those chosen: nothing is omitted because it was not selected."""
        p = self.chosen.theta.size
        if self.search is None or p > len(self.noise):
            may = np.ones(p, dtype=bool)
        else:
            may = self.search.may if self.chosen.constants else ~self.search.must
        if (self.chosen.free == may).all():
            return self.chosen
        part = self.chosen.likelihood
        return Subset(part, may, *part.minimise(may, self.chosen.theta), self.chosen.constants)

    @property
    def counts(self) -> bool:
        """Whether the Gauss-Markov term takes part in the limits: chosen, or requested."""
        return self.chosen is self.markov or (self.search is not None and self.search.asked)

    @property
    def everything(self) -> Subset:
        """The subset in which no term is omitted that could take another's place."""
        return self.fitted[-1]

    def profile(self, which: int) -> ThetaProfile:
        """Profile of the likelihood of one theta, nothing omitted that could take its place."""
        return ThetaProfile(self.everything, which)

    @cached_property
    def expected_power(self) -> FloatArray:
        """Power of the terms in every bin, without a filter, shape (bins,)."""
        part, theta, constants = self.part, self.chosen.theta, self.chosen.constants
        m = (self.chosen.likelihood.expectation(theta) - self.chosen.likelihood.added) / part.passed[self.used]
        if self.used.all():
            return m
        everywhere = part.but(used=np.ones_like(self.used))
        columns = everywhere.whole.S
        if constants:
            shaped = everywhere.columns(constants)
            columns = np.column_stack((columns[:, : -shaped.shape[1]], shaped))
        return np.asarray(columns @ theta)

    @cached_property
    def largest_misfit(self) -> float:
        """The largest misfit of a cell beyond twice its standard error, as a share of the power."""
        seen, used = self.seen, self.used
        cell, count = cell_of(seen, used)[used], seen.count[used]
        m = self.chosen.likelihood.expectation(self.chosen.theta)
        nu, total = np.bincount(cell, count), np.bincount(cell, count * seen.power[used] / m)
        held = nu > WELL_KNOWN
        beyond = np.abs(total[held] / nu[held] - 1) - 2 * np.sqrt(2 / nu[held])
        return max(float(beyond.max(initial=0.0)), self.part.misfit)

    @property
    def score(self) -> float:
        """2 L of the chosen subset and the penalties of its terms, of a filter, and of what is not read.

        There each bin has a level of its own, so that readings of other bins can be compared.
        """
        seen, out = self.seen, ~self.used
        unread = float(seen.told[out] @ (1 + np.log(seen.power[out])) + AKAIKE * out.sum())
        return self.chosen.score(penalties(self.part)) + FILTERED * (self.part.filter is not None) + unread

    @property
    def slowest(self) -> int:
        """The column of the noise of the longest memory, which is known from a few coefficients only."""
        return max(range(len(self.noise)), key=lambda i: np.nan_to_num(TERMS[self.noise[i]].slope, nan=-math.inf))

    @cached_property
    def akaike(self) -> FloatArray:
        """Penalties in 2 L of the terms, 2 for each number that is fitted, shape (p,)."""
        return AKAIKE * np.array([1.0 + len(TERMS[symbol].parameters) for symbol in self.noise])

    @cached_property
    def schwarz(self) -> FloatArray:
        """The same, but angle noise must gain ln n, n the coefficients that it could dominate, shape (p,).

        It is clearly there or of no weight, as n is a fixed share of all (G. Schwarz, 1978). A Gauss-Markov term that
        was not requested must have its `EVIDENCE`.
        """
        part = self.chosen.likelihood
        share = part.S[:, : len(self.noise)] / part.expectation(self.chosen.theta)[:, None]
        dominated = part.count @ (share / share.max(axis=0)) ** 2
        edge = np.array([TERMS[symbol].edge > 0 for symbol in self.noise])
        found = np.where(edge, np.maximum(np.log(dominated), AKAIKE), self.akaike)
        found[edge] += angle_price(self.part)
        if self.search is not None and not self.search.asked:
            found[-1] += EVIDENCE - 2 * AKAIKE
        return found

    def laws(self, which: int) -> tuple[Law, Law] | None:
        """Laws of a coefficient: the law of its limits and that of its value; None where no model has the term.

        Whether the limits hold zero is a matter of evidence, as the value is.
        """
        along = traces(self.fitted, which, (self.akaike, self.schwarz))
        if not along:
            return None
        wide, sharp = law(along, self.akaike), law(along, self.schwarz)
        return replace(wide, zero=sharp.zero), sharp

    @property
    def flicker(self) -> Subset | None:
        """The best without a Gauss-Markov term, if flicker is in it."""
        which = flicker_in(self.noise)
        return self.plain if which is not None and self.plain.theta[which] > 0 else None

    def rivals(self) -> list[Subset]:
        """The best of each family: flicker, Gauss-Markov, both, two Gauss-Markov."""
        if self.search is None:
            return []
        if not set(self.search.symbols) <= {row.substitute for row in TERMS.values()}:
            return [subset for subset in (self.plain, self.markov) if subset is not None]
        penalty = penalties(self.part)
        both = replace(self.search, may=np.ones(len(self.noise), dtype=bool), shortest=0.0)
        found = [self.flicker, self.markov or self.search.best(penalty), both.best(penalty), self.search.pair()]
        there = [subset for subset in found if subset is not None]
        complete = [s for s in there if not s.constants or (s.theta[len(self.noise) - 1 :] > 0).all()]
        flicker = flicker_in(self.noise)
        # both without flicker is Gauss-Markov alone once more
        return [s for s in complete if s is not found[2] or (flicker is not None and s.theta[flicker] > 0)]


def look(
    record: Record,
    symbols: Sequence[str],
    band: tuple[float, float] | None,
    masks: Sequence[tuple[float, float]] = (),
    *,
    rival: bool,
) -> Found:
    """Fit every subset of the terms; with Gauss-Markov noise among them, or as a `rival` of flicker: see `whittle`."""
    return looked(spectrum(record, detrend=deterministic(symbols)), symbols, band, masks, rival=rival)


def deterministic(symbols: Sequence[str]) -> bool:
    """Whether there is a ramp among the terms."""
    return any(TERMS[symbol].waveform is not None for symbol in symbols)


def looked(
    seen: BinnedSpectrum,
    symbols: Sequence[str],
    band: tuple[float, float] | None,
    masks: Sequence[tuple[float, float]] = (),
    *,
    rival: bool,
) -> Found:
    """The same of a spectrum."""
    used = seen.read(band, masks)
    return fitted(replace(portion(seen, symbols, used), vouched=not rival), rival=rival)


def fitted(part: Portion, *, rival: bool, shortest: float = SLOW) -> Found:
    """Fit every subset of the terms of a portion; see `look`.

    `shortest` is the least time constant, in samples, of a Gauss-Markov term that was not requested; beside resonances
    it is longer than the period of the lowest, so that it does not stand in for their skirts.
    """
    if part.excess is not None and shortest:
        shortest = max(shortest, 2 * math.pi / part.excess.lowest)
    asked = [symbol for symbol in TERMS if symbol in part.shapely]
    noise = [symbol for symbol in part.noise if symbol not in asked]
    if len(asked) > MOST:
        raise UsageError(
            f"at most two noises with a time constant or a frequency can be looked for at a time, not "
            f"{', '.join(asked)}",
            choice="terms",
        )
    flicker = flicker_in(noise)
    if not asked and not (rival and flicker is not None):
        every = subsets(part.likelihood)
        best = select(every, penalties(part))
        return Found(part, noise, every, best, None, best, None)
    if not asked:
        return _with_markov(part.among((*noise, TERMS[noise[flicker or 0]].substitute)), shortest, asked=False)
    # two of them, or the one that is there
    choices = [tuple(asked), *((symbol,) for symbol in asked if len(asked) > 1)]
    tried = (_with_markov(part.among((*noise, *shapely)), 0.0, asked=True) for shapely in choices)
    return min(tried, key=lambda found: found.score)


def _believed(plain: Subset, markov: Subset, part: Portion) -> bool:
    """Whether Gauss-Markov noise that was not requested describes the record, and takes no more than flicker's place.

    What no model explains, a filter's roll-off or motion, it describes better than flicker does, but it is not that.
    At a short time constant it stands in for angle random walk too, which needs as much evidence once more. A rate
    random walk is Gauss-Markov noise without end: it has one number less, which the penalties count.
    """
    return lacking(plain, markov, part) <= 0 and (
        goodness(part.seen, markov.likelihood, markov.theta, part.used).p >= EXPLAINED
    )


def lacking(plain: Subset, markov: Subset, part: Portion) -> float:
    """What Gauss-Markov noise would have to gain in 2 L beyond what it does, to be claimed; see `_believed`."""
    penalty = penalties(part)
    other = np.array([not (TERMS[symbol].substitute or TERMS[symbol].slope > 0) for symbol in part.noise])
    lost = int((other & (plain.theta > 0) & (markov.theta == 0)).sum())
    return markov.score(penalty) + lost * EVIDENCE - plain.score(penalty)


def _with_markov(part: Portion, shortest: float, *, asked: bool) -> Found:
    """Subsets with and without a Gauss-Markov term; where it was not requested, it stands in the place of flicker."""
    noise, penalty = list(part.noise), penalties(part)
    may = np.ones(len(noise), dtype=bool)
    kind = Shapes if sum(len(TERMS[symbol].parameters) for symbol in part.shapely) > 1 else Search
    search = kind(part.likelihood, part, may, shortest, asked)
    every = subsets(part.likelihood, may=~search.must) if len(noise) > len(part.shapely) else []
    plain = select(every, penalty) if every else None
    markov = search.best(penalty)
    best = min((s for s in (plain, markov) if s is not None), key=lambda s: s.score(penalty), default=None)
    if plain and markov and best is markov and not (asked or _believed(plain, markov, part)):
        best = plain
    if best is None:  # nothing but Gauss-Markov noise was requested, and there is none
        best = search.coarse
    return Found(part, noise, every, best, search, plain or best, markov)
