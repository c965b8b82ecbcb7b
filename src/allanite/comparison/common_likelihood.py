"""Likelihoods of several records: one common model against a model for each, and a coefficient against its like."""

# Derivation: docs/derivations.md.

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, reduce

import numpy as np

from allanite.core.arrays import BoolArray, FloatArray
from allanite.core.errors import DataError
from allanite.core.model import Term
from allanite.core.plain import Portable
from allanite.core.record import SHORTEST, Record
from allanite.core.units import Signal
from allanite.core.validity import Scope
from allanite.identification.likelihood.filters import FILTERS
from allanite.identification.likelihood.law import AKAIKE, Subset, law, select, subsets, traces
from allanite.identification.likelihood.likelihood import Likelihood
from allanite.identification.likelihood.spectrum import FEWEST_BINS, BinnedSpectrum, spectrum
from allanite.identification.likelihood.whittle import column, gain_of, likelihood
from allanite.phrases.phrase import join, say, say_count, spelled
from allanite.terms import TERMS, WHITE

RANK = 1e-9  # share of a bin's largest direction below which another is none


def reduced(part: Likelihood, columns: BoolArray) -> Likelihood:
    """The likelihood of some of the terms; a direction to which none of them adds is dropped."""
    W = part.W[:, columns]
    kept = part.flat | W.any(axis=1)
    return replace(part, S=part.S[:, columns], UU=part.UU[:, kept][:, :, kept], Uc=part.Uc[:, kept], W=W[kept],
                   flat=part.flat[kept])  # fmt: skip


def tied(parts: Sequence[Likelihood], maps: Sequence[FloatArray] | None = None) -> Likelihood:
    """One likelihood of all parts, theta of part j being maps[j] @ theta; without maps one theta for all."""
    maps = maps or [np.eye(part.S.shape[1]) for part in parts]
    sizes = np.cumsum([0, *(part.flat.size for part in parts)])
    bins = np.cumsum([0, *(part.count.size for part in parts)])
    UU, Uc = np.zeros((bins[-1], sizes[-1], sizes[-1])), np.zeros((bins[-1], sizes[-1]))
    for part, i, j in zip(parts, bins, sizes, strict=False):
        here, own = slice(i, i + part.count.size), slice(j, j + part.flat.size)
        UU[here, own, own], Uc[here, own] = part.UU, part.Uc
    return Likelihood(S=np.concatenate([part.S @ H for part, H in zip(parts, maps, strict=True)]),
                      power=np.concatenate([part.power for part in parts]),
                      count=np.concatenate([part.count for part in parts]),
                      UU=UU, Uc=Uc, W=np.concatenate([part.W @ H for part, H in zip(parts, maps, strict=True)]),
                      flat=np.concatenate([part.flat for part in parts]))  # fmt: skip


def least(parts: Sequence[Likelihood], start: FloatArray | None = None) -> tuple[list[FloatArray], float]:
    """Theta of each part by itself, and the sum of the minima of L."""
    free = np.ones(parts[0].S.shape[1], dtype=bool)
    minima = [part.minimise(free, start) for part in parts]
    return [theta for theta, _ in minima], sum(value for _, value in minima)


def drawn(part: Likelihood, theta: FloatArray, rng: "np.random.Generator") -> Likelihood:
    """The same likelihood for powers drawn at random under a model."""
    # In each bin the coefficients have as many components along the directions as these span (F F' = UU), and the rest
    # of the count beside them.
    m = part.expectation(theta)
    value, vector = np.linalg.eigh(part.UU)
    spanned = value > RANK * np.maximum(value.max(axis=1, initial=0.0), 1e-300)[:, None]
    F = vector * np.sqrt(np.where(spanned, value, 0.0))[:, None, :]
    z = rng.standard_normal(spanned.shape) * np.sqrt(m)[:, None] * spanned
    rest = np.maximum(part.count - spanned.sum(axis=1), 0.0)
    squares = (z**2).sum(axis=1) + m * 2 * rng.standard_gamma(rest / 2)
    eta = np.where(part.flat, 0.0, np.sqrt(part.W @ theta)) * rng.standard_normal(part.flat.size)
    Uc = np.einsum("bij,bj->bi", F, z)
    squares += (part.UU @ eta) @ eta + 2 * Uc @ eta
    return replace(part, power=squares / part.count, Uc=Uc + part.UU @ eta)


