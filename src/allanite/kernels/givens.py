"""Givens rotations: rows of an equation system into its triangular factor, one after the other."""

import math

import numpy as np

from .compiling import kernel


@kernel
def absorb(factor, rows, values):  # type: ignore[no-untyped-def]
    """Rotate each row (with its value behind it) into the upper triangular `factor`, in place.

    `factor` has shape (p, p + 1), its diagonal is not negative; `rows` (n, p), `values` (n,). Returns what is left of
    each value, shape (n,): the innovation over its standard deviation, where rows and values have unit noise. No cosine
    is negative, so it keeps the innovation's sign.
    """
    p = factor.shape[0]
    left = np.empty(values.size)
    work = np.empty(p + 1)
    for i in range(values.size):
        work[:p] = rows[i]
        work[p] = values[i]
        for j in range(p):
            if work[j] == 0.0:
                continue
            line = factor[j]
            length = math.sqrt(line[j] * line[j] + work[j] * work[j])
            c = line[j] / length
            s = work[j] / length
            line[j] = length
            head = line[j + 1 :]
            tail = work[j + 1 :]
            for k in range(tail.size):
                above = head[k]
                head[k] = c * above + s * tail[k]
                tail[k] = c * tail[k] - s * above
        left[i] = work[p]
    return left
