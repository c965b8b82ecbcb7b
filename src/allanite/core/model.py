"""Term and Model: the noise terms that describe a sensor's random errors, and functions that make them."""

import math
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from inspect import Parameter, Signature
from typing import Any, Protocol

import numpy as np

from allanite.phrases.phrase import Phrase, join, say, spelled
from allanite.terms import TERMS, NoiseTerm

from .aliases import public
from .arrays import LARGEST, FloatArray
from .encoding import read_key
from .errors import DataError, StoredError, UnitError, UsageError, WrongTypeError, given
from .kinds import title_of
from .limits import demand_stored_size
from .names import demand_name, row_of, unknown
from .plain import Value
from .ranges import INTERVALS, POSITIVE, REAL, TIME, Range
from .syntax import NUMBER, split_quantities
from .units import SIGNALS, Signal, convert, signal_with, unit_of


@dataclass(frozen=True, repr=False)
class Term(Value):
    """One noise term with its coefficient; terms add up to a model.

    Attributes
    ----------
    symbol : str
        A name in `TERMS`.
    value : float
        The coefficient, SI.
    signal : Signal
        The type of sensor.
    shape : tuple of float
        Values of the `parameters` of the term's row, SI: the time constant of GM, GMA and W, natural frequency and
        damping of GM2, frequency and phase of Sine.

    Examples
    --------
    >>> from allanite import B, N
    >>> model = N(0.01, "deg/sqrt(h)") + B(0.5, "deg/h")
    >>> model["B"].to("deg/h")
    0.5
    """

    symbol: str
    value: float
    signal: Signal
    shape: tuple[float, ...] = ()

    @property
    def row(self) -> NoiseTerm:
        """The term's row of `TERMS`; for a term with a shape only its texts: see `sampled`."""
        return TERMS[self.symbol]

    def sampled(self, rate: float) -> NoiseTerm:
        """The row whose functions hold for a sample interval of 1 / rate."""
        for parameter, value in zip(self.row.parameters, self.shape, strict=True):
            if parameter.time > 0:
                INTERVALS.demand(value * rate, f"the {parameter.name} of {self.symbol} over the sampling interval")
        return self.row.shaped(self.shape, rate) if self.row.shaped else self.row

    def power(self, rate: float) -> float:
        """Square of the coefficient, where the sample interval is the unit of time."""
        return float(self.value**2 * rate ** (2 * self.row.power))

    @property
    def unit(self) -> str:
        """SI unit of `value`."""
        return self.signal.si[self.row.power]

    def to(self, unit: str) -> float:
        """The coefficient in another unit."""
        return self.value / coefficient_factor(self.symbol, unit, self.signal)

    def __add__(self, other: "Term | Model") -> "Model":
        return Model((self,)) + other

    @property
    def plain(self) -> dict[str, Any]:
        """Plain data, SI, as part of a model: without the type of sensor."""
        shape = {p.name: value for p, value in zip(self.row.parameters, self.shape, strict=True)}
        return {"symbol": self.symbol, "value": self.value, "unit": self.unit, **shape}

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data, SI; `level` changes nothing."""
        return {"allanite": 1, "type": "Term", "signal": self.signal.name, **self.plain}

    @classmethod
    def _stored(cls, data: dict[str, Any]) -> "Term":
        symbol = read_key(data, "symbol", str)
        names = ("value", *(p.name for p in row_of("term", symbol, TERMS).parameters))
        value, *shape = (float(read_key(data, name, float)) for name in names)
        demand_stored_size(value)
        return cls(symbol, value, read_key(data, "signal", Signal), tuple(shape))

    @property
    def shape_words(self) -> str:
        """The shape with its units, without what is as usual; empty if the term has none."""
        pairs = [(p, value) for p, value in zip(self.row.parameters, self.shape, strict=True) if value != p.default]
        return join(", ", [say("{parameter} {value:.4g} {unit}", parameter=p.title, value=value, unit=p.unit) if p.unit
                           else say("{parameter} {value:.4g}", parameter=p.title, value=value)
                           for p, value in pairs])  # fmt: skip

    def __str__(self) -> str:
        sheet, shape = self.signal.sheet[self.row.power], self.shape_words
        size = f"{self.symbol} = {self.to(sheet):.4g} {sheet}"
        return say("{term} with {shape}", term=size, shape=shape) if shape else size

    _summary = __str__


def coefficient_factor(symbol: str, unit: str, signal: Signal | None = None) -> float:
    """Size of `unit` in SI, if it is a unit of the coefficient `symbol`; a UnitError names the usual ones if not."""
    size = unit_of(unit)
    fits = signal_with(size.dimension, TERMS[symbol].power, values=True)
    if fits is None or (signal is not None and fits is not signal):
        meant = [s for s in SIGNALS if (s.inertial if signal is None else s is signal)]
        usual = ", ".join(s.sheet[TERMS[symbol].power] for s in meant)
        title = TERMS[symbol].title if signal is None else title_of(symbol, signal)
        raise UnitError(f"{unit!r} is not a unit of {symbol} ({title}); usual units: {usual}")
    return size.factor


def term(symbol: str, value: float, unit: str, shape: tuple[float, ...] = ()) -> Term:
    """The term `symbol` with a coefficient in `unit` and the values of its row's `parameters`, if it has any."""
    demand_name("noise term", symbol, TERMS)
    factor = coefficient_factor(symbol, unit)
    signal = signal_with(unit_of(unit).dimension, TERMS[symbol].power, values=True)
    assert signal is not None  # noqa: S101 - coefficient_factor has found it
    if not math.isfinite(value) or (value < 0 and TERMS[symbol].waveform is None):
        raise UsageError(f"the coefficient of {symbol} must be finite and not negative, not {given(value)}")
    if value and not 1 / LARGEST < abs(value * factor) < LARGEST:
        allowed = f"from {1 / LARGEST:g} to {LARGEST:g} {signal.si[TERMS[symbol].power]}, or 0"
        raise UsageError(f"{symbol} = {given(value)} {unit} cannot be computed with: it must be {allowed}")
    return Term(symbol, value * factor, signal, _shape(symbol, shape))


