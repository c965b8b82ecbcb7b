"""Methods of identification, and the terms that they support."""

from collections.abc import Callable
from dataclasses import dataclass

from allanite.core.errors import UsageError
from allanite.core.fit import Fit
from allanite.statistics.row import Statistic
from allanite.statistics.table import STATISTICS
from allanite.terms import TERMS


@dataclass(frozen=True)
class Method:
    """A method of identification.

    Attributes
    ----------
    title : str
    takes : type
        Whether it needs the record or a curve.
    fit : (source, symbols, ...) -> Fit
    efficiency : str
        RMS error over the Cramer-Rao bound of the coefficients, smallest and largest, where that bound is at most 12 %,
        measured with known terms (benchmarks/methods.py).
    statistic, taus : str
        The curve computed from a record; empty if none is used.
    reads : statistic -> bool
        Whether it can fit a curve of this row of `STATISTICS`; None for a method that uses the record.
    options : tuple of str
        Options other than the terms.
    shapes : bool
        Whether it supports terms with a shape: Gauss-Markov noise, sinusoids.
    signed : bool
        Whether it determines the sign of a ramp; a curve gives only the size.
    """

    title: str
    takes: type
    fit: Callable[..., Fit]
    efficiency: str
    statistic: str = ""
    taus: str = ""
    reads: Callable[[Statistic], bool] = lambda row: False
    options: tuple[str, ...] = ()
    shapes: bool = False
    signed: bool = False

    @property
    def allowed(self) -> tuple[str, ...]:
        """Names of the statistics whose curves it can fit; empty for a method that uses the record."""
        return tuple(name for name, row in STATISTICS.items() if self.reads(row))


def automatic() -> str:
    """The default terms."""
    return ",".join(symbol for symbol, row in TERMS.items() if row.automatic)


def symbols_of(terms: str) -> tuple[str, ...]:
    """Symbols from a text like ``QNGMK``: the longest match comes first; commas and blanks are allowed.

    Raises
    ------
    UsageError
        A symbol is unknown or occurs twice, or none is a noise.
    """
    rest = automatic() if terms == "auto" else terms
    symbols: tuple[str, ...] = ()
    known = sorted(TERMS, key=len, reverse=True)
    while rest := rest.lstrip(", "):
        symbol = next(filter(rest.startswith, known), None)
        if symbol is None:
            raise UsageError(f"unknown term {rest[0]!r} in {terms!r}; known terms: {', '.join(TERMS)}", choice="terms")
        symbols, rest = (*symbols, symbol), rest[len(symbol) :]
    if len(set(symbols)) < len(symbols) or all(TERMS[s].waveform is not None for s in symbols):
        raise UsageError(f"terms must name each symbol once, and at least one noise, unlike {terms!r}", choice="terms")
    return symbols
