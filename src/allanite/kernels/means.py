"""Squared differences of means of the remaining samples, at every window of a record with gaps."""

import numpy as np

from .compiling import kernel, swift_part


@swift_part
def _between_bounds(x, m, span, count, step):  # type: ignore[no-untyped-def]
    """Sums of h and h^2 delta^2, and the windows with a reading in each part, for i = span[0], span[0] + span[2] ..

    `count` are the readings of the parts at span[0], each of which grows by `step` from sample to sample. A third part
    that is not there has a step of 2.
    """
    begin, end, stride = span
    weight = squares = 0.0
    windows = 0
    for i in range(begin, end, stride):
        k = i - begin
        a, b, y, z = count[0] + step[0] * k, count[1] + step[1] * k, x[i + m] - x[i], x[i + 2 * m] - x[i + m]
        if step[2] == 2:
            inverse, product, difference, full = a + b, a * b, a * z - b * y, a * b
        else:
            c, last = count[2] + step[2] * k, x[i + 3 * m] - x[i + 2 * m]
            inverse, product = b * c + 4.0 * a * c + a * b, a * b * c
            difference, full = b * c * y - 2.0 * a * c * z + a * b * last, product
        inverse = max(inverse, 1.0)
        weight += product / inverse
        squares += (difference / inverse) ** 2
        windows += full > 0
    return weight, squares, windows


@kernel
def of_means(x, bounds, m, differences, stride):  # type: ignore[no-untyped-def]
    """Sum of h, sum of h^2 delta^2, and the number of windows, starting every `stride` samples; see `moments.means`.

    x are sums of the readings before each sample, and `bounds` the begin and the end of each stretch of them, by turns.
    The readings of all parts grow or shrink evenly until an edge of a part meets a bound.
    """
    parts, last = differences, x.size - differences * m
    # of each edge of a part: bounds up to it, and readings before it
    passed, before = np.zeros(4, np.int64), np.zeros(4)
    count, step = np.zeros(3), np.full(3, 2.0)
    weight = squares = 0.0
    windows = i = 0
    for p in range(parts + 1):
        while passed[p] < bounds.size and bounds[passed[p]] <= p * m:
            at = passed[p]
            before[p] += bounds[at] - bounds[at - 1] if at % 2 else 0.0
            passed[p] += 1
        at = passed[p]
        before[p] += p * m - bounds[at - 1] if at % 2 else 0.0
    while i < last:
        end = last
        for p in range(parts + 1):
            if passed[p] < bounds.size:
                end = min(end, bounds[passed[p]] - p * m)
        first = (i + stride - 1) // stride * stride
        for p in range(parts):
            step[p] = passed[p + 1] % 2 - passed[p] % 2
            count[p] = before[p + 1] - before[p] + step[p] * (first - i)
        more, squared, full = _between_bounds(x, m, (first, end, stride), count, step)
        weight += more
        squares += squared
        windows += full
        for p in range(parts + 1):
            before[p] += (passed[p] % 2) * (end - i)
            while passed[p] < bounds.size and bounds[passed[p]] <= end + p * m:
                passed[p] += 1
        i = end
    return weight, squares, windows
