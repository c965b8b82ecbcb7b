"""The curve of a stream, and its limits: a level of the sums is a record of its own that is sampled less often."""

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Literal

import numpy as np

from allanite.core.arrays import FloatArray, IntArray
from allanite.core.averaged import Averaged
from allanite.core.curve import Curve, Law
from allanite.core.errors import DataError
from allanite.core.fit import Fit
from allanite.core.limits import Remembered
from allanite.core.model import ModelLike, model_of
from allanite.core.plain import Portable
from allanite.phrases.phrase import say
from allanite.statistics.confidence.averaged import AveragedLaw
from allanite.statistics.confidence.supposed import LaterLaw, supposed
from allanite.statistics.row import Statistic
from allanite.statistics.table import CurvePoints

if TYPE_CHECKING:
    from .accumulator import Accumulator


def grid() -> tuple[IntArray, IntArray]:
    """Averaging factors over the stride of their windows, and the levels: strides are 2^level."""
    from allanite.kernels.ladder import FIRST, LEVELS, OCTAVE

    q = np.concatenate((np.arange(1, FIRST + 1), np.tile(np.arange(OCTAVE, FIRST + 1), LEVELS - 1)))
    level = np.concatenate((np.zeros(FIRST, np.int64), np.repeat(np.arange(1, LEVELS), OCTAVE)))
    return q, level


def curve_of(stream: "Accumulator", noise: ModelLike | Fit | None) -> Curve:
    """The statistic of a stream at all averaging times that have a window; see `Accumulator.curve`."""
    row, like, state = stream.row, stream.like, stream.sums.state
    which = np.flatnonzero(state.counts)
    if not which.size:
        raise DataError(
            say(
                "{size} samples without a gap are too few for {statistic}; wait for more",
                size=stream.size,
                statistic=row.name,
            )
        )
    q, level = (values[which] for values in grid())
    m, count = q << level, state.counts[which]
    mean = state.sums[which] / count / (row.norm(m) * m.astype(np.float64) ** 2)
    unit = like.factor * (1.0 if like.integrated else like.interval) / like.interval ** (1 - row.power)
    law = None
    if noise is not None:
        law = LaterLaw(Remembered(partial(supposed, noise)), partial(law_of, row, q, level, (count, like.rate)))
    return Curve(
        statistic=row.name,
        m=m,
        tau=np.asarray(m * row.tau_factor / like.rate, dtype=np.float64),
        variance=mean * (m * row.tau_factor) ** (2.0 * row.power) * unit**2,
        count=count,
        factor=np.ones(m.size),
        unit=like.signal.si[row.power],
        rate=like.rate,
        size=stream.stop - stream.start,
        name=like.name,
        history=(say("stream: windows of m = q 2^k, q = 8 .. 15, start every 2^k samples (stride)"),),
        noise=None if noise is None else model_of(noise),
        law=law,
        supposes=law.words if law else None,
    )


def law_of(
    row: Statistic, q: IntArray, level: IntArray, seen: tuple[IntArray, float], noise: Averaged | Literal["auto"]
) -> "StrideLaw":
    """The law of points from their numbers of windows and the sampling rate, under models."""
    assert isinstance(noise, Averaged)  # noqa: S101 - `curve_of` takes models only
    count, rate = seen
    per, fixed = row.span
    size = count + per * q + fixed - 1
    parts: list[Law] = []
    for k, n in dict.fromkeys(zip(level.tolist(), size.tolist(), strict=True)):
        here = q[(level == k) & (size == n)]
        points = CurvePoints(row, here, [(n, 1)], n, rate / 2.0**k, 0.5)
        parts.append(AveragedLaw(points, noise, np.ones((len(noise), here.size))))
    return StrideLaw(tuple(parts))


@dataclass(frozen=True, eq=False)
class StrideLaw(Portable):
    """The laws of the levels one after the other.

    Windows that start every 2^k samples, of an angle that is taken there only, are the windows at every sample of a
    record with 2^k times the sample interval, for which everything is known exactly.
    """

    parts: tuple[Law, ...]

    def __call__(self, level: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Degrees of freedom and limits over the variance; see `Curve`."""
        edf, low, high = (np.concatenate(each) for each in zip(*(part(level) for part in self.parts), strict=True))
        return edf, low, high
