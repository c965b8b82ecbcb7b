"""The neighbours of a state: what may be added, left out or exchanged, each judged first by one step of scoring."""

import math
from collections.abc import Iterator

import numpy as np
import scipy

from allanite.core.arrays import FloatArray
from allanite.identification.likelihood.filters import FILTERS
from allanite.identification.likelihood.whittle import step_coefficients

from .components import (  # isort: skip
    AT_BOUND, BROAD, COMPONENTS, FEWEST_PERIODS, HIDING, INSIDE, LEAST_MARKOV, LONGEST_MARKOV, LONGEST_WARM_UP,
    MOST_PERIODS, PERIODS, QUICKEST_MARKOV, SHORTEST_WARM_UP, Part, cost_of, most_periods
)  # fmt: skip
from .fitting import Fitted, fitted
from .frame import DIRECTIONS, LOW, Frame, starts_of
from .refining import CANDIDATES, FAR, MISSED, Local, Move, refined
from .state import State

PLACES, FINE_PLACES = 512, 61  # places at which a step is looked for, and places between the neighbours of the best
WARM_UPS = 11  # time constants of a warm-up that are tried, from a hundredth of the record on


def _lowest(at: Local) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The lowest coefficients, their standard deviations, and an orthonormal basis of what is loose in them."""
    frame = at.f.frame
    k = min(LOW, frame.count.size)
    c, root = (frame.spectrum.even + frame.spectrum.odd)[:k], np.sqrt(at.f.m[:k])
    parts = (p for p in at.f.state if p.name in DIRECTIONS)
    loose = [each for p in parts for each in _low(frame, p, k)]
    if frame.ramps:
        ramp = np.zeros(k)
        ramp[: min(k, frame.spectrum.ramp.size)] = frame.spectrum.ramp[:k]
        loose.append(ramp)
    Q = np.linalg.qr((np.array(loose) / root).T)[0] if loose else np.zeros((k, 0))
    return c / root, root, Q


def _low(frame: Frame, part: Part, k: int) -> list[FloatArray]:
    """The lowest coefficients of the directions of a part."""
    odd = frame.spectrum.first[:k] % 2 > 0
    return [np.where(odd, at_odd[:k], at_even[:k]) for at_even, at_odd in frame.directions(part.name, part.shape[0])]


def _gains(D: FloatArray, y: FloatArray, Q: FloatArray) -> FloatArray:
    """Gains of directions, shape (k, coefficients), beside what is loose."""
    D = D - D @ Q @ Q.T
    return np.asarray((D @ y) ** 2 / np.maximum((D**2).sum(axis=1), 1e-9))


def steps(at: Local) -> Iterator[State]:
    """One more step of the bias, where it gains most beside those of the state and a ramp."""
    frame, state = at.f.frame, at.f.state
    if not frame.able_to_step or len(state.of("step")) >= COMPONENTS["step"].most:
        return
    y, root, Q = _lowest(at)
    apart = frame.size / (PLACES + 1)
    places, gain = apart * np.arange(1, PLACES + 1), np.zeros(1)
    for _ in range(2):
        places = places[(places > 1) & (places < frame.size - 1)]
        D = step_coefficients(frame.size, places)[:, : y.size] / root
        gain = _gains(D, y, Q)
        best = float(places[int(gain.argmax())])
        places = best + apart * np.linspace(-1, 1, FINE_PLACES + 2)[1:-1]
    if at.able(float(gain.max()), COMPONENTS["step"].cost(frame.size)):
        yield state.having(Part("step", "", (best,)))


def warm_ups_of(frame: Frame) -> list[Part]:
    """Warm-ups that are tried first."""
    return [
        Part("warm-up", "", (tau,))
        for tau in (frame.size * np.geomspace(1 / 100, LONGEST_WARM_UP / INSIDE, WARM_UPS)).tolist()
    ]


def _tuned_warm_up(f: Fitted, rest: State, part: Part) -> State:
    """The state with the best time constant near that of a warm-up."""
    n = f.frame.size
    low, high = max(part.shape[0] / 2, SHORTEST_WARM_UP * n), min(part.shape[0] * 2, LONGEST_WARM_UP * n)

    def value(x: float) -> float:
        return fitted(f.frame, rest.having(Part("warm-up", "", (math.exp(x),))), f.free).value

    bounds = math.log(low), math.log(high)
    best = scipy.optimize.minimize_scalar(value, bounds=bounds, method="bounded", options={"xatol": 2e-3})
    return rest.having(Part("warm-up", "", (math.exp(float(best.x)),)))


def warm_ups(at: Local) -> Iterator[State]:
    """A warm-up, or the one of the state with another time constant."""
    frame, state = at.f.frame, at.f.state
    if not frame.able_to_warm_up:
        return
    own, loose, parts = state.of("warm-up"), state.of("step"), warm_ups_of(frame)
    if loose and not own:  # steps near the start, that fall like a warm-up
        bare = state.lacking(*loose)
        values = [fitted(frame, bare.having(part)).value for part in parts]
        yield _tuned_warm_up(at.f, bare, parts[values.index(min(values))])
    rest = state.lacking(*own)
    if own:
        yield _tuned_warm_up(at.f, rest, own[0])
        return
    y, root, Q = _lowest(at)
    D = np.concatenate([_low(frame, part, y.size) for part in parts]) / root
    gain = _gains(D, y, Q)
    if at.able(float(gain.max()), COMPONENTS["warm-up"].cost(frame.size)):
        yield _tuned_warm_up(at.f, rest, parts[int(gain.argmax())])


WAVES = 25  # numbers of periods of a wave that are tried, a quarter apart
NEAR = 0.3  # periods within which the best is looked for: from a number that is tried beyond the next


def waves(at: Local) -> Iterator[State]:
    """A slow wave, or that of the state with another period."""
    frame, state = at.f.frame, at.f.state
    if not frame.able_to_warm_up:
        return
    rest = state.lacking(*state.of("wave"))
    if rest != state:
        yield _tuned_wave(at.f, rest, state.of("wave")[0].shape[0])
        return
    y, root, Q = _lowest(at)
    tried = np.linspace(FEWEST_PERIODS, MOST_PERIODS, WAVES + 1)[1:-1]
    periods = tried[tried < most_periods(frame)].tolist()
    if not periods:
        return
    gain = [_gain_together(np.array(_low(frame, Part("wave", "", (c,)), y.size)) / root, y, Q) for c in periods]
    if at.able(max(gain), COMPONENTS["wave"].cost(frame.size)):
        yield _tuned_wave(at.f, rest, periods[int(np.argmax(gain))])


def _gain_together(D: FloatArray, y: FloatArray, Q: FloatArray) -> float:
    """Gain of several directions together beside what is loose."""
    basis = np.linalg.qr((D - D @ Q @ Q.T).T)[0]
    return float(((y @ basis) ** 2).sum())


def _tuned_wave(f: Fitted, rest: State, periods: float) -> State:
    """The state with the best period near that of a wave."""

    def value(x: float) -> float:
        return fitted(f.frame, rest.having(Part("wave", "", (x,))), f.free).value

    bounds = max(periods - NEAR, FEWEST_PERIODS), min(periods + NEAR, most_periods(f.frame))
    best = scipy.optimize.minimize_scalar(value, bounds=bounds, method="bounded", options={"xatol": 1e-3})
    return rest.having(Part("wave", "", (float(best.x),)))


PER_DECADE, PROMISING = 4, 2  # time constants a decade that are tried, and how many of them are fitted
TRIED_QUALITIES = (2.5, 6.0, 15.0, 40.0, 120.0)  # qualities with which resonances are looked for

EQUAL = 0.5  # change of the value up to which the numerators of a resonance are the same: those of a sharp one are
BINS = 8  # bins that stand out at which resonances are looked for


def less(at: Local) -> Iterator[State]:
    """Without each of its parts that may be missed; a filter takes its floor along."""
    for part in dict.fromkeys(at.f.state):
        if at.loss(part) > cost_of(part, at.f.frame) + MISSED:
            continue
        rest = at.f.state.lacking(part)
        yield rest.lacking(*rest.of("floor")) if part.name == "filter" else rest


def exchanged(at: Local) -> Iterator[State]:
    """With another numerator of a resonance, beyond `BROAD` where it stops there, or another filter of that cut-off."""
    state = at.f.state
    for part in state.of("resonance"):
        other = "flat" if part.label == "high-pass" else "high-pass"
        flipped = state.lacking(part).having(part._replace(label=other))
        if abs(rise := fitted(at.f.frame, flipped, at.f.free).value - at.f.value) > EQUAL and rise < MISSED:
            yield flipped
        if abs(math.log(part.shape[1] / BROAD)) < AT_BOUND:
            beyond = BROAD / INSIDE if part.shape[1] >= BROAD else BROAD * INSIDE
            yield state.lacking(part).having(part._replace(shape=(part.shape[0], beyond)))
    if state.filter is None:
        return
    rest, cutoff = state.lacking(state.filter), state.filter.shape[0]
    tries = []
    for row, filter_ in FILTERS.items():
        if row != state.filter.label:
            near = [c for c in (0.8 * cutoff, cutoff, 1.25 * cutoff) if LOW_CUT < c < filter_.widest]
            tries += [fitted(at.f.frame, rest.having(Part("filter", row, (c,)))) for c in near]
    for f in sorted(tries, key=lambda f: f.value)[:CANDIDATES]:
        yield f.state


LOW_CUT = 0.0101  # cycles a sample: just above the lowest cut-off


def floors(at: Local) -> Iterator[State]:
    """White noise behind the filter."""
    state, part = at.f.state, Part("floor", "", ())
    if state.filter is None or state.of("floor") or state.filter.shape[0] < HIDING:
        return
    passed = at.f.frame.gain(state.filter.label, state.filter.shape[0])
    if at.able(float(at.gains(((1 - passed) / at.f.m)[None])[0]), cost_of(part, at.f.frame)):
        yield state.having(part)


def time_constants(n: int) -> FloatArray:
    """Of Gauss-Markov noise, that are tried first."""
    high = max(LONGEST_MARKOV * n, 2 * LEAST_MARKOV)
    steps = max(4, round(PER_DECADE * math.log10(high / QUICKEST_MARKOV)))
    return np.geomspace(QUICKEST_MARKOV * INSIDE, high / INSIDE, steps)


def markov(at: Local) -> Iterator[State]:
    """Gauss-Markov noise."""
    frame, state = at.f.frame, at.f.state
    if len(state.of("noise")) >= COMPONENTS["noise"].most or any(len(p.shape) > 1 for p in state.of("noise")):
        return
    parts = [Part("noise", "GM", (T,)) for T in time_constants(frame.size).tolist()]
    yield from _promising(at, parts, np.array([frame.column("GM", p.shape) for p in parts]) * _acting(at.f))


def _acting(f: Fitted) -> FloatArray:
    """What the filter and the factors make of noise in the sensor, over m."""
    frame, first = f.frame, next((p for p in f.state if COMPONENTS[p.name].inside), None)
    if frame.powers:
        bare = frame.table(frame.powers[0])
    else:  # one noise with a shape was asked for, at least
        power = COMPONENTS[first.name].power if first else None
        bare = power(frame, first) if first and power else np.ones(1)
    return np.asarray(f.likelihood.S[:, 0] / np.maximum(bare, 1e-300) / f.m)


def _promising(at: Local, parts: list[Part], C: FloatArray) -> Iterator[State]:
    """The best parts by one step; by a fit of each where that is no guide."""
    state, gain = at.f.state, at.gains(C)
    able = [i for i in np.argsort(-gain) if at.able(float(gain[i]), cost_of(parts[i], at.f.frame))]
    if not able:
        return
    if gain[able[0]] > FAR:
        tries = [fitted(at.f.frame, state.having(part), None, None) for part in parts]
        yield from (f.state for f in sorted(tries, key=lambda f: f.value)[:PROMISING])
        return
    for i in able[:PROMISING]:
        yield state.having(parts[i])


def exponents(at: Local) -> Iterator[State]:
    """A power law in the place of flicker, where there is noise at low frequencies."""
    frame, state = at.f.frame, at.f.state
    if frame.flicker is None or state.of("exponent") or not (at.f.theta[: frame.slow.size][frame.slow] > 0).any():
        return
    tries = [fitted(frame, state.having(Part("exponent", "", (a,)))) for a in (0.75, 0.85, 1.2, 1.4, 1.55)]
    yield min(tries, key=lambda f: f.value).state


def filters(at: Local) -> Iterator[State]:
    """A low-pass filter: the best cut-off of each row, as their shapes are rivals."""
    frame, state = at.f.frame, at.f.state
    if state.filter is not None:
        return
    yield from _hiding_angle(at.f)
    tries, logs = frame.log_gains
    gain = at.gains(logs * (at.f.inside / at.f.m), signed=True)
    cost = COMPONENTS["filter"].cost(frame.size)
    if not at.able(float(gain.max()), cost):
        return
    best: dict[str, tuple[float, float]] = {}
    far = gain.max() > FAR
    for (row, cutoff), g in zip(tries, gain.tolist(), strict=True):
        if not far and not at.able(g, cost):
            continue
        value = fitted(frame, state.having(Part("filter", row, (cutoff,)))).value if far else -g
        best[row] = min(best.get(row, (math.inf, 0.0)), (value, cutoff))
    for row in sorted(best, key=lambda row: best[row])[: 5 if not state.of("resonance") else 2]:
        yield state.having(Part("filter", row, (best[row][1],)))


def _hiding_angle(f: Fitted) -> Iterator[State]:
    """A low-pass filter behind which angle noise is nearly white, so that neither gains without the other."""
    # White noise stands beside it, and is resolved below the cut-off: alone it would be white noise by another name.
    frame, angle = f.frame, f.frame.angle
    bare = not f.theta[: angle.size][angle].any() and all(p.name in DIRECTIONS for p in f.state)
    if frame.white is None or not angle.any() or not bare or frame.size * HIDING < PERIODS:
        return
    cutoffs = [c for c in starts_of("rc") if c > HIDING]
    tries = [fitted(frame, f.state.having(Part("filter", "rc", (c,)))) for c in cutoffs]
    best = refined(min(tries, key=lambda g: g.value))
    if best.theta[frame.white] > 0 and best.theta[: angle.size][angle].any():
        yield best.state


def peaks(at: Local) -> list[tuple[float, Part]]:
    """Resonances by their gains: the bins that stand out, with several qualities and both numerators."""
    frame = at.f.frame
    able = (frame.first >= 2 * PERIODS) & (at.over > 0) & (frame.centre * np.pi / frame.size < 3.05)
    three = np.ones(3)
    z = np.convolve(at.over * at.h, three, "same") / np.sqrt(np.convolve(at.h, three, "same") + 1e-9)
    order = [int(i) for i in np.argsort(-np.where(able, z, -np.inf)) if able[i]]
    places: list[int] = []
    for i in order:
        if all(abs(math.log(frame.centre[i] / frame.centre[j])) > 0.03 for j in places):
            places.append(i)
        if len(places) == BINS:
            break
    if not places:
        return []
    parts = [
        Part("resonance", label, (float(np.pi / frame.size * frame.centre[i]), q))
        for i in places for q in TRIED_QUALITIES for label in ("flat", "high-pass")
    ]  # fmt: skip
    power = COMPONENTS["resonance"].power
    assert power is not None  # noqa: S101 - its row has one
    gain = at.gains(np.array([power(frame, p) for p in parts]) / at.f.m)
    return sorted(zip(gain.tolist(), parts, strict=True), key=lambda pair: -pair[0])


def resonances(at: Local) -> Iterator[State]:
    """The best resonances that differ, and all that stand out at once."""
    frame, state = at.f.frame, at.f.state
    room = COMPONENTS["resonance"].most - len(state.of("resonance"))
    cost = COMPONENTS["resonance"].cost(frame.size)
    if room <= 0:
        return
    chosen: list[tuple[float, Part]] = []
    for gain, part in peaks(at):
        if not at.able(gain, cost):
            break
        if all(_apart(part, other) for _, other in chosen):
            chosen.append((gain, part))
    yield from (state.having(part) for _, part in chosen[:CANDIDATES])
    strong = [part for gain, part in chosen if gain > COMPONENTS["resonance"].price(frame.size)]
    distinct: list[Part] = []
    for part in strong:
        if all(
            abs(math.log(part.shape[0] / other.shape[0])) > 0.5 / min(part.shape[1], other.shape[1])
            for other in distinct
        ):
            distinct.append(part)
    if len(distinct) > 1:
        yield state.having(
            *(p if p.shape[1] >= BROAD else p._replace(shape=(p.shape[0], 2 * BROAD)) for p in distinct[:room])
        )


def _apart(part: Part, other: Part) -> bool:
    """Whether two resonances differ."""
    ratio = part.shape[1] / other.shape[1]
    return abs(math.log(part.shape[0] / other.shape[0])) > 0.08 or not 1 / 3 < ratio < 3


MOVES: tuple[Move, ...] = (less, exchanged, floors, steps, warm_ups, waves, markov, exponents, resonances, filters)
"""All ways from a state to its neighbours. Their order decides nothing."""
