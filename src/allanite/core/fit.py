"""Fit: the coefficients found, each with its interval, and whether the model explains the data."""

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

from allanite.terms import TERMS

from .arrays import FloatArray
from .curve import Curve
from .encoding import finite
from .errors import UsageError
from .finding import Finding
from .limits import demand_level
from .model import Model, Term, coefficient_factor
from .plain import Value
from .scope import APPROXIMATE, UNEXPLAINED, Scope, graded, worst
from .units import Signal

WEAK = 0.25
"""Relative standard error above which a term that was found is called weak."""

EXPLAINED = 0.01
"""A goodness-of-fit p value below this says that the model does not explain the record."""

REJECTED = "the model does not explain the record"
"""Reason why the coefficients of a model that does not are not valid."""


def chance(p: float) -> str:
    """A p value in words: ``p = 0.19``."""
    return f"p = {p:.2g}" if p > 1e-12 else "p < 1e-12"


@dataclass(frozen=True, eq=False, repr=False)
class Estimate(Value):
    """One coefficient, SI.

    Attributes
    ----------
    value : float or None
        The estimate; None where the term was not found.
    standard_error : float or None
        Of `value`; None where the method gives none.
    status : {"identified", "weak", "absent", "not observable", "not valid", "reported", "negative"}
        "identified": found, relative standard error at most 25 %; "weak": found, above; "absent": not found, see
        `upper`; "not observable": this record cannot tell, see `reason`; "not valid": the model does not explain the
        record, or the measured curve contradicts the value, see `reason`; "reported": by a method that gives no
        evidence; "negative": the method gives a negative square.
    upper : float or None
        One-sided 95 % upper limit of the size of the coefficient.
    limits : level -> (low, high)
        Interval as `interval` gives it; None where the method has none.
    profile : level -> (low, high)
        Two-sided limits, whether the term was found or not; None where the method has none.
    shape : tuple of float
        Values of the `parameters` of the term's row: the time constant of GM, s.
    shape_limits : level -> (low, high) of each of them
    reason : str
        Why nothing is known, or why the value is not valid.
    """

    symbol: str
    signal: Signal
    value: float | None
    standard_error: float | None
    status: str
    upper: float | None
    method: str
    limits: Callable[[float], tuple[float, float]] | None = None
    profile: Callable[[float], tuple[float, float]] | None = None
    shape: tuple[float, ...] = ()
    shape_limits: Callable[[float], tuple[tuple[float, float], ...]] | None = None
    reason: str = ""

    def invalid(self, reason: str) -> "Estimate":
        """The same, not valid: the value stays to be looked at, its limits do not."""
        return replace(
            self, status="not valid", reason=reason, standard_error=None, upper=None, limits=None, profile=None,
            shape_limits=None,
        )  # fmt: skip

    @property
    def unit(self) -> str:
        """SI unit."""
        return self.signal.si[TERMS[self.symbol].power]

    @property
    def sheet_unit(self) -> str:
        """Unit of data sheets."""
        return self.signal.sheet[TERMS[self.symbol].power]

    @property
    def claimed(self) -> bool:
        """Whether the term is said to be there."""
        return self.status in ("identified", "weak")

    def interval(self, level: float = 0.95) -> tuple[float, float]:
        """Confidence limits (low, high) in SI; from 0 to `upper` for an absent term."""
        demand_level(level)
        return (math.nan, math.nan) if self.limits is None else self.limits(level)

    def to(self, unit: str) -> float:
        """The value in `unit`; NaN where there is none."""
        return math.nan if self.value is None else self.value / coefficient_factor(self.symbol, unit, self.signal)

    def words(self, unit: str | None = None, level: float = 0.95) -> str:
        """What is known, in words: ``0.31 (0.30 .. 0.32) deg/sqrt(h)`` or ``not identified, below 2.1 deg/h``.

        Examples
        --------
        >>> from .units import SIGNALS
        >>> Estimate("B", SIGNALS[0], None, None, "absent", 4.848e-6, "whittle").words("deg/h")
        'not identified, below 1 deg/h'
        """
        unit = unit or self.sheet_unit
        scale = 1 / coefficient_factor(self.symbol, unit, self.signal)
        if self.status == "not observable":
            return f"not observable: {self.reason}"
        if self.status == "not valid":
            shown = "" if self.value is None else f" ({self.value * scale:.4g} {unit})"
            return f"not valid{shown}: {self.reason}"
        if self.value is None:
            return "not identified" if self.upper is None else f"not identified, below {self.upper * scale:.3g} {unit}"
        low, high = self.interval(level)
        around = f" ({low * scale:.4g} .. {high * scale:.4g})" if math.isfinite(low) and math.isfinite(high) else ""
        return f"{self.value * scale:.4g}{around} {unit}"

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data, SI, with the data-sheet form under "shown"."""
        low, high = map(finite, self.interval(level))
        scale = 1 / coefficient_factor(self.symbol, self.sheet_unit, self.signal)
        known = {"value": self.value, "low": low, "high": high}
        shown = {key: None if v is None else finite(v * scale) for key, v in known.items()}
        extra = {"low": low, "high": high, "unit": self.unit, "level": level}
        return super().to_dict(level) | extra | {"shown": {**shown, "unit": self.sheet_unit}} | self._shape_dict(level)

    def _summary(self) -> str:
        size = "" if self.value is None else f" {self.to(self.sheet_unit):.4g} {self.sheet_unit}"
        return f"{self.symbol}{size}, {self.status}"

    def _shape_dict(self, level: float) -> dict[str, Any]:
        limits = self.shape_limits(level) if self.shape_limits else ((math.nan, math.nan),) * len(self.shape)
        return {
            p.name: {"value": finite(value), "low": finite(low), "high": finite(high), "unit": p.unit}
            for p, value, (low, high) in zip(TERMS[self.symbol].parameters, self.shape, limits, strict=False)
        }


@dataclass(frozen=True, eq=False, repr=False)
class Goodness(Value):
    """Does the model explain the data? By cells of frequency.

    `frequency` (Hz, shape (cells + 1,)) bounds the cells, `ratio` is observed over expected power in each, `z` the same
    as a standard normal deviate; `p` is the probability of worse by chance; `reasons` say in words what is wrong, and
    `remarks` what is not noise but could be dealt with.
    """

    frequency: FloatArray
    ratio: FloatArray
    z: FloatArray
    p: float
    reasons: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()

    @property
    def explained(self) -> bool:
        """Whether the model can be believed."""
        return self.p >= EXPLAINED and not self.reasons

    @property
    def grade(self) -> str:
        """One of `GRADES`; a narrow peak that the test does not feel does no harm to the coefficients."""
        return "explained" if self.explained else UNEXPLAINED if self.p < EXPLAINED else APPROXIMATE

    @property
    def verdict(self) -> str:
        """One sentence."""
        return "; ".join((f"{graded(self.grade)} (goodness of fit {chance(self.p)})", *self.reasons, *self.remarks))


@dataclass(frozen=True, repr=False)
class Line(Value):
    """A sinusoid that was found in a record and taken out before its noise was identified.

    Attributes
    ----------
    frequency, amplitude, standard_error, phase : float
        Hz; SI, of the rate itself and not of its mean over a sample interval; the amplitude's; rad at the start.
    signal : Signal
    """

    _also = ("unit",)

    frequency: float
    amplitude: float
    standard_error: float
    phase: float
    signal: Signal

    @property
    def term(self) -> Term:
        """As a term of a model."""
        return Term("Sine", self.amplitude, self.signal, (self.frequency, self.phase))

    def words(self) -> str:
        """Frequency and amplitude: ``12 Hz (amplitude 0.31 ± 0.02 deg/h)``."""
        unit = self.signal.sheet[0]
        size = coefficient_factor("Sine", unit, self.signal)
        return (
            f"{self.frequency:.6g} Hz (amplitude {self.amplitude / size:.3g} ± {self.standard_error / size:.2g} {unit})"
        )

    @property
    def unit(self) -> str:
        """SI unit of the amplitude."""
        return self.signal.si[0]

    def _summary(self) -> str:
        return self.words()


@dataclass(frozen=True, repr=False)
class Alternative(Value):
    """Another model of the same record: `aic` is its Akaike criterion less that of the fit's own model."""

    model: Model
    aic: float

    def _summary(self) -> str:
        return f"AIC {self.aic:+.1f}: {self.model}"


