"""Power spectral density of a record: the methods by name, averages over bands, and deviations from a spectrum."""

import math
from collections.abc import Sequence
from dataclasses import fields, replace
from typing import Any, Unpack

import numpy as np

from allanite.core.aliases import public
from allanite.core.arrays import FloatArray, IntArray
from allanite.core.curve import Curve
from allanite.core.errors import UsageError, given
from allanite.core.kinds import signal_of_kind
from allanite.core.names import demand_name
from allanite.core.plain import Header
from allanite.core.record import Record, Samples, Sampling, as_record
from allanite.core.spectrum import SIDES, Spectrum, side_factor
from allanite.core.threads import one_thread
from allanite.core.units import signal_with, unit_of
from allanite.statistics.row import Statistic
from allanite.statistics.table import STATISTICS, statistic_named

from .estimators import Multitaper, Raw, SpectralEstimator, Welch

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
    """The method of `METHODS` with other settings; an unknown setting is an error that lists the known ones."""
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
    if isinstance(bins, bool) or not isinstance(bins, (int, np.integer)) or not 1 <= bins <= MAX_PER_DECADE:
        raise UsageError(f"bins is the number of values per decade, from 1 to {MAX_PER_DECADE}, not {given(bins)}: "
                         "omit it to have all")  # fmt: skip
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


RESOLVED = 1 / 8
"""Averaging time times the resolution of the spectrum, at most: the transfer function peaks near 0.37/tau."""

POINTS_PER_PERIOD = 8  # points of the integral in each period of the transfer function
MAX_BAND_POINTS = 4096  # points in a band, beyond which only the mean over many periods counts


@public
def deviation_of_spectrum(
    spectrum: Spectrum, statistic: str = "oadev", *, taus: str | Sequence[float] | FloatArray = "octave"
) -> Curve:
    """The deviation that a power spectral density amounts to.

    Its square is the integral of the density times the transfer function of the statistic for sampled rates: of the
    Allan variance ``2 sin^4(pi f tau) / (m sin(pi f tau0))^2``, one-sided.

    The bandwidth is that of the spectrum. Above, it ends at half the sampling rate, and aliases are in the density
    already. Below the lowest frequency the density is taken as constant: what is slower is missing, and drift was
    removed by the estimator. Averaging times are therefore limited to an eighth of the inverse resolution, for Welch's
    method with its default segments about a hundredth of the record: for longer ones, use `deviation` of the record.

    Parameters
    ----------
    spectrum : Spectrum
        Of any method and convention of sides.
    statistic : str
        A statistic that is made of differences: adev, oadev, mdev, tdev, hdev, ohdev, haar.
    taus : "octave" or array_like, shape (k,)
        Averaging times, s: multiples of the sample interval; "octave" takes all powers of two that the resolution
        allows.

    Returns
    -------
    Curve
        SI, without intervals; `count` is the number of values of the spectrum.

    Raises
    ------
    UsageError
        The statistic is not one of differences, or an averaging time is not a multiple of the sample interval, or
        longer than the resolution allows.

    References
    ----------
    IEEE Std 952-2020; NIST SP 1065, section 7.2.

    Examples
    --------
    >>> from allanite import N, simulate, spectrum
    >>> record = simulate(N(1.0, "rad/sqrt(s)"), 100_000, 10.0, rng=np.random.default_rng(1))
    >>> curve = deviation_of_spectrum(spectrum(record), taus=[0.1, 1.0, 10.0])
    >>> curve.deviation.round(1).tolist()
    [3.2, 1.0, 0.3]
    """
    row = statistic_named(statistic)
    if not row.differences or row.order < 2:
        able = ", ".join(name for name, other in STATISTICS.items() if other.differences and other.order > 1)
        raise UsageError(f"{statistic} has no transfer function that is known here; a spectrum gives {able}")
    m = _factors(spectrum, row, taus)
    variance = np.array([_integral(spectrum, row, k) for k in m.tolist()])
    tau = m.astype(np.float64) * (row.tau_factor / spectrum.rate)
    unit = unit_of(spectrum.unit)
    # a measured angle is a signal of its own, the integral of a rate is not
    signal = signal_with(unit.dimension) or signal_of_kind(spectrum.unit, "value")
    if signal is None:
        raise UsageError(f"{spectrum.unit!r} is the unit of no signal")
    return Curve(
        statistic=row.name, m=m, tau=tau, variance=variance * unit.factor**2 * tau ** (2 * row.power),
        count=np.full(m.shape, spectrum.frequency.size), factor=np.ones(m.shape), unit=signal.si[row.power],
        rate=spectrum.rate, name=spectrum.name, history=spectrum.history,
    )  # fmt: skip


