"""Identification by any of the methods: the selection of a method and its input."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Unpack, overload

from allanite.core.aliases import public
from allanite.core.curve import Curve
from allanite.core.errors import DataError, UsageError
from allanite.core.fit import Fit
from allanite.core.names import demand_name
from allanite.core.plain import Portable
from allanite.core.ranges import demand_band
from allanite.core.record import Record, Recording, Samples, Sampling, as_source
from allanite.core.threads import one_thread
from allanite.core.validity import Band
from allanite.phrases.phrase import join, say, spelled
from allanite.prepare import outliers as robust
from allanite.readers.options import FrameLike
from allanite.statistics import deviation, statistic_named
from allanite.terms import TERMS

from .methods import METHODS, symbols_of
from .search.identify import Pending
from .search.pooling import Together, together


class Choices(Sampling, total=False):
    """Options other than the method; see `identify`."""

    terms: str | Sequence[str]
    statistic: str | None
    band: Band | None
    masks: Sequence[tuple[float, float]]
    lines: bool
    ranges: Mapping[str, tuple[float, float]] | None
    outliers: str


@overload
def identify(source: Recording | FrameLike, method: str | None = ..., **choices: Unpack[Choices]) -> dict[str, Fit]: ...


@overload
def identify(source: Samples | Curve, method: str | None = ..., **choices: Unpack[Choices]) -> Fit: ...


@public
def identify(  # noqa: PLR0913 - each is a choice of its own
    source: Samples | Curve | Recording | FrameLike,
    method: str | None = None,
    *,
    terms: str | Sequence[str] = "auto",
    statistic: str | None = None,
    band: Band | None = None,
    masks: Sequence[tuple[float, float]] = (),
    lines: bool = True,
    ranges: Mapping[str, tuple[float, float]] | None = None,
    outliers: str = "mark",
    **sampling: Unpack[Sampling],
) -> Fit | dict[str, Fit]:
    """Identify the noise coefficients of a record, or of a curve of it.

    Missing samples (NaN) are cut out, and the effect of the joints on each term is accounted for.

    Parameters
    ----------
    source : Record, Curve, Recording, array or table
        A recording, a table and the columns of an array of shape (n, channels) are identified channel by channel.
    method : {"whittle", "gls", "joint", "nnls", "piecewise", "ls", "curve", "slopes"}, optional
        "whittle", the default for a record, reaches the Cramer-Rao bound and gives intervals. "gls", the default for a
        curve, is the best method for curves and gives standard errors. The others are methods of papers and programs,
        for comparison, without intervals. `METHODS` lists the efficiency of each.
    terms : str or sequence of str
        "auto" for Q, N, B, K and R, and Gauss-Markov noise (GM, and GML for a second) beside them if there is clear
        evidence ("whittle" only); or symbols, for example "QNK", "N,GM,K" or ["N", "K"].
    statistic : str, optional
        Statistic of the curve computed from a record, for methods that fit a curve; by default oadev.
    band : {"auto", "all"} or (low, high), optional
        Frequencies to fit, Hz ("whittle" only). "auto", the default, uses all of them, and looks for a low-pass filter,
        vibration, steps, a warm-up and power of any other shape beside the terms (`Fit.components`); "all" looks for
        neither filter nor vibration, a band for no filter.
    masks : sequence of (low, high)
        Frequencies that are not used, Hz ("whittle" only), beside those that "auto" or a band leaves out.
    lines : bool
        Whether sinusoids are detected, removed and reported before the noise is identified ("whittle" only).
    ranges : mapping of symbol to (low, high), optional
        Range of averaging times, s, for each term ("piecewise" only).
    outliers : {"mark", "keep"}
        Whether outliers are excluded ("whittle" and "joint" only); `Fit.notes` say how many and where.
    **sampling
        `rate`, `unit`, `kind`, `scale` and `name` of a `Record`, for an array or a column of a table; `rate`, `unit`,
        `kind` and `scale` as for `read` for a table.

    Returns
    -------
    Fit
        With every requested term, absent ones with their upper limit. For a recording a dict with the fit of each
        usable channel, by name and in channel order.

    Raises
    ------
    UsageError
        The method or term is unknown, or the method does not support an option, statistic or term.
    DataError
        The record is too short or constant, contains infinite samples, or has too few samples left; for a recording, no
        channel is usable.

    Examples
    --------
    >>> import numpy as np
    >>> from allanite import N, simulate
    >>> record = simulate(N(0.1, "deg/sqrt(h)"), 20_000, 100.0, rng=np.random.default_rng(1))
    >>> fit = identify(record)
    >>> low, high = fit["N"].interval(0.95)
    >>> fit["N"].status, fit["B"].status, low < fit.model["N"].value < high
    ('identified', 'absent', True)
    """
    source = as_source(source, "identify", sampling)  # a table becomes a recording, an array a record
    begin = partial(
        started, method=method, terms=terms, statistic=statistic, band=band, masks=masks, lines=lines, ranges=ranges,
        outliers=outliers,
    )  # fmt: skip
    if isinstance(source, Recording):
        return _by_channel(source, begin)
    if not isinstance(source, Record | Curve):
        raise UsageError(f"identify takes a record, samples or a curve, not a {type(source).__name__}")
    return begin(source).fit()


@dataclass(frozen=True, eq=False)
class Started(Portable):
    """An identification that is not concluded: a search, or the fit of a method that has none; `notes` come last."""

    search: Pending | Fit
    notes: tuple[str, ...] = ()

    def fit(self, shared: Together | None = None) -> Fit:
        """The fit, behind a filter that channels have in common if there is one."""
        with one_thread():
            fit = self.search.fit(shared) if isinstance(self.search, Pending) else self.search
        return replace(fit, notes=(*fit.notes, *self.notes))


def finished(begun: Sequence[Started]) -> list[Callable[[], Fit]]:
    """The fits of the channels of a recording, each to be made: those of one kind may have a filter in common."""
    searches = [(i, s.search) for i, s in enumerate(begun) if isinstance(s.search, Pending)]
    with one_thread():
        shared = dict(zip([i for i, _ in searches], together([s for _, s in searches]), strict=True))
    return [partial(s.fit, shared.get(i)) for i, s in enumerate(begun)]


def started(  # noqa: PLR0913 - each is a choice of its own
    source: Record | Curve,
    method: str | None = None,
    *,
    terms: str | Sequence[str] = "auto",
    statistic: str | None = None,
    band: Band | None = None,
    masks: Sequence[tuple[float, float]] = (),
    lines: bool = True,
    ranges: Mapping[str, tuple[float, float]] | None = None,
    outliers: str = "mark",
) -> Started:
    """Search for the noise of a record or curve; parameters and exceptions are those of `identify`."""
    name = method or ("whittle" if isinstance(source, Record) else "gls")
    demand_name("method", name, METHODS, choice="method")
    robust.demand_choice(outliers)
    if band is not None:
        demand_band(band)
    row = METHODS[name]
    symbols = symbols_of(terms)
    band = None if band == "auto" and "band" not in row.options else band  # no option was given
    given = {"band": band, "masks": masks if len(masks) else None, "lines": None if lines else False, "ranges": ranges}
    options: dict[str, Any] = {key: value for key, value in given.items() if value is not None}
    _demand(name, symbols, options)
    if "rival" in row.options:
        options["rival"] = terms == "auto"
    readable = _source(source, name, statistic)
    if outliers == "mark" and isinstance(readable, Record):
        outlying = robust.outliers(readable)
        with one_thread():
            search = row.begin(robust.marked(readable, outlying), symbols, **options)
        if not outlying.at.size:
            return Started(search)
        note = say("{outliers}: excluded from the fit ({option} includes them)",
                   outliers=outlying.words(readable), option=spelled("--outliers keep", "outliers='keep'"))  # fmt: skip
        return Started(search, (note,))
    with one_thread():
        return Started(row.begin(readable, symbols, **options))


def _demand(name: str, symbols: tuple[str, ...], options: dict[str, Any]) -> None:
    """Check that the method supports the options and terms."""
    row = METHODS[name]
    for key in options:
        if key not in row.options:
            have = ", ".join(repr(other) for other, method in METHODS.items() if key in method.options)
            raise UsageError(f"{key} is for method {have}, not for {name!r}")
    shaped = [s for s in symbols if TERMS[s].parameters]
    if shaped and not row.shapes:
        able = ", ".join(repr(other) for other, method in METHODS.items() if method.shapes)
        raise UsageError(
            f"method {name!r} estimates coefficients only, and {shaped[0]} ({TERMS[shaped[0]].title}) has shape "
            f"parameters as well: use method {able}"
        )


def _source(source: Record | Curve, name: str, statistic: str | None) -> Record | Curve:
    """The record, or the curve that the method fits."""
    row = METHODS[name]
    if row.takes is Record:
        if statistic is not None:
            raise UsageError(f"method {name!r} does not fit a curve of a selectable statistic")
        if isinstance(source, Curve):
            raise UsageError(f"method {name!r} needs the record, not a curve")
        return source
    wanted = statistic_named(statistic or (source.statistic if isinstance(source, Curve) else row.statistic)).name
    if wanted not in row.allowed:
        others = [other for other, method in METHODS.items() if wanted in method.allowed]
        able = f" (methods that fit {wanted}: {', '.join(others)})" if others else ""
        raise UsageError(f"method {name!r} fits {', '.join(row.allowed)}, not {wanted}{able}")
    if isinstance(source, Record):
        return deviation(source, wanted, taus=row.taus, gaps="complete")
    if wanted != source.statistic:
        raise UsageError(f"the curve is one of {source.statistic}, not of {wanted}")
    return source


def _by_channel(recording: Recording, begin: Callable[[Record], Started]) -> dict[str, Fit]:
    """The fits that are possible; an error if there are none."""
    begun, fits, refusals = dict[str, Started](), dict[str, Fit](), list[str]()
    for record in recording:
        try:
            begun[record.name] = begin(record)
        except DataError as error:
            refusals.append(str(error))
    for name, fit in zip(begun, finished(list(begun.values())), strict=True):
        try:
            fits[name] = fit()
        except DataError as error:
            refusals.append(str(error))
    if not fits:
        raise DataError(join("; ", refusals))
    return fits
