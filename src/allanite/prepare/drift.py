"""Whether the drift of one channel follows another: a temperature, a supply voltage."""

from typing import NamedTuple

import numpy as np
import scipy

from allanite.core.arrays import FloatArray
from allanite.core.record import Record

BLOCKS = 256  # maximum number of block means that are compared
FEWEST_BLOCKS = 32  # minimum number of block means, and of samples in each of them
MISSING = 0.1  # share of blocks without a sample above which no comparison is made
CLEAR = 16.0  # twice the gain of the log-likelihood above which a channel follows another; see `follows`
MUCH = 0.25  # share of the variance of the detrended block means that must be explained by the other channel

SHARES = np.concatenate(([0.0], np.geomspace(1e-3, 1e5, 17)))
"""Ratios of flicker and random walk to white noise, at half the sampling rate of the blocks."""


class Following(NamedTuple):
    """Twice the gain of the log-likelihood, and the explained share of the variance of the detrended block means."""

    gain: float
    share: float

    @property
    def clear(self) -> bool:
        """Whether the channel follows the other one significantly and to a large part."""
        return self.gain > CLEAR and self.share > MUCH


def follows(record: Record, other: Record) -> Following | None:
    """How much of the drift of a record follows another channel with the same sample times."""
    # Block means are transformed by the cosine transform, in which the coefficients of white noise, flicker and random
    # walk of the rate are independent. The likelihood of these three with a linear trend is compared with that of the
    # same three with a linear trend and the other channel. Two independent random walks often appear correlated, but
    # not in this test, whose null hypothesis includes a random walk.
    blocks = min(BLOCKS, record.size // FEWEST_BLOCKS)
    if blocks < FEWEST_BLOCKS or record.size != other.size:
        return None
    y, x = _means(record.rate_values, blocks), _means(other.rate_values, blocks)
    if y is None or x is None:
        return None
    line = np.linspace(-0.5, 0.5, blocks)
    x, y = x - float(x.mean()), y - float(y.mean())
    detrended = [values - line * float(line @ values) / float(line @ line) for values in (x, y)]
    if any(not np.ptp(rest) > 1e-9 * np.ptp(whole) for rest, whole in zip(detrended, (x, y), strict=True)):
        return None
    without, _ = _likelihood(y, [line])
    with_it, sizes = _likelihood(y, [line, x])
    rest = y - sizes[0] * line - sizes[1] * x
    return Following(without - with_it, 1 - float(rest.var() / detrended[1].var()))


def _means(values: FloatArray, blocks: int) -> FloatArray | None:
    """Means of blocks; means of blocks without samples are interpolated."""
    length = values.size // blocks
    parts = values[: blocks * length].reshape(blocks, length)
    sampled = np.isfinite(parts)
    count = sampled.sum(axis=1)
    known = np.flatnonzero(count)
    if known.size < (1 - MISSING) * blocks:
        return None
    sums = np.where(sampled, parts, 0.0).sum(axis=1)
    return np.asarray(np.interp(np.arange(blocks), known, sums[known] / count[known]))


def _likelihood(y: FloatArray, columns: list[FloatArray]) -> tuple[float, FloatArray]:
    """The smallest -2 log-likelihood over the grid of noises, and the regression coefficients there."""
    size = y.size
    data, *others = (scipy.fft.dct(values, norm="ortho")[1:] for values in (y, *columns))
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
