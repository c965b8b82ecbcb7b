"""Fit: the coefficients found, each with its interval, and whether the model explains the data."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

from allanite.terms import TERMS

from .arrays import FloatArray
from .averaged import Averaged, averaged
from .curve import Curve
from .errors import UsageError
from .estimate import Estimate
from .finding import Finding
from .model import Model, Term, coefficient_factor
from .plain import Value
from .scope import APPROXIMATE, UNEXPLAINED, Scope, graded, worst
from .units import Signal

EXPLAINED = 0.01
"""A goodness-of-fit p value below this says that the model does not explain the record."""

REJECTED = "the model does not explain the record"
"""Reason why the coefficients of a model that does not are not valid."""


def chance(p: float) -> str:
    """A p value in words: ``p = 0.19``."""
    return f"p = {p:.2g}" if p > 1e-12 else "p < 1e-12"


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
    the record best, all terms together: a coefficient of it is not quite the estimate, which is averaged over several
    models, and a term of it may still be called absent, where others could take its place (then `notes` say so).
    `scope` says which frequencies were read and behind which filter.
    `findings` name what is slow and no noise: a warm-up, or a power law that is not flicker's. `checked` is the grade
    of what the model leaves of the record, where that was looked at.
    """

    _keys: ClassVar = {"estimates": "terms", "rivals": "alternatives", "nodes": "averaged"}

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
    nodes: Callable[[], Averaged] | None = None

    @property
    def averaged(self) -> Averaged:
        """The models that the record leaves open, with their weights; `model` alone where the method knows no other."""
        return self.nodes() if self.nodes else averaged([self.model], [1.0])

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
        """The model to be used: every coefficient as estimated, without terms that are not valid or not observable.

        None where the model does not explain the record.
        """
        if self.validity == UNEXPLAINED:
            return None
        wrong = {e.symbol for e in self if e.status in ("not valid", "not observable")}
        sizes = {e.symbol: e.value for e in self if e.value is not None}
        return Model(tuple(replace(t, value=sizes.get(t.symbol, t.value)) for t in self.model if t.symbol not in wrong))

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
        others = {"alternatives": [other.to_dict() for other in self.alternatives], "averaged": self.averaged.to_dict()}
        return super().to_dict(level) | others | extra

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> "Fit":
        """The fit that `to_dict` has written; its limits are known for the stored level only."""
        others = data.get("alternatives")
        nodes = data.get("averaged")
        kept = {
            "alternatives": {"values": others} if others else None,
            "averaged": {"values": nodes} if nodes else None,
        }
        return super().from_dict(data | kept)

    def _summary(self) -> str:
        return f"of {self.name!r} by {self.method}: {self.model}"
