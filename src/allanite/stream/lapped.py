"""A transform of short segments that overlap by half: the modified discrete cosine transform with a sine window.

Its basis is orthogonal and has no edges, so that neither quantization, whose edges of a segment are louder than its
inside, nor slow noise leaks into other frequencies.

References
----------
H. S. Malvar, Signal Processing with Lapped Transforms, 1992.
"""

from functools import cache

import numpy as np

from allanite.core.arrays import FloatArray


@cache
def basis(hop: int) -> FloatArray:
    """Rows k = hop / 8 .. hop - 1 at the frequencies (k + 1/2) / (2 hop) per sample, shape (rows, 2 hop).

    Each is freed from its mean and has the length 1: a constant, or a slow noise of any size, is not seen.

    Examples
    --------
    >>> found = basis(16)
    >>> found.shape, bool(np.allclose(found.sum(axis=1), 0)), bool(np.allclose((found**2).sum(axis=1), 1))
    ((14, 32), True, True)
    """
    rows = _window(hop) * _cosines(hop)
    rows = rows - rows.mean(axis=1, keepdims=True)
    return np.asarray(rows / np.sqrt((rows**2).sum(axis=1, keepdims=True)))


@cache
def folded(hop: int) -> FloatArray:
    """The window, and the basis as weights of the folded samples and of their sum.

    A segment (a, b, c, d) in quarters, times the window, is folded to (-c' - d, a - b'), a prime for reversed order: of
    that the rows are those of a DCT-IV, and what frees them from their mean is a weight of the sum of the segment.
    Shape (1 + rows, 2 hop), where a row has hop + 1 weights.
    """
    k, j = np.arange(hop // 8, hop)[:, None] + 0.5, np.arange(hop) + 0.5
    raw = _window(hop) * _cosines(hop)
    mean = raw.mean(axis=1)
    length = np.sqrt(((raw - mean[:, None]) ** 2).sum(axis=1))
    found = np.zeros((1 + len(raw), 2 * hop))
    found[0] = _window(hop)
    found[1:, :hop] = np.cos(np.pi / hop * k * j) / length[:, None]
    found[1:, hop] = -mean / length
    return found


def _window(hop: int) -> FloatArray:
    return np.asarray(np.sin(np.pi / (2 * hop) * (np.arange(2 * hop) + 0.5)))


def _cosines(hop: int) -> FloatArray:
    k, i = np.arange(hop // 8, hop)[:, None] + 0.5, np.arange(2 * hop) + 0.5
    return np.asarray(np.cos(np.pi / hop * k * (i + hop / 2)))
