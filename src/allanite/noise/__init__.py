"""Identification of noise: from a record or a curve to coefficients."""

from collections.abc import Callable
from dataclasses import dataclass

from allanite.curve import Curve
from allanite.errors import UsageError
from allanite.fit import Fit
from allanite.record import Record
from allanite.statistics import deviation
from allanite.terms import TERMS

from .identify import whittle
from .leastsquares import least_squares, slopes

AUTOMATIC = "QNBKR"


@dataclass(frozen=True)
class Method:
    """A way to identify: what it is, whether it needs the record or a curve, and the function."""

    title: str
    takes: type
    fit: Callable[..., Fit]


METHODS: dict[str, Method] = {
    "whittle": Method("likelihood of the cosine transform's binned powers, profile intervals", Record, whittle),
    "ls": Method("unweighted least squares of the Allan variance (for comparison with papers)", Curve, least_squares),
    "slopes": Method("lines of the textbook slopes on the Allan deviation (for comparison)", Curve, slopes),
}


def identify(
    source: Record | Curve,
    method: str | None = None,
    *,
    terms: str = "auto",
    band: tuple[float, float] | None = None,
    lines: bool = True,
) -> Fit:
    """Find the noise coefficients of a record, or of an Allan curve.

    Parameters
    ----------
    source : Record or Curve
    method : {"whittle", "ls", "slopes"}, optional
        "whittle" for a record, the default there: reaches the Cramer-Rao bound and gives intervals. The others read an
        Allan curve (that of the record, at octaves, if a record is given) and give numbers only; "ls" is the default
        for a curve.
    terms : str
        "auto" for Q, N, B, K and R, where Gauss-Markov noise (GM) takes the place of flicker if the record clearly says
        so; or symbols, for example "QNK" or "N,GM,K", which are obeyed.
    band : (low, high), optional
        Frequencies that count, Hz ("whittle" only).
    lines : bool
        Whether sinusoids are found, taken out and reported before the noise is identified ("whittle" only).

    Returns
    -------
    Fit
        Every term asked for is in it, absent ones with their upper limit.

    Raises
    ------
    UsageError
        Unknown method or term, or an option the method does not have.
    DataError
        The record is too short, constant, or not finite.

    Examples
    --------
    >>> import numpy as np
    >>> from allanite.model import N
    >>> from allanite.simulate import simulate
    >>> record = simulate(N(0.1, "deg/sqrt(h)"), 20_000, 100.0, rng=np.random.default_rng(1))
    >>> fit = identify(record)
    >>> low, high = fit["N"].interval(0.95)
    >>> fit["N"].status, fit["B"].status, low < fit.model["N"].value < high
    ('identified', 'absent', True)
    """
    name = method or ("whittle" if isinstance(source, Record) else "ls")
    if name not in METHODS:
        raise UsageError(f"unknown method {name!r}; known are {', '.join(METHODS)}")
    row = METHODS[name]
    symbols = _symbols(terms)
    if row.takes is not Record and (band is not None or not lines):
        raise UsageError(
            f"a band, and whether lines are taken out, is for methods that work on the record, not for {name!r}"
        )
    if isinstance(source, Curve) and row.takes is Record:
        raise UsageError(f"method {name!r} needs the record, not a curve of it")
    if isinstance(source, Record) and row.takes is Curve:
        source = deviation(source, "oadev")
    if row.takes is Record:
        return row.fit(source, symbols, band, lines=lines, rival=terms == "auto")
    return row.fit(source, symbols)


def _symbols(terms: str) -> tuple[str, ...]:
    """Symbols out of a text like ``QNGMK``: the longest that fits comes first, commas and blanks may stand between."""
    rest = AUTOMATIC if terms == "auto" else terms
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
