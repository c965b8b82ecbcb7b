"""The modified total statistics: by reflection of every window, and from running sums.

With V the running sum of a window of 3m points less its mean and half-mean slope, continued oddly about both ends, the
sum of its squared third differences over a full round of 6m places is

    Q = 40 V.V - 30 (2 sum_0^2m V_j V_j+m - h(0, m) - h(2m, m)) + 12 (2 sum_0^m V_j V_j+2m - h(0, 2m) - h(m, 2m))
        + 4 h(0, 3m),    h(s, w) = sum over i = 0 .. w of V_s+i V_s+w-i

Here V_j = P_n+j - c_0 - c_1 j - c_2 j (j - 3m) / 2 with P the running sum of the record and c of four points of it. So

    Q = Q(P, P) - 2 sum_k c_k Q(P, p_k) + sum_kl c_k c_l Q(p_k, p_l)

where Q(P, p_k) is made of sums of P, j P, j^2 P over five ranges of the window. Summed over windows, h is a sum of
P_u P_u' over all |u - u'| <= w with u + u' in a range and of one parity: of P_u times sums over every other u'. P is
that of a frame of a few windows, less a parabola, which V does not hold: little cancels.
"""

import numpy as np

from .allan import dot, squares
from .compiling import inner, kernel, part, swift_part
from .summed import running_sum
from .theo import cut


@swift_part
def _less_parabola(out, S, place, line, m):  # type: ignore[no-untyped-def]
    """out[i] = S[i] - first - j (level + slope (j - 3m) / 2) with j = start + i, line = first, level, slope.

    `place` is start and the step of j: 1, or -1 for what is continued oddly, with S given backward.
    """
    first, level, slope = line
    start, step = float(place[0]), float(place[1])
    for i in range(out.size):
        j = start + step * i
        out[i] = step * ((S[i] - first) - j * (level + 0.5 * slope * (j - 3.0 * m)))


@part
def one_by_one(x, m):  # type: ignore[no-untyped-def]
    """Sum over windows n of q_n = 1/(6 m^3) sum over the 6m places of (third difference of the folded sum)^2.

    The running sum V_j, j = 0 .. 3m, of a window less its mean and half-mean slope vanishes at both ends; the sum of
    the window folded back evenly is odd about 0 and about 3m. Its squared third difference is even about both, so that
    half a round is enough: the centres 0 .. 3m.
    """
    half, odd = 3 * m // 2, m % 2
    reach = (3 * m) // 2  # the first centre is 0 or 1/2: it reaches back over 1.5 m
    places = 3 * m + 1 - odd
    length = max(1024, 9 * m)
    S = np.empty(length + 3 * m + 1)
    w = np.empty(places + 3 * m)
    total = 0.0
    for start in range(0, x.size + 1 - 3 * m, length):
        z = x[start : min(start + length + 3 * m - 1, x.size)]
        running_sum(z, S)
        top = z.size
        backward = S[: top + 1][::-1].copy()
        for n in range(top + 1 - 3 * m):
            zero, full = S[n], S[n + 3 * m]
            slope = ((full - S[n + 3 * m - half]) - (S[n + half] - zero)) / half / (3 * m - half)
            line = zero, (full - zero) / (3 * m), slope
            # V itself, then odd about both of its ends
            _less_parabola(w[reach : reach + 3 * m + 1], S[n : n + 3 * m + 1], (0, 1), line, m)
            at = top - n - reach
            _less_parabola(w[:reach], backward[at : at + reach], (reach, -1), line, m)
            rest = w.size - (reach + 3 * m + 1)
            at = top - (n + 3 * m - 1)
            _less_parabola(w[reach + 3 * m + 1 :], backward[at : at + rest], (3 * m - 1, -1), line, m)
            half_round = squares(w, m, 3, 0, places)
            if odd:
                total += 2.0 * half_round
            else:
                ends = (w[3 * m] - w[0]) - 3.0 * (w[2 * m] - w[m])
                last = places - 1
                far = (w[last + 3 * m] - w[last]) - 3.0 * (w[last + 2 * m] - w[last + m])
                total += 2.0 * half_round - ends * ends - far * far
    return total / (6.0 * m) / (float(m) * m)


