r"""Rotation vectors from gyro increments: Bortz' equation, integrated with a correction for coning.

With increments theta_i of equal intervals, the rotation vector over all of them is their sum and a sum of cross
products, whose coefficients fit a rate that is a polynomial in time.
"""

import numpy as np

from allanite.extending import DataError, FloatArray, UsageError, public

PAIRS: dict[int, tuple[tuple[int, int, float], ...]] = {
    1: (),
    2: ((0, 1, 2 / 3),),
    3: ((0, 2, 9 / 20), (1, 2, 27 / 40), (0, 1, 27 / 40)),
    4: ((0, 3, 54 / 105), (1, 3, 92 / 105), (2, 3, 214 / 105)),
}
"""First and second increment of a cross product, and its coefficient, by the number of increments."""


@public
def rotation_vectors(increments: FloatArray, samples: int = 2) -> FloatArray:
    """Rotation vectors over groups of increments, with the correction for coning of so many samples.

    Parameters
    ----------
    increments : array, shape (n, 3)
        Angle increments, rad, in the axes of the body.
    samples : int
        Increments in a group, 1 to 4; with 1 nothing is corrected. Increments beyond the last whole group are left out.

    Returns
    -------
    array, shape (n // samples, 3)

    Raises
    ------
    UsageError
        There is no correction of so many samples.

    References
    ----------
    J. E. Bortz, IEEE Trans. AES-7 (1971) 61; R. B. Miller, J. Guidance 6 (1983) 287.

    Examples
    --------
    >>> rotation_vectors(np.array([[1e-3, 0.0, 0.0], [0.0, 1e-3, 0.0]]))[0].round(12).tolist()
    [0.001, 0.001, 6.66667e-07]
    """
    if samples not in PAIRS:
        raise UsageError(f"a coning correction takes {', '.join(map(str, PAIRS))} samples, not {samples!r}")
    groups = grouped(increments, samples)
    parts = groups.swapaxes(0, 1)
    found = parts.sum(axis=0)
    for i, j, c in PAIRS[samples]:
        found += c * np.cross(parts[i], parts[j])
    return np.asarray(found)


@public
def rotation_vectors_with_previous(increments: FloatArray) -> FloatArray:
    """Rotation vectors over single increments, corrected by the increment before: d + d_before x d / 12.

    Raises
    ------
    DataError
        The increments do not have the shape (n, 3).

    Examples
    --------
    >>> rotation_vectors_with_previous(np.array([[1e-3, 0.0, 0.0], [0.0, 1.2e-3, 0.0]]))[1].round(12).tolist()
    [0.0, 0.0012, 1e-07]
    """
    increments = grouped(increments, 1)[:, 0]
    before = np.concatenate((increments[:1], increments[:-1]))
    return np.asarray(increments + np.cross(before, increments) / 12)


def grouped(increments: FloatArray, samples: int) -> FloatArray:
    """Whole groups of increments, shape (n // samples, samples, 3)."""
    increments = np.ascontiguousarray(increments, dtype=np.float64)
    if increments.ndim != 2 or increments.shape[1] != 3:
        raise DataError(f"increments have the shape (n, 3), not {increments.shape}")
    n = len(increments) // samples
    return np.asarray(increments[: n * samples].reshape(n, samples, 3))


@public
def attitudes(vectors: FloatArray, start: FloatArray) -> FloatArray:
    """Attitude after each rotation vector, from `start`: quaternions, shape (n, 4), scalar first.

    They rotate from the axes of the body to those of the start's reference; with
    ``scipy.spatial.transform.Rotation.from_quat(q, scalar_first=True)`` they become matrices or angles.
    """
    from allanite.kernels.attitude import rotated

    found = np.empty((len(vectors), 4))
    rotated(np.ascontiguousarray(vectors), np.array(start, dtype=np.float64), found)
    return found
