"""Rotation vectors from gyro increments: Bortz' equation, integrated over pairs of increments.

With two increments a, b of equal intervals the rotation vector over both is a + b + 2/3 a x b for a rate that is a
straight line in time: the cross product corrects for coning.
"""

import numpy as np

from allanite.extending import DataError, FloatArray, UsageError, public


@public
def rotation_vectors(increments: FloatArray, samples: int = 2) -> FloatArray:
    """Rotation vectors over pairs of increments, corrected for coning, or over single ones as they are.

    Parameters
    ----------
    increments : array, shape (n, 3)
        Angle increments, rad, in the axes of the body.
    samples : int
        Increments in a group, 1 or 2; with 1 nothing is corrected. An increment beyond the last pair is left out.

    Returns
    -------
    array, shape (n // samples, 3)

    Raises
    ------
    UsageError
        There is no correction of so many samples.
    DataError
        The increments do not have the shape (n, 3).

    References
    ----------
    J. E. Bortz, IEEE Trans. AES-7 (1971) 61; R. B. Miller, J. Guidance 6 (1983) 287.

    Examples
    --------
    >>> rotation_vectors(np.array([[1e-3, 0.0, 0.0], [0.0, 1e-3, 0.0]]))[0].round(12).tolist()
    [0.001, 0.001, 6.66667e-07]
    """
    if samples not in (1, 2):
        raise UsageError(f"a coning correction takes 1 or 2 samples, not {samples!r}")
    increments = np.ascontiguousarray(increments, dtype=np.float64)
    if increments.ndim != 2 or increments.shape[1] != 3:
        raise DataError(f"increments have the shape (n, 3), not {increments.shape}")
    if samples == 1:
        return increments
    first, second = increments[: len(increments) // 2 * 2].reshape(-1, 2, 3).swapaxes(0, 1)
    return np.asarray(first + second + 2 / 3 * np.cross(first, second))


@public
def attitudes(vectors: FloatArray, start: FloatArray) -> FloatArray:
    """Attitude after each rotation vector, from `start`: quaternions, shape (n, 4), scalar first.

    They rotate from the axes of the body to those of the start's reference; with
    ``scipy.spatial.transform.Rotation.from_quat(q, scalar_first=True)`` they become matrices or angles.
    """
    from allanite.kernels.attitude import rotated

    quaternions = np.empty((len(vectors), 4))
    rotated(np.ascontiguousarray(vectors), np.array(start, dtype=np.float64), quaternions)
    return quaternions
