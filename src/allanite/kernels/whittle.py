"""The binned Whittle likelihood and its minimum over non-negative theta; see `identification.likelihood.likelihood`.

`columns` are S of the bins and then W of the finite directions, shape (p, bins + finite directions): times theta they
make `m`, the expected power of the bins and the variances of the directions. `data` is (power, count, UU, Uc) with the
bins along the last axis, the directions of any size before the finite ones. All is float64 and contiguous.
"""

import math

import numpy as np

from .allan import dot, table, zeros
from .compiling import once, swift, swift_part
from .leastsquares import ROUNDING, backward, cholesky, forward, weighted_nnls

NOTHING = 1e-250
SMALLEST_STEP = 1e-4
FASTEST = 0.95
CONVERGED = 1e-7
ITERATIONS = 200
LAST = 5
ROOT_HALF = 0x3FE6A09E667F3BCD  # the bits of sqrt(1/2)
SMALLEST = 2.3e-308


@swift_part
def _add(total, factor, row):  # type: ignore[no-untyped-def]
    for i in range(total.size):
        total[i] += factor * row[i]


@swift_part
def _expectation(columns, theta, held):  # type: ignore[no-untyped-def]
    """M, shape (bins + finite directions,), of which `held` is the part of other terms."""
    m = zeros(held.size)
    _add(m, 1.0, held)
    for j in range(theta.size):
        if theta[j] != 0.0:
            _add(m, theta[j], columns[j])
    return m


@once
def _normal_matrix(m, UU, Uc):  # type: ignore[no-untyped-def]
    """Lower half of U' M^-1 U, and U' M^-1 c."""
    r, n = Uc.shape
    G, b, inverse = table(r, r), zeros(r), zeros(n)
    for i in range(n):
        inverse[i] = 1.0 / m[i]
    for j in range(r):
        b[j] = dot(inverse, Uc[j])
        for k in range(j + 1):
            G[j, k] = dot(inverse, UU[j, k])
    return G, b


@once
def _directions(m, data):  # type: ignore[no-untyped-def]
    """Root of V^-1, that times eta, each finite direction's own estimate and error variance, their part of 2 L.

    The estimate of a finite direction leaves those of any size unknown, and knows nothing of its variance.
    """
    G, b = _normal_matrix(m, data[2], data[3])
    r, n = data[3].shape
    loose = r - (m.size - n)
    own = table(2, r - loose)
    part = 0.0
    for j in range(loose, r):
        own[0, j - loose], own[1, j - loose] = b[j], G[j, j]
        # a direction without variance gets a precision beyond all others: its eta and V vanish, its part of L too
        precision = 1.0 / max(m[n + j - loose], NOTHING)
        G[j, j] += precision
        part -= math.log(precision)
    cholesky(G)
    forward(G, b)
    for j in range(r):
        part += 2 * math.log(G[j, j]) - b[j] * b[j]
    for j in range(loose, r):
        for i in range(loose):
            own[0, j - loose] -= G[j, i] * b[i]
            own[1, j - loose] -= G[j, i] * G[j, i]
        own[0, j - loose] /= own[1, j - loose]
        own[1, j - loose] = 1 / own[1, j - loose]
    return G, b, own, part


@once
def _solved(root, b):  # type: ignore[no-untyped-def]
    """Eta and V."""
    eta, V = zeros(b.size), table(b.size, b.size)
    for j in range(b.size):
        eta[j], V[j, j] = b[j], 1.0
        forward(root, V[j])
        backward(root, V[j])
    backward(root, eta)
    return eta, V


@swift_part
def _logarithms(x):  # type: ignore[no-untyped-def]
    """Ln x for positive normal x, several at a time: x = 2^e f with f within sqrt(2) of 1, ln f by artanh's series."""
    bits, rest, result = x.view(np.int64), np.zeros(x.size, np.int64), zeros(x.size)
    f = rest.view(np.float64)
    for i in range(x.size):
        e = (bits[i] - ROOT_HALF) >> 52
        rest[i] = bits[i] - (e << 52)
        result[i] = e * math.log(2.0)
    for i in range(x.size):
        s = (f[i] - 1) / (f[i] + 1)
        t = s * s
        p = ((((t / 21 + 1 / 19) * t + 1 / 17) * t + 1 / 15) * t + 1 / 13) * t + 1 / 11
        p = ((((p * t + 1 / 9) * t + 1 / 7) * t + 1 / 5) * t + 1 / 3) * t + 1
        result[i] += 2 * s * p
    return result


@once
def _plain(m, power, count):  # type: ignore[no-untyped-def]
    """2 L of the bins alone; infinite where the expectation is not positive."""
    n = power.size
    positive = 0
    for i in range(n):
        positive += m[i] > SMALLEST
    if positive < n:
        return np.inf
    logarithm, total = _logarithms(m[:n]), 0.0
    for i in range(n):
        total += count[i] * (logarithm[i] + power[i] / m[i])
    return total


