"""What no component describes: where a factor may stand, and how large it may be."""

from collections.abc import Iterator

import numpy as np

from allanite.core.arrays import FloatArray

from .components import COMPONENTS, FACTORS, SIZES, Part
from .factors import SLOWEST_OCTAVE
from .fitting import Fitted, factor_basis, fitted
from .local import CANDIDATES, FAR, Local
from .refining import refined
from .state import State

FACTOR_SIZES = np.array([0.01, 0.02, 0.04, 0.08, 0.16, 0.32, 0.64, 1.28, 2.56])
"""Sizes of a factor that are tried, RMS of the logarithm of the power."""

SHORT_OF_PRICE, LEAST_EVIDENCE = 4.0, 1.5
"""Evidence for a factor, in 2 L, from which it is fitted: so much below its price, where it weighs e^-1 of the state
without it, and at least so much, as a factor of no size has none."""

WIDE_SIZES, MANY = (0.64, 2.56), 14
"""Sizes of a factor that are fitted where one step is no guide, and rounds of scoring of these fits: each
divides the power by e^2 at most."""


def factors(at: Local) -> Iterator[State | Fitted]:
    """What no component describes: by the evidence of one step, and by a fit of each where that is no guide."""
    frame, state = at.f.frame, at.f.state
    if frame.white is None or len(state.of("factor")) >= COMPONENTS["factor"].most:
        return
    splines, taken = frame.splines, {(p.label, *p.shape[:2]) for p in state.of("factor")}
    base = splines.B.T * (at.f.inside / at.f.m)
    b, rest = at.projected(base)
    G = (base * at.h) @ base.T - rest @ rest.T
    ranked = []
    for place in splines.places:
        if place not in taken:
            L = splines.root(place)
            size, vectors = np.linalg.eigh(L.T @ G @ L)
            size, y = np.maximum(size, 0.0), (vectors.T @ (L.T @ b)) ** 2
            t2 = FACTOR_SIZES[:, None] ** 2
            gain = (t2 * y / (1 + t2 * size)).sum(axis=1) - np.log1p(t2 * size).sum(axis=1)
            best = int(gain.argmax())
            if gain[best] > max(FACTORS[place[0]] - SHORT_OF_PRICE, LEAST_EVIDENCE):
                ranked.append((float(gain[best]) - FACTORS[place[0]], place, float(FACTOR_SIZES[best])))
    ranked.sort(key=lambda each: -each[0])
    if not ranked:
        return
    tries = [
        state.having(Part("factor", place[0], (place[1], place[2], size))) for _, place, size in ranked[:CANDIDATES]
    ]
    if ranked[0][0] > FAR and not taken:
        wide = [p for p in splines.places if p[0] != "between" and p not in taken]
        parts = [Part("factor", p[0], (p[1], p[2], size)) for p in wide for size in WIDE_SIZES]
        each = sorted((_raised(at, part) for part in parts), key=lambda f: f.score)[: 2 * CANDIDATES]
        yield from sorted((refined(f, MANY) for f in each), key=lambda f: f.score)[:CANDIDATES]
    yield from tries


def _raised(at: Local, part: Part) -> Fitted:
    """The fit beside a factor that begins where it fits the logarithms of the residuals best."""
    state = at.f.state.having(part)
    A = factor_basis(at.f.frame, state) * (at.f.inside / at.f.m)[:, None]
    return fitted(at.f.frame, state, v=nearest(A, at.h[: A.shape[0]], at.logs))


def nearest(A: FloatArray, h: FloatArray, u: FloatArray) -> FloatArray:
    """Coefficients v ~ N(0, 1) with A v as near to u as they allow, h being half the counts."""
    v = np.linalg.solve(np.eye(A.shape[1]) + (A * h[:, None]).T @ A, A.T @ (h * u))
    return np.asarray(v, dtype=np.float64)


def neighbours(part: Part) -> Iterator[Part]:
    """A factor with another size, or a place beside its own."""
    low, high, size = part.shape
    for other in (size / 2, size / 2**0.5, size * 2**0.5, size * 2):
        if SIZES[0] < other < SIZES[1]:
            yield part._replace(shape=(low, high, other))


def places_beside(part: Part, top: float) -> Iterator[Part]:
    """The same beginning or ending elsewhere."""
    low, high, size = part.shape
    step = 0.5 if "above" in part.label else 1.0
    if part.label == "all":
        return
    for a, b in ((low - step, high), (low + step, high), (low, high - step), (low, high + step)):
        if ("above" in part.label and b != high) or a < SLOWEST_OCTAVE:
            continue
        if 0 <= a < b - 1 and b <= top + 1e-9 and (a <= top - 1e-9):
            yield part._replace(shape=(a, b, size))
