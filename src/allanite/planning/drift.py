"""Variance of an angle or a velocity without aid, and of its integrals, from the structure function of the noise."""

# Derivation: docs/derivations.md.

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from itertools import product

import numpy as np
from numpy.typing import NDArray

from allanite.core.arrays import FloatArray
from allanite.core.model import Term
from allanite.core.units import convert
from allanite.terms.row import FAR

GRAVITY = convert(1.0, "g", "m/s^2")
RADIUS = 6_371_008.8  # mean radius of the earth, m; with gravity it makes the Schuler period of 84.4 min

INSTANT = 1.0
"""Mean of flicker that is its bias at the start where nothing was averaged, s: at an instant flicker has no value."""

BRIEF = 1e-5  # the same of a random walk and a ramp, which have one, as a share of t: the limit at 0
SMALL = 0.1  # size of an exponent below which an integral is taken from its series

NODES, HALVINGS, MOST = 24, 40, 4000
"""Gauss-Legendre nodes of a panel; panels, of which each is half as long as the next; half periods that have panels."""


@dataclass(frozen=True)
class Response:
    """What the integral x of a rate's error does to a quantity: at(0) x(t) + the integral of psi(t - s) x(s)."""

    at: float = 0.0  # weight of x(t)
    kernel: tuple[tuple[complex, int, float], ...] = ()  # psi(a) is the sum of the real parts of c a^k exp(i nu a)

    def psi(self, a: FloatArray) -> FloatArray:
        """The kernel at ages `a`, s."""
        return np.asarray(sum(((c * a**k * np.exp(1j * nu * a)).real for c, k, nu in self.kernel), np.zeros_like(a)))

    def bias(self, t: FloatArray) -> FloatArray:
        """What a constant error of the rate of 1 has made of the quantity after `t` s."""
        return np.array([_panels(self, float(each), 0.0).bias for each in t])

    def step(self, t: FloatArray) -> FloatArray:
        """What a constant error of the integral of 1, from the start on, has made of it after `t` s."""
        return np.array([_panels(self, float(each), 0.0).whole for each in t])


@dataclass(frozen=True, eq=False)
class Panels:
    """Nodes h in [0, t], and the weights of D at them: of two ages h apart, of the age h, of the age t - h."""

    h: FloatArray
    pairs: FloatArray
    recent: FloatArray
    early: FloatArray
    whole: float
    bias: float


def flat(order: int, gain: float = 1.0) -> Response:
    """The `order`-th integral of x over a flat earth, times `gain`."""
    return Response(gain) if order == 0 else Response(0.0, ((gain / math.factorial(order - 1), order - 1, 0.0),))


def schuler(order: int, gain: float = 1.0) -> Response:
    """The same of an axis that stays level on a round earth: integrals of cos(w s), w^2 = g/R, instead of 1."""
    w = math.sqrt(GRAVITY / RADIUS)
    kernels = {0: ((1j * gain * w, 0, w),), 1: ((gain + 0j, 0, w),), 2: ((-1j * gain / w, 0, w),)}
    return Response(gain if order == 0 else 0.0, kernels[order])


@lru_cache(maxsize=1024)
def _panels(response: Response, t: float, period: float) -> Panels:
    """Nodes of panels that grow from 0 to t, with ends at every half of a period, and of those of the response."""
    x, w = np.polynomial.legendre.leggauss(NODES)
    edges = np.append(0.0, t * 0.5 ** np.arange(HALVINGS, -1, -1.0))
    for half in (period / 2, *(math.pi / nu for _, _, nu in response.kernel if nu)):
        if half > 0:
            edges = np.append(edges, np.arange(1, min(MOST, int(t / half) + 1)) * half)
    edges = np.unique(edges[edges <= t])
    wide = np.diff(edges)[:, None] / 2
    h, weight = (edges[:-1, None] + wide * (1 + x)).ravel(), (wide * w).ravel()
    recent, early = weight * response.psi(h), weight * response.psi(t - h)
    whole = response.at + recent.sum()
    pairs = 2 * weight * _products(response, h, t)
    return Panels(h, pairs, recent, early, float(whole), float(t * whole - recent @ h))


def _products(response: Response, h: FloatArray, t: float) -> FloatArray:
    """The integral of psi(a) psi(a + h) over all ages a from 0 to t - h, shape of h."""
    # Of the real parts of x and y it takes half the real part of x y + conj(x) y.
    total = np.zeros(h.shape)
    for (c, k, nu), (d, n, mu) in product(response.kernel, repeat=2):
        for first, w in ((c, nu), (np.conj(c), -nu)):
            for j in range(n + 1):  # of (a + h)^n
                inner = math.comb(n, j) * h ** (n - j) * _moment(k + j, 1j * (w + mu), t - h)
                total += 0.5 * (first * d * np.exp(1j * mu * h) * inner).real
    return total


def drift_variance(
    term: Term, response: Response, times: FloatArray, *, calibration: float = 0.0, rate: float | None = None
) -> FloatArray:
    """Variance of a quantity from one noise term, `times` after the start, SI."""
    own = rate if term.row.per_sample and rate else 1.0
    row, size = term.sampled(own), term.power(own) / own**2
    general = float(row.structure(np.array([FAR]))[0]) < 0  # D of noise without a finite variance of its increments
    usual = (INSTANT if row.growth < 2.5 else 0.0) if general and not calibration else calibration

    def one(t: float) -> float:
        window = usual or (BRIEF * t if general else 0.0)
        if row.periodic:
            return _sinusoid(response, t, window, 2 * math.pi * row.shape[0])
        return _sum(response, t, window, lambda h: row.structure(h * own), row.period / own)

    return size * np.array([one(float(t)) for t in times])


def _sum(response: Response, t: float, window: float, D: Callable[[FloatArray], FloatArray], period: float) -> float:
    """-1/2 times the sum of all products of weights and D of their distance."""
    at, p = response.at, _panels(response, t, period)
    whole, r = p.whole, p.bias / window if window else 0.0
    end, last, before = D(np.array([t, window, t + window])).tolist()
    inner = D(p.h)
    variance = -0.5 * p.pairs @ inner - at * (p.recent @ inner)
    variance += (whole + r) * (at * end + p.early @ inner)
    if window:
        variance += r * ((whole + r) * last - at * before - p.early @ D(p.h + window))
    return max(float(variance), 0.0)


def _sinusoid(response: Response, t: float, window: float, w: float) -> float:
    """The mean over the phase of the square, for a rate of amplitude 1: half the square of the complex response."""
    p, turned = _panels(response, t, 0.0), np.asarray(response.at + 0j)
    for c, k, nu in response.kernel:  # the real part of c exp(i nu a) is half of it and of its conjugate
        turned = turned + (c * _moment(k, 1j * (nu - w), t) + c.conjugate() * _moment(k, -1j * (nu + w), t)) / 2
    r = p.bias / window if window else 0.0
    total = turned * np.exp(1j * w * t) - p.whole - r + r * np.exp(-1j * w * window)
    return float(abs(total) ** 2 / (2 * w**2))


def _moment(k: int, u: complex, t: float | FloatArray) -> NDArray[np.complex128]:
    """The integral of a^k exp(u a) from 0 to t, shape of t."""
    z = u * np.asarray(t)
    near = sum(z**j / (math.factorial(j) * (j + k + 1)) for j in range(12)) * np.asarray(t) ** (k + 1)
    if not u:
        return np.asarray(near)
    whole = np.exp(z)
    integral = (whole - 1) / u
    for j in range(1, k + 1):
        integral = (t**j * whole - j * integral) / u
    return np.where(np.abs(z) < SMALL, near, integral)
