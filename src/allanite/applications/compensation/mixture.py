"""The distribution of the coefficients if the noise is known only from the same record, and what is gained."""

# Derivation: docs/derivations.md.

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from allanite.extending import (  # isort: skip
    TERMS, DataError, FloatArray, Likelihood, NormalMixture, Record, Value, likelihood, spectrum)  # fmt: skip

Stretch = tuple[int, int]

FEW = 4  # stretches up to which the edges of each are directions of their own (they matter for quantization alone)


def restricted(y: FloatArray, X: FloatArray, stretches: Sequence[Stretch], *, rate: float, symbols: str) -> Likelihood:
    """Likelihood of the noise terms in `y` less any combination of the columns of `X`."""
    edged = len(stretches) <= FEW
    parts = [_part(y[a:b], X[a:b], rate, symbols) for a, b in stretches]
    edges = sum(e for _, e, _, _ in parts) if edged else 0
    p = X.shape[1]
    UU, Uc, W, at = [], [], [], 0
    for base, count, square, cross in parts:
        kept = np.r_[0 : count if edged else 0, count : count + p]
        place = np.r_[at : at + len(kept) - p, edges : edges + p]
        at += len(kept) - p
        wide, long = np.zeros((len(base.count), edges + p, edges + p)), np.zeros((len(base.count), edges + p))
        wide[:, place[:, None], place], long[:, place] = square[:, kept[:, None], kept], cross[:, kept]
        UU.append(wide)
        Uc.append(long)
        W += [base.W] if edged else []
    return Likelihood(
        S=np.concatenate([base.S for base, *_ in parts]), power=np.concatenate([base.power for base, *_ in parts]),
        count=np.concatenate([base.count for base, *_ in parts]), UU=np.concatenate(UU), Uc=np.concatenate(Uc),
        W=np.concatenate([*W, np.zeros((p, parts[0][0].S.shape[1]))]), flat=np.arange(edges + p) >= edges,
    )  # fmt: skip


def _part(y: FloatArray, X: FloatArray, rate: float, symbols: str) -> tuple[Likelihood, int, FloatArray, FloatArray]:
    """One stretch: its likelihood, the number of its edges, and products of edges and columns with each other and y."""
    from scipy.fft import dct

    powers = spectrum(Record(y, rate, "rad/s"), detrend=False)
    base = likelihood(powers, symbols)
    n, count = powers.size, base.flat.size
    c = dct(y - y.mean(), norm="ortho")[1:]
    k = np.arange(1, n)
    a = np.sqrt(2 / n) * np.cos(np.pi / (2 * n) * k)
    columns = [np.where(k % 2 == parity, a, 0.0) for parity in (0, 1)]
    columns += [dct(column - column.mean(), norm="ortho")[1:] for column in X.T]
    at = powers.first - 1
    square = np.empty((at.size, len(columns), len(columns)))
    cross = np.empty((at.size, len(columns)))
    for i, u in enumerate(columns):
        cross[:, i] = np.add.reduceat(u * c, at)
        for j in range(i + 1):
            square[:, i, j] = square[:, j, i] = np.add.reduceat(u * columns[j], at)
    return base, count, square, cross


NODES = 16  # values of each slow noise coefficient that are tried
REACH = 14.0  # excess in 2 L at which nothing is left to be tried

PRIOR = -0.5
"""Power of a slow noise coefficient by which its likelihood is weighted. Flat weights (0) let the trend of a warming
sensor pass as noise too often where there is little slow noise, 1/c lets false effects pass where there is much of it:
see benchmarks/compensation.py."""


