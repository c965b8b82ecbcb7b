"""Fit: the estimated coefficients with their intervals, and whether the model explains the data."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

from allanite.phrases.phrase import Phrase, join, say
from allanite.terms import TERMS

from .arrays import FloatArray
from .curve import Curve
from .errors import UsageError
from .estimate import Averaged, Estimate, averaged
from .kinds import title_of
from .model import Model, Term, coefficient_factor
from .names import demand_name
from .plain import Value
from .units import Signal
from .validity import APPROXIMATE, GRADES, UNEXPLAINED, Finding, Scope, graded, worst

SURE = 0.73
"""Weight of the models that hold a component from which it is claimed: odds of e (`search.components.CLAIMED`)."""


@dataclass(frozen=True, repr=False)
class Component(Value):
    """A part of the model of a record beside its terms."""

    # a fixed keyword for programs: "filter", "resonance", "step", "warm-up", "wave", "exponent", "noise" for
    # Gauss-Markov noise, "floor" for white noise behind a filter, "factor" for power that nothing describes
    name: str
    weight: float  # of the models that hold it, of all that are consistent with the record
    words: str = ""  # what it is, with numbers
    # low, high: frequencies, Hz, between which it changes the spectrum; equal where it does so nowhere in particular
    low: float = 0.0
    high: float = 0.0

    @property
    def claimed(self) -> bool:
        """Whether the models that hold it outweigh the others."""
        return self.weight >= SURE

    @property
    def loop(self) -> bool:
        """Whether it is a claimed resonance as broad as that of a control loop: more than a tenth of its frequency."""
        return self.name == "resonance" and self.claimed and self.high - self.low > 0.1 * self.high

    def _summary(self) -> str:
        return f"{self.words or self.name}, weight {self.weight:.2f}"


MIN_P = 0.01  # p-value of the goodness of fit below which the model does not explain the record

REJECTED = say("the model does not explain the record")
"""Reason why the coefficients are not valid if the model does not explain the record."""


def chance(p: float) -> str:
    """A p-value as text: ``p = 0.19``."""
    return f"p = {p:.2g}" if p > 1e-12 else "p < 1e-12"


def tested(grade: str, scope: Scope | None, good: "Goodness | None") -> Phrase:
    """A grade with the p-value of its test: ``explained (goodness of fit p = 0.29)``."""
    if good is None:
        return graded(grade, scope)
    return say("{grade} (goodness of fit {p})", grade=graded(grade, scope), p=chance(good.p))


@dataclass(frozen=True, eq=False, repr=False)
class Goodness(Value):
    """Goodness of fit, by cells of frequency."""

    # `frequency` (Hz, shape (cells + 1,)) holds the edges of the cells, `ratio` the observed over the expected power in
    # each, `z` the same as a standard normal deviate; `p` is the p-value. `reasons` describe the misfit; `remarks`
    # describe deviations from noise that do not affect the coefficients.
    _alike = ("cells ratio z",)

    frequency: FloatArray
    ratio: FloatArray
    z: FloatArray
    p: float
    reasons: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()

    @property
    def cells(self) -> FloatArray:
        """Lower edges of the cells, Hz."""
        return self.frequency[:-1]

    @property
    def explained(self) -> bool:
        """Whether the model explains the data."""
        return self.p >= MIN_P and not self.reasons

    @property
    def grade(self) -> str:
        """One of `GRADES`; a narrow peak that the test does not detect does not affect the coefficients."""
        return "explained" if self.explained else UNEXPLAINED if self.p < MIN_P else APPROXIMATE

    @property
    def verdict(self) -> str:
        """A sentence that states the grade."""
        return join("; ", (tested(self.grade, None, self), *self.reasons, *self.remarks))


@dataclass(frozen=True, repr=False)
class Line(Value):
    """A sinusoid that was detected in a record and removed before its noise was identified."""

    _also = ("unit",)

    # frequency, amplitude, standard_error, phase: frequency, Hz; amplitude, SI, of the rate itself, not of its mean
    # over a sample interval; standard error of the amplitude; phase at the start of the record, rad
    frequency: float
    amplitude: float
    standard_error: float
    phase: float
    signal: Signal

    @property
    def term(self) -> Term:
        """The sinusoid as a term of a model."""
        return Term("Sine", self.amplitude, self.signal, (self.frequency, self.phase))

    def words(self) -> str:
        """Frequency and amplitude: ``12 Hz (amplitude 0.31 ± 0.02 deg/h)``."""
        unit = self.signal.sheet[0]
        size = coefficient_factor("Sine", unit, self.signal)
        return say("{frequency:.6g} Hz (amplitude {amplitude:.3g} ± {error:.2g} {unit})", frequency=self.frequency,
                   amplitude=self.amplitude / size, error=self.standard_error / size, unit=unit)  # fmt: skip

    @property
    def unit(self) -> str:
        """SI unit of the amplitude."""
        return self.signal.si[0]

    def _summary(self) -> str:
        return self.words()


@dataclass(frozen=True, repr=False)
class Alternative(Value):
    """Another model of the same record; `aic` is its Akaike information criterion minus that of the fit's model."""

    model: Model
    aic: float

    def _summary(self) -> str:
        return f"AIC {self.aic:+.1f}: {self.model}"