Shape = tuple[float, ...]

PASSED = 0.25  # share of a filter's cut-off up to which records are compared


@dataclass(frozen=True, eq=False)
class Joint(Portable):
    """The likelihoods of several records of one kind of sensor, for squared coefficients in SI."""

    symbols: tuple[str, ...]  # the noise terms: the columns
    parts: tuple[Likelihood, ...]
    spectra: tuple[BinnedSpectrum, ...]  # the spectrum of each part
    signal: Signal
    band: tuple[float, float]  # the frequencies that every part has, Hz
    # the shape of each term that has one, SI: the same in all records
    shapes: Mapping[str, Shape] = field(default_factory=dict)

    def term(self, symbol: str, value: float) -> Term:
        """A term of a model, with a coefficient in SI."""
        return Term(symbol, value, self.signal, self.shapes.get(symbol, ()))

    @cached_property
    def whole(self) -> Likelihood:
        """All parts with one common model."""
        return tied(self.parts)

    @cached_property
    def fitted(self) -> list[Subset]:
        """Every set of terms, fitted to all parts in common."""
        return subsets(self.whole)

    @cached_property
    def chosen(self) -> Subset:
        """What any part may hold: the common model, with the terms that gain `AKAIKE` in 2 L."""
        return select(self.fitted, AKAIKE)

    def limits(self, which: int, level: float) -> tuple[float, float]:
        """Limits of a common coefficient, SI."""
        penalty = np.full(len(self.symbols), AKAIKE)
        return law(traces(self.fitted, which, penalty), penalty).limits(level)

    def only(self, columns: BoolArray) -> tuple[Likelihood, ...]:
        """The parts with some of the terms."""
        return tuple(reduced(part, columns) for part in self.parts)


def joint(records: Sequence[Record], symbols: Sequence[str], band: tuple[float, float] | None = None, *,
          shapes: Mapping[str, Shape] | None = None, scopes: Sequence[Scope | None] = ()) -> Joint:  # fmt: skip
    """The likelihoods of records in the band of frequencies that all of them have."""
    demand_one_kind(records)
    shapes = shapes or {}
    for record in records:
        if record.size < SHORTEST:
            short = say_count(record.size, "{name!r} has {count} sample; noise coefficients need at least {least}",
                              "{name!r} has {count} samples; noise coefficients need at least {least}",
                              name=record.name, least=SHORTEST)  # fmt: skip
            raise DataError(short)
    plain = [s for s in symbols if not TERMS[s].parameters]
    shaped = [s for s in symbols if s in shapes]
    quiet = [s for s in plain if TERMS[s].waveform is None]
    noise = (*quiet, *shaped)
    spectra = tuple(spectrum(record, detrend=len(quiet) < len(plain)) for record in records)
    band, scopes = common_band(records, band, scopes), scopes or [None] * len(records)
    wholes = [likelihood(bins, plain) for bins in spectra]
    for symbol in shaped:
        term = Term(symbol, 1.0, records[0].signal, shapes[symbol])
        every = zip(wholes, records, spectra, strict=True)
        wholes = [whole.with_more(column(term.sampled(record.rate), bins)) for whole, record, bins in every]
    own = zip(wholes, spectra, scopes, strict=True)
    parts = tuple(part_of(whole, bins, noise, scope, band=band, scopes=scopes) for whole, bins, scope in own)
    return Joint(noise, parts, spectra, records[0].signal, band, shapes)