def _shape(symbol: str, given: tuple[float, ...]) -> tuple[float, ...]:
    """The shape, completed by defaults; an error if it is wrong."""
    parameters = TERMS[symbol].parameters
    wanted = ", ".join(f"{p.name} in {p.unit}" if p.unit else p.name for p in parameters) or "no shape"
    shape = (*given, *(p.default for p in parameters[len(given) :] if p.default is not None))
    if len(shape) != len(parameters):
        raise UsageError(f"{symbol} has {wanted}, but {len(given)} values were given")
    for p, value in zip(parameters, shape, strict=True):
        span = POSITIVE if not p.time else TIME if p.time > 0 else Range(1 / TIME.high, 1 / TIME.low, p.unit)
        within = REAL if p.least is None else span
        within.demand(value, f"the {p.name} of {symbol}")
    return tuple(float(value) for value in shape)


@dataclass(frozen=True, repr=False, init=False)
class Model(Value):
    """A sum of terms of one signal; their structure functions and spectra add.

    A symbol occurs once, or, if its term has a shape, several times with different shapes.

    Parameters
    ----------
    terms : str, Term or sequence of Term
        In a text they are separated by commas: ``"N 0.003 deg/sqrt(h), GM 0.1 deg/h 20 s, Sine 3 deg/h 0.5 Hz"``. Each
        has a symbol, a number and a unit, followed by the parameters of a term with a shape, whose units may be omitted
        if they are s, Hz and rad. The output of ``str(model)`` is accepted, too.

    doubt : str, optional
        As the attribute.

    Attributes
    ----------
    terms : tuple of Term
    doubt : str
        Why it is no model of the record that it was identified from: it does not explain it, or a coefficient is not
        valid. Empty otherwise, and for any model that was not identified. Models that differ in it alone are equal;
        sums keep it.

    Raises
    ------
    UsageError
        A term is unknown, incomplete or occurs twice, or a unit does not fit it.

    Examples
    --------
    >>> print(Model("N 0.003 deg/sqrt(h), Q 0.2 arcsec, GM 0.1 deg/h 2 min"))
    N = 0.003 deg/sqrt(h), Q = 0.2 arcsec, GM = 0.1 deg/h with time constant 120 s
    >>> from allanite import K, N
    >>> model = N(1.0, "rad/sqrt(s)") + K(0.1, "rad/s^1.5")
    >>> [str(t.symbol) for t in model], model.structure(np.array([6.0])).round(12).tolist()
    (['N', 'K'], [5.64])
    """

    terms: tuple[Term, ...]
    doubt: str = field(default="", compare=False)

    def __init__(self, terms: str | Term | Iterable[Term], *, doubt: str = "") -> None:
        listed = _terms_of(terms) if isinstance(terms, str) else _listed(terms)
        object.__setattr__(self, "terms", listed)
        object.__setattr__(self, "doubt", doubt)
        symbols = [t.symbol for t in self.terms]
        if not symbols:
            raise UsageError("a model needs at least one term, for example N(0.01, 'deg/sqrt(h)')")
        if len({(t.symbol, t.shape) for t in self.terms}) < len(symbols):
            raise UsageError(f"each term may occur once in a model, but these were given: {', '.join(symbols)}")
        if len({t.signal.name for t in self.terms}) > 1:
            raise UnitError("terms of different signals cannot be added: " + ", ".join(map(str, self.terms)))

    @property
    def signal(self) -> Signal:
        """The type of sensor that the model describes."""
        return self.terms[0].signal

    @property
    def drifts(self) -> bool:
        """Whether the model contains a ramp."""
        return any(t.row.waveform is not None and t.row.scatters for t in self.terms)

    def structure(self, t: FloatArray) -> FloatArray:
        """Structure function D(t) = E[(x(s+t) - x(s))^2] of the angle, SI, t in seconds, shape of `t`."""
        try:
            return np.asarray(sum(t_.value**2 * t_.sampled(1.0).structure(t) for t_ in self.terms))
        except ValueError as error:  # a warm-up has none
            raise UsageError(str(error)) from None

    def spectrum(self, f: FloatArray, interval: float) -> FloatArray:
        """Two-sided power spectral density of the rate, SI, at `f` Hz for a sample interval in s."""
        return np.asarray(sum(t.value**2 * t.sampled(1 / interval).spectrum(f, interval) for t in self.terms))

    def __add__(self, other: "Term | Model") -> "Model":
        added = model_of(other)
        return Model((*self, *added), doubt=self.doubt or added.doubt)

    def usable(self, *, unexplained: bool = False) -> "Model":
        """The model from which a job may go on: a plan, a filter, a simulation, a prediction.

        Raises
        ------
        DataError
            There is a `doubt`, and `unexplained` does not accept the model nevertheless.
        """
        if self.doubt and not unexplained:
            raise DataError(nevertheless(self.doubt, spelled("--unexplained", "pass model.usable(unexplained=True)")))
        return Model(self.terms) if self.doubt else self

    @property
    def noise(self) -> "Model | None":
        """The model without its sinusoids and warm-ups; None if no term remains."""
        kept = tuple(t for t in self.terms if t.row.scatters)
        return Model(kept, doubt=self.doubt) if kept else None

    def __getitem__(self, symbol: str) -> Term:
        alike = [t for t in self.terms if t.symbol == symbol]
        if len(alike) > 1:
            raise UsageError(f"{symbol!r} occurs {len(alike)} times in this model: iterate over its terms")
        if alike:
            return alike[0]
        raise UsageError(f"no term {symbol!r} in this model; its terms: {', '.join(t.symbol for t in self.terms)}")

    def __iter__(self) -> Iterator[Term]:
        return iter(self.terms)

    def __str__(self) -> str:
        return join(", ", map(str, self.terms))

    _summary = __str__

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data; a model has no limits, so that `level` changes nothing."""
        terms = [t.plain for t in self.terms]
        doubt = {"doubt": str(self.doubt)} if self.doubt else {}
        return {"allanite": 1, "type": "Model", "signal": self.signal.name, "terms": terms, **doubt}

    @classmethod
    def _stored(cls, data: dict[str, Any]) -> "Model":
        common = {"signal": read_key(data, "signal", str)}
        terms = [common | term for term in read_key(data, "terms", tuple[dict[str, Any], ...])]
        if not terms:
            raise StoredError("a model has at least one term")
        doubt = read_key({"doubt": "", **data}, "doubt", str)
        return cls(read_key({"terms": terms}, "terms", tuple[Term, ...]), doubt=doubt)


def _terms_of(text: str) -> tuple[Term, ...]:
    """The terms of a model that a text describes; see `Model`."""
    parts: list[list[str]] = []
    titles = (f"{p.name} {p.title}" for row in TERMS.values() for p in row.parameters)
    fillers = {"with", *" ".join(titles).replace("_", " ").split()}  # words that carry no information
    for part in text.split(","):
        words = [word for word in part.replace("=", " ").split() if word not in fillers]
        if parts and words and NUMBER.match(words[0]):  # the previous term has another parameter
            parts[-1] += words
        else:
            parts.append(words)
    return tuple(_term(words, text) for words in parts)


def _term(words: list[str], text: str) -> Term:
    if not words or words[0] not in TERMS:
        where = f" in {text!r}"
        error = unknown("term", words[0], TERMS, where=where) if words else UsageError(f"there is no term{where}")
        raise type(error)(f"{error}; a model has the form 'N 0.003 deg/sqrt(h), Q 0.2 arcsec'", cure=error.cure)
    symbol, parameters = words[0], TERMS[words[0]].parameters
    # the unit of the coefficient may begin with 1, as 1/s
    plain = len(words) > 2 and NUMBER.fullmatch(words[1]) and re.fullmatch(r"1(/.*)?", words[2])
    first = [(float(words[1]), words[2])] if plain else []
    quantities = [*first, *split_quantities(words[1 + 2 * len(first) :])]
    if not 0 < len(quantities) <= 1 + len(parameters) or not quantities[0][1]:
        wanted = "".join(f", its {p.name.replace('_', ' ')}{p.unit and f' in {p.unit}'}" for p in parameters)
        raise UsageError(f"{' '.join(words)!r} is not a noise term: {symbol} must be followed by a number and a "
                         f"unit{wanted}, e.g. 'N 0.003 deg/sqrt(h), GM 0.1 deg/h 20 s'")  # fmt: skip
    (value, unit), *rest = quantities
    shape = (convert(v, u or p.unit or "1", p.unit or "1") for (v, u), p in zip(rest, parameters, strict=False))
    return term(symbol, value, unit, tuple(shape))


def _listed(terms: Any) -> tuple[Term, ...]:
    listed = tuple(terms) if isinstance(terms, Iterable) and not isinstance(terms, Term) else (terms,)
    for term in listed:
        if not isinstance(term, Term):
            raise WrongTypeError(f"Model: terms must be text or terms, e.g. N(0.01, 'deg/sqrt(h)'), not {given(term)}")
    return listed


class HasModel(Protocol):
    """An object with a model, such as the result of a fit."""

    @property
    def model(self) -> Model: ...  # noqa: D102


ModelLike = Model | Term | HasModel  # what is accepted wherever a model is expected


def nevertheless(why: str, remedy: str) -> Phrase:
    """Why the coefficients of a model that does not explain its record are not used, and how they are nevertheless."""
    return say("{why}. To use the coefficients nevertheless: {remedy}", why=why, remedy=remedy)


def usable_model(value: ModelLike) -> Model:
    """The model from which a job may go on: given, or identified without a doubt; of a fit its valid coefficients."""
    usable = getattr(value, "usable", None)
    return usable() if usable is not None else model_of(value).usable()


def model_of(value: ModelLike) -> Model:
    """The model that a term, a model or a fit represents; anything else is refused."""
    if isinstance(value, Model | Term):
        return value if isinstance(value, Model) else Model((value,))
    inner = getattr(value, "model", None)
    if isinstance(inner, Model):
        return inner
    shown = f"the text {given(value)}" if isinstance(value, str) else f"an object of type {type(value).__name__}"
    raise WrongTypeError("a noise model must be a Model, a Term such as N(0.01, 'deg/sqrt(h)'), or a Fit, not "
                         f"{shown}; Model(text) makes one of a text")  # fmt: skip


class Constructor(Protocol):
    """A function that makes the term of one symbol from a coefficient, its unit, and the parameters by name."""

    def __call__(self, value: float | str, unit: str = "", **shape: float) -> Term: ...  # noqa: D102


def constructor(symbol: str) -> Constructor:
    """The function that makes a term of this symbol, from the term's row of `TERMS`."""
    row, usual = TERMS[symbol], (Parameter.POSITIONAL_OR_KEYWORD, Parameter.KEYWORD_ONLY)
    named = [
        Parameter("value", usual[0], annotation=float | str), Parameter("unit", usual[0], annotation=str, default=""),
        *(Parameter(p.name, usual[1], annotation=float, default=Parameter.empty if p.default is None else p.default)
          for p in row.parameters),
    ]  # fmt: skip
    signature = Signature(named, return_annotation=Term)
    sheet = SIGNALS[0].sheet[row.power]

    def build(value: float | str, unit: str = "", **shape: float) -> Term:
        if isinstance(value, str) and not unit and not shape:
            return Model(f"{symbol} {value}")[symbol]
        bound = signature.bind(value, unit, **shape)
        bound.apply_defaults()
        if isinstance(value, str) or not unit:
            raise UsageError(f"{symbol} needs a number and its unit, e.g. al.{symbol}({given(value)}, {sheet!r})")
        return term(symbol, value, unit, tuple(bound.arguments[p.name] for p in row.parameters))

    example = "".join(f", {p.name}={p.typical:g}" for p in row.parameters if p.default is None)
    units = "".join(f"; {p.name} in {p.unit}" for p in row.parameters if p.unit)
    build.__name__ = build.__qualname__ = symbol
    build.__doc__ = (f"{row.title.capitalize()}: {row.meaning}.\n\n"
                     f"For example ``{symbol}({row.typical:g}, {sheet!r}{example})``{units}.")  # fmt: skip
    build.__signature__ = signature  # type: ignore[attr-defined]
    build.__annotations__ = {name: parameter.annotation for name, parameter in signature.parameters.items()}
    return public(build)


Q, N, B, K, R, W = map(constructor, ("Q", "N", "B", "K", "R", "W"))
F, GM, GMA, GM2, GML, Sine = map(constructor, ("F", "GM", "GMA", "GM2", "GML", "Sine"))
