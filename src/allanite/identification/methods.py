"""What a way to identify is, and the terms that one may ask of it."""

from collections.abc import Callable
from dataclasses import dataclass

from allanite.core.errors import UsageError
from allanite.core.fit import Fit
from allanite.statistics.row import Statistic
from allanite.statistics.table import STATISTICS
from allanite.terms import TERMS


@dataclass(frozen=True)
class Method:
    """A way to identify.

    Attributes
    ----------
    title : str
    takes : type
        Whether it needs the record or a curve.
    fit : (source, symbols, ...) -> Fit
    efficiency : str
        Root mean square error over the Cramer-Rao bound of the coefficients, smallest and largest where that bound is
        at most 12 %, measured with the true terms known (benchmarks/methods.py).
    statistic, taus : str
        The curve that is made of a record; empty where none is read.
    reads : statistic -> bool
        Whether it can read a curve of this row of `STATISTICS`; none for a method that takes the record.
    options : tuple of str
        What may be said beside the terms.
    shapes : bool
        Whether it finds terms with a shape: Gauss-Markov noise, sinusoids.
    signed : bool
        Whether it knows the sign of a ramp; a curve tells the size only.
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
        """Names of the statistics whose curves it can read; none for a method that takes the record."""
        return tuple(name for name, row in STATISTICS.items() if self.reads(row))


def automatic() -> str:
    """The terms that are looked for where nobody says which."""
    return ",".join(symbol for symbol, row in TERMS.items() if row.automatic)


def symbols_of(terms: str) -> tuple[str, ...]:
    """Symbols out of a text like ``QNGMK``: the longest that fits comes first, commas and blanks may stand between.

    Raises
    ------
    UsageError
        One is unknown or stands twice, or none is noise.
    """
    rest = automatic() if terms == "auto" else terms
    symbols: tuple[str, ...] = ()
    known = sorted(TERMS, key=len, reverse=True)
    while rest := rest.lstrip(", "):
        symbol = next(filter(rest.startswith, known), None)
        if symbol is None:
            raise UsageError(f"unknown term {rest[0]!r} in {terms!r}; known are {', '.join(TERMS)}")
        symbols, rest = (*symbols, symbol), rest[len(symbol) :]
    if len(set(symbols)) < len(symbols) or all(TERMS[s].waveform is not None for s in symbols):
        raise UsageError(f"terms name each symbol once, and at least one is noise, unlike {terms!r}")
    return symbols
