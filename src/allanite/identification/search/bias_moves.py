"""What may be added to the bias of a record: a step, and a warm-up, from the lowest coefficients."""

import math
from collections.abc import Iterator

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.identification.likelihood.whittle import Pair, step_coefficients, warm_up_direction

from .components import COMPONENTS, INSIDE, LONGEST_WARM_UP, SHORTEST_WARM_UP, Part
from .fitting import Fitted, fitted
from .frame import LOW, Frame
from .local import Local
from .state import State

PLACES, FINE_PLACES = 512, 61
"""Places at which a step is looked for, and places between the neighbours of the best."""

WARM_UPS = 11
"""Time constants of a warm-up that are tried, from a hundredth of the record on."""


def _both(pair: Pair) -> FloatArray:
    """Coefficients of even and of odd index."""
    return pair[0] + pair[1]


def _lowest(at: Local) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The lowest coefficients, their standard deviations, and an orthonormal basis of what is loose in them."""
    frame = at.f.frame
    k = min(LOW, frame.count.size)
    c, root = (frame.spectrum.even + frame.spectrum.odd)[:k], np.sqrt(at.f.m[:k])
    loose = [step_coefficients(frame.size, p.shape[0])[:k] for p in at.f.state.of("step")]
    loose += [_both(warm_up_direction(frame.spectrum, p.shape[0]))[:k] for p in at.f.state.of("warm-up")]
    if frame.ramps:
        ramp = np.zeros(k)
        ramp[: min(k, frame.spectrum.ramp.size)] = frame.spectrum.ramp[:k]
        loose.append(ramp)
    Q = np.linalg.qr((np.array(loose) / root).T)[0] if loose else np.zeros((k, 0))
    return c / root, root, Q


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
        D = step_coefficients(frame.size, places)[:, : y.size] / root
        gain = _gains(D, y, Q)
        best = float(places[int(gain.argmax())])
        places = best + apart * np.linspace(-1, 1, FINE_PLACES + 2)[1:-1]
        places = places[(places > 1) & (places < frame.size - 1)]
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
    from scipy.optimize import minimize_scalar

    n = f.frame.size
    low, high = max(part.shape[0] / 2, SHORTEST_WARM_UP * n), min(part.shape[0] * 2, LONGEST_WARM_UP * n)

    def value(x: float) -> float:
        return fitted(f.frame, rest.having(Part("warm-up", "", (math.exp(x),))), f.free).value

    best = minimize_scalar(value, bounds=(math.log(low), math.log(high)), method="bounded", options={"xatol": 2e-3})
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
    D = np.array([_both(warm_up_direction(frame.spectrum, part.shape[0]))[: y.size] for part in parts]) / root
    gain = _gains(D, y, Q)
    if at.able(float(gain.max()), COMPONENTS["warm-up"].cost(frame.size)):
        yield _tuned_warm_up(at.f, rest, parts[int(gain.argmax())])