def part_of(whole: Likelihood, bins: BinnedSpectrum, noise: Sequence[str], scope: Scope | None, *,
            band: tuple[float, float], scopes: Sequence[Scope | None]) -> Likelihood:  # fmt: skip
    """The likelihood of one record behind its filter, within the band and outside all masks, in SI."""
    if scope and scope.filter:
        row, cutoff = scope.filter.row, scope.filter.cutoff / bins.rate
        white = next((i for i, s in enumerate(noise) if TERMS[s].slope == WHITE), None)
        gain = gain_of(row, cutoff, bins)
        whole = whole.behind(gain, float(gain @ bins.count / bins.count.sum()), FILTERS[row].edges(cutoff), white)
    low, high = band
    # coefficient k represents frequencies from k - 1/2 to k + 1/2
    half = bins.rate / (4 * bins.size)
    first, last = bins.frequency(bins.first) + half, bins.frequency(bins.first + bins.count - 1)
    inside = (first > low) & (last <= high * (1 + 1e-9))
    for start, end in (mask for other in filter(None, scopes) for mask in (*other.masks, *other.disturbed)):
        inside &= (last < start) | (first > end)
    if inside.sum() < FEWEST_BINS:
        raise DataError(say_count(int(inside.sum()),
                                  "the common frequency band of the records is too narrow: from {low:.3g} to "
                                  "{high:.3g} Hz, where no vibration hides the noise, one of them has {count} bin "
                                  "of the spectrum, fewer than {fewest}; record longer, at rest, or at more similar "
                                  "rates",
                                  "the common frequency band of the records is too narrow: from {low:.3g} to "
                                  "{high:.3g} Hz, where no vibration hides the noise, one of them has {count} bins "
                                  "of the spectrum, fewer than {fewest}; record longer, at rest, or at more similar "
                                  "rates", low=low, high=high, fewest=FEWEST_BINS))  # fmt: skip
    part = whole.only(inside)
    size = np.array([(bins.rate ** TERMS[s].power / bins.unit_factor) ** 2 for s in noise])  # of squares, in SI
    return replace(part, S=part.S * size, W=part.W * size)


def common_band(records: Sequence[Record], band: tuple[float, float] | None = None,
                scopes: Sequence[Scope | None] = ()) -> tuple[float, float]:  # fmt: skip
    """The frequencies that all records have, Hz, within a band if one is given, and where the models hold."""
    # For a filtered record those that the filter hardly changes: how well its cut-off is known plays no part there.
    low, high = max(1 / (2 * r.duration) for r in records), min(r.rate / 2 for r in records)
    for scope in filter(None, scopes):
        low, high = max(low, scope.band[0]), min(high, scope.band[1])
        high = min(high, PASSED * scope.filter.cutoff) if scope.filter else high
    low, high = (low, high) if band is None else (max(low, band[0]), min(high, band[1]))
    if not low < high:
        bands = [(1 / (2 * r.duration), r.rate / 2) for r in records]
        spans = join(", ", [say("{low:.3g} to {high:.3g} Hz", low=start, high=end) for start, end in bands])
        if band is not None:
            raise DataError(say("the records have no frequency band in common within {low:g} to {high:g} Hz: they "
                                "cover {spans}; record longer, or at more similar rates",
                                low=band[0], high=band[1], spans=spans))  # fmt: skip
        raise DataError(say("the records have no frequency band in common: they cover {spans}; record longer, or at "
                            "more similar rates", spans=spans))  # fmt: skip
    return low, high


def demand_one_kind(records: Sequence[Record]) -> None:
    """Make sure that records are of one kind of sensor."""
    kinds = dict.fromkeys(record.signal.name for record in records)
    if len(kinds) > 1:
        named = reduce(lambda first, second: say("{first} and {second}", first=first, second=second), kinds)
        raise DataError(say("only sensors of one type can be compared, not {kinds}; select channels of one type with "
                            "{option}", kinds=named, option=spelled("--channels", "channels=...")))  # fmt: skip