SHORT = 10
"""Averaging factors below which the windows are done one by one."""

LEFT_OVER = 1e-6
"""Share of the frames' squares below which a sum is made again one by one, for nine digits."""

LEFT, LEAST = 6, 96
"""Windows that start in a frame, over m, and at least."""


@kernel
def modified_total(x, m):  # type: ignore[no-untyped-def]
    """Sum over windows n of q_n = 1/(6 m^3) sum over the 6m places of (third difference of the folded sum)^2."""
    sums = np.zeros(m.size)
    for k in range(m.size):
        if m[k] >= SHORT:
            sums[k], squares = _framed(x, m[k])
            if sums[k] > LEFT_OVER * squares:
                continue
        sums[k] = one_by_one(x, m[k])
    return sums


@part
def _framed(x, m):  # type: ignore[no-untyped-def]
    windows, length = x.size + 1 - 3 * m, max(LEAST, LEFT * m)
    ranges, factors = _ranges(m)
    own = _own(ranges, factors, m)
    total = squares = 0.0
    for start in range(0, windows, length):
        count = min(length, windows - start)
        P = np.empty(count + 3 * m)
        cut(x, start, 2, True, P)
        total += _squares(P, m, count) + _cross(P, m, (ranges, factors, own), count)
        squares += 40.0 * _products(P, (0, 3 * m), count)
    return total / (6.0 * m) / (float(m) * m), squares / (6.0 * m) / (float(m) * m)


@part
def _squares(P, m, count):  # type: ignore[no-untyped-def]
    """Q(P, P) of `count` windows."""
    every = np.zeros(P.size + 2)
    for i in range(P.size):
        every[i + 2] = every[i] + P[i]
    backward = every[::-1].copy()
    total = 40.0 * _products(P, (0, 3 * m), count)
    total -= 60.0 * _products(P, (m, 2 * m), count)
    total += 24.0 * _products(P, (2 * m, m), count)
    for factor, s, w in ((30.0, 0, m), (30.0, 2 * m, m), (-12.0, 0, 2 * m), (-12.0, m, 2 * m), (4.0, 0, 3 * m)):
        total += factor * _mirrored(P, (every, backward), (s, w), count)
    return total


@inner
def _products(P, place, count):  # type: ignore[no-untyped-def]
    """Sum over n < count and j = 0 .. width of P[n+j] P[n+j+lag], place = lag, width."""
    lag, width = place
    sums = np.empty(count + width + 1)
    sums[0] = part = 0.0
    a, b = P[: count + width], P[lag : lag + count + width]
    for i in range(a.size):
        part += a[i] * b[i]
        sums[i + 1] = part
    total = 0.0
    low, high = sums[:count], sums[width + 1 :]
    for n in range(count):
        total += high[n] - low[n]
    return total


@part
def _mirrored(P, sums, place, count):  # type: ignore[no-untyped-def]
    """Sum over n < count of h(s, w) of the window at n; `sums` are those of every other point, forward and backward."""
    every, backward = sums
    s, w = place
    end = backward.size
    # the partners u' run from the larger of u - w and 2 s + w - u to the smaller of u + w and 2 (s + count - 1) + w - u
    total = dot(P[s : s + count], every[s + w + 2 : s + w + 2 + count])
    total += dot(P[s + count : s + count + w], backward[end - 1 - (s + w + count) : end - (s + count + 1)])
    total -= dot(P[s : s + w], backward[end - 1 - (s + w) : end - (s + 1)])
    return total - dot(P[s + w : s + w + count], every[s : s + count])


