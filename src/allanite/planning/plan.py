"""Record length needed for a given accuracy of each coefficient."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from allanite.core.aliases import public
from allanite.core.arrays import FloatArray
from allanite.core.encoding import finite, plain
from allanite.core.errors import UsageError, given
from allanite.core.model import Model, ModelLike, usable_model
from allanite.core.plain import Value
from allanite.core.record import SHORTEST

from .bound import bound

DURATIONS = (600.0, 3600.0, 21_600.0, 86_400.0)
"""10 minutes, 1 hour, 6 hours, 24 hours."""

LONGEST = 1e14
"""Samples beyond which no length is given."""


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
    """

    _alike = ("names errors needed searched searched_needed",)

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

    def rows(self) -> tuple[list[str], list[list[Any]]]:
        """Headings and rows, with the terms known and then not; errors in percent, lengths in s."""
        headings = ["parameter", "terms", *(f"{d:g} s, %" for d in self.durations), f"s for {100 * self.accuracy:g} %"]
        kinds = (("known", self.errors, self.needed), ("searched", self.searched, self.searched_needed))
        rows = [
            [name, kind, *row, least]
            for kind, errors, needed in kinds
            for name, row, least in zip(self.names, (100 * errors).tolist(), needed.tolist(), strict=True)
        ]
        return headings, rows

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data; a plan has no limits, so that `level` changes nothing."""
        errors, needed = plain(self.errors), map(finite, self.needed.tolist())
        rows = zip(self.names, errors, needed, strict=True)
        parameters = [{"name": name, "errors": row, "needed": least} for name, row, least in rows]
        return super().to_dict(level) | {"parameters": parameters}

    def _summary(self) -> str:
        needed = (f"{name} {least:.3g} s" for name, least in zip(self.names, self.needed, strict=True))
        return f"at {self.rate:g} Hz for {100 * self.accuracy:g} %: {', '.join(needed)}"


@public
def plan(
    model: ModelLike,
    rate: float,
    *,
    durations: Sequence[float] = DURATIONS,
    accuracy: float = 0.1,
    ramp: bool | None = None,
) -> RecordingPlan:
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
    if accuracy > 1:
        raise UsageError(f"the accuracy is a share between 0 and 1, not {accuracy:g}; did you mean {accuracy / 100:g}?")
    if not (math.isfinite(rate) and rate > 0) or not accuracy > 0 or not all(d > 0 for d in durations):
        raise UsageError(
            f"the sampling rate, the accuracy and all lengths must be above 0, not {given(rate)} Hz, "
            f"{given(accuracy)}, ({', '.join(map(given, durations))})"
        )
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
    return RecordingPlan(model, rate, unknown, names, tuple(durations), errors, accuracy, needed, searched, least)


def _least(errors: Callable[[int], FloatArray], which: int, wanted: float) -> float:
    """Least number of samples at which an error is `wanted`, to 0.1 %: it falls about as a power of the length."""

    def excess(n: float) -> float:
        return math.log(float(errors(round(n))[which]) / wanted)

    low = high = float(SHORTEST)
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
