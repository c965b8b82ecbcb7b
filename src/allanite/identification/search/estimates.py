"""Estimates of the terms: the laws of the coefficients in SI, and why there are none."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from allanite.core.estimate import WEAK, Averaged, Estimate, averaged
from allanite.core.limits import NormalMixture, Remembered, Stored, quantile
from allanite.core.model import Model, Term
from allanite.core.plain import Portable
from allanite.core.units import Signal
from allanite.core.validity import Scope
from allanite.identification.likelihood.law import ThetaProfile
from allanite.phrases.phrase import say
from allanite.terms import TERMS, WHITE

from .components import CLAIMED, COMPONENTS, TERM, Part
from .fitting import Fitted, fitted, place_of, values_of, with_values
from .laws import Entry, Law, column_of, law_of, noise_part, subset_of
from .refining import refined, resized
from .search import Searched, shows

TWO_SIDED = 1.96  # standard errors from an estimate to its 95 % limits

PROFILE_NODES, PRIOR = 12, 0.0
"""Models along the profile of the slowest noise, at most, and the power of the coefficient in its prior."""

MODELS = 6  # models over which a ramp is averaged, the heaviest
LEAST_NODE_WEIGHT = 1e-3  # weight of a model, over that of the heaviest, below which it is omitted
BEGUN = 0.5  # share of the lowest coefficient of a ramp that must be visible, where it is not read
SHOWS_ANGLE = 0.6  # share of half the sampling rate at which a user's band must end to show angle noise
SEARCHED = 24  # steps in which the limit of a shape is looked for


@dataclass(frozen=True)
class Scale:
    """From theta, in the record's unit and per sample, to coefficients in SI."""

    signal: Signal
    rate: float
    factor: float
    slope: float

    def shape(self, symbol: str, values: Sequence[float]) -> tuple[float, ...]:
        """Values of a term's parameters, SI, from those in sample intervals."""
        known = zip(values, TERMS[symbol].parameters, strict=False)
        return tuple(value * math.pow(self.rate, -p.time) for value, p in known)

    def coefficient(self, symbol: str, root: float) -> float:
        """Coefficient of the root of a theta, with its sign."""
        return root * self.factor * math.pow(self.rate, -TERMS[symbol].power)

    def terms(self, f: Fitted) -> tuple[Term, ...]:
        """The terms of a fit; a second Gauss-Markov noise has the symbol of the slower one."""
        roots = np.sqrt(np.maximum(f.theta, 0.0)).tolist()
        named = [(symbol, ()) for symbol in f.frame.powers] + list(shaped_terms(f))
        return tuple(
            Term(symbol, self.coefficient(symbol, root), self.signal, self.shape(symbol, shape))
            for (symbol, shape), root in zip(named, roots, strict=False)
            if root > 0 and symbol
        )


def shaped_terms(f: Fitted) -> Iterator[tuple[str, tuple[float, ...]]]:
    """Symbols and shapes of the noise in the sensor that has one; no symbol for a power law, which is no term."""
    before = set[str]()
    for part in f.state:
        if part.name == "noise":
            symbol = TERMS[part.label].second if part.label in before else part.label
            before.add(part.label)
            yield symbol, part.shape
        elif part.name == "exponent":
            yield "", ()


