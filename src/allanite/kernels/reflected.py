"""The modified total statistics: every window detrended, folded back at both ends and differenced all the way round."""

import numpy as np

from .allan import squares
from .compiling import part, swift_part
from .summed import running_sum


@swift_part
def _less_parabola(out, S, start, line, m):  # type: ignore[no-untyped-def]
    """out[i] = S[i] - first - j (level + slope (j - 3m) / 2) with j = start + i, line = first, level, slope."""
    first, level, slope = line
    for i in range(out.size):
        j = float(start + i)
        out[i] = (S[i] - first) - j * (level + 0.5 * slope * (j - 3.0 * m))


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
            _less_parabola(w[reach : reach + 3 * m + 1], S[n : n + 3 * m + 1], 0, line, m)
            at = top - n - reach
            _mirrored(w[:reach], backward[at : at + reach], reach, line, m)
            rest = w.size - (reach + 3 * m + 1)
            at = top - (n + 3 * m - 1)
            _mirrored(w[reach + 3 * m + 1 :], backward[at : at + rest], 3 * m - 1, line, m)
            half_round = squares(w, m, 3, 0, places)
            if odd:
                total += 2.0 * half_round
            else:
                ends = (w[3 * m] - w[0]) - 3.0 * (w[2 * m] - w[m])
                last = places - 1
                far = (w[last + 3 * m] - w[last]) - 3.0 * (w[last + 2 * m] - w[last + m])
                total += 2.0 * half_round - ends * ends - far * far
    return total / (6.0 * m) / (float(m) * m)


@swift_part
def _mirrored(out, S, start, line, m):  # type: ignore[no-untyped-def]
    """out[i] = -(S[i] - first - j (level + slope (j - 3m) / 2)) with j = start - i, S given backward."""
    first, level, slope = line
    for i in range(out.size):
        j = float(start - i)
        out[i] = j * (level + 0.5 * slope * (j - 3.0 * m)) - (S[i] - first)
