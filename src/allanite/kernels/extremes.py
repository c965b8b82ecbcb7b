"""The largest range of x within any window."""

import numpy as np

from .compiling import inner, kernel


@kernel
def largest_range(x, m):  # type: ignore[no-untyped-def]
    """Largest (max - min)^2 of m + 1 neighbouring points, for every m, shape of m; 0 where no window fits."""
    result = np.zeros(m.size)
    high, low = np.empty(x.size, np.int64), np.empty(x.size, np.int64)
    for j in range(m.size):
        result[j] = _one(x, m[j], high, low) ** 2
    return result


@inner
def _one(x, m, high, low):  # type: ignore[no-untyped-def]
    """Two queues of places that may still become the window's maximum and minimum (Lemire 2006)."""
    most = 0.0
    h0 = h1 = l0 = l1 = 0
    for i in range(x.size):
        while h1 > h0 and x[high[h1 - 1]] <= x[i]:
            h1 -= 1
        high[h1] = i
        h1 += 1
        while l1 > l0 and x[low[l1 - 1]] >= x[i]:
            l1 -= 1
        low[l1] = i
        l1 += 1
        if high[h0] < i - m:
            h0 += 1
        if low[l0] < i - m:
            l0 += 1
        if i >= m:
            most = max(most, x[high[h0]] - x[low[l0]])
    return most
