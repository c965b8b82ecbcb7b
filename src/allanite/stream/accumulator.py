"""Accumulator: curve and coefficients of a stream of samples, of which only sums are kept."""

import math
from copy import deepcopy
from typing import Any

import numpy as np

from allanite.core.aliases import public
from allanite.core.arrays import unmasked
from allanite.core.curve import Curve
from allanite.core.declared import demand_size
from allanite.core.errors import DataError, UsageError
from allanite.core.fit import Fit
from allanite.core.model import ModelLike
from allanite.core.ranges import SAMPLES, Range
from allanite.core.record import Record
from allanite.phrases.phrase import say
from allanite.statistics.row import Statistic
from allanite.statistics.table import STATISTICS, statistic_named

from .sums import TAIL, Sums

PLACES = Range(0, SAMPLES.high)  # of samples in a stream

WAITING = 320  # samples that wait until there are more: what comes in short chunks is added together


def streamable() -> tuple[str, ...]:
    """Statistics that can be computed of a stream: means of squared second or third differences at every sample."""
    return tuple(name for name, row in STATISTICS.items() if row.overlapped and row.differences in TAIL)


class Accumulator:
    """Curve and noise coefficients of a stream, whatever its length, in about 30 kB.

    Chunks are added by `push`; parts of a stream that were accumulated apart, on other machines, by `merge`. At any
    time `curve` and `fit` tell what is known so far.

    Parameters
    ----------
    rate, unit, kind, scale, name
        As of a `Record`.
    statistic : {"oadev", "mdev", "tdev", "ohdev", "haar"}
        What `curve` shows; `fit` is the same for all.
    start : int
        Place of the first sample in the whole stream, for parts that are to be merged.

    Attributes
    ----------
    size : int
        Number of samples so far.

    Raises
    ------
    UsageError
        The properties of the samples are impossible, or the statistic is not one of differences that overlap.

    Notes
    -----
    Averaging factors are 1 to 15, then 8 to 15 times every power of two. Up to 15 a window begins at every sample;
    at q 2^k at every 2^k-th sample (the stride), m/8 to m/15 apart, which costs 1 % of the standard deviation at most.
    The variances are those of the record itself taken at these windows, to rounding, and the intervals those
    of that many windows, exactly.

    Examples
    --------
    >>> import numpy as np
    >>> rng = np.random.default_rng(1)
    >>> stream = Accumulator(rate=100.0, unit="deg/h", name="z")
    >>> for _ in range(20):
    ...     stream.push(rng.normal(0.0, 2.0, 1000))
    >>> stream.size, round(float(stream.curve().to("deg/h").deviation[0]), 1)
    (20000, 2.0)
    """

    @public
    def __init__(self, rate: float, unit: str, kind: str = "rate", *, scale: float | None = None, name: str = "",
                 statistic: str = "oadev", start: int = 0) -> None:  # fmt: skip
        self.like = Record(np.zeros(3, np.int64), rate, unit, kind, scale, name)
        self.row: Statistic = statistic_named(statistic)
        if self.row.name not in streamable():
            raise UsageError(f"a stream has no {statistic!r}: choose one of {', '.join(streamable())}, or make a "
                             "Record of it")  # fmt: skip
        self.start: int = PLACES.demand(start, "start, the place of the first sample in the stream,")
        self._sums = Sums(self.row, start)
        self._waiting, self._held = np.empty(WAITING), 0
        self.last = math.nan

    @property
    def sums(self) -> Sums:
        """What is kept, with all samples that came."""
        if self._held:
            held, self._held = self._held, 0
            self._sums.push(self._waiting[:held])
        return self._sums

    @property
    def size(self) -> int:
        """Number of samples that are not missing."""
        return self.sums.size

    @property
    def stop(self) -> int:
        """Place in the whole stream of the next sample."""
        return self._sums.stop + self._held

    @property
    def missing(self) -> int:
        """Number of samples that are missing."""
        return self.stop - self.start - self.size

    @property
    def nbytes(self) -> int:
        """Size of what is kept."""
        return self._sums.nbytes + self._waiting.nbytes

    def push(self, chunk: Any) -> None:
        """Add samples that follow the last ones; those that are not finite are missing.

        Parameters
        ----------
        chunk : array, shape (n,)
            Samples in the unit of the stream; of kind "angle" points, of which the first of all only begins the stream.

        Raises
        ------
        DataError
            The chunk is not a row of real numbers.
        """
        if not isinstance(chunk, np.ndarray):
            demand_size("chunk", chunk, Any)
        values = np.ascontiguousarray(unmasked(chunk))
        if values.ndim != 1 or values.dtype.kind not in "fiu":
            raise DataError(say(
                "a chunk is a row of real numbers, shape (n,), not {dtype} of shape {shape}; push every channel "
                "to an Accumulator of its own", dtype=values.dtype, shape=values.shape))  # fmt: skip
        values = values.astype(np.float64, copy=False)
        if self.like.kind == "angle" and values.size:
            begun = self.stop > self.start or math.isfinite(self.last)
            values, self.last = np.diff(np.append(self.last, values) if begun else values), float(values[-1])
        if self._held + values.size > WAITING:
            sums = self.sums
            if values.size > WAITING:
                sums.push(values)
                return
        self._waiting[self._held : self._held + values.size] = values
        self._held += values.size

    @public
    def skip(self, samples: int) -> None:
        """Go on after so many missing samples."""
        PLACES.demand(self.stop + PLACES.demand(samples, "the number of missing samples"), "the place of a sample")
        self.last = math.nan
        self.sums.stop += samples

    @public
    def merge(self, other: "Accumulator") -> None:
        """Add a later part of the same stream, which is not changed.

        Where it begins right after this one, the result is that of one stream; otherwise what lies between is missing.
        In whatever order parts that follow each other are merged, the result is the same to rounding.

        Raises
        ------
        UsageError
            The other one is of another kind of stream or statistic, or begins before this one ends.
        """
        own, theirs = ((a.like.rate, a.like.unit, a.like.kind, a.like.scale, a.row.name) for a in (self, other))
        if own != theirs:
            raise UsageError(f"only parts of one stream can be merged, not {own} and {theirs}")
        if other.start < self.stop:
            raise UsageError(f"a part that begins at sample {other.start} cannot follow one that ends at {self.stop}; "
                             "merge the parts in their order, and give each its start=...")  # fmt: skip
        other = deepcopy(other)
        self.sums.merge(other.sums)
        self.last = other.last

    @public
    def curve(self, noise: "ModelLike | Fit | None" = None) -> Curve:
        """The statistic so far, without intervals unless the `noise` is given, for example `fit()`.

        Raises
        ------
        DataError
            There are too few samples for any averaging time.
        """
        from .coefficients import curve_of

        return curve_of(self, noise)

    @public
    def fit(self, terms: str = "auto", **choices: Any) -> Fit:
        """The noise coefficients so far; see `stream.coefficients.search_in`."""
        from .coefficients import search_in

        return search_in(self, terms, **choices).fit()

    def __repr__(self) -> str:
        return f"Accumulator({self.row.name} of {self.size} samples, {self.like.rate:g} Hz, {self.like.unit})"
