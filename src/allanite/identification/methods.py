"""The table of the methods of identification, and the terms that they support."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from allanite.core.curve import Curve
from allanite.core.errors import UsageError
from allanite.core.fit import Fit
from allanite.core.names import nearest, unknown
from allanite.core.record import Record
from allanite.phrases.phrase import say
from allanite.statistics.row import Statistic
from allanite.statistics.table import STATISTICS
from allanite.terms import TERMS

from .curves.leastsquares import gls, joint, least_squares, nnls, whole
from .curves.reading import piecewise, slopes
from .search.identify import Pending, pending


@dataclass(frozen=True)
class Method:
    """A method of identification."""

    title: str
    takes: type  # whether it needs the record or a curve
    begin: Callable[..., Pending | Fit]  # from that, symbols and options to the fit, or to a search for it
    # RMS error over the Cramer-Rao bound of the coefficients, smallest and largest, where that bound is at most 12 %,
    # measured with known terms (benchmarks/methods.py)
    efficiency: str
    # statistic, taus: the curve computed from a record; empty if none is used
    statistic: str = ""
    taus: str = ""
    # whether it can fit a curve of this row of `STATISTICS`; None for a method that uses the record
    reads: Callable[[Statistic], bool] = lambda row: False
    options: tuple[str, ...] = ()  # options other than the terms
    shapes: bool = False  # whether it supports terms with a shape: Gauss-Markov noise, sinusoids
    signed: bool = False  # whether it determines the sign of a ramp; a curve gives only the size
    synonyms: tuple[str, ...] = ()  # other names by which it is asked for; they are suggested, not taken

    @property
    def allowed(self) -> tuple[str, ...]:
        """Names of the statistics whose curves it can fit; empty for a method that uses the record."""
        return tuple(name for name, row in STATISTICS.items() if self.reads(row))


def times(least: float, most: float) -> str:
    """The efficiency of a method."""
    return say("{least:g} to {most:g} times the Cramer-Rao bound", least=least, most=most)


METHODS: dict[str, Method] = {
    "whittle": Method(
        say("Whittle likelihood of binned cosine-transform powers, intervals averaged over models"),
        Record, pending, efficiency=times(0.91, 1.07),
        options=("band", "masks", "lines", "rival"), shapes=True, signed=True, synonyms=("mle", "likelihood"),
    ),
    "gls": Method(
        say("generalized least squares of a curve with the covariance of its points under the model"),
        Curve, gls, efficiency=times(0.91, 1.26),
        statistic="oadev", taus="octave", reads=lambda row: row.readable and row.overlapped,
    ),
    "joint": Method(
        say("non-negative fit of Allan and Hadamard variance together, weighted by degrees of freedom"),
        Record, joint, efficiency=times(0.91, 1.49),
        statistic=say("{first} and {second}", first="oadev", second="ohdev"), taus="octave",
    ),
    "nnls": Method(
        say("non-negative least squares with equal relative weights up to T/10 (for comparison with programs)"),
        Curve, nnls, efficiency=times(1.21, 11.5),
        statistic="oadev", taus="log", reads=lambda row: row.readable,
    ),
    "piecewise": Method(
        say("lines of the textbook slopes through ranges of averaging times (for comparison)"),
        Curve, piecewise, efficiency=times(4.17, 83.8),
        statistic="oadev", taus="octave", reads=lambda row: row.allan, options=("ranges",),
    ),
    "ls": Method(
        say("unweighted least squares of the Allan variance (for comparison with papers)"),
        Curve, least_squares, efficiency=times(1.13, 147),
        statistic="oadev", taus="octave", reads=lambda row: row.allan,
    ),
    "curve": Method(
        say("unweighted non-negative least squares of the whole curve as drawn (for comparison with papers)"),
        Curve, whole, efficiency=times(1.02, 53.8),
        statistic="oadev", taus="log", reads=lambda row: row.allan or bool(row.parts), synonyms=("whole",),
    ),
    "slopes": Method(
        say("lines of the textbook slopes on the Allan deviation (for comparison)"),
        Curve, slopes, efficiency=times(1.7, 3.68e+04),
        statistic="oadev", taus="octave", reads=lambda row: row.allan, synonyms=("allan", "avar", "lines"),
    ),
}  # fmt: skip


def automatic() -> str:
    """The default terms."""
    return ",".join(symbol for symbol, row in TERMS.items() if row.automatic)


def symbols_of(terms: str | Sequence[str]) -> tuple[str, ...]:
    """Symbols from a list of them, or a text like ``QNGMK``: the longest match comes first; with or without commas."""
    # A second Gauss-Markov noise, ``N,GM,GM``, is the slow one, GML.
    rest = automatic() if terms == "auto" else terms if isinstance(terms, str) else ",".join(terms)
    symbols: tuple[str, ...] = ()
    known = sorted(TERMS, key=len, reverse=True)
    while rest := rest.lstrip(", "):
        symbol = next(filter(rest.startswith, known), None)
        if symbol is None:
            names = [name.strip() for name in rest.split(",")]
            error = unknown("term", names[0], TERMS, choice="terms")
            if error.cure[1]:  # with the others that follow it
                error.cure = ",".join(names), ",".join(n if n in TERMS else nearest(n, TERMS) or n for n in names)
            raise error
        again = symbol in symbols and TERMS[symbol].second
        symbols, rest = (*symbols, again or symbol), rest[len(symbol) :]
    if len(set(symbols)) < len(symbols) or all(TERMS[s].waveform is not None for s in symbols):
        raise UsageError(
            f"terms must name each symbol once, GM twice at most, and at least one noise, unlike {terms!r}",
            choice="terms",
        )
    return symbols
