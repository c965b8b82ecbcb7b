r"""The binned Whittle likelihood of a spectrum that is linear in squared coefficients, with its few loose directions.

The coefficients of the transform are independent with variances m = S theta, but for a few directions U: the two edges
of the record, which quantization makes noisier than its inside (variance proportional to theta), and a ramp (any
size). They are integrated out exactly: with eta ~ N(0, W), M = diag(m), A = U'M^-1 U, b = U'M^-1 c and V = (W^-1 +
A)^-1

    2 L(theta) = sum nu (ln m + I / m) + ln det(W V^-1) - b'V b            to be minimised over theta >= 0,

for a ramp with W^-1 = 0 (restricted likelihood, REML). The gradient of L is that of the plain likelihood with I
replaced by its expectation given the data, (c - U eta)^2 + U V U', while each direction of finite W is one observation
more.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


_NOTHING = 1e-250


@dataclass(frozen=True, eq=False)
class Likelihood:
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
    """

    S: FloatArray
    power: FloatArray
    count: FloatArray
    UU: FloatArray
    Uc: FloatArray
    W: FloatArray
    flat: BoolArray

    def only(self, bins: BoolArray) -> "Likelihood":
        """The likelihood of some of the bins; a direction of which they hold nothing is dropped."""
        UU, Uc = self.UU[bins], self.Uc[bins]
        held = np.einsum("bii->i", UU) > 0
        return Likelihood(
            S=self.S[bins],
            power=self.power[bins],
            count=self.count[bins],
            UU=UU[:, held][:, :, held],
            Uc=Uc[:, held],
            W=self.W[held],
            flat=self.flat[held],
        )

    def expectation(self, theta: FloatArray) -> FloatArray:
        """Expected power m of the bins, without the directions."""
        return np.asarray(self.S @ theta)

    def directions(self, theta: FloatArray) -> tuple[FloatArray, FloatArray, float]:
        """Estimates eta, their covariance V and the directions' part of 2 L."""
        inverse_m = 1 / self.expectation(theta)
        r = self.flat.size
        # a direction without variance gets a precision beyond all others: its eta and V vanish, and its part of L too
        precision = np.where(self.flat, 0.0, 1 / np.maximum(self.W @ theta, _NOTHING))
        G = (inverse_m @ self.UU.reshape(-1, r * r)).reshape(r, r)
        G.flat[:: r + 1] += precision
        V = np.asarray(np.linalg.inv(G), dtype=np.float64)
        b = inverse_m @ self.Uc
        eta = V @ b
        part = np.linalg.slogdet(G)[1] - np.log(precision[~self.flat]).sum() - b @ eta
        return eta, V, float(part)

    def value(self, theta: FloatArray) -> float:
        """L at `theta`; infinite where the expectation is not positive."""
        m = self.S @ theta
        if not m.min() > 0:
            return np.inf
        return 0.5 * (float(self.count @ (np.log(m) + self.power / m)) + self.directions(theta)[2])

    def completed(self, theta: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """What the terms are to explain: power, its expectation, the part of that which is not theirs, and the count.

        First the bins, given the directions; then each direction of finite W, whose generalised least squares estimate
        is one observation of variance W + (its error variance).
        """
        m, finite = self.S @ theta, ~self.flat
        eta, V, _ = self.directions(theta)
        second = np.outer(eta, eta) + V
        power = self.power + (self.UU.reshape(self.count.size, -1) @ second.ravel() - 2 * self.Uc @ eta) / self.count
        estimate, error = self._estimates(m)
        return (
            np.concatenate((power, estimate**2)),
            np.concatenate((m, self.W[finite] @ theta + error)),
            np.concatenate((np.zeros_like(m), error)),
            np.concatenate((self.count, np.ones_like(error))),
        )

    def _estimates(self, m: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Each finite direction's estimate and error variance, the flat ones unknown; finite ones are orthogonal."""
        r, flat = self.flat.size, self.flat
        A = ((1 / m) @ self.UU.reshape(-1, r * r)).reshape(r, r)
        b = (1 / m) @ self.Uc
        precision, moment = np.diag(A)[~flat], b[~flat]
        if flat.any():
            share = A[~flat][:, flat] @ np.linalg.inv(A[flat][:, flat])
            precision = precision - np.einsum("ij,ji->i", share, A[flat][:, ~flat])
            moment = moment - share @ b[flat]
        return moment / precision, 1 / precision

    @cached_property
    def columns(self) -> FloatArray:
        """S of the bins and then of the directions, shape (bins + finite directions, p)."""
        return np.concatenate((self.S, self.W[~self.flat]))

    def gradient(self, theta: FloatArray) -> FloatArray:
        """dL/dtheta, shape (p,)."""
        power, m, _, count = self.completed(theta)
        return np.asarray((0.5 * count / m * (1 - power / m)) @ self.columns)

    def information(self, theta: FloatArray) -> FloatArray:
        """Expected information of theta with the directions unknown, shape (p, p)."""
        m = self.S @ theta
        _, V, _ = self.directions(theta)
        X = self.S / m[:, None]
        A = np.einsum("bij,bp->pij", self.UU / m[:, None, None], X)
        loss = np.einsum("bij,bp,bq,ij->pq", self.UU / m[:, None, None], X, X, V)
        return np.asarray(0.5 * (X.T * self.count) @ X - loss + 0.5 * np.einsum("pij,jk,qkl,li->pq", A, V, A, V))

    def minimise(
        self, free: BoolArray, start: FloatArray | None = None, fixed: tuple[int, float] | None = None
    ) -> tuple[FloatArray, float]:
        """Theta >= 0 at the minimum of L, zero where not `free`; Fisher scoring with step halving.

        Parameters
        ----------
        free : bool array, shape (p,)
        start : array, shape (p,), optional
        fixed : (column, theta), optional
            A term held at a value, whether free or not.

        Returns
        -------
        (theta, L)
        """
        theta = np.where(free, self._start(free) if start is None else start, 0.0)
        moving = free.copy()
        if fixed is not None:
            moving[fixed[0]] = False
            theta[fixed[0]] = fixed[1]
        best = self.value(theta)
        if not moving.any():
            return theta, best
        if not best < np.inf:  # the start lies outside: let every free term in
            theta = np.where(moving, np.maximum(theta, self._start(free)), theta)
            best = self.value(theta)
        columns = self.columns
        for _ in range(200):
            power, m, rest, count = self.completed(theta)
            rest = rest + columns[:, ~moving] @ theta[~moving]
            target = theta.copy()
            target[moving] = _nnls(columns[:, moving], power - rest, np.sqrt(count) / m)
            theta, value = self._halve(theta, target, best)
            if best - value < 1e-7:
                return theta, value
            best = value
        return theta, best

    def _halve(self, here: FloatArray, there: FloatArray, best: float) -> tuple[FloatArray, float]:
        """The longest of the steps 1, 1/2, 1/4 ... towards `there` that lowers L, or none."""
        step = 1.0
        while step > 1e-4:
            theta = here + step * (there - here)
            value = self.value(theta)
            if value <= best:
                return theta, value
            step /= 2
        return here, best

    def _start(self, free: BoolArray) -> FloatArray:
        """Least squares relative to the smoothed power; no column is left at zero, so that m > 0 everywhere."""
        window = np.ones(5)
        smooth = np.convolve(self.power * self.count, window, "same") / np.convolve(self.count, window, "same")
        floor = np.maximum(smooth, 1e-12 * smooth.max())
        S = self.S[:, free]
        theta = np.zeros(self.S.shape[1])
        share = (S / floor[:, None]).max(axis=0)
        theta[free] = np.maximum(_nnls(S, floor, np.sqrt(self.count) / floor), 1e-3 / share)
        return theta


def _nnls(S: FloatArray, power: FloatArray, weight: FloatArray) -> FloatArray:
    """Non-negative least squares of weight * (power - S theta), columns normalised."""
    from scipy.optimize import nnls

    X = S * weight[:, None]
    size = np.sqrt(np.einsum("ij,ij->j", X, X))
    return np.asarray(nnls(X / size, power * weight)[0] / size)
