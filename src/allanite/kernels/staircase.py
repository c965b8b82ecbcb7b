"""Branch and bound for the staircase floor(x + p l + q r) that is nearest to the data."""

import numpy as np

from .compiling import inner, kernel, swift

FEW = 6
"""Undecided samples of a box at which its cells are counted out, one by one."""

MANY = 10_000
"""The same for boxes that cannot be cut further; with more than these the bound alone remains."""

FINEST = 1e-9
"""Side of the smallest box, pulses."""

TOUCH = 1e-10
"""Distance, pulses, below which a line is taken to run through a point."""

DEEPEST = 200
"""Levels of boxes: two for each halving of both sides, from any size to the finest."""


@swift
def misfit(e, x, right, corner):  # type: ignore[no-untyped-def]
    """Sum over i of (e - floor(x + p (1 - right) + q right))^2 at corner = (p, q)."""
    total = 0.0
    p, slope = corner[0], corner[1] - corner[0]
    for i in range(e.size):
        difference = e[i] - np.floor(x[i] + p + slope * right[i])
        total += difference * difference
    return total


@inner
def _bound(samples, box, part, out):  # type: ignore[no-untyped-def]
    """Split the samples `part` by whether their step is decided within a box.

    `samples` is (e, x, right), `box` (p0, p1, q0, q1), half open. The step is monotone in p and q: it lies between that
    of the lower corner and the last one below the upper corner. Returns the misfit of the decided ones, the least one
    of the others, their misfit in the box's middle, and how many of them there are (their indices are in `out`).
    """
    e, x, right = samples
    p0, p1, q0, q1 = box
    decided, least, middle, count = 0.0, 0.0, 0.0, 0
    for j in range(part.size):
        i = part[j]
        r = right[i]
        left = 1.0 - r
        low = np.floor(x[i] + p0 * left + q0 * r)
        high = np.ceil(x[i] + p1 * left + q1 * r) - 1.0
        if high <= low:
            decided += (e[i] - low) ** 2
        else:
            out[count] = i
            count += 1
            nearest = min(max(np.rint(e[i]), low), high)
            least += (e[i] - nearest) ** 2
            middle += (e[i] - np.floor(x[i] + 0.5 * (p0 + p1) * left + 0.5 * (q0 + q1) * r)) ** 2
    return decided, least, middle, count


@inner
def _lines(samples, box, part):  # type: ignore[no-untyped-def]
    """The lines p (1 - right) + q right = at on which the undecided samples step up, and the misfits on either side."""
    e, x, right = samples
    r, at, low, gain = np.empty(part.size), np.empty(part.size), np.empty(part.size), np.empty(part.size)
    for j in range(part.size):
        i = part[j]
        r[j] = right[i]
        step = np.floor(x[i] + box[0] * (1.0 - r[j]) + box[2] * r[j])
        at[j] = step + 1.0 - x[i]
        low[j] = (e[i] - step) ** 2
        gain[j] = (e[i] - step - 1.0) ** 2 - low[j]
    return r, at, low.sum(), gain


@inner
def _about(lines, p, q):  # type: ignore[no-untyped-def]
    """Least misfit of the cells that meet in a point.

    The lines are in order of `right`: those of them through the point that a cell is above of are a beginning or an end
    of their list.
    """
    r, at, total, gain = lines
    whole = 0.0
    for j in range(r.size):
        above = p * (1.0 - r[j]) + q * r[j] - at[j]
        if abs(above) < TOUCH:
            whole += gain[j]
        elif above > 0:
            total += gain[j]
    least, head = min(0.0, whole), 0.0
    for j in range(r.size):
        if abs(p * (1.0 - r[j]) + q * r[j] - at[j]) < TOUCH:
            head += gain[j]
            least = min(least, head, whole - head)
    return total + least


@inner
def _along(lines, box, side):  # type: ignore[no-untyped-def]
    """Least misfit along a side of the box (0, 1: p = p0, p1; 2, 3: q = q0, q1), and where."""
    r, at, total, gain = lines
    fixed = box[side]
    start, end = (box[2], box[3]) if side < 2 else (box[0], box[1])
    crossing = np.empty(r.size)
    for j in range(r.size):
        own, other = (r[j], 1.0 - r[j]) if side < 2 else (1.0 - r[j], r[j])
        rest = at[j] - fixed * other
        crossing[j] = rest / own if own > 0 else (start if rest <= 0 else end)
    order = np.argsort(crossing)
    least, where, here = np.inf, start, start
    for j in range(r.size + 1):
        there = min(max(crossing[order[j]], start), end) if j < r.size else end
        if there > here and total < least:
            least, where = total, 0.5 * (here + there)
        here = there
        if j < r.size:
            total += gain[order[j]]
    return (least, fixed, where) if side < 2 else (least, where, fixed)


