"""Mean squares over windows in compact form: what a statistic's window makes of any structure function D(t)."""

# Derivation: docs/derivations.md.

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.statistics.row import Window
from allanite.terms import NoiseTerm

from .lagsums import lag_nodes

FAR_WINDOWS = 20
"""Windows' lengths beyond which a covariance is taken from derivatives of D: differences of D lose its digits there."""

MIN_EXPECTATION = 1e-11
"""What is left of an expectation, relative to its summands, where the window removes the term altogether."""

TINY = 1e-60

Structure = Callable[[FloatArray], FloatArray]


@dataclass(frozen=True, eq=False)
class Compact:
    """The window of one averaging factor."""

    # ``E = mean @ D(h)``, h = 1 - points, ..., points - 1. ``sum_rs w_r w_s C^i_rs(l) C^j_rs(l)`` is the inner product
    # of ``factor @ D_i(l + h)`` and the like of D_j; `factor` has the shape (k, 2 points - 1). ``moment = sum_r w_r
    # mu_r^2`` with ``mu_r = sum_j f_r[j] j^q / q!``: far apart C_rs is mu_r mu_s times a derivative of D.
    mean: FloatArray
    factor: FloatArray
    moment: float

    @property
    def points(self) -> int:
        """Points of the window."""
        return self.mean.size // 2 + 1

    @cached_property
    def white(self) -> FloatArray:
        """The inner product of white angle noise (D = 2) at lag l with D is ``sum_h white[l, h] D(l + h)``."""
        return np.ascontiguousarray(-2 * self.factor[:, self.points - 1 :: -1].T @ self.factor)

    def covariances(self, structure: Structure, lags: FloatArray) -> FloatArray:
        """Covariances of two windows at each lag, shape (lags, k): only inner products have a meaning."""
        h = np.arange(1.0 - self.points, self.points)
        return np.asarray(structure(np.abs(lags[:, None] + h)) @ self.factor.T)


@lru_cache(maxsize=256)
def mean_weights(window: Callable[[int], Window], m: int) -> FloatArray:
    """``E = mean_weights @ D(h)``, shape (2 points - 1,)."""
    weights, filters = window(m)
    A = (filters.T * weights) @ filters
    return -0.5 * np.array([np.trace(A, k) for k in range(1 - A.shape[0], A.shape[0])])


@lru_cache(maxsize=128)
def compact(window: Callable[[int], Window], order: int, m: int) -> Compact:
    """The compact form of ``window(m)``, a difference of this order."""
    weights, filters = window(m)
    A = (filters.T * weights) @ filters
    points = A.shape[0]
    h = np.arange(1 - points, points)
    # sum over j, j' of A[j, j'] A[j + h, j' + h'], by FFT
    spectrum = np.abs(np.fft.rfft2(A, (2 * points, 2 * points))) ** 2
    pairs = np.fft.irfft2(spectrum, (2 * points, 2 * points))[np.ix_(h, h)]
    size, directions = np.linalg.eigh((pairs + pairs.T) / 8)
    kept = size > 1e-13 * size[-1]
    power = np.prod([(np.arange(points) - points / 2) / k for k in range(1, order + 1)], axis=0)
    return Compact(mean=mean_weights(window, m),
                   factor=np.ascontiguousarray((directions[:, kept] * np.sqrt(size[kept])).T),
                   moment=float(weights @ (filters @ power) ** 2))  # fmt: skip


