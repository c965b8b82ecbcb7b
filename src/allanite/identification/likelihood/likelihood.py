"""The binned Whittle likelihood of a spectrum that is linear in squared coefficients, with its few loose directions."""

# Derivation: docs/derivations.md.

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from allanite.core.arrays import BoolArray, FloatArray, IntArray
from allanite.core.plain import Portable
from allanite.kernels import leastsquares, whittle

NO_ERRORS = np.zeros(0)
EMPTY = 1e-9  # share of a bin that a filter holds back, at least: a direction of nothing has no estimate


class Minimum(NamedTuple):
    """Theta at the minimum of a likelihood, and what is known beside it where shapes of its columns are not exact."""

    theta: FloatArray
    least: float  # L
    trust: FloatArray  # shape (bins,); share of each bin's coefficients that counts beside their error
    value: float  # 2 L of all coefficients with the error integrated out
    part: float  # of the directions in 2 L
    completed: tuple[FloatArray, ...]  # power, expectation, the part of it that is not the terms', count; eta and V


@dataclass(frozen=True, eq=False)
class PreparedData:
    """The data of likelihoods that differ in their columns, as the kernels take them."""

    of: tuple[FloatArray, ...]  # power, count and products of directions of which it is made
    data: tuple[FloatArray, ...]

    @cached_property
    def smooth(self) -> FloatArray:
        """Power of the bins, smoothed and above zero, shape (bins,)."""
        power, count, *_ = self.of
        window = np.ones(5)
        smooth = np.convolve(power * count, window, "same") / np.convolve(count, window, "same")
        return np.asarray(np.maximum(smooth, 1e-12 * smooth.max()))


