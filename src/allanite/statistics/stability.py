"""N-second stability of a record, and the minimum of a curve."""

import math
from typing import Any, NamedTuple

import numpy as np

from allanite.core.aliases import public
from allanite.core.curve import Curve
from allanite.core.errors import DataError, UsageError
from allanite.core.model import ModelLike, model_of
from allanite.core.record import Record
from allanite.phrases.phrase import say

from .row import BoolArray, FloatArray

FLOOR = math.sqrt(2 * math.log(2) / math.pi)
"""Allan deviation of flicker over B: 0.66428. (The 0.6648 of some texts is a misprint.)"""

FEWEST = 2
"""Minimum number of complete means."""

KNOWN = 10.0
"""Minimum degrees of freedom of a point for the minimum."""


class Stability(NamedTuple):
    """Standard deviation `value` of N-second means, SI, and its exact expectation under a model (`expected`).

    There are `blocks` means over `seconds`; `duration` is that of the record, s: except for white noise the value grows
    with it.
    """

    value: float
    seconds: float
    blocks: int
    duration: float
    unit: str
    expected: float | None


class Minimum(NamedTuple):
    """The minimum of a curve, and the bias instability if all of it were flicker, which is an upper limit.

    `value` is ``deviation / 0.66428``, in the curve's unit. `inside` says whether the curve rises again beyond `tau`;
    otherwise the minimum is the last point and only an upper limit.
    """

    value: float
    deviation: float
    tau: float
    inside: bool


@public
def averaging_stability(record: Record, seconds: float = 10.0, *, model: ModelLike | None = None) -> Stability:
    """N-second stability: the standard deviation of the means over `seconds`, without overlap.

    ``s^2 = sum (Y_j - mean Y)^2 / (K - 1)``. Under a model its expectation is ``1/(K (K-1)) sum_l (K - l) (2 D(tau) + 2
    D(l tau) - D((l+1) tau) - D((l-1) tau)) / tau^2``. Means that overlap a gap are omitted.

    Raises
    ------
    UsageError
        `seconds` is not a multiple of the sample interval.
    DataError
        There are fewer than 2 means.

    Examples
    --------
    >>> record = Record([1.0, 3, 2, 2, 5, 3], rate=1.0, unit="rad/s", kind="rate")
    >>> round(averaging_stability(record, 2.0).value, 4)
    1.1547
    """
    m = round(seconds * record.rate) if math.isfinite(seconds * record.rate) else 0
    if m < 1 or abs(m - seconds * record.rate) > 1e-6 * m:
        raise UsageError(f"{seconds:g} s is not a multiple of the sample interval {record.interval:g} s")
    means, whole = means_of(record, m)
    blocks = int(whole.sum())
    if blocks < FEWEST:
        names: dict[str, Any] = {"channel": record.name, "blocks": blocks, "seconds": seconds}
        if blocks < whole.size:
            raise DataError(
                say(
                    "{channel!r} has {blocks} complete means over {seconds:g} s, but 2 are needed, and a mean that "
                    "touches a gap is not complete; choose a shorter time",
                    **names,
                )
            )
        raise DataError(
            say(
                "{channel!r} has {blocks} complete means over {seconds:g} s, but 2 are needed; the longest "
                "possible time is {longest:g} s",
                **names, longest=record.duration / 2,
            )
        )  # fmt: skip
    value = scatter(means[whole])
    expected = None
    if model is not None:  # of successive means that are whole
        size, lag, D = 2 * whole.size, np.arange(1.0, whole.size), model_of(model).structure
        pairs = np.rint(np.fft.irfft(np.abs(np.fft.rfft(whole, size)) ** 2, size)[1 : whole.size])
        squares = 2 * D(np.full_like(lag, seconds)) + 2 * D(lag * seconds)
        squares = squares - D((lag + 1) * seconds) - D((lag - 1) * seconds)
        expected = math.sqrt(float(pairs @ squares / (blocks * (blocks - 1)) / seconds**2))
    return Stability(value, seconds, blocks, record.duration, record.signal.si[0.0], expected)


def means_of(record: Record, m: int) -> tuple[FloatArray, BoolArray]:
    """Means of m successive rates, without overlap, and which of them are complete."""
    rates = record.rate_values
    means = rates[: rates.size // m * m].reshape(-1, m).mean(axis=1)
    return means, np.isfinite(means)


def scatter(means: FloatArray) -> float:
    """Standard deviation of at least two means."""
    return float(np.std(means, ddof=1))


@public
def minimum(curve: Curve) -> Minimum:
    """The minimum of a curve as an upper limit of the bias instability.

    Only points with at least 10 degrees of freedom are used, if these are known: the lowest of scattered points is
    biased low. With N and K alone, and no flicker at all, the minimum is sqrt(2 N K / 1.732).

    Examples
    --------
    >>> from allanite import deviation
    >>> import numpy as np
    >>> record = Record(np.random.default_rng(1).standard_normal(5000), rate=1.0, unit="rad/s", kind="rate")
    >>> minimum(deviation(record)).inside
    False
    """
    known = curve.edf >= KNOWN if curve.law is not None else np.ones(curve.tau.size, dtype=bool)
    if not known.any():
        raise DataError(say("no point of the curve has {least:g} degrees of freedom; record longer", least=KNOWN))
    lowest = int(np.where(known, curve.deviation, np.inf).argmin())
    last = int(np.flatnonzero(known)[-1])
    value = float(curve.deviation[lowest])
    return Minimum(value / FLOOR, value, float(curve.tau[lowest]), lowest < last)