def _estimate_of(symbol: str) -> Any:
    """The property of a fit that is its estimate of a term."""

    def estimate(fit: "Fit") -> Estimate:
        try:
            return fit[symbol]
        except UsageError as error:
            raise AttributeError(*error.args) from None

    return property(estimate, doc=f"The estimate of {TERMS[symbol].title}, if the fit has this term.")


@dataclass(frozen=True, eq=False, repr=False)
class Fit(Value):
    """Noise coefficients of a record or curve; ``fit.N``, or ``fit["N"]``, is the `Estimate` of a term.

    Attributes
    ----------
    estimates : tuple of Estimate
        Absent terms are included.
    method : str
        Its name in `METHODS`.
    signal : Signal
    model : Model
        The single best model. Its coefficients differ slightly from the estimates, which are averaged over several
        models, and a term of it may be called absent if other terms could take its place (`notes` then say so).
    name : str
        Of the channel.
    goodness : Goodness or None
        Goodness of fit, if the method tests it.
    correlation : array, shape (terms, terms), or None
        Of the estimates of the noise terms of `model`; NaN for terms that it lacks.
    curve : Curve or None
        The curve that was fitted, or is drawn with the fit.
    notes : tuple of str
    lines : tuple of Line
        Sinusoids that were removed first; they are part of the model.
    rivals, nodes : callable or None
        What `alternatives` and `averaged` are computed by.
    scope : Scope or None
        Which frequencies were used, and any low-pass filter in the model.
    findings : tuple of Finding
        Slow behaviour that the terms do not describe: a warm-up, or a power law other than that of flicker.
    checked : str
        Grade from the residuals, if they were computed.
    warm_up : Term or None
        A warm-up that was found; it is part of the model only where it was asked for.
    steps : tuple of (float, float)
        Time in the record, s, and size, SI, of each step of the bias; the noise is that between them.
    components : tuple of Component
        What the models consistent with the record hold beside the terms, each with the weight of those that do:
        claimed, likely or not.
    cutoff : level -> (low, high), or None
        Limits of the -3 dB frequency of a low-pass filter, Hz, whether one is claimed or not; infinity where the record
        may have none. None if no filter was looked for.
    """

    _keys: ClassVar = {"estimates": "terms", "rivals": "alternatives", "nodes": "averaged"}
    _called: ClassVar = {"params": "coefficients"}
    _checks: ClassVar = {"checked": lambda grade: demand_name("grade", grade, (*GRADES, ""))}

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
    warm_up: Term | None = None
    steps: tuple[tuple[float, float], ...] = ()
    components: tuple[Component, ...] = ()
    cutoff: Callable[[float], tuple[float, float]] | None = None

    Q, F, N, B, K, R, W = map(_estimate_of, ("Q", "F", "N", "B", "K", "R", "W"))
    GM, GML, GMA, GM2, Sine = map(_estimate_of, ("GM", "GML", "GMA", "GM2", "Sine"))

    @property
    def coefficients(self) -> dict[str, Estimate]:
        """The estimates by the symbols of their terms, of terms alike the first."""
        return {e.symbol: self[e.symbol] for e in self}

    def __post_init__(self) -> None:
        doubt = self._doubt or ("" if self.goodness else self.model.doubt)
        object.__setattr__(self, "model", Model(self.model.terms, doubt=doubt))

    @property
    def supposed(self) -> tuple[str, ...]:
        """What the model holds beside the terms and the filter, as text; empty if there is nothing."""
        claimed = {name: [c.words for c in self.components if c.name == name and c.claimed]
                   for name in ("floor", "resonance", "factor")}  # fmt: skip
        sentences = []
        if claimed["floor"]:
            sentences.append(say("white noise behind the filter is part of the model"))
        if claimed["resonance"]:
            sentences.append(say("the model includes vibration: {where}", where=join(", ", claimed["resonance"])))
        sentences += [say("{words}; the intervals allow for it", words=words) for words in claimed["factor"]]
        return tuple(sentences)

    @property
    def _doubt(self) -> str:
        """Why `model` is not used as it stands."""
        if self.validity == UNEXPLAINED:
            return REJECTED
        wrong = [term.symbol for term in self.model if term.symbol in self._wrong]
        return say("not valid in this model: {terms}; the fit leaves it out: pass the fit in place of its model",
                   terms=", ".join(wrong)) if wrong else ""  # fmt: skip

    @property
    def _wrong(self) -> set[str]:
        """The terms whose coefficients are no part of a model to be used."""
        return {e.symbol for e in self if e.status in ("not valid", "not observable")}

    @property
    def averaged(self) -> Averaged:
        """The models consistent with the record, with their weights; only `model` if the method has no alternatives."""
        return self.nodes() if self.nodes else averaged([self.model], [1.0])

    @property
    def validity(self) -> str:
        """Grade of the model, one of `GRADES`; empty if the method does not test it."""
        if self.goodness is None:
            return ""
        slow = (UNEXPLAINED if finding.fatal else APPROXIMATE for finding in self.findings)
        wrong = [e.status == "not valid" for e in self]
        coefficients = UNEXPLAINED if wrong and all(wrong) else APPROXIMATE if any(wrong) else ""
        return worst(self.scope.grade if self.scope else "", self.goodness.grade, coefficients, self.checked, *slow)

    @property
    def valid(self) -> Model | None:
        """The model to use: every coefficient as estimated, without terms that are not valid or not observable.

        None if the model does not explain the record, or has no other terms.
        """
        kept = tuple(term for term in self.model if term.symbol not in self._wrong)
        if self.validity == UNEXPLAINED or not kept:
            return None
        sizes = {e.symbol: e.value for e in self if e.value is not None}
        return Model(tuple(replace(term, value=sizes.get(term.symbol, term.value)) for term in kept))

    def usable(self, *, unexplained: bool = False) -> Model:
        """The model from which a job may go on: `valid`, or with `unexplained` the best one, whatever it explains.

        Raises
        ------
        DataError
            No model explains the record, and `unexplained` does not accept the best one.
        """
        return self.valid or self.model.usable(unexplained=unexplained)

    def complete(self, noise: Model) -> Model:
        """What the record is made of under a model of its noise: with the warm-up that was found."""
        if self.warm_up is None or any(term.row.transient for term in noise):
            return noise
        return Model((*noise, self.warm_up))

    @property
    def advice(self) -> tuple[str, ...]:
        """The notes that apply; none if the model does not explain the record."""
        return self.notes if self.validity != UNEXPLAINED else ()

    def invalid(self, reason: str, symbols: Iterable[str] | None = None) -> "Fit":
        """The fit with all coefficients, or those of the given symbols, marked as not valid."""
        wrong = tuple(e.symbol for e in self) if symbols is None else tuple(symbols)
        return replace(self, estimates=tuple(e.invalid(reason) if e.symbol in wrong else e for e in self))

    @property
    def alternatives(self) -> tuple[Alternative, ...]:
        """Other families of terms for the bias drift (flicker, Gauss-Markov, both, two of these), the best first.

        They are computed on first use; empty if the method has none.
        """
        return self.rivals() if self.rivals else ()

    def __getitem__(self, symbol: str) -> Estimate:
        for estimate in self.estimates:
            if estimate.symbol == symbol:
                return estimate
        terms = ", ".join(estimate.symbol for estimate in self.estimates)
        raise UsageError(f"{symbol!r} is not a term of this fit; its terms: {terms}")

    def __iter__(self) -> Iterator[Estimate]:
        return iter(self.estimates)

    def rows(self, level: float = 0.95) -> tuple[list[str], list[list[Any]]]:
        """Headings and rows, data sheet and SI side by side."""
        headings = ["term", "name", "value", "low", "high", "unit", "SI value", "SI unit", "status"]
        return headings, [
            [e.symbol, title_of(e.symbol, e.signal), *e.to_dict(level)["shown"].values(),
             e.upper if e.value is None else e.value, e.unit, e.status]
            for e in self.estimates
        ]  # fmt: skip

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data."""
        good = self.goodness
        p, reasons, remarks = (good.p, good.reasons, good.remarks) if good else (None, (), ())
        extra = {"validity": self.validity or None, "gof_p": p, "gof_reasons": list(reasons),
                 "gof_remarks": list(remarks)}  # fmt: skip
        others = {"alternatives": [other.to_dict() for other in self.alternatives], "averaged": self.averaged.to_dict()}
        return super().to_dict(level) | others | extra

    @classmethod
    def _stored(cls, data: dict[str, Any]) -> "Fit":
        kept = {key: {"values": data[key]} if data.get(key) else None for key in ("alternatives", "averaged")}
        return super()._stored(data | kept)

    def _summary(self) -> str:
        return f"of {self.name!r} by {self.method}: {self.model}"