@dataclass(frozen=True, eq=False)
class Answer(Portable):
    """What a search says: the models of the average, and the one that is shown."""

    result: Searched
    entries: list[Entry]
    scale: Scale
    symbols: tuple[str, ...]

    @property
    def best(self) -> Fitted:
        """The fit of the least score."""
        return self.entries[0].f

    @cached_property
    def weights(self) -> dict[str, float]:
        """The weight of the models that have a component, by its row."""
        models = [({part.name for part in e.f.state}, e.weight) for e in self.entries]
        held = set[str]().union(*(names for names, _ in models))
        return {name: sum(weight for names, weight in models if name in names) for name in COMPONENTS if name in held}

    @cached_property
    def laws(self) -> list[Law | None]:
        """The laws of the powers."""
        return [law_of(self.entries, i) for i in range(len(self.result.frame.powers))]

    @cached_property
    def shown(self) -> Fitted:
        """The best fit that the terms can express: without a power law, which is no term, and with a term at all."""
        plain = (e.f for e in self.entries if self._expressed(e.f))
        others = (f for f in self.result.every.values() if self._expressed(f))
        return next(plain, None) or min(others, key=lambda f: f.score)

    def _expressed(self, f: Fitted) -> bool:
        return not f.state.lacks_flicker and bool(self.scale.terms(f))

    @cached_property
    def full(self) -> Fitted:
        """The same with every term free that may stand beside the others: what was not selected is not zero."""
        return resized(self.shown, np.ones(self.shown.theta.size, dtype=bool))

    @property
    def slowest(self) -> int:
        """The column of the noise of the longest memory, which is known from a few coefficients only."""
        f = self.full
        slopes = [TERMS[s].slope for s in f.frame.powers] + [-1.0] * (f.theta.size - len(f.frame.powers))
        return max(range(len(slopes)), key=lambda i: slopes[i])

    def nodes(self, beside: tuple[Term, ...]) -> Averaged:
        """Models along the profile of that noise, all terms free, with what stands `beside` it."""
        thetas, weight = ThetaProfile(subset_of(self.full), self.slowest).weighted(PROFILE_NODES, PRIOR)
        along = [(*self.scale.terms(replace(self.full, theta=theta)), *beside) for theta in thetas]
        # beside resonances and white noise behind a filter none of the terms need be there
        kept = [
            (Model(t), float(w))
            for t, w in zip(along, weight, strict=True)
            if t and w > LEAST_NODE_WEIGHT * weight.max()
        ]
        kept = kept or [(Model((*self.scale.terms(self.shown), *beside)), 1.0)]
        return averaged([m for m, _ in kept], [w for _, w in kept])


@dataclass(frozen=True, eq=False)
class LawLimits:
    """Limits of a noise term, in SI; 0 and infinity where nothing is known. An absent one begins at 0."""

    symbol: str
    law: Law | None
    scale: Scale
    claimed: bool

    def __call__(self, level: float) -> tuple[float, float]:
        """Two-sided limits."""
        low, high = self.law.limits(level) if self.law else (0.0, math.inf)
        ends = (low if self.claimed else 0.0, high)
        return self.scale.coefficient(self.symbol, ends[0]), self.scale.coefficient(self.symbol, ends[1])

    def upper(self, level: float) -> float:
        """One-sided upper limit."""
        return self.scale.coefficient(self.symbol, self.law.quantile(level) if self.law else math.inf)


def law_of_term(symbol: str, answer: Answer) -> tuple[Law | None, tuple[float, ...], bool]:
    """The law of a noise term, its shape in samples, and whether it is claimed."""
    if symbol in answer.result.frame.powers:
        law = answer.laws[answer.result.frame.powers.index(symbol)]
        return law, (), law is not None and law.claimed
    which, entries = _numbered(symbol), answer.entries
    fits = [e.f for e in having(symbol, answer)]
    if not fits:  # the best that was searched
        fits = sorted((f for f in answer.result.every.values() if noise_part(f, *which)), key=lambda f: f.score)
        entries = [Entry(f, 1.0) for f in fits[:1]]
    if not fits:
        return None, (), False
    where, count, part = column_of(fits[0], *which), len(fits[0].state.of("noise")), noise_part(fits[0], *which)
    same = [len(e.f.state.of("noise")) == count and column_of(e.f, *which) == where for e in entries]
    return law_of(entries, where or 0, same), part.shape if part else (), claims(symbol, answer)


def _numbered(symbol: str) -> tuple[str, int]:
    """The label of a noise with a time constant, and which of them it is: 0 for the fastest."""
    fast = next((s for s in TERMS if TERMS[s].second == symbol), None)
    return (fast, 1) if fast else (symbol, 0)


def having(symbol: str, answer: Answer) -> list[Entry]:
    """The models that have a noise with a time constant."""
    at = [(e, column_of(e.f, *_numbered(symbol))) for e in answer.entries if e.f.state.of("noise")]
    return [e for e, i in at if i is not None and e.f.theta[i] > 0]


def claims(symbol: str, answer: Answer) -> bool:
    """Whether the models that have a noise with a time constant outweigh the others."""
    return sum(e.weight for e in having(symbol, answer)) >= CLAIMED


