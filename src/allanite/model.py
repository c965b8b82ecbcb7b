"""Term and Model: what a sensor's random error is supposed to be made of."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .errors import UnitError, UsageError
from .terms import TERMS, NoiseTerm
from .units import SIGNALS, Signal, signal_named, signal_with, unit_of

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Term:
    """One noise term with its coefficient in SI.

    Terms add up to a model, each symbol at most once.

    Examples
    --------
    >>> model = N(0.01, "deg/sqrt(h)") + B(0.5, "deg/h")
    >>> model["B"].to("deg/h")
    0.5
    """

    symbol: str
    value: float
    signal: Signal

    @property
    def row(self) -> NoiseTerm:
        """The term's row of `TERMS`."""
        return TERMS[self.symbol]

    @property
    def unit(self) -> str:
        """SI unit of `value`."""
        return self.signal.si[self.row.power]

    def to(self, unit: str) -> float:
        """The coefficient in another unit."""
        return self.value / coefficient_factor(self.symbol, unit, self.signal)

    def __add__(self, other: "Term | Model") -> "Model":
        return Model((self,)) + other

    def __str__(self) -> str:
        sheet = self.signal.sheet[self.row.power]
        return f"{self.symbol} = {self.to(sheet):.4g} {sheet}"


def coefficient_factor(symbol: str, unit: str, signal: Signal | None = None) -> float:
    """Size of `unit` in SI, once it is found to be a unit of the coefficient `symbol`.

    Raises
    ------
    UnitError
        If `unit` is no unit of this coefficient; the message names the usual ones.
    """
    found = unit_of(unit)
    fits = signal_with(found.dimension, TERMS[symbol].power)
    if fits is None or (signal is not None and fits is not signal):
        usual = ", ".join(s.sheet[TERMS[symbol].power] for s in SIGNALS if signal is None or s is signal)
        raise UnitError(f"{unit!r} is no unit of {symbol} ({TERMS[symbol].title}); usual ones are {usual}")
    return found.factor


def term(symbol: str, value: float, unit: str) -> Term:
    """The term `symbol` with a coefficient in `unit`."""
    if symbol not in TERMS:
        raise UsageError(f"unknown noise term {symbol!r}; known are {', '.join(TERMS)}")
    factor = coefficient_factor(symbol, unit)
    signal = signal_with(unit_of(unit).dimension, TERMS[symbol].power)
    assert signal is not None  # noqa: S101 - coefficient_factor has found it
    if not math.isfinite(value) or (value < 0 and TERMS[symbol].waveform is None):
        raise UsageError(f"the coefficient of {symbol} must be a finite number, not negative, but is {value!r}")
    return Term(symbol, value * factor, signal)


def Q(value: float, unit: str) -> Term:
    """Quantization noise, for example ``Q(0.4, "arcsec")``."""
    return term("Q", value, unit)


def N(value: float, unit: str) -> Term:
    """Angle (velocity) random walk, for example ``N(0.01, "deg/sqrt(h)")``."""
    return term("N", value, unit)


def B(value: float, unit: str) -> Term:
    """Bias instability (flicker), for example ``B(0.5, "deg/h")``; the curve's floor is 0.664 B."""
    return term("B", value, unit)


def K(value: float, unit: str) -> Term:
    """Rate random walk, for example ``K(0.1, "deg/h/sqrt(h)")``."""
    return term("K", value, unit)


def R(value: float, unit: str) -> Term:
    """Rate ramp, with its sign, for example ``R(-0.02, "deg/h^2")``."""
    return term("R", value, unit)


@dataclass(frozen=True)
class Model:
    """A sum of terms of one signal; their structure functions and spectra add.

    Examples
    --------
    >>> model = N(1.0, "rad/sqrt(s)") + K(0.1, "rad/s^1.5")
    >>> [str(t.symbol) for t in model], model.structure(np.array([6.0])).round(12).tolist()
    (['N', 'K'], [5.64])
    """

    terms: tuple[Term, ...]

    def __post_init__(self) -> None:
        symbols = [t.symbol for t in self.terms]
        if not symbols:
            raise UsageError("a model needs at least one term, for example N(0.01, 'deg/sqrt(h)')")
        if len(set(symbols)) < len(symbols):
            raise UsageError(f"each term may stand once in a model, but these came: {', '.join(symbols)}")
        if len({t.signal.name for t in self.terms}) > 1:
            raise UnitError("terms of different signals cannot be added: " + ", ".join(map(str, self.terms)))

    @property
    def signal(self) -> Signal:
        """What kind of sensor the model is of."""
        return self.terms[0].signal

    def structure(self, t: FloatArray) -> FloatArray:
        """D(t) = E[(x(s+t) - x(s))^2], SI, t in seconds, shape of `t`."""
        return np.asarray(sum(t_.value**2 * t_.row.structure(t) for t_ in self.terms))

    def spectrum(self, f: FloatArray, interval: float) -> FloatArray:
        """Two-sided spectral density of the rate, SI, at `f` Hz for a sample interval in s."""
        return np.asarray(sum(t.value**2 * t.row.spectrum(f, interval) for t in self.terms))

    def __add__(self, other: "Term | Model") -> "Model":
        return Model(self.terms + (other.terms if isinstance(other, Model) else (other,)))

    def __getitem__(self, symbol: str) -> Term:
        for t in self.terms:
            if t.symbol == symbol:
                return t
        raise UsageError(f"no term {symbol!r} in this model; there are {', '.join(t.symbol for t in self.terms)}")

    def __iter__(self) -> Iterator[Term]:
        return iter(self.terms)

    def __str__(self) -> str:
        return ", ".join(map(str, self.terms))

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        terms = [{"symbol": t.symbol, "value": t.value, "unit": t.unit} for t in self.terms]
        return {"allanite": 1, "type": "Model", "signal": self.signal.name, "terms": terms}

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> "Model":
        """The model that `to_dict` has written."""
        signal = signal_named(data["signal"])
        return cls(tuple(Term(t["symbol"], float(t["value"]), signal) for t in data["terms"]))