@inner
def _cells(lines, box):  # type: ignore[no-untyped-def]
    """Least misfit in a box of sides below 1, exactly: a cell touches its border or has a corner where lines meet."""
    r, at = lines[0], lines[1]
    least, best_p, best_q = np.inf, 0.0, 0.0
    for side in range(4):
        found, p, q = _along(lines, box, side)
        if found < least:
            least, best_p, best_q = found, p, q
    last_p, last_q = np.inf, np.inf
    for i in range(r.size):
        for j in range(i + 1, r.size):
            across = r[j] - r[i]
            p = (at[i] * r[j] - at[j] * r[i]) / across
            q = (at[j] * (1.0 - r[i]) - at[i] * (1.0 - r[j])) / across
            inside = box[0] <= p <= box[1] and box[2] <= q <= box[3]
            if inside and not (abs(p - last_p) < TOUCH and abs(q - last_q) < TOUCH):
                last_p, last_q = p, q
                found = _about(lines, p, q)
                if found < least:
                    least, best_p, best_q = found, p, q
    return least, best_p, best_q


@inner
def _room(store, needed):  # type: ignore[no-untyped-def]
    """`store`, or a larger one with the same beginning."""
    if needed <= store.size:
        return store
    larger = np.empty(2 * needed, dtype=np.int32)
    larger[: store.size] = store
    return larger


@inner
def _half(box, upper):  # type: ignore[no-untyped-def]
    """One half of a box, cut across its longer side."""
    p0, p1, q0, q1 = box
    if p1 - p0 >= q1 - q0:
        cut = 0.5 * (p0 + p1)
        return (cut, p1, q0, q1) if upper else (p0, cut, q0, q1)
    cut = 0.5 * (q0 + q1)
    return (p0, p1, cut, q1) if upper else (p0, p1, q0, cut)


@kernel
def nearest_staircase(samples, known, half, work):  # type: ignore[no-untyped-def]
    """Least misfit over the box |p|, |q| < half.

    Depth first, each box cut in two across its longer side, the half nearer to the best point first. A box is left as
    soon as its bound is not below the best misfit. A sample that is decided in a box is decided in all of its parts,
    and is never looked at again.
    """
    n = samples[0].size
    store = np.empty(4 * n + 64, dtype=np.int32)
    store[:n] = np.arange(n)
    boxes = np.empty((DEEPEST, 4))
    # of each level: where its undecided samples are stored, the misfit of the decided ones, halves done, the first one
    first, last = np.zeros(DEEPEST, dtype=np.int64), np.zeros(DEEPEST, dtype=np.int64)
    fixed, turn, near = np.zeros(DEEPEST), np.zeros(DEEPEST, dtype=np.int64), np.zeros(DEEPEST, dtype=np.int64)
    boxes[0, 0], boxes[0, 1], boxes[0, 2], boxes[0, 3] = -half, half, -half, half
    last[0] = n
    p, q, best = known
    looked, unresolved, depth = 0.0, np.inf, 0
    while depth >= 0 and looked <= work:
        if turn[depth] == 2:
            depth -= 1
            continue
        whole = (boxes[depth, 0], boxes[depth, 1], boxes[depth, 2], boxes[depth, 3])
        if turn[depth] == 0:
            upper = _half(whole, 1)
            near[depth] = p >= upper[0] and q >= upper[2]
        box = _half(whole, near[depth] ^ turn[depth])
        turn[depth] += 1
        size = last[depth] - first[depth]
        store = _room(store, last[depth] + size)
        part, out = store[first[depth] : last[depth]], store[last[depth] : last[depth] + size]
        decided, least, middle, count = _bound(samples, box, part, out)
        looked += size
        decided += fixed[depth]
        if decided + middle < best:
            best, p, q = decided + middle, 0.5 * (box[0] + box[1]), 0.5 * (box[2] + box[3])
        if decided + least >= best:
            continue
        side = max(box[1] - box[0], box[3] - box[2])
        if side < FINEST and count > MANY:
            unresolved = min(unresolved, decided + least)
        elif (count <= FEW and side < 1.0) or side < FINEST:
            found, p_, q_ = _cells(_lines(samples, box, out[:count]), box)
            looked += count * count
            if decided + found < best:
                best, p, q = decided + found, p_, q_
        else:
            depth += 1
            boxes[depth, 0], boxes[depth, 1], boxes[depth, 2], boxes[depth, 3] = box
            first[depth], last[depth] = last[depth - 1], last[depth - 1] + count
            fixed[depth], turn[depth] = decided, 0
    return p, q, best, min(best, unresolved) if depth < 0 else -np.inf, looked
