"""Identification of noise: from a record or a curve to coefficients."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import overload

from allanite.curve import Curve
from allanite.errors import DataError, UsageError
from allanite.fit import Fit
from allanite.record import Record, Recording
from allanite.statistics import deviation, robust
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


@overload
def identify(
    source: Record | Curve,
    method: str | None = ...,
    *,
    terms: str = ...,
    band: tuple[float, float] | None = ...,
    lines: bool = ...,
    outliers: str = ...,
) -> Fit: ...


@overload
def identify(
    source: Recording,
    method: str | None = ...,
    *,
    terms: str = ...,
    band: tuple[float, float] | None = ...,
    lines: bool = ...,
    outliers: str = ...,
) -> dict[str, Fit]: ...


def identify(
    source: Record | Curve | Recording,
    method: str | None = None,
    *,
    terms: str = "auto",
    band: tuple[float, float] | None = None,
    lines: bool = True,
    outliers: str = "mark",
) -> Fit | dict[str, Fit]:
    """Find the noise coefficients of a record, or of an Allan curve.

    Lost readings (NaN) are cut out, and what the joints do to each term is accounted for.

    Parameters
    ----------
    source : Record, Curve or Recording
        A recording is identified channel by channel.
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
    outliers : {"mark", "keep"}
        Whether outliers count as lost ("whittle" only); `Fit.notes` say how many and where.

    Returns
    -------
    Fit
        Every term asked for is in it, absent ones with their upper limit. Of a recording a dict: the fit of each
        channel that supports the job, by its name and in channel order.

    Raises
    ------
    UsageError
        Unknown method or term, or an option the method does not have.
    DataError
        The record is too short or constant, holds infinite readings, or too little of it is left; of a recording,
        none of its channels supports the job.

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
    if isinstance(source, Recording):

        def one(record: Record) -> Fit:
            return identify(record, method, terms=terms, band=band, lines=lines, outliers=outliers)

        return _by_channel(source, one)
    name = method or ("whittle" if isinstance(source, Record) else "ls")
    if name not in METHODS:
        raise UsageError(f"unknown method {name!r}; known are {', '.join(METHODS)}")
    robust.demand_choice(outliers)
    row = METHODS[name]
    symbols = symbols_of(terms)
    if row.takes is not Record and (band is not None or not lines):
        raise UsageError(
            f"a band, and whether lines are taken out, is for methods that work on the record, not for {name!r}"
        )
    if isinstance(source, Curve) and row.takes is Record:
        raise UsageError(f"method {name!r} needs the record, not a curve of it")
    if isinstance(source, Record) and row.takes is Curve:
        source = deviation(source, "oadev")
    if row.takes is Curve:
        return row.fit(source, symbols)
    assert isinstance(source, Record)  # noqa: S101 - a curve was refused above
    found = robust.outliers(source) if outliers == "mark" else None
    record = robust.marked(source, found) if found else source
    fit = row.fit(record, symbols, band, lines=lines, rival=terms == "auto")
    return _noted(fit, found, source.rate) if found else fit


def _by_channel(recording: Recording, fit: Callable[[Record], Fit]) -> dict[str, Fit]:
    """The fits that can be made, or why there is none."""
    fits, refusals = {}, []
    for record in recording:
        try:
            fits[record.name] = fit(record)
        except DataError as error:
            refusals.append(str(error))
    if not fits:
        raise DataError("; ".join(refusals))
    return fits


def _noted(fit: Fit, found: robust.Outliers, rate: float) -> Fit:
    """The fit with a note on the outliers that it leaves out."""
    if not found.at.size:
        return fit
    note = f"{found.words(rate)}: left out of the fit (--outliers keep counts them in)"
    return replace(fit, notes=(*fit.notes, note))


def symbols_of(terms: str) -> tuple[str, ...]:
    """Symbols out of a text like ``QNGMK``: the longest that fits comes first, commas and blanks may stand between.

    Raises
    ------
    UsageError
        One is unknown or stands twice, or none is noise.
    """
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
