"""Sums over all windows of a record, from its autocorrelation, in frames (docs/derivations.md)."""

from typing import NamedTuple

import numpy as np
import scipy

from allanite.core.arrays import FloatArray
from allanite.kernels import theo

STARTS_PER_FRAME = 3  # windows' starts in a frame, over the length of the longest window
MAX_BLOCK = 1 << 16  # longest block that is transformed at once: with its zeros it stays in the cache's neighbourhood
BATCH_POINTS = 1 << 17  # points of frames that are transformed in one call
LEAF = 256  # side of the triangles that are summed directly
RADIX = 16  # blocks into which a triangle is cut


class Edges(NamedTuple):
    """The first points of a record, its last ones backward, and what represents the seams between frames."""

    # The sum over windows is that of w(l) R(l) less the sum of sign E(edge).
    edges: list[FloatArray]
    signs: list[float]


def framed(
    x: FloatArray, reach: int, degree: int, *, summed: bool = False, whole: bool = False
) -> tuple[FloatArray, Edges]:
    """The products R(l) of a record at lags l = 0 .. `reach`, and its edges; in one frame if `whole`."""
    # The record is the angle x or, with `summed`, its running sum, of one point more. The longest window covers reach +
    # 1 points; the form does not see polynomials of `degree` 1 or 2.
    points = x.size + summed
    block = min(scipy.fft.next_fast_len(reach, real=True), MAX_BLOCK)
    right = -(-reach // block)
    step = STARTS_PER_FRAME * right * block
    count = 0 if whole else max(0, (points - reach) // step)
    total = np.zeros((right + 1, 2 * block + 2))
    seams = _Seams(reach, degree)
    batch = max(1, BATCH_POINTS // (step + right * block))
    rows = np.zeros((min(batch, count), step + right * block))
    for k in range(0, count, batch):
        part = rows[: min(batch, count - k)]
        for i, row in enumerate(part):
            theo.cut(x, (k + i) * step, degree, summed, row[: step + reach])
            seams.begin(row[:reach].copy())
            seams.end(row[step : step + reach].copy())
        # add the rows' cross spectra between each of the first `left` blocks and those behind it
        spectra = np.fft.rfft(part.reshape(part.shape[0], -1, block), 2 * block)
        theo.add_products(total, spectra.view(np.float64), STARTS_PER_FRAME * right)
    tail = np.empty(points - count * step)
    theo.cut(x, count * step, degree, summed, tail)
    seams.begin(tail[:reach])
    _add_one(total, tail, block)
    edges, signs = seams.edges()
    return _lags(total, block)[: reach + 1], Edges([*edges, tail[::-1][:reach]], [*signs, 1.0])


def autocorrelation(z: FloatArray) -> FloatArray:
    """Sum over i < z.size - l of z[i] z[i + l], shape of z."""
    block = min(scipy.fft.next_fast_len(z.size, real=True), MAX_BLOCK)
    total = np.zeros((-(-z.size // block), 2 * block + 2))
    _add_one(total, z, block)
    return _lags(total, block)[: z.size]


def _add_one(total: FloatArray, z: FloatArray, block: int) -> None:
    """Add the cross spectra of a frame that is followed by nothing, of any length."""
    whole, rest = divmod(z.size, block)
    spectra = np.empty((1, whole + (rest > 0), block + 1), dtype=np.complex128)
    if whole:
        np.fft.rfft(z[: whole * block].reshape(whole, block), 2 * block, out=spectra[0, :whole])
    if rest:
        np.fft.rfft(z[whole * block :], 2 * block, out=spectra[0, whole])
    theo.add_products(total, spectra.view(np.float64), spectra.shape[1])


def _lags(total: FloatArray, block: int) -> FloatArray:
    """Products by lag, from the cross spectra of blocks that lie 0, 1, 2 ... blocks apart."""
    result = np.zeros((total.shape[0] + 1, block))
    for o, spectrum in enumerate(total):
        lags = np.fft.irfft(spectrum.view(np.complex128), 2 * block)
        result[o] += lags[:block]
        if o:
            result[o - 1, 1:] += lags[block + 1 :]
    return result.ravel()


class _Seams:
    """The first frame's near edge, and what the seams between frames add up to."""

    def __init__(self, reach: int, degree: int) -> None:
        self.reach = reach
        self.first: FloatArray | None = None
        self.far: FloatArray | None = None
        self.nodes = np.linspace(0, reach - 1, degree + 1).astype(np.int64)
        self.sums = np.zeros((degree + 1, reach))
        self.squares = np.zeros((degree + 1, degree + 1))

    def begin(self, z: FloatArray) -> None:
        """The near edge of a frame, which begins where the last one has ended."""
        if self.far is None:
            self.first = z
            return
        g = self.far[self.nodes] - z[self.nodes]
        for j, size in enumerate(g):
            self.sums[j] += size * z
        self.squares += np.outer(g, g)

    def end(self, z: FloatArray) -> None:
        """The edge beyond the last start of a window in a frame."""
        self.far = z

    def edges(self) -> tuple[list[FloatArray], list[float]]:
        """Edges and signs; 2 E(Y, p) = E(Y/s + s p)/2 - E(Y/s - s p)/2."""
        assert self.first is not None  # noqa: S101 - there is always a tail
        edges, signs = [self.first], [1.0]
        if self.far is None:
            return edges, signs
        # the polynomials that are 1 at one node and 0 at the others, shape (nodes, reach)
        nodes = self.nodes
        basis = np.ones((nodes.size, self.reach))
        u = np.arange(self.reach, dtype=np.float64)
        for i, node in enumerate(nodes):
            for other in np.delete(nodes, i):
                basis[i] *= (u - other) / (node - other)
        for sums, squares, p in zip(self.sums, self.squares, basis, strict=True):
            Y = sums + 0.5 * squares @ basis
            if size := float(np.abs(Y).max()):
                edges += [np.sqrt(0.5 / size) * (Y + size * p), np.sqrt(0.5 / size) * (Y - size * p)]
                signs += [-1.0, 1.0]
        return edges, signs


def triangles(edges: Edges, steps: tuple[int, int, int], count: int) -> FloatArray:
    """Sum over edges e of sign sum over i < a m of e[i] e[i + d m + offset], m = 0 ... count - 1, steps = a, d, offset.

    Cut into blocks of h averaging factors: a block of m and a block of i that lies wholly below make a rectangle, which
    is a correlation; the blocks of i beside the block of m itself are triangles again, until they are small.
    """
    heights = [LEAF]
    while heights[-1] * RADIX < count and heights[-1] < MAX_BLOCK:
        heights.append(heights[-1] * RADIX)
    out = np.zeros(-(-count // heights[-1]) * heights[-1])
    for h in heights:
        blocks = out.size // h if h == heights[-1] else RADIX
        parents = max(1, MAX_BLOCK // (h * blocks))
        for begin in range(0, out.size, parents * blocks * h):
            part = out[begin : begin + parents * blocks * h].reshape(-1, blocks, h)
            part += _rectangles(edges, steps, begin, part.shape)
    for e, sign in zip(edges.edges, edges.signs, strict=True):
        theo.add_leaves(out[:count], np.ascontiguousarray(e), sign, steps, LEAF)
    return out[:count]


def _rectangles(edges: Edges, steps: tuple[int, int, int], begin: int, shape: tuple[int, int, int]) -> FloatArray:
    """What the blocks of i below give to each block of m, shape (parents, blocks, h)."""
    a, d, offset = steps
    parents, blocks, h = shape
    starts = begin + blocks * h * np.arange(parents)
    size = (a + abs(d)) * h
    total = np.zeros((parents, blocks, 2 * (size // 2 + 1)))
    # a I + d J with 0 <= I < J < blocks
    places = sorted({a * low + d * high for high in range(blocks) for low in range(high)})
    for e, sign in zip(edges.edges, edges.signs, strict=True):
        rows = np.array([sign * _stretch(e, a * start, a * blocks * h) for start in starts.tolist()])
        near = np.fft.rfft(rows.reshape(parents, blocks, a * h), size).view(np.float64)
        for place in places:
            first = (a + d) * starts + place * h + offset + min(d, 0) * (h - 1)
            far = np.fft.rfft(np.array([_stretch(e, k, size) for k in first.tolist()])).view(np.float64)
            theo.add_rectangles(total, near, far, place, (a, d))
        del rows, near  # each is as long as the edge
    lags = np.fft.irfft(total.view(np.complex128), size)[:, :, : abs(d) * h : abs(d)]
    return lags if d > 0 else lags[:, :, ::-1]


def _stretch(e: FloatArray, start: int, size: int) -> FloatArray:
    """e[start : start + size], zero where there is nothing."""
    if start >= 0 and start + size <= e.size:
        return e[start : start + size]
    row = np.zeros(size)
    low, high = max(start, 0), min(start + size, e.size)
    if low < high:
        row[low - start : high - start] = e[low:high]
    return row
