"""Whether the slow part of one channel follows another: a temperature, a supply."""

from typing import NamedTuple

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.record import Record

BLOCKS = 256
"""Block means that are compared at most."""

FEWEST = 32
"""Block means that there must be, and readings in each of them."""

MISSING = 0.1
"""Share of blocks without a reading above which nothing is asked."""

CLEAR = 16.0
"""Twice the gain of the log-likelihood from which on a channel follows another; see `follows`."""

MUCH = 0.25
"""Share of the variance of the block means, less a line, that must go with the other channel."""

SHARES = np.concatenate(([0.0], np.geomspace(1e-3, 1e5, 17)))
"""Flicker and random walk over white noise, at the angle of half the sampling rate of the blocks."""


class Following(NamedTuple):
    """Twice the gain of the log-likelihood, and the share of the variance of the block means, less a line."""

    gain: float
    share: float

    @property
    def clear(self) -> bool:
        """Whether the one follows the other, and much of it does."""
        return self.gain > CLEAR and self.share > MUCH


def follows(record: Record, other: Record) -> Following | None:
    """How much of the slow part of a record goes with another channel of the same clock.

    Means of blocks are transformed by the cosine transform, where a coefficient of white noise, flicker and random walk
    of the rate is independent of the others; the likelihood of these three, beside a line, is compared with that of the
    same three beside a line and the other channel. Two independent random walks look alike to the eye and to an
    ordinary correlation, but not here: without the other channel they are a random walk.

    Returns
    -------
    Following or None
        None where there is nothing to ask: too few readings, or a channel that is constant or a line.
    """
    blocks = min(BLOCKS, record.size // FEWEST)
    if blocks < FEWEST or record.size != other.size:
        return None
    y, x = _means(record.rate_values, blocks), _means(other.rate_values, blocks)
    if y is None or x is None:
        return None
    line = np.linspace(-0.5, 0.5, blocks)
    x, y = x - float(x.mean()), y - float(y.mean())
    left = [values - line * float(line @ values) / float(line @ line) for values in (x, y)]
    if any(not np.ptp(rest) > 1e-9 * np.ptp(whole) for rest, whole in zip(left, (x, y), strict=True)):
        return None
    without, _ = _likelihood(y, [line])
    with_it, sizes = _likelihood(y, [line, x])
    rest = y - sizes[0] * line - sizes[1] * x
    return Following(without - with_it, 1 - float(rest.var() / left[1].var()))


def _means(values: FloatArray, blocks: int) -> FloatArray | None:
    """Means of blocks; where a few have no reading, what lies between their neighbours."""
    length = values.size // blocks
    parts = values[: blocks * length].reshape(blocks, length)
    there = np.isfinite(parts)
    count = there.sum(axis=1)
    known = np.flatnonzero(count)
    if known.size < (1 - MISSING) * blocks:
        return None
    sums = np.where(there, parts, 0.0).sum(axis=1)
    return np.asarray(np.interp(np.arange(blocks), known, sums[known] / count[known]))


def _likelihood(y: FloatArray, columns: list[FloatArray]) -> tuple[float, FloatArray]:
    """Twice the negative log-likelihood at its minimum over the grid of noises, and the sizes of the columns there."""
    from scipy.fft import dct

    size = y.size
    data, *others = (dct(values, norm="ortho")[1:] for values in (y, *columns))
    design = np.stack(others)
    angle = 2 * np.sin(np.pi * np.arange(1, size) / (2 * size))
    flicker, walk = (shares.ravel()[:, None] for shares in np.meshgrid(SHARES, SHARES))
    power = 1 + flicker * 1e-2 / angle + walk * 1e-4 / angle**2
    weight = 1 / power
    normal = np.einsum("gk,ik,jk->gij", weight, design, design)
    sizes = np.linalg.solve(normal, np.einsum("gk,ik,k->gi", weight, design, data)[..., None])[..., 0]
    rest = data - sizes @ design
    value = (size - 1) * np.log((weight * rest**2).sum(axis=1)) + np.log(power).sum(axis=1)
    best = int(value.argmin())
    return float(value[best]), sizes[best]