@dataclass(frozen=True, eq=False, repr=False)
class Mixture(Value):
    """Normal distributions of p coefficients under several noises, and the weight of each noise.

    Attributes
    ----------
    weights : array, shape (k,)
    centres, spreads : arrays, shape (k, p)
        Generalized least-squares estimates and their standard errors.
    covariance : array, shape (p, p)
        Covariance of all coefficients.

    Examples
    --------
    >>> one = Mixture(np.ones(1), np.array([[2.0]]), np.array([[1.0]]), np.eye(1))
    >>> round(one.quantile(0.975, 0), 3), round(one.p(0), 4)
    (3.96, 0.0455)
    """

    weights: FloatArray
    centres: FloatArray
    spreads: FloatArray
    covariance: FloatArray

    @property
    def values(self) -> FloatArray:
        """Means, shape (p,)."""
        return np.asarray(self.weights @ self.centres)

    @property
    def errors(self) -> FloatArray:
        """Standard errors, shape (p,)."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    def law(self, which: int) -> NormalMixture:
        """The law of one coefficient."""
        return NormalMixture(self.centres[:, which], self.spreads[:, which], self.weights)

    def below(self, value: float, which: int) -> float:
        """Probability that a coefficient lies below `value`."""
        return self.law(which).below(value)

    def p(self, which: int) -> float:
        """Probability of a coefficient as far from zero if it is zero, two-sided."""
        return self.law(which).p

    def quantile(self, level: float, which: int) -> float:
        """Quantile of a coefficient, by bisection."""
        return self.law(which).quantile(level)

    def scaled(self, by: FloatArray, shift: FloatArray) -> "Mixture":
        """The mixture of by * (coefficient + shift)."""
        return Mixture(self.weights, by * (self.centres + shift), np.abs(by) * self.spreads,
                       self.covariance * np.outer(by, by))  # fmt: skip

    @classmethod
    def _stored(cls, data: dict[str, Any]) -> Self:
        """The mixture written by `to_dict`; DataError if it was changed so that it makes no sense."""
        stored = super()._stored(data)
        parts = stored.weights, stored.centres, stored.spreads, stored.covariance
        k, p = stored.weights.size, len(stored.covariance)
        fine = k > 0 and [part.shape for part in parts] == [(k,), (k, p), (k, p), (p, p)] and stored.spreads.min() > 0
        if not (fine and all(np.isfinite(part).all() for part in parts)):
            raise DataError("these numbers do not form a valid mixture")
        return stored

    def _summary(self) -> str:
        return f"of {self.weights.size} noises: {', '.join(f'{value:g}' for value in self.values)}"


def mixture(likelihood: Likelihood, symbols: str) -> tuple[FloatArray, FloatArray, Mixture]:
    """The most likely noise, and the coefficients averaged over what the slow noise may be."""
    # Slow noise (bias instability, rate random walk) is what hides a slow effect, and is known from a few coefficients
    # of the spectrum only. With it at its most likely value, a tenth of records show an effect that is not there.
    # Averaged over all noise allowed by the restricted likelihood, each term between zero and where 2 L has risen by
    # `REACH`, the coefficients have the wide tails of Student's t, and the intervals remain valid if the noise was not
    # observed.
    every = np.ones(len(symbols), dtype=bool)
    best, least = likelihood.minimise(every)
    # white rate or angle noise hides nothing slow
    slow = [i for i, symbol in enumerate(symbols) if TERMS[symbol].slope >= 0]
    axes = []
    for i in slow:
        # up to where 2 L has risen by `REACH` or a little more; rounding may turn the sign of what alike columns leave
        high = float(best[i]) + 3 / math.sqrt(abs(likelihood.information(best)[i, i]))
        while 2 * (likelihood.minimise(every, best, (i, high))[1] - least) < REACH:
            high *= 1.6
        axes.append(np.linspace(0.0, math.sqrt(high), NODES))
    thetas, excess = [best], [0.0]
    if slow:
        thetas, excess = _grid(likelihood, slow, axes, best)
    weight = np.exp(-0.5 * (np.array(excess) - min(excess)))
    for i, axis in zip(slow, axes, strict=True):
        size = np.sqrt([theta[i] for theta in thetas])
        # the trapezoidal rule: the end of an axis has half a step, and represents what lies between it and its half
        weight *= np.maximum(size, axis[1] / 4) ** PRIOR * np.where(size == 0, 0.5, 1.0)
    kept = weight > 1e-5 * weight.sum()
    weight = weight[kept] / weight[kept].sum()
    likely = [theta for theta, k in zip(thetas, kept, strict=True) if k]
    flat = np.flatnonzero(likelihood.flat)
    directions = [likelihood.directions(theta)[:2] for theta in likely]
    centres = np.array([eta[flat] for eta, _ in directions])
    within = np.array([V[np.ix_(flat, flat)] for _, V in directions])
    off = centres - weight @ centres
    covariance = np.einsum("k,kij->ij", weight, within) + (off.T * weight) @ off
    return best, weight @ np.array(likely), Mixture(weight, centres, np.sqrt(np.einsum("kii->ki", within)), covariance)


def _grid(
    likelihood: Likelihood, slow: list[int], axes: list[FloatArray], best: FloatArray
) -> tuple[list[FloatArray], list[float]]:
    """The other terms at their most likely values, and 2 L, at all combinations of the slow ones."""
    moving = np.ones(best.size, dtype=bool)
    moving[slow] = False
    thetas, values = [], []
    start = best
    for sizes in np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(slow)):
        start = start.copy()
        start[slow] = sizes**2
        start[moving] = np.maximum(start[moving], 1e-3 * best[moving])
        if not likelihood.expectation(start).min() > 0:
            continue  # no noise at all
        if moving.any():
            start, _ = likelihood.moved(start, moving)
        thetas.append(start)
        values.append(2 * likelihood.value(start))
    return thetas, values


@dataclass(frozen=True, repr=False)
class Gain(Value):
    """Mean squares of the rate before and after a correction, SI.

    They are about the mean; where a linear drift was estimated beside the regressors, about a straight line, since the
    correction leaves a drift.

    Attributes
    ----------
    before, after : float
    expected : float
        Expected reduction: for the fitted record, by chance alone without any dependence; for another record, from the
        estimated dependence minus the effect of its errors.
    low, high : float or None
        95 % limits of the reduction of another record; it may be negative.

    Examples
    --------
    >>> gain = Gain(4.0, 3.0, 0.1)
    >>> gain.reduction, gain.explained
    (1.0, 0.25)
    """

    _also = ("explained", "met")

    before: float
    after: float
    expected: float
    low: float | None = None
    high: float | None = None

    @property
    def reduction(self) -> float:
        """Reduction of the mean square, SI squared."""
        return self.before - self.after

    @property
    def explained(self) -> float:
        """Share of the variance that was removed; negative if the correction does harm."""
        return self.reduction / self.before if self.before > 0 else math.nan

    @property
    def met(self) -> bool | None:
        """Whether the reduction lies within its interval; None if there is none."""
        return None if self.low is None or self.high is None else self.low <= self.reduction <= self.high


def about_line(values: FloatArray, trend: FloatArray) -> FloatArray:
    """Centred values, shape (n,) or (n, p), less their projection on the columns of `trend`, if there are any."""
    Q, _ = np.linalg.qr(trend)
    return np.asarray(values - Q @ (Q.T @ values))