def _factors(spectrum: Spectrum, row: Statistic, taus: str | Sequence[float] | FloatArray) -> IntArray:
    """Averaging factors; an error if the spectrum does not resolve them."""
    slowest = max(spectrum.resolution, float(spectrum.frequency[0]))
    longest = RESOLVED / slowest
    if isinstance(taus, str):
        if taus != "octave":
            raise UsageError(f"taus must be 'octave' or averaging times in s, not {given(taus)}")
        octaves = int(np.log2(max(longest * spectrum.rate, 1.0)))
        return np.asarray(2 ** np.arange(octaves + 1), dtype=np.int64)
    wanted = np.atleast_1d(np.asarray(taus, dtype=np.float64)) * spectrum.rate / row.tau_factor
    m = np.rint(wanted)
    if not m.size or not np.all((m >= 1) & np.isfinite(m)) or np.abs(wanted - m).max() > 1e-6 * m.max():
        raise UsageError(f"averaging times must be multiples of the sample interval, {1 / spectrum.rate:g} s")
    if m.max() > longest * spectrum.rate * (1 + 1e-9):
        raise UsageError(
            f"a spectrum with a resolution of {slowest:.3g} Hz gives averaging times up to {longest:.3g} s, not "
            f"{m.max() / spectrum.rate:g} s: use longer segments, or the deviation of the record itself"
        )
    return m.astype(np.int64)


def _integral(spectrum: Spectrum, row: Statistic, m: int) -> float:
    """The variance for a unit sample interval: sum over the bands of density and integral of the transfer function."""
    # ends of the bands of a spectrum, Hz, from 0 to half the sampling rate; the first band has no value of its
    # own
    half = spectrum.width[0] / 2
    start = np.hypot(spectrum.frequency[0], half) - half  # the frequency of a band is the geometric mean of its ends
    inner = start + np.cumsum(spectrum.width[:-1])
    edges = np.concatenate(([0.0, start], np.minimum(inner, spectrum.rate / 2), [spectrum.rate / 2]))
    width = np.diff(edges)
    wanted = np.ceil(POINTS_PER_PERIOD * row.differences * m * width / spectrum.rate)
    points = np.clip(wanted, 1, MAX_BAND_POINTS).astype(np.int64)
    first = np.repeat(np.cumsum(points) - points, points)
    inside = (np.arange(points.sum()) - first + 0.5) * np.repeat(width / points, points)
    f = (np.repeat(edges[:-1], points) + inside) / spectrum.rate
    # squared magnitude of the transfer function of the rate, f in cycles a sample
    unit = np.sin(np.pi * f) ** 2  # the angle is the running sum of the rates, and `summed` that of the angle
    stride = np.sin(np.pi * f * m) ** 2
    norm = float(row.norm(np.array([m]))[0]) * float(m) ** 2
    gain = (np.add.reduceat(np.asarray((4 * stride) ** row.differences / (4 * unit) ** (1 + row.summed) / norm),
                            np.cumsum(points) - points) / points)  # fmt: skip
    density = np.concatenate((spectrum.density[:1], spectrum.density)) * 2 / SIDES[spectrum.sides]
    return float(density @ (gain * width))
