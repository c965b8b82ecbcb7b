"""Record length needed for a given accuracy, and what a statistic makes of each power law of noise."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any

import numpy as np

from allanite.core.aliases import public
from allanite.core.arrays import FloatArray, IntArray
from allanite.core.errors import UsageError
from allanite.core.model import Model, ModelLike, usable_model
from allanite.core.plain import Value
from allanite.core.ranges import PART, TIME
from allanite.core.record import SHORTEST
from allanite.core.units import SIGNALS
from allanite.statistics.confidence.limits import mixtures, models_of
from allanite.statistics.grids import checked, factors_of, times
from allanite.statistics.moments.moments import expected_at
from allanite.statistics.table import CurvePoints, statistic_named
from allanite.terms import TERMS

from .bound import Bound, bound

DURATIONS = (600.0, 3600.0, 21_600.0, 86_400.0)  # 10 minutes, 1 hour, 6 hours, 24 hours
LONGEST = 1e14  # samples beyond which no length is given


@dataclass(frozen=True, eq=False, repr=False)
class RecordingPlan(Value):
    """Accuracy of a model's coefficients against the length of the record.

    Attributes
    ----------
    model, rate : Model, float
        The expected noise, and the sampling rate, Hz.
    ramp : bool
        Whether a ramp of unknown size is assumed.
    names : tuple of str
        The parameters, as in `Bound`.
    durations : tuple of float
        Lengths, s.
    errors : array, shape (parameters, durations)
        Smallest possible relative standard errors; NaN if the record would have fewer than 200 samples.
    accuracy : float
        The relative standard error to reach.
    needed : array, shape (parameters,)
        Record length needed for it, s; infinite if no practical length is sufficient.
    searched, searched_needed : arrays, shapes as for `errors` and `needed`
        The same if it is unknown which of the five terms are present, as for `identify`.
    absent, limits : tuple of str, array of shape (absent terms, durations)
        The terms that the model lacks, and their expected 95 % upper limits, SI; NaN as for `errors`.
    """

    _alike = ("names errors needed searched searched_needed", "absent limits")

    model: Model
    rate: float
    ramp: bool
    names: tuple[str, ...]
    durations: tuple[float, ...]
    errors: FloatArray
    accuracy: float
    needed: FloatArray
    searched: FloatArray
    searched_needed: FloatArray
    absent: tuple[str, ...]
    limits: FloatArray

    def rows(self) -> tuple[list[str], list[list[Any]]]:
        """Headings and rows, with the terms known and then not; errors in percent, lengths in s."""
        headings = ["parameter", "terms", *(f"{d:g} s, %" for d in self.durations), f"s for {100 * self.accuracy:g} %"]
        kinds = (("known", self.errors, self.needed), ("searched", self.searched, self.searched_needed))
        rows = [[name, kind, *row, least] for kind, errors, needed in kinds
                for name, row, least in zip(self.names, (100 * errors).tolist(), needed.tolist(),
                                            strict=True)]  # fmt: skip
        return headings, rows

    def _summary(self) -> str:
        needed = (f"{name} {least:.3g} s" for name, least in zip(self.names, self.needed, strict=True))
        return f"at {self.rate:g} Hz for {100 * self.accuracy:g} %: {', '.join(needed)}"


@public
def plan(
    model: ModelLike, rate: float, *, durations: Annotated[Sequence[float], TIME] = DURATIONS,
    accuracy: Annotated[float, PART] = 0.1, ramp: bool | None = None,
) -> RecordingPlan:  # fmt: skip
    """Predict the accuracy of each coefficient against record length, and the length needed for a given accuracy.

    From the Cramer-Rao bound (see `bound`), with the terms known and with all five looked for, which the default method
    of `identify` reaches if the bound is below about 12 %; nothing is simulated.

    Parameters
    ----------
    model : Model, Term or Fit
        The expected noise: from a data sheet, from `sensor`, or ``identify(record)`` of a first record.
    rate : float
        Sampling rate, Hz.
    durations : sequence of float
        Lengths, s.
    accuracy : float
        Relative standard error of a coefficient to reach.
    ramp : bool, optional
        Whether to assume a ramp of unknown size; by default, if the model has one.

    Returns
    -------
    RecordingPlan

    Raises
    ------
    UsageError
        The model has no noise, a length, the rate or the accuracy is not positive, or the accuracy is above 1.

    Examples
    --------
    >>> from allanite import sensor
    >>> found = plan(sensor("mems"), 100.0, accuracy=0.1)
    >>> [f"{100 * error:.2g}" for error in found.errors[1]]
    ['17', '7', '2.9', '1.4']
    >>> [round(float(hours), 1) for hours in found.needed / 3600]
    [0.0, 0.5, 3.4]
    """
    model = usable_model(model)
    unknown = model.drifts if ramp is None else ramp

    names = bound(model, SHORTEST, rate, ramp=unknown).names
    nothing = np.full(len(names), math.nan)

    def planned(terms: str) -> tuple[FloatArray, FloatArray]:
        """Errors at the lengths, and the lengths that are needed."""

        @cache
        def error(n: int) -> FloatArray:
            return bound(model, n, rate, ramp=unknown if terms == "known" else None, terms=terms).errors[: len(names)]

        table = [error(round(d * rate)) if d * rate >= SHORTEST else nothing for d in durations]
        columns = np.array(table).reshape(len(durations), len(names)).T
        return columns, np.array([_least(error, i, accuracy) for i in range(len(names))]) / rate

    (errors, needed), (searched, least) = planned("known"), planned("auto")
    sizes = [round(d * rate) for d in durations]
    expected = [bound(model, n, rate, terms="auto").limits if n >= SHORTEST else {} for n in sizes]
    absent = tuple(next(filter(None, expected), {}))
    limits = np.array([[of.get(symbol, math.nan) for of in expected] for symbol in absent])
    return RecordingPlan(model, rate, unknown, names, tuple(durations), errors, accuracy, needed, searched, least,
                         absent, limits)  # fmt: skip


def further(model: ModelLike, size: int, rate: float, accuracy: float) -> dict[str, float]:
    """Time beyond a record until each parameter has the accuracy, s, where all terms are looked for; 0 if it has it."""
    model = usable_model(model)

    @cache
    def known(n: int) -> Bound:
        return bound(model, n, rate, terms="auto")

    names = enumerate(known(size).names)
    return {name: (_least(lambda n: known(n).errors, i, accuracy, size) - size) / rate for i, name in names}


def _least(errors: Callable[[int], FloatArray], which: int, wanted: float, least: int = SHORTEST) -> float:
    """Least number of samples at which an error is `wanted`, to 0.1 %: it falls about as a power of the length."""

    def excess(n: float) -> float:
        return math.log(float(errors(round(n))[which]) / wanted)

    low = high = float(least)
    while excess(high) > 0:
        low, high = high, 4 * high
        if high > LONGEST:
            return math.inf
    while round(high) - round(low) > 1 and excess(high) < -5e-4:
        a, b = excess(low), excess(high)
        # aimed a little beyond, or the lower end alone would creep towards the answer
        share = min(max((a + 2.5e-4) / (a - b), 0.02), 0.98) if math.isfinite(a) else 0.5
        middle = low * (high / low) ** share
        low, high = (middle, high) if excess(middle) > 0 else (low, middle)
    return high


SIZE = 7200  # samples of the record where no length is given: two hours at 1 Hz


@dataclass(frozen=True, eq=False, repr=False)
class Properties(Value):
    """Expectation and scatter of a statistic for single noise terms.

    >>> found = properties("theo1", m=[100, 1000])
    >>> [f"{x:.3f}" for x in found.ratio[:, found.symbols.index("B")]]
    ['1.837', '1.857']
    """

    statistic: str
    size: int  # samples of the record
    m: IntArray  # shape (k,); averaging factors
    tau: FloatArray  # shape (k,); averaging times in sampling intervals
    symbols: tuple[str, ...]  # terms: the power laws that the statistic does not remove
    # shape (k, s); expected Allan variance over the expected variance of the statistic at the same tau; for a
    # statistic of third differences, expected Hadamard variance
    ratio: FloatArray
    edf: FloatArray  # shape (k, s); equivalent degrees of freedom, 2 E^2 / Var

    def rows(self) -> tuple[list[str], list[list[Any]]]:
        """Headings and rows: one of each averaging factor."""
        headings = ["m", "tau", *(f"ratio {s}" for s in self.symbols), *(f"edf {s}" for s in self.symbols)]
        together = zip(self.m.tolist(), self.tau.tolist(), self.ratio.tolist(), self.edf.tolist(), strict=True)
        return headings, [[m, tau, *ratio, *edf] for m, tau, ratio, edf in together]

    def _summary(self) -> str:
        return f"{self.statistic} of {self.size} samples at {self.m.size} averaging factors"


def properties(
    statistic: str, size: int = SIZE, *, taus: str | Sequence[float] | None = None, m: Sequence[int] | None = None
) -> Properties:
    """Bias against the Allan (or Hadamard) variance, and degrees of freedom, of a statistic."""
    row = statistic_named(statistic)
    if row.extreme or row.power:
        raise UsageError(f"{row.name} is not an estimate of the Allan or Hadamard variance; explain another statistic")
    # the points asked for, or octaves
    wanted = m if m is not None and taus is None else factors_of("octave" if taus is None else taus, row, size, 1.0)
    factors = checked(wanted, row, size)
    points = CurvePoints(row, factors, [(size, 1)], size, 1.0)
    symbols = tuple(symbol for symbol, term in TERMS.items() if term.alpha is not None)
    models = models_of(symbols, SIGNALS[0])
    tau = times(row, points.m, size)
    ratio = []
    for model in models:
        # Allan or Hadamard variance of one term at any averaging times, by differences of the angle's structure
        # function: -sum_k (-1)^k C(2d, d + k) D(k tau) / (d! tau^2) for k = 1 .. d, the order of the differences
        (term,) = model
        D, d = term.sampled(1.0).structure, row.order
        total = -sum((-1) ** k * math.comb(2 * d, d + k) * D(k * tau) for k in range(1, d + 1))
        target = term.power(1.0) * total / (math.factorial(d) * tau**2)
        ratio.append(target / expected_at(row, model, factors, size, 1.0))
    degrees = [mixtures(points, [model])[0] for model in models]
    return Properties(row.name, size, points.m, tau, symbols, np.stack(ratio, axis=1), np.stack(degrees, axis=1))