@dataclass(frozen=True, eq=False)
class Likelihood(Portable):
    """Power in bins, the columns that may explain it, and the loose directions.

    Attributes
    ----------
    S : array, shape (bins, p)
        Expected power of each term with theta = 1.
    power, count : arrays, shape (bins,)
        Mean power I and number of coefficients nu.
    UU, Uc : arrays, shapes (bins, r, r) and (bins, r)
        Sums over each bin of products of the directions with each other and with the coefficients.
    W : array, shape (r, p)
        Variance along each direction with theta = 1.
    flat : bool array, shape (r,)
        Directions of any size (W is not used).
    added : array, shape (bins,), or 0
        Expected power that is known: m = S theta + added.
    """

    S: FloatArray
    power: FloatArray
    count: FloatArray
    UU: FloatArray
    Uc: FloatArray
    W: FloatArray
    flat: BoolArray
    added: FloatArray | float = 0.0
    prepared: PreparedData | None = field(default=None, repr=False)  # of likelihoods with the same data

    def __getstate__(self) -> dict[str, Any]:
        return super().__getstate__() | {"prepared": None}

    def only(self, bins: BoolArray) -> "Likelihood":
        """The likelihood of some of the bins; a direction of which they hold nothing is dropped."""
        UU, Uc = self.UU[bins], self.Uc[bins]
        held = np.einsum("bii->i", UU) > 0
        return Likelihood(S=self.S[bins], power=self.power[bins], count=self.count[bins], UU=UU[:, held][:, :, held],
                          Uc=Uc[:, held], W=self.W[held], flat=self.flat[held],
                          added=self.added if isinstance(self.added, float) else self.added[bins])  # fmt: skip

    def behind(self, gain: FloatArray, mean: float, edges: tuple[float, float], white: int | None) -> "Likelihood":
        """The likelihood if a filter of this power gain, shape (bins,), stands before the samples.

        `edges` are those of `Filter.edges`, `white` is the column of white noise. A ramp lies far below the cut-off.
        """
        part = self.edged(gain, mean, edges, white)
        return part.explained(self.S * gain[:, None], part.W)

    def edged(self, gain: FloatArray, mean: float, edges: tuple[float, float], white: int | None) -> "Likelihood":
        """The same columns, the edges being those behind a filter: where it lets noise pass, and apart where not."""
        # What a filter holds back begins more gently than white noise does: there the edges are others, and tell
        # nothing of those where it passes. There angle noise has the share `mean` of its variance, the mean gain.
        ends = int(np.count_nonzero(~self.flat))
        which = np.r_[:ends, : self.flat.size]
        share = np.ones((which.size, gain.size))
        share[:ends], share[ends : 2 * ends] = np.sqrt(np.minimum(gain, 1)), np.sqrt(np.maximum(1 - gain, EMPTY))
        UU = self.UU[:, which][:, :, which] * np.einsum("ib,jb->bij", share, share)
        W, (even, steep) = self.W[which], edges
        W[:ends] *= mean
        W[ends : 2 * ends] *= steep / 2
        if white is not None:
            W[: 2 * ends, white] += even
        return replace(self, UU=UU, Uc=self.Uc[:, which] * share.T, W=W, flat=self.flat[which], prepared=None)

    def trusted(self, share: FloatArray) -> "Likelihood":
        """The likelihood in which only a share of each bin's coefficients counts, shape (bins,).

        The sums of the directions are over them too: else a direction could explain more than all power of a bin.
        """
        own = self.power, self.count * share, self.UU * share[:, None, None], self.Uc * share[:, None]
        same = PreparedData(own, (self.power, own[1], self.data[2] * share, self.data[3] * share))
        return replace(self, count=own[1], UU=own[2], Uc=own[3], prepared=same)

    def with_more(self, S: FloatArray) -> "Likelihood":
        """The likelihood with one more column, of a term that does not know the edges of the record."""
        return self.explained(np.column_stack((self.S, S)), np.column_stack((self.W, np.zeros(self.W.shape[0]))))

    def explained(self, S: FloatArray, W: FloatArray) -> "Likelihood":
        """The same data with other columns."""
        return replace(self, S=S, W=W, prepared=self._prepared)

    def adding(self, added: FloatArray) -> "Likelihood":
        """The same data with known power beside the columns."""
        return replace(self, added=added, prepared=self._prepared)

    def expectation(self, theta: FloatArray) -> FloatArray:
        """Expected power m of the bins, without the directions."""
        return np.asarray(self.S @ theta + self.added)

    @cached_property
    def _prepared(self) -> PreparedData:
        same, own = self.prepared, (self.power, self.count, self.UU, self.Uc)
        if same is not None and all(a is b for a, b in zip(same.of, own, strict=True)):
            return same
        UU, Uc = self.UU.transpose(1, 2, 0)[np.ix_(self._order, self._order)], self.Uc.T[self._order]
        return PreparedData(own, (self.power, self.count, np.ascontiguousarray(UU), np.ascontiguousarray(Uc)))

    @property
    def data(self) -> tuple[FloatArray, ...]:
        """Power, count and directions as the kernels take them: bins along the last axis, flat directions first."""
        return self._prepared.data

    @cached_property
    def columns(self) -> FloatArray:
        """S of the bins and then W of the finite directions, shape (p, bins + finite directions)."""
        bins, terms = self.S.shape
        columns = np.empty((terms, bins + np.count_nonzero(~self.flat)))
        columns[:, :bins], columns[:, bins:] = self.S.T, self.W[~self.flat].T
        return columns

    @cached_property
    def _held(self) -> FloatArray:
        """What is known of the expectation, as the kernels take it; the directions have no part in it."""
        known = np.zeros(self.columns.shape[1])
        known[: self.power.size] = self.added
        return known

    @cached_property
    def _order(self) -> IntArray:
        """Directions in the order of the kernels."""
        return np.argsort(~self.flat, kind="stable")

    def directions(self, theta: FloatArray) -> tuple[FloatArray, FloatArray, float]:
        """Estimates eta, their covariance V and the directions' part of 2 L."""
        *_, part, (*_, eta, V) = self._evaluated(theta)
        back = np.argsort(self._order)
        return eta[back], V[np.ix_(back, back)], float(part)

    def value(self, theta: FloatArray) -> float:
        """L at `theta`; infinite where the expectation is not positive."""
        return self._evaluated(theta).value / 2

    def completed(self, theta: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """What the terms are to explain: power, its expectation, the part of that which is not theirs, and the count.

        First the bins, given the directions; then each direction of finite W, whose generalized least-squares estimate
        is one observation of variance W + (its error variance).
        """
        power, m, rest, count, *_ = self._evaluated(theta).completed
        return power, m, rest, count

    def _evaluated(self, theta: FloatArray) -> Minimum:
        theta = np.asarray(theta, dtype=np.float64)
        return self.minimum(theta, np.zeros(theta.size, dtype=bool), first=whittle.LAST)

    def gradient(self, theta: FloatArray) -> FloatArray:
        """dL/dtheta, shape (p,)."""
        power, m, _, count = self.completed(theta)
        return np.asarray(self.columns @ (0.5 * count / m * (1 - power / m)))

    def information(self, theta: FloatArray) -> FloatArray:
        """Expected information of theta with the directions unknown, shape (p, p)."""
        m = self.expectation(theta)
        _, V, _ = self.directions(theta)
        X = self.S / m[:, None]
        UU = self.UU.reshape(m.size, V.size)
        A = ((X / m[:, None]).T @ UU).reshape(X.shape[1], *V.shape)
        loss = UU @ V.ravel() / m
        return np.asarray((X.T * (0.5 * self.count - loss)) @ X + 0.5 * np.einsum("pij,jk,qkl,li->pq", A, V, A, V))

    def minimise(
        self, free: BoolArray, start: FloatArray | None = None, fixed: tuple[int, float] | None = None
    ) -> tuple[FloatArray, float]:
        """Theta >= 0 at the minimum of L, zero where not `free`, and L; Fisher scoring with step halving.

        `fixed` is a term that is held at a value of theta, whether free or not.
        """
        theta = np.where(free, self._start(free) if start is None else start, 0.0)
        moving = free.copy()
        if fixed is not None:
            moving[fixed[0]] = False
            theta[fixed[0]] = fixed[1]
        best = self.minimum(theta, moving)
        if best.least == np.inf and start is not None:  # it lies outside: let every free term in
            best = self.minimum(np.where(moving, np.maximum(theta, self._start(free)), theta), moving)
        return best.theta, best.least

    def settled(
        self, free: BoolArray, start: FloatArray | None, loud: int, errors: FloatArray, *, known: bool = False
    ) -> Minimum:
        """The same where the last `loud` columns have an error of their shapes, the best of some.

        `known` is whether `start` is the minimum without it, or with another.
        """
        theta = np.where(free, self._start(free) if start is None else start, 0.0)
        best = self.minimum(theta, free, loud, errors, int(known))
        if best.least == np.inf and start is not None:
            best = self.minimum(np.where(free, np.maximum(theta, self._start(free)), theta), free, loud, errors)
        return best

    def moved(self, theta: FloatArray, moving: BoolArray) -> tuple[FloatArray, float]:
        """Theta >= 0 at the minimum of L, and L; what is not `moving` is held."""
        least = self.minimum(theta, moving)
        return least.theta, least.least

    def minimum(
        self, theta: FloatArray, moving: BoolArray, loud: int = 0, errors: FloatArray = NO_ERRORS, first: int = 0
    ) -> Minimum:
        """The minimum from a first theta on; what is not `moving` is held."""
        return Minimum(*whittle.minimise(theta, moving, self._held, self.columns, self.data, loud, errors, first))

    def _start(self, free: BoolArray) -> FloatArray:
        """Least squares relative to the smoothed power; no column is left at zero, so that m > 0 everywhere."""
        # A term that is in the directions alone starts at 1.
        columns, smooth = self.columns[:, : self.power.size], self._prepared.smooth
        share = (columns / smooth).max(axis=1)
        theta, shown = np.where(free, 1.0, 0.0), free & (share > 0)
        weight, start = self.count / smooth**2, np.zeros(np.count_nonzero(shown))
        least = leastsquares.weighted_nnls(columns[shown], smooth, weight, start)
        theta[shown] = np.maximum(least, 1e-3 / share[shown])
        return theta
