"""Expected curves of a model on their own: what its deviations look like before anything is recorded."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from allanite.core.aliases import public
from allanite.core.arrays import FloatArray
from allanite.core.curve import Curve
from allanite.core.errors import UsageError
from allanite.core.model import Model, ModelLike, Term, model_of
from allanite.core.plain import Value
from allanite.core.ranges import RATE, SAMPLES, TIME
from allanite.phrases.phrase import spelled
from allanite.statistics.grids import factors_of, times
from allanite.statistics.moments.moments import expected
from allanite.statistics.row import Statistic
from allanite.statistics.table import statistic_named

DEFAULT_TIMES = (1e-2, 1e4)  # averaging times of a single term, s
MARGIN = 30.0  # ratio of the first and last averaging time to the times at which one term takes over from another
TIMES_PER_DECADE = 20  # averaging times a decade if there is no sampling rate


@dataclass(frozen=True, eq=False, repr=False)
class Expectation(Value):
    """Expected curves of a model without data, one for each statistic.

    Attributes
    ----------
    model : Model
    curves : tuple of Curve
        Without intervals, and with counts of 0; m is 0 where there is no sampling rate.
    name : str
        Name of the sensor.
    """

    model: Model
    curves: tuple[Curve, ...]
    name: str = ""

    def terms(self, curve: Curve) -> list[FloatArray]:
        """Deviation of each term of the model alone, in the curve's unit."""
        return [np.sqrt(_variance(term, curve.statistic, curve.tau, curve.rate, curve.size)) for term in self.model]


@dataclass(frozen=True, eq=False, repr=False)
class Expectations(Value):
    """Expected curves of several models, to be shown together."""

    each: tuple[Expectation, ...]

    @property
    def apart(self) -> list[tuple[str, Expectation]]:
        """Each with its name, or the text of its model."""
        return [(expected.name or str(expected.model), expected) for expected in self.each]


@public
def expectation(
    model: ModelLike,
    statistics: Sequence[str] = ("oadev",),
    *,
    tau: str | Sequence[float] = "log",
    rate: float | None = None,
    size: int | None = None,
    name: str = "",
) -> Expectation:
    """The exact expectation of statistics under a model, as curves.

    Parameters
    ----------
    model : Model, Term or Fit
    statistics : sequence of str
        Names in `STATISTICS`.
    tau : {"log", "octave", "decade", "all"} or sequence of float
        Averaging times: a named grid, or seconds.
    rate : float, optional
        Sampling rate, Hz; the differences adev, oadev, hdev, ohdev, haar do not need it.
    size : int, optional
        Samples of the record. Without it, or without a rate, the times extend to where one term alone is left.
    name : str, optional
        Name of the sensor.

    Returns
    -------
    Expectation

    Raises
    ------
    UsageError
        The rate or the length is required, a time does not match them, or the statistic has no expectation.

    Examples
    --------
    >>> from allanite import K, N
    >>> found = expectation(N(1.0, "rad/sqrt(s)") + K(1.0, "rad/s^1.5"), tau=[1.0, 3.0])
    >>> found.curves[0].variance.round(9).tolist()
    [1.333333333, 1.333333333]
    """
    model = model_of(model)
    RATE.demand(rate)
    rows = [statistic_named(statistic) for statistic in statistics]
    return Expectation(model, tuple(_curve(model, row, tau, rate, size) for row in rows), name)


def _curve(model: Model, row: Statistic, tau: str | Sequence[float], rate: float | None, size: int | None) -> Curve:
    m = np.zeros(0, np.int64)
    if rate is None and isinstance(tau, str):
        if tau != "log":
            raise UsageError(f"the averaging times {tau!r} are multiples of a sample interval: pass " + spelled(
                                 "--rate HZ", "rate=...",
                             ) + ", or the times in seconds")  # fmt: skip
        low, high = (TIMES_PER_DECADE * math.log10(end) for end in reach(model))
        at = np.asarray(10 ** (np.arange(math.floor(low), math.ceil(high) + 1) / TIMES_PER_DECADE))
    elif rate is None:
        at = TIME.demand(np.atleast_1d(np.asarray(tau, dtype=np.float64)), "averaging times")
    else:
        length = size or max(8, math.ceil(min(4 * reach(model)[1] * rate, SAMPLES.high)))
        m = factors_of(tau, row, length, rate)
        at = times(row, m, length) / rate
    if not at.size:
        raise UsageError(f"a record of {size} samples is too short for {row.name}")
    return Curve(
        row.name, m if m.size else np.zeros(at.size, np.int64), at,
        _variance(model, row.name, at, rate or 0.0, size or 0), np.zeros(at.size, np.int64), np.ones(at.size),
        model.signal.si[row.power], rate or 0.0, size or 0,
    )  # fmt: skip


def _variance(model: Model | Term, statistic: str, tau: FloatArray, rate: float, size: int) -> FloatArray:
    return np.maximum(expected(model, statistic, tau, rate=rate or None, size=size or None), 0.0)


def reach(model: Model) -> tuple[float, float]:
    """Averaging times from where one term alone matters to where another alone does, s."""
    tau = np.geomspace(1e-9, 1e9, 361)
    # Allan variance by the structure function, without a sampling rate
    rows = [term.sampled(1.0) for term in model]
    each = np.array([
        np.asarray(term.value**2 * (4 * row.structure(tau) - row.structure(2 * tau)) / (2 * tau**2))
        for term, row in zip(model, rows, strict=True)
    ])  # fmt: skip
    changes = tau[1:][np.diff(each.argmax(axis=0)) != 0]
    # times that a term has of its own: a time constant, a period
    own = [
        value if parameter.unit == "s" else 1 / value
        for term in model
        for parameter, value in zip(term.row.parameters, term.shape, strict=True)
        if parameter.unit in ("s", "Hz") and value > 0
    ]
    marks = np.array([*changes, *own])
    return (float(marks.min()) / MARGIN, float(marks.max()) * MARGIN) if marks.size else DEFAULT_TIMES
