"""Estimate: the estimate of one coefficient and its status; the models consistent with a record, with their weights."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np

from allanite.phrases.phrase import say
from allanite.terms import TERMS, Parameter

from .arrays import FloatArray
from .digits import Digits, digits, upper_limit
from .display_units import shown_unit
from .encoding import finite
from .errors import UsageError, given
from .limits import demand_level, demand_stored_size
from .model import Model, ModelLike, Term, coefficient_factor, model_of
from .names import demand_name
from .plain import Value
from .units import Signal


@dataclass(frozen=True, eq=False, repr=False)
class Averaged(Value):
    """Models that are consistent with a record, each with its weight."""

    terms: Model  # every term that occurs in at least one of the models
    # shape (k, t); power of each term in each model over its power in `terms`; 0 where the model lacks it
    scale: FloatArray
    weight: FloatArray  # shape (k,); weight of each model; the weights sum to 1

    @property
    def model(self) -> Model:
        """The model with the mean powers: what it predicts is the weighted mean of the predictions of the models."""
        return _scaled(self.terms, self.weight @ self.scale)

    def __iter__(self) -> Iterator[tuple[Model, float]]:
        for scale, weight in zip(self.scale, self.weight.tolist(), strict=True):
            yield _scaled(self.terms, scale), weight

    def __len__(self) -> int:
        return self.weight.size

    def _summary(self) -> str:
        return f"{len(self)} models of {', '.join(term.symbol for term in self.terms)}"


def _scaled(terms: Model, scale: FloatArray) -> Model:
    kept = zip(terms, scale.tolist(), strict=True)
    return Model(tuple(Term(t.symbol, t.value * s**0.5, t.signal, t.shape) for t, s in kept if s > 0))


def averaged(models: Sequence[ModelLike], weights: Sequence[float] | FloatArray) -> Averaged:
    """Models with their weights."""
    weight = np.asarray(weights, dtype=np.float64)
    if not models or weight.shape != (len(models),) or not (weight > 0).all():
        raise UsageError(f"{len(models)} models need as many positive weights, not {weights!r}")
    each = [model_of(model) for model in models]
    sizes: dict[Any, Term] = {}
    for term in (term for model in each for term in model):
        key = term.symbol, term.shape
        if key not in sizes or abs(term.value) > abs(sizes[key].value):
            sizes[key] = term
    scale = np.zeros((len(each), len(sizes)))
    where = {key: i for i, key in enumerate(sizes)}
    for row, model in zip(scale, each, strict=True):
        for term in model:
            key = term.symbol, term.shape
            row[where[key]] = (term.value / (sizes[key].value or 1.0)) ** 2
    return Averaged(Model(tuple(sizes.values())), scale, weight / weight.sum())


def noise_choice(value: ModelLike | Literal["auto"] | None) -> Averaged | Literal["auto"] | None:
    """The noise assumed for confidence intervals: models, "auto" for the noise of the record, None for no intervals."""
    # A model or a term is used as given; a fit represents all models that are consistent with its record.
    if value is None or (isinstance(value, str) and value == "auto"):
        return value
    if isinstance(value, str):
        raise UsageError("noise must be a Model, a Term such as N(0.01, 'deg/sqrt(h)'), a Fit, 'identified', 'auto' "
                         f"or None, not {given(value)}; allanite.Model(text) makes one of a text")  # fmt: skip
    models = value if isinstance(value, Averaged) else getattr(value, "averaged", None)
    return models if isinstance(models, Averaged) else averaged([value], [1.0])


WEAK = 0.25  # relative standard error above which an identified term is called weak


class Status(NamedTuple):
    """What is known of a coefficient."""

    name: str
    meaning: str
    # claimed, valued, usable: whether the term was detected; its value is a result of the method; its value or its
    # limit is one
    claimed: bool = False
    valued: bool = False
    usable: bool = True
    # mark, color: how its row is marked in a table (see `reporting.sheet.Mark`), and its color in a terminal
    mark: Literal["", "strong", "struck"] = ""
    color: str = ""


STATUSES: dict[str, Status] = {
    row.name: row
    for row in (
        Status(say("identified"), say("relative standard error at most 25 %"),
               claimed=True, valued=True, mark="strong", color="green"),
        Status(say("weak"), say("relative standard error above 25 %: an order of magnitude, not a specification"),
               claimed=True, valued=True, mark="strong", color="yellow"),
        Status(say("absent"), say("not identified; the limit is the one-sided 95 % upper limit"), color="dim"),
        Status(say("not observable"), say("cannot be determined from the part of the record that was used, for the "
                                          "reason given"), usable=False, color="dim"),
        Status(say("not valid"), say("the model does not explain the record, or its measured curve contradicts the "
                                     "value: not a result"), usable=False, mark="struck", color="red"),
        Status(say("reported"), say("by a method that gives no evidence for the term: it may be absent"),
               valued=True, color="cyan"),
        Status(say("negative"), say("the estimated square of the coefficient is negative: the method finds no such "
                                    "term"), usable=False),
    )
}  # fmt: skip
"""Every status of a coefficient, by its name."""

TERM: dict[str, Callable[[Any], None]] = {"symbol": partial(demand_name, "term", known=TERMS)}
"""The check of a stored symbol."""


@dataclass(frozen=True, eq=False, repr=False)
class Estimate(Value):
    """One coefficient, SI.

    Attributes
    ----------
    value : float or None
        The estimate; None if the term is absent.
    standard_error : float or None
        Standard error of `value`; None if the method gives none. With the likelihood, at least so large that the lower
        95 % limit is at most 1.96 standard errors below the value.
    status : {"identified", "weak", "absent", "not observable", "not valid", "reported", "negative"}
        "identified": detected, with a relative standard error of at most 25 %; "weak": detected, with a larger error;
        "absent": not detected, see `upper`; "not observable": cannot be determined from this record, see `reason`; "not
        valid": the model does not explain the record, or the measured curve contradicts the value, see `reason`;
        "reported": given by a method without a test; "negative": the method gives a negative square.
    upper : float or None
        One-sided 95 % upper limit of the size of the coefficient.
    limits : level -> (low, high)
        Interval as returned by `interval`; None if the method has none.
    profile : level -> (low, high)
        Two-sided interval, whether or not the term was detected; None if the method has none.
    median : float or None
        Median estimate of the size, given that the term is present. It is no evidence for the term. None if the method
        has none.
    shape : tuple of float
        Values of the `parameters` of the term's row: the time constant of GM, s.
    shape_limits : level -> (low, high) of each of them
    reason : str
        Why the term is not observable, or why the value is not valid.
    wanted : tuple of str
        Units in which it is shown, if not in those of data sheets; see `units.shown_unit`.
    """

    _checks: ClassVar = TERM | {"status": partial(demand_name, "status", known=STATUSES), **dict.fromkeys(
        ("value", "upper", "limits", "profile"), demand_stored_size)}  # fmt: skip

    symbol: str
    signal: Signal
    value: float | None
    standard_error: float | None
    status: str
    upper: float | None
    method: str
    limits: Callable[[float], tuple[float, float]] | None = None
    profile: Callable[[float], tuple[float, float]] | None = None
    median: float | None = None
    shape: tuple[float, ...] = ()
    shape_limits: Callable[[float], tuple[tuple[float, float], ...]] | None = None
    reason: str = ""
    wanted: tuple[str, ...] = ()

    def invalid(self, reason: str) -> "Estimate":
        """The same estimate with status "not valid": the value is kept, its interval is not."""
        return replace(self, status="not valid", reason=reason, standard_error=None, upper=None, limits=None,
                       profile=None, median=None, shape_limits=None)  # fmt: skip

    @property
    def unit(self) -> str:
        """SI unit."""
        return self.signal.si[TERMS[self.symbol].power]

    @property
    def sheet_unit(self) -> str:
        """Unit of data sheets, or the one that is wanted."""
        return shown_unit(self.signal, TERMS[self.symbol].power, self.wanted)

    @property
    def row(self) -> Status:
        """The row of `STATUSES`."""
        return STATUSES[self.status]

    @property
    def claimed(self) -> bool:
        """Whether the term was detected."""
        return self.row.claimed

    @property
    def valued(self) -> bool:
        """Whether `value` is a result of the method: that of a term that was detected, or reported without evidence."""
        return self.value is not None and math.isfinite(self.value) and self.row.valued

    def interval(self, level: float = 0.95) -> tuple[float, float]:
        """Confidence interval (low, high) in SI; from 0 to `upper` for an absent term."""
        demand_level(level)
        return (math.nan, math.nan) if self.limits is None else self.limits(level)

    @property
    def low(self) -> float:
        """Lower limit of the 95 % interval, SI."""
        return self.interval()[0]

    @property
    def high(self) -> float:
        """Upper limit of the 95 % interval, SI."""
        return self.interval()[1]

    def __float__(self) -> float:
        """The value, SI; NaN if there is none."""
        return math.nan if self.value is None else float(self.value)

    def to(self, unit: str) -> float:
        """The value in `unit`; NaN if there is none."""
        return float(self) / coefficient_factor(self.symbol, unit, self.signal)

    def shaped(self, level: float = 0.95) -> Iterator[tuple[Parameter, float, float, float]]:
        """Each parameter of the shape with its value and its limits, NaN where there are none."""
        limits = self.shape_limits(level) if self.shape_limits else ((math.nan, math.nan),) * len(self.shape)
        for parameter, value, (low, high) in zip(TERMS[self.symbol].parameters, self.shape, limits, strict=False):
            yield parameter, value, low, high

    def words(self, unit: str | None = None, level: float = 0.95) -> str:
        """The estimate as text: ``0.31 (0.30 .. 0.32) deg/sqrt(h)`` or ``not identified, below 2.1 deg/h``.

        >>> from .units import SIGNALS
        >>> Estimate("B", SIGNALS[0], None, None, "absent", 4.848e-6, "whittle").words("deg/h")
        'not identified, below 1.0 deg/h'
        """
        unit = unit or self.sheet_unit
        if self.status == "not observable":
            return say("not observable: {reason}", reason=self.reason)
        number, most = self.rounded(unit, level), self.rounded_limit(unit)
        if number is None:  # why there is no value, and its limit
            if self.status == "not valid":
                return say("not valid: {reason}", reason=self.reason)
            if most is None:
                return say("not identified")
            return say("not identified, below {limit} {unit}", limit=most.plain()[0], unit=unit)
        if self.status == "not valid":
            return say("not valid ({value} {unit}): {reason}", value=number.words(), unit=unit, reason=self.reason)
        return f"{number.words()} {unit}"

    def rounded(self, unit: str, level: float = 0.95, *, signed: bool = False) -> Digits | None:
        """The value in `unit`, rounded with its interval; None where there is no value."""
        if self.value is None:
            return None
        factor = coefficient_factor(self.symbol, unit, self.signal)
        return digits(self.value / factor, *(v / factor for v in self.interval(level)), signed=signed)

    def rounded_limit(self, unit: str) -> Digits | None:
        """The upper limit in `unit`, rounded up; None where there is none."""
        factor = coefficient_factor(self.symbol, unit, self.signal)
        return None if self.upper is None else upper_limit(self.upper / factor)

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data, SI; in the data-sheet form under "shown", `high` of an absent term is `upper`."""
        low, high = map(finite, self.interval(level))
        scale = 1 / coefficient_factor(self.symbol, self.sheet_unit, self.signal)
        limited = self.status == "absent" and self.upper is not None
        known = {"value": self.value, "low": 0.0 if limited else low, "high": self.upper if limited else high}
        shown = {key: None if v is None else finite(v * scale) for key, v in known.items()}
        extra = {"low": low, "high": high, "unit": self.unit, "level": level}
        shape = {p.name: {"value": finite(value), "low": finite(low), "high": finite(high), "unit": p.unit}
                 for p, value, low, high in self.shaped(level)}  # fmt: skip
        return super().to_dict(level) | extra | {"shown": {**shown, "unit": self.sheet_unit}} | shape

    def _summary(self) -> str:
        size = f" {self.to(self.sheet_unit):.4g} {self.sheet_unit}"
        size = "" if self.value is None else f"{size} = {self.value:.4g} {self.unit}"
        return f"{self.symbol}{size}, {self.status}"
