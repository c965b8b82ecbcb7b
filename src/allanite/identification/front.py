"""Identification by any of the methods: their table, the choice of one, and of what it reads."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, TypedDict, Unpack, overload

from allanite.core.curve import Curve
from allanite.core.errors import DataError, UsageError
from allanite.core.fit import Fit
from allanite.core.record import Record, Recording
from allanite.core.scope import Band, demand_band
from allanite.prepare import outliers as robust
from allanite.statistics import deviation
from allanite.terms import TERMS

from .curves.allan_hadamard import joint
from .curves.gls import gls
from .curves.leastsquares import least_squares, slopes
from .curves.nonnegative import nnls
from .curves.piecewise import piecewise
from .likelihood.identify import whittle
from .methods import Method, symbols_of

METHODS: dict[str, Method] = {
    "whittle": Method(
        "likelihood of the cosine transform's binned powers, intervals averaged over models", Record, whittle,
        efficiency="0.93 to 1.14 times the Cramer-Rao bound",
        options=("band", "lines", "rival"), shapes=True, signed=True,
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


class Choices(TypedDict, total=False):
    """What may be said beside the method; see `identify`."""

    terms: str
    statistic: str | None
    band: Band | None
    lines: bool
    ranges: Mapping[str, tuple[float, float]] | None
    outliers: str


@overload
def identify(source: Record | Curve, method: str | None = ..., **choices: Unpack[Choices]) -> Fit: ...


@overload
def identify(source: Recording, method: str | None = ..., **choices: Unpack[Choices]) -> dict[str, Fit]: ...


def identify(
    source: Record | Curve | Recording,
    method: str | None = None,
    *,
    terms: str = "auto",
    statistic: str | None = None,
    band: Band | None = None,
    lines: bool = True,
    ranges: Mapping[str, tuple[float, float]] | None = None,
    outliers: str = "mark",
) -> Fit | dict[str, Fit]:
    """Find the noise coefficients of a record, or of a curve of it.

    Lost readings (NaN) are cut out, and what the joints do to each term is accounted for.

    Parameters
    ----------
    source : Record, Curve or Recording
        A recording is identified channel by channel.
    method : {"whittle", "gls", "joint", "nnls", "piecewise", "ls", "slopes"}, optional
        "whittle" for a record, the default there: reaches the Cramer-Rao bound and gives intervals. "gls", the default
        for a curve, is the best that reads one, and gives standard errors. The others are what papers and programs do,
        for comparison: numbers only. `METHODS` says how far each is from the bound.
    terms : str
        "auto" for Q, N, B, K and R, where Gauss-Markov noise (GM) takes the place of flicker if the record clearly says
        so ("whittle" only); or symbols, for example "QNK" or "N,GM,K", which are obeyed.
    statistic : str, optional
        Of the curve that is made of a record, for methods that read one; oadev if left out.
    band : {"auto", "all"} or (low, high), optional
        Frequencies that count, Hz ("whittle" only). "auto", the default there, reads all of them if the terms explain
        them; else it looks for a filter before the readings, leaves out resonances, and finds the widest band that the
        terms explain (`Fit.scope`).
    lines : bool
        Whether sinusoids are found, taken out and reported before the noise is identified ("whittle" only).
    ranges : mapping of symbol to (low, high), optional
        Averaging times, s, that a term is read from ("piecewise" only).
    outliers : {"mark", "keep"}
        Whether outliers count as lost ("whittle" and "joint" only); `Fit.notes` say how many and where.

    Returns
    -------
    Fit
        Every term asked for is in it, absent ones with their upper limit. Of a recording a dict: the fit of each
        channel that supports the job, by its name and in channel order.

    Raises
    ------
    UsageError
        Unknown method or term, or an option, a statistic or a term that the method does not have.
    DataError
        The record is too short or constant, holds infinite readings, or too little of it is left; of a recording,
        none of its channels supports the job.

    Examples
    --------
    >>> import numpy as np
    >>> from allanite.core.model import N
    >>> from allanite.simulation.record import simulate
    >>> record = simulate(N(0.1, "deg/sqrt(h)"), 20_000, 100.0, rng=np.random.default_rng(1))
    >>> fit = identify(record)
    >>> low, high = fit["N"].interval(0.95)
    >>> fit["N"].status, fit["B"].status, low < fit.model["N"].value < high
    ('identified', 'absent', True)
    """
    if isinstance(source, Recording):
        same = Choices(terms=terms, statistic=statistic, band=band, lines=lines, ranges=ranges, outliers=outliers)
        return _by_channel(source, lambda record: identify(record, method, **same))
    name = method or ("whittle" if isinstance(source, Record) else "gls")
    if name not in METHODS:
        raise UsageError(f"unknown method {name!r}; known are {', '.join(METHODS)}")
    robust.demand_choice(outliers)
    if band is not None:
        demand_band(band)
    row = METHODS[name]
    symbols = symbols_of(terms)
    band = None if band == "auto" and "band" not in row.options else band  # nothing was asked for
    said = {"band": band, "lines": None if lines else False, "ranges": ranges}
    options: dict[str, Any] = {key: value for key, value in said.items() if value is not None}
    _demand(name, symbols, options)
    if "rival" in row.options:
        options["rival"] = terms == "auto"
    readable = _source(source, name, statistic)
    if not isinstance(readable, Record):
        return row.fit(readable, symbols, **options)
    found = robust.outliers(readable) if outliers == "mark" else None
    fit = row.fit(robust.marked(readable, found) if found else readable, symbols, **options)
    return _noted(fit, found, readable) if found else fit


def _demand(name: str, symbols: tuple[str, ...], options: dict[str, Any]) -> None:
    """Options and terms must be such as the method has."""
    row = METHODS[name]
    for key in options:
        if key not in row.options:
            have = ", ".join(repr(other) for other, one in METHODS.items() if key in one.options)
            raise UsageError(f"{key} is for method {have}, not for {name!r}")
    shaped = [s for s in symbols if TERMS[s].parameters]
    if shaped and not row.shapes:
        able = ", ".join(repr(other) for other, one in METHODS.items() if one.shapes)
        raise UsageError(
            f"method {name!r} finds coefficients only, and {shaped[0]} ({TERMS[shaped[0]].title}) has a shape as well: "
            f"use method {able}"
        )


def _source(source: Record | Curve, name: str, statistic: str | None) -> Record | Curve:
    """The record, or the curve that the method reads."""
    row = METHODS[name]
    if row.takes is Record:
        if statistic is not None:
            raise UsageError(f"method {name!r} reads no curve of a statistic that could be chosen")
        if isinstance(source, Curve):
            raise UsageError(f"method {name!r} needs the record, not a curve of it")
        return source
    wanted = statistic or (source.statistic if isinstance(source, Curve) else row.statistic)
    if wanted not in row.allowed:
        others = [other for other, one in METHODS.items() if wanted in one.allowed]
        able = f" (those that read {wanted}: {', '.join(others)})" if others else ""
        raise UsageError(f"method {name!r} reads {', '.join(row.allowed)}, not {wanted}{able}")
    if isinstance(source, Record):
        return deviation(source, wanted, taus=row.taus, gaps="complete")
    if wanted != source.statistic:
        raise UsageError(f"the curve is one of {source.statistic}, not of {wanted}")
    return source


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


def _noted(fit: Fit, found: robust.Outliers, record: Record) -> Fit:
    """The fit with a note on the outliers that it leaves out."""
    if not found.at.size:
        return fit
    note = f"{found.words(record)}: left out of the fit (--outliers keep counts them in)"
    return replace(fit, notes=(*fit.notes, note))