def expectation(mean: FloatArray, structure: Structure) -> float:
    """E of a process with this D; an exact zero where the window removes it."""
    D = structure(np.abs(np.arange(mean.size) - mean.size // 2.0))
    total = float(mean @ D)
    return 0.0 if abs(total) <= MIN_EXPECTATION * float(np.abs(mean) @ np.abs(D)) else total


def kinked_nodes(kinks: FloatArray, end: float) -> tuple[FloatArray, FloatArray]:
    """Lags and weights of a sum up to `end` of what has kinks: at these, two between each of them, and those beyond."""
    between = np.diff(kinks) - 1
    half = np.sqrt(np.maximum(between**2 - 1, 0) / 12)
    centre = (kinks[1:] + kinks[:-1]) / 2
    x, w = lag_nodes([float(kinks[-1])], max(float(end), float(kinks[-1])))
    lag = np.concatenate((kinks[:-1], centre - half, centre + half, x))
    return lag, np.concatenate((np.ones(between.size), between / 2, between / 2, w))


@lru_cache(maxsize=16)
def lattice(points: int, step: float, count: int) -> tuple[FloatArray, FloatArray]:
    """Lags and weights of ``L^-2 sum_|l|<L (L - |l|) f(step l)`` for even f."""
    # f has kinks at the integers up to `points` and is smooth between: there the rule is that of two nodes for sums
    # over integers, of any real number of them.
    if count <= 3 * points:
        lag, weight = np.arange(float(count)), np.ones(count)
    else:
        kinks = np.minimum(np.arange(points + 1) / step, count)
        lag, weight = kinked_nodes(kinks[: np.searchsorted(kinks, count) + 1], count - 1)
    kept = np.abs(weight) > 1e-9
    lag, weight = lag[kept], weight[kept]
    return lag * step, weight * (count - lag) / float(count) ** 2 * np.where(lag > 0, 2.0, 1.0)


def products(
    window: Compact, terms: Sequence[NoiseTerm], order: int, step: float, count: int
) -> tuple[FloatArray, FloatArray]:
    """E (t,) and T (t, t) of `count` windows, one sample apart, which is `step` of the window's own intervals."""
    lags, weights = lattice(window.points, step, count)
    near = lags <= FAR_WINDOWS * window.points
    structures = [averaged(term, step) for term in terms]
    close = np.array([window.covariances(D, lags[near]).T for D in structures]).reshape(len(terms), -1, int(near.sum()))
    far = np.array([term.derivative(2 * order, lags[~near] / step) for term in terms])
    far *= -0.5 * (-1) ** order * window.moment / step ** (2 * order)
    T = np.einsum("ikl,jkl->ij", close * weights[near], close) + (far * weights[~near]) @ far.T
    return np.array([expectation(window.mean, D) for D in structures]), T


def white_level(term: NoiseTerm) -> float:
    """D just above a lag of zero: white angle noise; 0 for a term whose angle is continuous."""
    level = float(term.structure(np.array([TINY]))[0])
    return level if level > math.sqrt(TINY) else 0.0


def averaged(term: NoiseTerm, step: float) -> Structure:
    """D of a term at lags in units of 1/step samples; a point is the mean of 1/step points of white angle noise."""
    white = white_level(term)

    def structure(t: FloatArray) -> FloatArray:
        D = term.structure(t / step)
        return D - white * (t > 0) + white * step * np.minimum(t, 1.0) if white else D

    return structure


def sampled(term: NoiseTerm, step: float) -> Structure:
    """D of a term at lags in units of 1/step samples, where a point is a sample."""
    return lambda t: term.structure(t / step)


def slower(term: NoiseTerm, step: float, D: Callable[[NoiseTerm, float], Structure]) -> NoiseTerm:
    """The term in a record whose samples last as long as 1/step of its own; D is `averaged` or `sampled`."""
    return replace(term, structure=D(term, step), derivative=lambda k, t: step**-k * term.derivative(k, t / step))


def extrapolation(levels: Sequence[int], m: int, power: int) -> FloatArray:
    """Weights of the values at `levels` in that at m of the polynomial in m^-power through them."""
    x, at = np.array(levels, dtype=np.float64) ** -power, float(m) ** -power
    others = ~np.eye(x.size, dtype=bool)
    return np.array([np.prod((at - x[o]) / (x[i] - x[o])) for i, o in enumerate(others)])


def ratios(E: FloatArray, T: FloatArray, terms: Sequence[NoiseTerm]) -> FloatArray:
    """r_ij = T_ij / (E_i E_j); 0 where the window removes a term, and for two deterministic ones."""
    scale = np.outer(E, E)
    noise = np.array([term.waveform is None for term in terms])
    return np.divide(T, scale, out=np.zeros_like(T), where=(scale != 0) & (noise[:, None] | noise))
