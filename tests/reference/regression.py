"""Regression under correlated noise, from full matrices."""

import numpy as np
from scipy.linalg import block_diag, null_space

from tests.reference.noise import covariance


def dense(y, X, stretches, sizes):
    """Generalised least squares and twice the restricted likelihood, each stretch with its own constant.

    y: (n,), X: (n, p), stretches: [(first, behind last)], sizes: those of `noise`. Returns (beta, covariance,
    2 L up to a constant that the noise does not change).
    """
    z, Z, C = [], [], []
    for a, b in stretches:
        contrasts = null_space(np.ones((1, b - a))).T
        z.append(contrasts @ y[a:b])
        Z.append(contrasts @ X[a:b])
        C.append(contrasts @ covariance(sizes, b - a) @ contrasts.T)
    z, Z, C = np.concatenate(z), np.concatenate(Z), block_diag(*C)
    inverse = np.linalg.inv(C)
    V = np.linalg.inv(Z.T @ inverse @ Z)
    beta = V @ Z.T @ inverse @ z
    left = z - Z @ beta
    return beta, V, np.linalg.slogdet(C)[1] - np.linalg.slogdet(V)[1] + left @ inverse @ left