@dataclass(frozen=True, eq=False, repr=False)
class Fit(Value):
    """Coefficients of a record or curve.

    `lines` are sinusoids that were taken out first; they stand in the model. `alternatives` are other families of terms
    for the wandering of the bias (flicker, Gauss-Markov, both, two of these), the best first; worked out when asked.
    ``fit["N"]`` is the `Estimate` of a term; every term asked for is there, absent ones too. `model` is what describes
    the record best: a term of it may still be called absent, where others could take its place (then `notes` say so).
    `scope` says which frequencies were read and behind which filter.
    `findings` name what is slow and no noise: a warm-up, or a power law that is not flicker's. `checked` is the grade
    of what the model leaves of the record, where that was looked at.
    """

    _keys: ClassVar = {"estimates": "terms", "rivals": "alternatives"}

    estimates: tuple[Estimate, ...]
    method: str
    signal: Signal
    model: Model
    name: str = ""
    goodness: Goodness | None = None
    correlation: FloatArray | None = None
    curve: Curve | None = None
    notes: tuple[str, ...] = field(default=())
    lines: tuple[Line, ...] = ()
    rivals: Callable[[], tuple[Alternative, ...]] | None = None
    scope: Scope | None = None
    findings: tuple[Finding, ...] = ()
    checked: str = ""

    @property
    def validity(self) -> str:
        """Grade of the model, one of `GRADES`; empty where the method does not test it."""
        if self.goodness is None:
            return ""
        slow = (UNEXPLAINED if finding.fatal else APPROXIMATE for finding in self.findings)
        wrong = [e.status == "not valid" for e in self]
        coefficients = UNEXPLAINED if wrong and all(wrong) else APPROXIMATE if any(wrong) else ""
        return worst(self.scope.grade if self.scope else "", self.goodness.grade, coefficients, self.checked, *slow)

    @property
    def valid(self) -> Model | None:
        """The model without terms that are not valid or not observable; None where it does not explain the record."""
        if self.validity == UNEXPLAINED:
            return None
        wrong = {e.symbol for e in self if e.status in ("not valid", "not observable")}
        return Model(tuple(t for t in self.model if t.symbol not in wrong)) if wrong else self.model

    @property
    def advice(self) -> tuple[str, ...]:
        """The notes that still count: none of a model that explains nothing."""
        return self.notes if self.validity != UNEXPLAINED else ()

    def invalid(self, reason: str, symbols: Iterable[str] | None = None) -> "Fit":
        """The fit whose coefficients, all or those of the symbols, are not valid."""
        wrong = tuple(e.symbol for e in self) if symbols is None else tuple(symbols)
        return replace(self, estimates=tuple(e.invalid(reason) if e.symbol in wrong else e for e in self))

    @property
    def alternatives(self) -> tuple[Alternative, ...]:
        """Other models of the record; empty where the method knows none."""
        return self.rivals() if self.rivals else ()

    def __getitem__(self, symbol: str) -> Estimate:
        for estimate in self.estimates:
            if estimate.symbol == symbol:
                return estimate
        raise UsageError(f"{symbol!r} was not asked for; there are {', '.join(e.symbol for e in self.estimates)}")

    def __iter__(self) -> Iterator[Estimate]:
        return iter(self.estimates)

    def rows(self, level: float = 0.95) -> tuple[list[str], list[list[Any]]]:
        """Headings and rows, data sheet and SI side by side."""
        headings = ["term", "", "value", "low", "high", "unit", "SI value", "SI unit", "status"]
        rows = []
        for e in self.estimates:
            si = e.value if e.value is not None else e.upper
            rows.append([e.symbol, TERMS[e.symbol].title, *e.to_dict(level)["shown"].values(), si, e.unit, e.status])
        return headings, rows

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data."""
        good = self.goodness
        p, reasons, remarks = (good.p, good.reasons, good.remarks) if good else (None, (), ())
        extra = {
            "validity": self.validity or None,
            "gof_p": p,
            "gof_reasons": list(reasons),
            "gof_remarks": list(remarks),
        }
        return super().to_dict(level) | {"alternatives": [other.to_dict() for other in self.alternatives]} | extra

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> "Fit":
        """The fit that `to_dict` has written; its limits are known for the stored level only."""
        others = data.get("alternatives")
        return super().from_dict(data | {"alternatives": {"values": others} if others else None})

    def _summary(self) -> str:
        return f"of {self.name!r} by {self.method}: {self.model}"