@swift_part
def _evaluated(m, data):  # type: ignore[no-untyped-def]
    """L, infinite where the expectation is not positive, and what `_directions` found."""
    plain = _plain(m, data[0], data[1])
    found = _directions(m, data)
    return (0.5 * (plain + found[3]) if plain < np.inf else np.inf), found


@swift_part
def _completed(m, found, data):  # type: ignore[no-untyped-def]
    """Power, expectation, the part of it that is not the terms', and count; eta and V.

    The first four are those of the bins and then of the directions.
    """
    power, count, UU, Uc = data
    root, b, own, _ = found
    eta, V = _solved(root, b)
    n, more = power.size, zeros(power.size)
    for j in range(eta.size):
        _add(more, -2 * eta[j], Uc[j])
        for k in range(j + 1):
            _add(more, (eta[j] * eta[k] + V[j, k]) * (1.0 if k == j else 2.0), UU[j, k])
    full, whole, rest, weight = zeros(m.size), zeros(m.size), zeros(m.size), zeros(m.size)
    for i in range(n):
        full[i], whole[i], weight[i] = power[i] + more[i] / count[i], m[i], count[i]
    for i in range(m.size - n):
        full[n + i], whole[n + i], weight[n + i] = own[0, i] * own[0, i], m[n + i] + own[1, i], 1.0
        rest[n + i] = own[1, i]
    return full, whole, rest, weight, eta, V


@swift_part
def _stretch(theta, move, rate):  # type: ignore[no-untyped-def]
    """How much further than `move` to go, if every next one is `rate` times as long; not beyond theta = 0."""
    step = 1.0 / (1.0 - min(max(rate, -1.0), FASTEST))
    for j in range(theta.size):
        if move[j] < 0:
            step = min(step, max(1.0, -theta[j] / move[j]))
    return step


@once
def _towards(theta, held, columns, completed):  # type: ignore[no-untyped-def]
    """Step of Fisher scoring: weight of the bins and directions, and the way theta moves."""
    power, expected, rest, count = completed
    weight, wanted = zeros(held.size), zeros(held.size)
    for i in range(held.size):
        weight[i], wanted[i] = count[i] / (expected[i] * expected[i]), power[i] - rest[i] - held[i]
    move = weighted_nnls(columns, wanted, weight, theta)
    _add(move, -1.0, theta)
    return weight, move


@once
def _moved(theta, move, step):  # type: ignore[no-untyped-def]
    moved = zeros(theta.size)
    for j in range(theta.size):
        moved[j] = max(theta[j] + step * move[j], 0.0)
    return moved


@once
def _rate(weight, before, shift):  # type: ignore[no-untyped-def]
    """Length of this step along the one before, over its length; 0 after none."""
    size = along = 0.0
    for i in range(weight.size):
        size += weight[i] * (before[i] * before[i])
        along += weight[i] * (before[i] * shift[i])
    return along / size if size > 0 else 0.0


@once
def _scored(theta, held, columns, data, iterations):  # type: ignore[no-untyped-def]
    """Theta of the terms that move at the least L, L, the directions' part of 2 L, and what `_completed` gives.

    `held` is the expectation of the other terms. Nothing moves where L is infinite, or without iterations. Where the
    model is wrong, the steps of Fisher scoring shrink evenly: from two of them the sum of all is known.
    """
    nothing, r = np.zeros(held.size), data[3].shape[0]
    trial, move, shift, before = theta, theta, nothing, nothing
    best, step, part = np.inf, 0.0, 0.0
    completed = nothing, nothing, nothing, nothing, np.zeros(r), np.zeros((r, r))
    while True:
        m = _expectation(columns, trial, held)
        least, found = _evaluated(m, data)
        close = CONVERGED + ROUNDING * abs(best)
        if not least <= best + close:
            step = min(step / 2, 1.0)
            if step <= SMALLEST_STEP:
                break
        elif not least < best:
            break
        else:
            before = shift if step == 1.0 else nothing
            gain, theta, best, part = best - least, trial, least, found[3]
            completed = _completed(m, found, data)
            if gain < close or iterations == 0 or theta.size == 0:
                break
            iterations -= 1
            weight, move = _towards(theta, held, columns, completed[:4])
            shift = _expectation(columns, move, nothing)
            step = _stretch(theta, move, _rate(weight, before, shift))
        trial = _moved(theta, move, step)
    return theta, best, part, completed


@swift_part
def _integrated(count, ratio, d, trust):  # type: ignore[no-untyped-def]
    """What 2 L changes by where an error of variance d of ln m is integrated out in each bin.

    `ratio` is the power over m; 1 / (1 + d count / 2) is put in the place of `trust`.
    """
    total, more, log_ratio = 0.0, np.zeros(d.size), _logarithms(ratio)
    for i in range(d.size):
        more[i] = 1.0 + d[i] * count[i] / 2
    log_more = _logarithms(more)
    for i in range(d.size):
        trust[i] = 1.0 / more[i]
        total += log_more[i] - count[i] * (ratio[i] - 1.0 - log_ratio[i]) * (d[i] * count[i] / 2) * trust[i]
    return total


