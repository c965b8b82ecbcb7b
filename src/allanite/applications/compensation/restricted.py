r"""The likelihood of the noise with the regression's coefficients integrated out.

Noise identified from the uncorrected record includes the dependence; identified from the residuals of a fit it is too
small, because the fit has removed some of the noise, too. The restricted likelihood avoids both: the coefficients are
directions of any size in it (see `identification.likelihood`), and for given noise it yields their generalized
least-squares estimates and covariance. Fitting the noise to the residuals, and the coefficients under that noise, again
and again, would end at its maximum except for the correction of degrees of freedom that it makes. Stretches between
gaps have each its own constant.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from allanite.extending import Likelihood, Record, likelihood, spectrum

FloatArray = NDArray[np.float64]
Stretch = tuple[int, int]

FEW = 4
"""Stretches up to which the edges of each are directions of their own (they matter for quantization alone)."""


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
    terms = parts[0][0].S.shape[1]
    return Likelihood(
        S=np.concatenate([base.S for base, *_ in parts]),
        power=np.concatenate([base.power for base, *_ in parts]),
        count=np.concatenate([base.count for base, *_ in parts]),
        UU=np.concatenate(UU),
        Uc=np.concatenate(Uc),
        W=np.concatenate([*W, np.zeros((p, terms))]),
        flat=np.arange(edges + p) >= edges,
    )


def _part(y: FloatArray, X: FloatArray, rate: float, symbols: str) -> tuple[Likelihood, int, FloatArray, FloatArray]:
    """One stretch: its likelihood, the number of its edges, and products of edges and columns with each other and y."""
    from scipy.fft import dct

    seen = spectrum(Record(y, rate, "rad/s"), detrend=False)
    base = likelihood(seen, symbols)
    n, count = seen.size, base.flat.size
    c = dct(y - y.mean(), norm="ortho")[1:]
    k = np.arange(1, n)
    a = np.sqrt(2 / n) * np.cos(np.pi / (2 * n) * k)
    columns = [np.where(k % 2 == parity, a, 0.0) for parity in (0, 1)]
    columns += [dct(column - column.mean(), norm="ortho")[1:] for column in X.T]
    at = seen.first - 1
    square = np.empty((at.size, len(columns), len(columns)))
    cross = np.empty((at.size, len(columns)))
    for i, u in enumerate(columns):
        cross[:, i] = np.add.reduceat(u * c, at)
        for j in range(i + 1):
            square[:, i, j] = square[:, j, i] = np.add.reduceat(u * columns[j], at)
    return base, count, square, cross
