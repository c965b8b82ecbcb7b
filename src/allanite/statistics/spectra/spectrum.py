"""Power spectral density of a record: the methods by name, and their averages over bands."""

import math
from dataclasses import fields, replace
from typing import Any, Unpack

import numpy as np

from allanite.core.aliases import public
from allanite.core.arrays import FloatArray, IntArray
from allanite.core.errors import UsageError
from allanite.core.names import demand_name
from allanite.core.plain import Header
from allanite.core.record import Record, Samples, Sampling, as_record
from allanite.core.spectrum import Spectrum, side_factor
from allanite.core.threads import one_thread

from .multitaper import Multitaper
from .raw_spectrum import Raw, SpectralEstimator
from .welch import Welch

METHODS: dict[str, SpectralEstimator] = {"welch": Welch(), "multitaper": Multitaper()}
"""Methods by name, with their default settings."""

MAX_PER_DECADE = 1_000_000  # most values per decade: edges between them are computed before frequencies are counted


@public
@one_thread()
def spectrum(
    record: Samples,
    method: str | SpectralEstimator = "welch",
    *,
    sides: str = "one",
    bins: int | None = None,
    **sampling: Unpack[Sampling],
) -> Spectrum:
    """Estimate the power spectral density of a record.

    Parameters
    ----------
    record : Record or array, shape (n,)
        Missing samples (NaN) are skipped by Welch's method and refused by the multitaper method.
    method : {"welch", "multitaper"} or Welch or Multitaper
        A name selects the default settings.
    sides : {"one", "two"}
        Convention of the density.
    bins : int, optional
        Values per decade: values at adjacent frequencies are averaged and have more degrees of freedom. By default all
        frequencies of the method.
    **sampling
        `rate`, `unit`, `kind`, `scale` and `name` of a `Record`, for an array or a column of a table. Samples without a
        unit are dimensionless.

    Returns
    -------
    Spectrum
        SI, at positive frequencies below half the sampling rate. The frequency of an average is the geometric mean of
        its lowest and highest frequency.

    Raises
    ------
    UsageError
        A name is unknown, or a setting impossible.
    DataError
        The record is too short, or has gaps that the method cannot handle.

    Examples
    --------
    >>> from allanite import N, simulate
    >>> record = simulate(N(0.1, "deg/sqrt(h)"), 50_000, 100.0, rng=np.random.default_rng(1))
    >>> two = spectrum(record, sides="two", bins=1).to("deg/h")
    >>> float((two.amplitude[-1] / 60).round(2)), two.amplitude_unit
    (0.1, 'deg/h/sqrt(Hz)')
    >>> spectrum(record, Welch(segment=20.0), bins=1).frequency.size
    3
    """
    side_factor(sides)
    record = as_record(record, "spectrum", sampling, unit="1")
    record.demand_range()
    chosen = method_named(method) if isinstance(method, str) else method
    return of_raw(chosen.estimate(record), record, chosen.title, sides=sides, bins=bins)


def of_raw(raw: Raw, record: Record | Header, title: str, *, sides: str = "one", bins: int | None = None) -> Spectrum:
    """The averages over bands of the output of a method of this title."""
    factor = side_factor(sides)
    starts = _starts(raw.first, raw.density.size, bins)
    size = np.diff(np.append(starts, raw.density.size))
    k = raw.first + starts
    # degrees of freedom of means over k ... k + size - 1: 2 E^2 / Var, with the covariances of all pairs
    neighbours = _sum_of_pairs(raw.overlap, 1 - size, size)
    mirrored = _sum_of_pairs(raw.overlap, 2 * k, size) + _sum_of_pairs(
        raw.overlap, raw.period - 2 * (k + size - 1), size
    )
    return Spectrum(
        frequency=np.sqrt(k * (k + size - 1.0)) * raw.df, width=size * raw.df,
        density=np.add.reduceat(raw.density, starts) / size * factor,
        dof=np.asarray(2.0 * size**2 / (neighbours + mirrored)), unit=record.signal.unit, sides=sides, method=title,
        resolution=raw.resolution, rate=record.rate, name=record.name, history=record.history,
    )  # fmt: skip


def method_named(name: str, **settings: Any) -> SpectralEstimator:
    """The method of `METHODS` with other settings; an unknown setting is an error that lists the known ones.

    >>> method_named("welch", segment=20.0)
    Welch(segment=20.0, window='hann')
    """
    demand_name("method", name, METHODS)
    method: Any = METHODS[name]
    known = [field.name for field in fields(method)]
    for key in settings:
        if key not in known:
            raise UsageError(f"{key!r} is not a setting of {name!r}; its settings: {', '.join(known)}")
    return replace(method, **settings)  # type: ignore[no-any-return]


def _starts(first: int, size: int, bins: int | None) -> IntArray:
    """Where each bin starts, counted from the first frequency; a bin holds at least one."""
    if bins is None:
        return np.arange(size)
    if isinstance(bins, bool) or not isinstance(bins, (int, np.integer)) or bins < 1:
        raise UsageError(f"bins must be the number of values per decade, at least 1, not {bins!r}")
    if bins > MAX_PER_DECADE:
        raise UsageError(f"a spectrum has at most {MAX_PER_DECADE} values per decade, not {bins}: omit bins to have "
                         "all")  # fmt: skip
    decades = math.log10((first + size) / first)
    # edges lie half way between frequencies
    edges = (first - 0.5) * 10 ** (np.arange(math.ceil(decades * bins) + 1) / bins)
    starts = np.unique(np.ceil(edges).astype(np.int64)) - first
    return starts[starts < size]


def _sum_of_pairs(overlap: FloatArray, lowest: IntArray, size: IntArray) -> FloatArray:
    """Sum of c(lowest + i + j) over i, j = 0 ... size - 1: a second difference of the twice summed c."""
    end = overlap.size - 1
    once = np.cumsum(np.concatenate((overlap[:0:-1], overlap)))
    twice = np.cumsum(once)

    def summed(lag: IntArray) -> FloatArray:
        inside = np.clip(lag, -end, end)
        values = twice[inside + end] + once[-1] * (lag - inside)
        return np.where(lag < -end, 0.0, values)

    return summed(lowest + 2 * size - 2) - 2 * summed(lowest + size - 2) + summed(lowest - 2)