@inner
def _ranges(m):  # type: ignore[no-untyped-def]
    """Ranges of j, and factors[range, power of j, k], that Q(P, p_k) consists of."""
    ranges = np.array([[0, 3 * m], [0, 2 * m], [m, 3 * m], [0, m], [2 * m, 3 * m]])
    factors = np.zeros((5, 3, 3))
    # p_k(sign j + shift) over a range
    for which, factor, sign, shift in (
        (0, 40.0, 1, 0), (0, 4.0, -1, 3 * m),
        (1, -30.0, 1, m), (2, -30.0, 1, -m), (3, 30.0, -1, m), (4, 30.0, -1, 5 * m),
        (3, 12.0, 1, 2 * m), (4, 12.0, 1, -2 * m), (1, -12.0, -1, 2 * m), (2, -12.0, -1, 4 * m),
    ):  # fmt: skip
        factors[which, 0, 0] += factor
        factors[which, 0, 1] += factor * shift
        factors[which, 1, 1] += factor * sign
        factors[which, 0, 2] += factor * shift * (shift - 3 * m) / 2
        factors[which, 1, 2] += factor * sign * (2 * shift - 3 * m) / 2
        factors[which, 2, 2] += factor / 2
    return ranges, factors


@inner
def _own(ranges, factors, m):  # type: ignore[no-untyped-def]
    """Q(p_k, p_l), shape (3, 3)."""
    own = np.zeros((3, 3))
    for r in range(5):
        for j in range(ranges[r, 0], ranges[r, 1] + 1):
            p = (1.0, float(j), j * (j - 3.0 * m) / 2)
            for k in range(3):
                value = factors[r, 0, k] + j * (factors[r, 1, k] + j * factors[r, 2, k])
                for o in range(3):
                    own[k, o] += value * p[o]
    return own


@part
def _cross(P, m, forms, count):  # type: ignore[no-untyped-def]
    """What the polynomials that V lacks take from Q(P, P)."""
    ranges, factors, own = forms
    T = np.zeros((3, P.size + 1))
    for i in range(P.size):
        T[0, i + 1] = T[0, i] + P[i]
        T[1, i + 1] = T[1, i] + i * P[i]
        T[2, i + 1] = T[2, i] + float(i) * i * P[i]
    cross = np.zeros((3, count))
    for r in range(5):
        low, high = ranges[r, 0], ranges[r, 1] + 1
        _add_moments(cross, T[:, low : low + count], T[:, high : high + count], factors[r])
    half = 3 * m // 2
    a, b, c, d = P[:count], P[half : half + count], P[3 * m - half : 3 * m - half + count], P[3 * m : 3 * m + count]
    total = 0.0
    for n in range(count):
        c0, c1 = a[n], (d[n] - a[n]) / (3 * m)
        c2 = ((d[n] - c[n]) - (b[n] - a[n])) / half / (3 * m - half)
        total -= 2 * (c0 * cross[0, n] + c1 * cross[1, n] + c2 * cross[2, n])
        total += c0 * (own[0, 0] * c0 + 2 * (own[0, 1] * c1 + own[0, 2] * c2))
        total += c1 * (own[1, 1] * c1 + 2 * own[1, 2] * c2) + own[2, 2] * c2 * c2
    return total


@swift_part
def _add_moments(cross, low, high, factors):  # type: ignore[no-untyped-def]
    """cross[k, n] += sum_p factors[p, k] sum over the range of j^p P[n+j], from running sums of (n+j)^p P[n+j]."""
    l0, l1, l2, h0, h1, h2 = low[0], low[1], low[2], high[0], high[1], high[2]
    first, second, third = cross[0], cross[1], cross[2]
    f00, f01, f11 = factors[0, 0], factors[0, 1], factors[1, 1]
    f02, f12, f22 = factors[0, 2], factors[1, 2], factors[2, 2]
    for i in range(first.size):
        n = float(i)
        d0, d1, d2 = h0[i] - l0[i], h1[i] - l1[i], h2[i] - l2[i]
        m1 = d1 - n * d0
        m2 = d2 - n * (d1 + m1)
        first[i] += f00 * d0
        second[i] += f01 * d0 + f11 * m1
        third[i] += f02 * d0 + f12 * m1 + f22 * m2