def noise_estimate(symbol: str, answer: Answer) -> Estimate:
    """Estimate of a noise term, absent where the models without it weigh too much."""
    scale = answer.scale
    law, shape, claimed = law_of_term(symbol, answer)
    limit = LawLimits(symbol, law, scale, claimed)
    limits, upper = Remembered(limit), Remembered(limit.upper)
    median = scale.coefficient(symbol, law.quantile(0.5)) if law else None
    if not claimed or law is None or median is None:
        return _absent(symbol, scale, upper, limits, median)
    low, high = limits(0.95)
    # the lower limit is not beyond two standard errors
    relative = max((high - low) / (2 * TWO_SIDED * median), (1 - low / median) / TWO_SIDED)
    status = "identified" if relative <= WEAK else "weak"
    plain = Estimate(
        symbol, scale.signal, median, median * relative, status, upper(0.95), "whittle", limits, limits, median
    )
    if not shape:
        return plain
    f = next(f for _, _, f in law.parts)
    parts = f.state.of("noise")
    own = next((part for part in parts if part.shape == shape), parts[0])
    ends = Remembered(ShapeLimits(f, own, scale, symbol))
    return replace(plain, shape=scale.shape(symbol, own.shape), shape_limits=ends)


@dataclass(frozen=True, eq=False)
class ShapeLimits:
    """Limits of the shape of a part, from the profile of the value over each of its numbers, the others following."""

    f: Fitted
    part: Part
    scale: Scale
    symbol: str

    def __call__(self, level: float) -> tuple[tuple[float, float], ...]:
        """Two-sided limits, SI."""
        drop = quantile((1 + level) / 2) ** 2
        ends = [profile_ends(self.f, self.part, i, drop) for i in range(len(self.part.shape))]
        low, high = zip(*ends, strict=True)
        return tuple(zip(self.scale.shape(self.symbol, low), self.scale.shape(self.symbol, high), strict=True))


def profile_ends(f: Fitted, part: Part, which: int, drop: float) -> tuple[float, float]:
    """Values of a shape at which the value of the fit has risen by `drop`; as far as that is looked for."""
    at = place_of(f.state, part) + which
    free = fitted(f.frame, f.state, None, f, f.v)
    best, held = refined(free, settled=EXACT), np.zeros(values_of(f.state).size, dtype=bool)
    held[at] = True
    x = values_of(best.state)

    def excess(y: float) -> float:
        moved = x.copy()
        moved[at] = y
        start = fitted(f.frame, with_values(best.state, moved), None, best, best.v)
        return refined(start, 4, held=held, settled=EXACT).value - best.value - drop

    return _end(excess, x[at], -1.0, math.log(LEAST_SHAPE)), _end(excess, x[at], 1.0, math.log(f.frame.size))


EXACT = 1e-3  # gain in 2 L that ends the rounds of scoring where limits are read off: 0.1 % of a standard error
LEAST_SHAPE = 1e-4  # value of a shape, samples or radians a sample, at which its lower limit is given up


def _end(excess: Callable[[float], float], x: float, sign: float, bound: float) -> float:
    """Where the excess is zero to one side of x; the bound if it is not before."""
    step, inside = 0.02, x
    for _ in range(SEARCHED):
        outside = x + sign * step
        if (outside - bound) * sign >= 0:
            return math.exp(bound)
        if excess(outside) > 0:
            break
        inside, step = outside, step * 2
    else:
        return math.exp(bound)
    for _ in range(SEARCHED):
        middle = (inside + outside) / 2
        if excess(middle) > 0:
            outside = middle
        else:
            inside = middle
        if abs(outside - inside) < 2e-3 * max(abs(outside - x), 1e-3) + 1e-5:
            break
    return math.exp((inside + outside) / 2)


def ramp_estimate(symbol: str, answer: Answer) -> Estimate:
    """The signed ramp: normal for given noise, averaged over possible noise of the longest memory, and over models."""
    # That noise is what hides a ramp, and is known from a few coefficients only: averaging gives the wide tails of
    # Student's t. A model without slow noise counts with its weight, as it does for the other terms.
    scale, size = answer.scale, answer.scale.coefficient(symbol, 1.0)
    if not answer.result.frame.plain.flat.any():  # the band excludes the frequencies of a ramp
        return _absent(symbol, scale, Stored(math.inf), Stored((-math.inf, math.inf)))
    ramps = [(w, _ramp_law(f, answer, size)) for w, f in _heaviest(answer)]
    ramp = NormalMixture(np.concatenate([r.centre for _, r in ramps]), np.concatenate([r.spread for _, r in ramps]),
                         np.concatenate([w * r.weight for w, r in ramps]))  # fmt: skip
    value, error = ramp.value, ramp.error
    limits, upper = Remembered(ramp), Remembered(ramp.upper)
    low, high = limits(1 - TERM)
    if low <= 0 <= high:
        return _absent(symbol, scale, upper, limits, value)
    if not _begins(answer, value / size):
        return _absent(symbol, scale, Stored(math.inf), Stored((-math.inf, math.inf)))
    status = "identified" if error <= WEAK * abs(value) else "weak"
    return Estimate(symbol, scale.signal, value, error, status, upper(0.95), "whittle", limits, limits, value)


