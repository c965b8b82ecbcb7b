"""Integration, and differences of the angle: at every factor, in sliding windows, over gaps, and their range."""

import numpy as np

from .compiling import inner, kernel, swift_part

BLOCK = 8192
"""Samples per block: what one averaging factor has loaded the next finds in the cache."""


@kernel
def integrate(values, constant):  # type: ignore[no-untyped-def]
    """x[0] = 0, x[k+1] = x[k] + (values[k] - constant), shape (n + 1,), float64.

    Integers stay exact as long as the sum is below 2^53 steps.
    """
    x = np.empty(values.size + 1)
    x[0] = 0.0
    total = 0.0
    for k in range(values.size):
        total += values[k] - constant
        x[k + 1] = total
    return x


@swift_part
def squares(x, m, order, start, stop):  # type: ignore[no-untyped-def]
    """Sum over i = start .. stop - 1 of the squared difference of order 1, 2 or 3 of x[i], x[i+m], x[i+2m], x[i+3m]."""
    a, b = x[start:stop], x[start + m : stop + m]
    total = 0.0
    if order == 1:
        for i in range(a.size):
            difference = b[i] - a[i]
            total += difference * difference
        return total
    c = x[start + 2 * m : stop + 2 * m]
    if order == 2:
        for i in range(a.size):
            difference = (c[i] - b[i]) - (b[i] - a[i])
            total += difference * difference
        return total
    d = x[start + 3 * m : stop + 3 * m]
    for i in range(a.size):
        difference = (d[i] - a[i]) - 3.0 * (c[i] - b[i])
        total += difference * difference
    return total


@kernel
def strided(x, m, order):  # type: ignore[no-untyped-def]
    """Sum of the squared differences at every m[j]-th i, shape of m."""
    sums = np.zeros(m.size)
    for k in range(m.size):
        points = x[:: m[k]].copy()
        if points.size > order:
            sums[k] = squares(points, 1, order, 0, points.size - order)
    return sums


@inner
def zeros(size):  # type: ignore[no-untyped-def]
    """An array of zeros: numpy's own is compiled anew for every set of options of a caller."""
    x = np.empty(size)
    for i in range(size):
        x[i] = 0.0
    return x


@inner
def table(rows, size):  # type: ignore[no-untyped-def]
    """Rows of zeros."""
    x = np.empty((rows, size))
    for i in range(rows):
        for k in range(size):
            x[i, k] = 0.0
    return x


@swift_part
def dot(a, b):  # type: ignore[no-untyped-def]
    """Sum of a b, over the length of a."""
    total = 0.0
    for i in range(a.size):
        total += a[i] * b[i]
    return total


@swift_part
def _folded_squares(a, b, c, signs, shift):  # type: ignore[no-untyped-def]
    """Sum of (shift + signs[0] a - 2 b + signs[1] c)^2."""
    left, right = signs
    total = 0.0
    for i in range(b.size):
        difference = (shift + right * c[i] - b[i]) + (left * a[i] - b[i])
        total += difference * difference
    return total


@kernel
def folded(x, m):  # type: ignore[no-untyped-def]
    """Sum over i = 1 .. x.size - 2 of x'[i-m] - 2 x[i] + x'[i+m] squared, x' folded back at the first and last point.

    x'[-j] = 2 x[0] - x[j] and x'[last+j] = 2 x[last] - x[last-j] are read off the reversed record.
    """
    last = x.size - 1
    back = x[::-1].copy()
    sums = np.zeros(m.size)
    for start in range(1, last, BLOCK):
        stop = min(start + BLOCK, last)
        for j in range(m.size):
            k = m[j]
            if k >= last:
                continue
            inner, outer = min(k, last - k), max(k, last - k)
            for first, after in (
                (start, min(stop, inner)),
                (max(start, inner), min(stop, outer)),
                (max(start, outer), stop),
            ):
                if after <= first:
                    continue
                a, left, shift = x[max(first - k, 0) :], 1.0, 0.0
                if first < k:
                    a, left, shift = back[last - k + first :], -1.0, 2 * x[0]
                c, right = x[first + k :], 1.0
                if after - 1 > last - k:
                    c, right, shift = back[first + k - last :], -1.0, shift + 2 * x[last]
                sums[j] += _folded_squares(a[: after - first], x[first:after], c, (left, right), shift)
    return sums


@kernel
def sliding(blocks, f):  # type: ignore[no-untyped-def]
    """Sums of every f neighbours, shape (blocks.size - f + 1,), by additions only (van Herk, Gil and Werman).

    Within groups of f the blocks are added up from the left and from the right; a window is the right part of one group
    and the left part of the next. Nothing is subtracted: what has left the window leaves no rounding error behind.
    """
    left, right = blocks.copy(), blocks.copy()
    for i in range(1, blocks.size):
        if i % f:
            left[i] += left[i - 1]
    for i in range(blocks.size - 2, -1, -1):
        if (i + 1) % f:
            right[i] += right[i + 1]
    sums = left[f - 1 :].copy()
    for i in range(sums.size):
        if i % f:
            sums[i] += right[i]
    return sums


@kernel
def windowed(x, m, count, order, step):  # type: ignore[no-untyped-def]
    """Sum of the squared differences that start at w step ... w step + count[j] - 1, shape (windows, m.size).

    Every difference is taken once: its square goes into the sum of a block of `step` of them, of which the first
    ``count mod step`` are added up apart, as the end of a window.
    """
    windows = (x.size - order * m[0] - count[0]) // step + 1
    result = np.empty((windows, m.size))
    for j in range(m.size):
        f, rest = count[j] // step, count[j] % step
        heads, blocks = np.empty(windows + f), np.zeros(windows + f)
        for b in range(windows + f):
            heads[b] = squares(x, m[j], order, b * step, b * step + rest)
            # the last block only ends a window: what follows its head may lie beyond the record
            if b + 1 < windows + f:
                blocks[b] = heads[b] + squares(x, m[j], order, b * step + rest, (b + 1) * step)
        for w in range(windows):
            result[w, j] = heads[f + w]
        if f:
            sums = sliding(blocks[: windows + f - 1], f)
            for w in range(windows):
                result[w, j] += sums[w]
    return result


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
