"""The ways to identify, as a table, and the terms that one may ask of them."""

from collections.abc import Callable
from dataclasses import dataclass

from allanite.core.curve import Curve
from allanite.core.errors import UsageError
from allanite.core.fit import Fit
from allanite.core.record import Record
from allanite.statistics import STATISTICS
from allanite.statistics.row import Statistic
from allanite.terms import TERMS

from .curves.allan_hadamard import joint
from .curves.gls import gls
from .curves.leastsquares import least_squares, slopes
from .curves.nonnegative import nnls
from .curves.piecewise import piecewise
from .likelihood.identify import whittle


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

    @property
    def allowed(self) -> tuple[str, ...]:
        """Names of the statistics whose curves it can read; none for a method that takes the record."""
        return tuple(name for name, row in STATISTICS.items() if self.reads(row))


METHODS: dict[str, Method] = {
    "whittle": Method(
        "likelihood of the cosine transform's binned powers, profile intervals", Record, whittle,
        efficiency="0.93 to 1.14 times the Cramer-Rao bound",
        options=("band", "lines", "rival"), shapes=True,
    ),
    "gls": Method(
        "generalised least squares of a curve with the covariance that the model gives its points", Curve, gls,
        efficiency="0.96 to 1.19 times the Cramer-Rao bound",
        statistic="oadev", taus="octave", reads=lambda row: row.readable and row.overlapped,
    ),
    "joint": Method(
        "non-negative fit of Allan and Hadamard variance together, weights by degrees of freedom", Record, joint,
        efficiency="0.96 to 1.38 times the Cramer-Rao bound",
        statistic="oadev and ohdev", taus="octave",
    ),
    "nnls": Method(
        "non-negative least squares with equal relative weights up to T/10 (for comparison with programs)", Curve, nnls,
        efficiency="1.11 to 9.73 times the Cramer-Rao bound",
        statistic="oadev", taus="log", reads=lambda row: row.readable,
    ),
    "piecewise": Method(
        "lines of the textbook slopes through ranges of averaging times (for comparison)", Curve, piecewise,
        efficiency="3.91 to 84.9 times the Cramer-Rao bound",
        statistic="oadev", taus="octave", reads=lambda row: row.allan, options=("ranges",),
    ),
    "ls": Method(
        "unweighted least squares of the Allan variance (for comparison with papers)", Curve, least_squares,
        efficiency="1.13 to 151 times the Cramer-Rao bound",
        statistic="oadev", taus="octave", reads=lambda row: row.allan,
    ),
    "slopes": Method(
        "lines of the textbook slopes on the Allan deviation (for comparison)", Curve, slopes,
        efficiency="1.85 to 65100 times the Cramer-Rao bound",
        statistic="oadev", taus="octave", reads=lambda row: row.allan,
    ),
}  # fmt: skip


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