def _heaviest(answer: Answer) -> list[tuple[float, Fitted]]:
    """The heaviest models, one of each family and set of terms, and their shares."""
    total: dict[object, float] = {}
    first: dict[object, Fitted] = {}
    for e in answer.entries:
        kind = e.f.state.family, e.f.free[: len(e.f.frame.powers)].tobytes()
        total[kind] = total.get(kind, 0.0) + e.weight
        first.setdefault(kind, e.f)
    kinds = sorted(total, key=lambda kind: -total[kind])[:MODELS]
    whole = sum(total[kind] for kind in kinds)
    return [(total[kind] / whole, first[kind]) for kind in kinds]


def _ramp_law(f: Fitted, answer: Answer, size: float) -> NormalMixture:
    slopes = [TERMS[s].slope for s in f.frame.powers] + [-1.0] * (f.theta.size - len(f.frame.powers))
    slowest = max(np.flatnonzero(f.free).tolist(), key=lambda i: slopes[i])
    thetas, weight = ThetaProfile(subset_of(f), slowest).weighted()
    along = [f.trusted.directions(theta)[:2] for theta in thetas]
    centre = size * (np.array([eta[-1] for eta, _ in along]) + answer.scale.slope)
    return NormalMixture(centre, size * np.sqrt([V[-1, -1] for _, V in along]), weight)


def _begins(answer: Answer, slope: float) -> bool:
    """Whether the lowest coefficient, which has 98 % of the power of a ramp, is read, or is half of the ramp's."""
    # Else it is what leaks from a cycle or another motion slower than what is read.
    frame, spectrum = answer.result.frame, answer.result.frame.spectrum
    lowest = spectrum.even[0] + spectrum.odd[0] + spectrum.slope * spectrum.ramp[0]
    return bool(frame.used[0] or lowest / (slope * spectrum.ramp[0]) > BEGUN)


def _absent(
    symbol: str, scale: Scale, upper: Callable[[float], float], limits: Callable[[float], tuple[float, float]],
    median: float | None = None,
) -> Estimate:  # fmt: skip
    highest = upper(0.95) if math.isfinite(upper(0.95)) else None
    return Estimate(symbol, scale.signal, None, None, "absent", highest, "whittle", limits, limits, median)


def observable(estimate: Estimate, scope: Scope, answer: Answer) -> Estimate:
    """The estimate, or why the term is not observable with the frequencies that are read and what stands beside it."""
    (low, high), claimed, f, reason = scope.band, estimate.claimed, answer.best, ""
    edge, shaped = bool(TERMS[estimate.symbol].edge), f.state.rises or bool(f.state.of("factor"))
    if edge and not claimed and scope.filter is not None:
        reason = say("the filter hides the frequencies where it would be visible")
    elif edge and high < SHOWS_ANGLE * answer.scale.rate / 2:
        reason = say("the band, which ends at {frequency:.3g} Hz, excludes the frequencies where it would be visible",
                     frequency=high)  # fmt: skip
    elif edge and claimed and shaped and not shows(f, f.frame.powers.index(estimate.symbol)):
        reason = say("it dominates the spectrum at no frequency, and beside a filter or vibration a smaller share "
                     "cannot be told from their shapes")  # fmt: skip
    elif low > 0 and not claimed and estimate.upper in (None, 0.0, math.inf):
        reason = say(
            "the band begins at {frequency:.3g} Hz, above the frequencies where it would be visible", frequency=low
        )
    if not reason:
        return estimate
    return Estimate(estimate.symbol, estimate.signal, None, None, "not observable", None, "whittle", reason=reason)


def under(a: float, estimate: Estimate) -> Estimate:
    """The estimate if the bias drift follows another power law: only the white noise besides it is valid."""
    row = TERMS[estimate.symbol]
    if row.waveform is not None or estimate.status == "not observable" or row.slope == WHITE:
        return estimate
    return estimate.invalid(
        say("the power spectral density falls as f^-{exponent:.2f}, like none of the terms", exponent=a)
    )