@swift_part
def _trusted(data, trust):  # type: ignore[no-untyped-def]
    """The data of which only a share of each bin counts."""
    power, count, UU, Uc = data
    less, products, sums = np.zeros(count.size), np.zeros(UU.shape), np.zeros(Uc.shape)
    for i in range(count.size):
        less[i] = count[i] * trust[i]
    for j in range(Uc.shape[0]):
        for i in range(count.size):
            sums[j, i] = Uc[j, i] * trust[i]
        for k in range(Uc.shape[0]):
            for i in range(count.size):
                products[j, k, i] = UU[j, k, i] * trust[i]
    return power, less, products, sums


@swift_part
def _set(values, some, moving):  # type: ignore[no-untyped-def]
    k = 0
    for j in range(values.size):
        if moving[j]:
            values[j] = some[k]
            k += 1


@swift_part
def _shares(theta, m, columns, share):  # type: ignore[no-untyped-def]
    """Put the share of all columns in m in its place."""
    for i in range(share.size):
        share[i] = 0.0
    for j in range(theta.size):
        for i in range(share.size):
            share[i] += theta[j] * columns[j, i] / m[i]


@swift_part
def _best_error(ratio, share, count, errors, trust):  # type: ignore[no-untyped-def]
    """The error of a share of m that explains the power over m best, and what 2 L changes by; the trust beside it."""
    best, error, d, tried = np.inf, 0.0, np.zeros(share.size), np.zeros(share.size)
    for k in range(errors.size):
        for i in range(share.size):
            d[i] = (errors[k] * share[i]) * (errors[k] * share[i])
        change = _integrated(count, ratio, d, tried)
        if change < best:
            best, error = change, errors[k]
            for i in range(share.size):
                trust[i] = tried[i]
    return error, best


@swift
def minimise(theta, moving, held, columns, data, loud, errors, first):  # type: ignore[no-untyped-def]  # noqa: PLR0917
    """Theta >= 0 at the least L by Fisher scoring; what is not `moving` keeps its theta.

    `held` is the expectation of what is no term. The last `loud` columns have a shape that is not exact: the best of
    some errors, relative to their power, is integrated out. From the stage `first` on, least and error take turns:
    `LAST` only evaluates. Returns theta, L, the trust in each bin beside the error, and 2 L with that integrated out;
    of the last least, or if there was none the evaluation, the directions' part of 2 L and what `_completed` gives.
    """
    free, n = 0, data[0].size
    for j in range(theta.size):
        free += moving[j]
    some, chosen, rest, moved = np.zeros(free), np.zeros((free, held.size)), np.zeros(held.size), np.zeros(theta.size)
    _add(rest, 1.0, held)
    _add(moved, 1.0, theta)
    k = 0
    for j in range(theta.size):
        if moving[j]:
            some[k] = theta[j]
            _add(chosen[k], 1.0, columns[j])
            k += 1
        elif theta[j] != 0.0:
            _add(rest, theta[j], columns[j])
    share, ratio, trust, error, r = np.zeros(n), np.zeros(n), np.ones(n), np.zeros(1), data[3].shape[0]
    best, value, part, counted = np.inf, np.inf, 0.0, data
    completed = rest, rest, rest, rest, np.zeros(r), np.zeros((r, r))
    for stage in range(first, LAST + 1 if loud or first else 1):
        weighing = stage % 2 == 1
        some, least, own, what = _scored(
            some, rest, chosen, data if weighing else counted, 0 if weighing else ITERATIONS
        )
        if weighing:
            for i in range(n):
                ratio[i] = max(what[0][i] / what[1][i], 1e-12)
            if stage < LAST:
                _shares(moved[theta.size - loud :], what[1], columns[theta.size - loud :], share)
            error[0], change = _best_error(ratio, share, data[1], errors if stage < LAST else error, trust)
            value, counted = 2 * least + change, _trusted(data, trust)
        else:
            best = least
            _set(moved, some, moving)
        if not weighing or first == LAST:
            part, completed = own, what
    return moved, best, trust, value, part, completed


@swift
def resonance(cosine, twice, a, b, high_pass):  # type: ignore[no-untyped-def]
    """Power of noise through two poles and its derivatives by their coefficients a and b, sums over each bin's points.

    `cosine` and `twice` have shape (bins, points): cosines of the frequencies and of twice these.
    """
    sums = np.zeros((3, cosine.shape[0]))
    for i in range(cosine.shape[0]):
        for j in range(cosine.shape[1]):
            x, y = cosine[i, j], twice[i, j]
            # at its peak the denominator of a sharp one is a difference of equal numbers
            below = max((1 + a * a + b * b) + (2 * a * (1 + b)) * x + (2 * b) * y, 1e-15)
            power = ((1 - x * x) if high_pass else 1.0) / below
            sums[0, i] += power
            sums[1, i] -= (2 * a + 2 * (1 + b) * x) * power / below
            sums[2, i] -= (2 * b + 2 * a * x + 2 * y) * power / below
    return sums
