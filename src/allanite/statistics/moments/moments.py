"""Expectation, covariance and degrees of freedom of every statistic under any model (docs/derivations.md)."""

import math
from collections import Counter
from collections.abc import Sequence
from itertools import combinations_with_replacement

import numpy as np

from allanite.core.aliases import public
from allanite.core.arrays import FloatArray, IntArray
from allanite.core.errors import UsageError, given
from allanite.core.model import Model, ModelLike, model_of
from allanite.phrases.phrase import spelled
from allanite.statistics.grids import checked, factors_of
from allanite.statistics.row import Statistic
from allanite.statistics.table import STATISTICS, statistic_named
from allanite.terms import NoiseTerm

from . import lagsums, windowed
from .profile import crossed
from .windowed import Pairs

RATIOS = 12  # number of ratios that are evaluated; the bias ratio is the mean of up to thousands, which vary smoothly


@public
def covariance(
    row: Statistic, model: ModelLike, m: IntArray, size: int, rate: float, *, join: float = 0.2, divisor: int = 30
) -> FloatArray:
    """Covariance between the variances at averaging factors `m` of one record without gaps, SI, shape (k, k).

    Exact for overlapping differences (oadev, ohdev, mdev, tdev), except for the quadrature, and for windows of up to
    750 points; for longer ones (theo1, pdev, mtotdev, ttotdev, htotdev) within 1 % of the two standard deviations, and
    within 0.1 % but for white angle noise. What noise and a ramp add together is exact for windows of up to 2^19
    points. That of theobr and theoh is of first order in the scatter of their bias ratio. Of a model with sinusoids,
    that of its noise.

    Raises
    ------
    UsageError
        It is not known: of totdev, maxima and windows that do not overlap.

    Examples
    --------
    >>> from allanite import N
    >>> C = covariance(STATISTICS["theo1"], N(1.0, "rad/sqrt(s)"), np.array([10, 20]), 1000, 1.0)
    >>> (np.sqrt(np.diag(C)) * [7.5, 15]).round(3).tolist()
    [0.068, 0.089]
    """
    row = row.joined(join)
    noise, m = noise_of(model_of(model)), checked(m, row, size)
    if not row.parts:
        return np.asarray(covariance_by_term([row] * m.size, noise, m, size, rate).sum(axis=(2, 3)))
    which = row.part_of(m, size)
    late = which == len(row.parts) - 1
    # some of the ratios i = 0 .. last, and the weight of each in their mean
    last = max((size + 1) // divisor - 3, 0)
    i = np.unique(np.rint(np.linspace(0, last, RATIOS)).astype(np.int64))
    weight = np.array([np.interp(np.arange(last + 1), i, row) for row in np.eye(i.size)]).mean(axis=1)
    allan, theo = STATISTICS[row.parts[-1].target], row.parts[-1]
    rows = [row.parts[k] for k in which] + [allan] * i.size + [theo] * i.size
    factors = np.concatenate((m, 9 + 3 * i, 12 + 4 * i))
    E = np.array([by_term(part, noise, int(k), size, rate).sum() for part, k in zip(rows, factors, strict=True)])
    a, t = E[m.size : m.size + i.size], E[m.size + i.size :]
    ratio = float(weight @ (a / t))
    slopes = np.zeros((m.size, E.size))
    slopes[:, : m.size] = np.diag(np.where(late, ratio, 1.0))
    slopes[:, m.size :] = np.outer(E[: m.size] * late, np.concatenate((weight / t, -weight * a / t**2)))
    C = covariance_by_term(rows, noise, factors, size, rate).sum(axis=(2, 3))
    return np.asarray(slopes @ C @ slopes.T)


Runs = Sequence[tuple[int, int]]  # (samples, how many such runs): the stretches without gaps of a record

DISTINCT = 40  # different lengths of runs that are processed one by one


def variances(row: Statistic, model: Model, m: FloatArray | IntArray, size: int | None, rate: float) -> FloatArray:
    """Expected variance of a model at averaging factors, SI, shape of m; errors as of `by_term`."""
    if not row.differences or any(t.row.transient for t in model):
        return np.array([by_term(row, model, int(k), size, rate).sum() for k in m])
    terms = [t.sampled(rate) for t in model]
    _demand_stationary(row, terms)
    E = np.array([t.power(rate) for t in model]) @ lagsums.responses(row, terms, m)
    return np.asarray(E * (m * row.tau_factor / rate) ** (2.0 * row.power))


def by_term(row: Statistic, model: Model, m: int, size: int | None, rate: float) -> FloatArray:
    """Expected variance of each term of a model, SI, shape (t,)."""
    # UsageError where the statistic has no expectation under one of the terms, or none without the record's length.
    E = _responses(row, [t.sampled(rate) for t in model], m, size) * np.array([t.power(rate) for t in model])
    return np.asarray(E * (m * row.tau_factor / rate) ** (2.0 * row.power))


def _responses(row: Statistic, terms: Sequence[NoiseTerm], m: int, size: int | None) -> FloatArray:
    if row.extreme:
        raise UsageError(f"{row.name} is a maximum: a model gives no expectation of it")
    alone = np.array([term.transient for term in terms])
    if alone.any():
        E = np.empty(len(terms))
        E[alone] = [_of_waveform(row, term, m, size) for term in terms if term.transient]
        E[~alone] = _responses(row, [term for term in terms if not term.transient], m, size) if not alone.all() else 0
        return E
    if row.differences:
        _demand_stationary(row, terms)
        return lagsums.responses(row, terms, np.array([m]))[:, 0]
    if size is None and not row.span[0]:
        raise UsageError(f"the expectation of {row.name} depends on the length of the record: pass size=...")
    E = np.empty(len(terms))
    periodic = np.array([term.periodic for term in terms])
    E[~periodic] = windowed.response(row, [term for term in terms if not term.periodic], m, size or 0)
    E[periodic] = [_of_sinusoid(row, term, m, size or 0) for term in terms if term.periodic]
    return E


def _of_waveform(row: Statistic, term: NoiseTerm, m: int, size: int | None) -> float:
    """A row's variance of a record that is a waveform of coefficient 1, for a unit sample interval."""
    if size is None or term.waveform is None:
        raise UsageError(
            f"the expectation of {row.name} under {term.symbol} ({term.title}) depends on the length of the record: "
            "pass size=..., or omit the term from the model"
        )
    factors = np.array([m])
    angle = np.concatenate(([0.0], np.cumsum(term.waveform(size))))
    angle -= np.linspace(0.0, angle[-1], angle.size)
    scale = row.norm(factors)[0] * float(m) ** 2 * row.count(size, factors)[0]
    return float(row.sums(angle, factors)[0] / scale)


def _of_sinusoid(row: Statistic, term: NoiseTerm, m: int, size: int) -> float:
    """Mean over all phases of a row's variance under a sinusoid of amplitude 1, for a unit sample interval."""
    # A quadratic form of ``cos(wt + phase)`` has as its mean over the phase half the sum of its values at cosine and
    # sine; one window is enough, but where the windows depend on the record.
    n = row.span[0] * m + row.span[1] if row.span[0] else size
    w = 2 * math.pi * term.shape[0]
    angle = w * np.arange(n + 1.0)
    factors = np.array([m])
    sums: list[FloatArray] = [row.sums(wave / w, factors) for wave in (np.cos(angle), np.sin(angle))]
    scale = row.norm(factors)[0] * float(m) ** 2 * row.count(n, factors)[0]
    return float((sums[0][0] + sums[1][0]) / 2 / scale)


def _demand_stationary(row: Statistic, terms: Sequence[NoiseTerm]) -> None:
    free = [
        term.symbol
        for term in terms
        if not (row.order > 1 if term.waveform is not None else term.growth < 2 * row.order)
    ]
    if free:
        raise UsageError(f"{row.name} under {', '.join(free)} depends on the record, not only on the model")


@public
def edf(row: Statistic, model: ModelLike, m: IntArray, runs: Runs | int, rate: float) -> FloatArray:
    """Equivalent degrees of freedom 2 E^2 / Var at averaging factors `m`, shape of m.

    Exact for the model's mixture except for the quadrature: 1e-7 for differences, below 1 % for windows. A single row,
    not a hybrid. Of a model with sinusoids, that of its noise.
    """
    model = noise_of(model_of(model))
    runs = [(runs, 1)] if isinstance(runs, int) else runs
    factors = checked(m, row, max((size for size, _ in runs), default=0))
    E, r = moments(row, [t.sampled(rate) for t in model], factors, [grouped(runs, row, k) for k in factors.tolist()])
    E *= [t.power(rate) for t in model]
    return np.asarray(E.sum(axis=1) ** 2 / np.einsum("ki,kij,kj->k", E, r, E))


def noise_of(model: Model) -> Model:
    """The part of a model that scatters; UsageError if there is none."""
    if model.noise is None:
        raise UsageError(f"{model} has no noise: confidence intervals need at least one noise term")
    return model.noise


def moments(
    row: Statistic, terms: Sequence[NoiseTerm], m: IntArray, runs: Sequence[Runs]
) -> tuple[FloatArray, FloatArray]:
    """E_i, shape (k, t), and r_ij, shape (k, t, t), at averaging factors with their own runs; unit sample interval."""
    # For terms of coefficient 1, none of which is periodic.
    if row.differences and not any(term.transient for term in terms):
        _demand_stationary(row, terms)
        E = lagsums.responses(row, terms, m).T
    else:
        sizes = [sum(n * times for n, times in own) for own in runs]
        E = np.array([_responses(row, terms, k, size) for k, size in zip(m.tolist(), sizes, strict=True)])
    return E * (m[:, None] * row.tau_factor) ** (2.0 * row.power), relative(row, terms, m, runs)


def relative(row: Statistic, terms: Sequence[NoiseTerm], m: IntArray, runs: Sequence[Runs]) -> FloatArray:
    """r_ij, shape (k, t, t): half the relative covariance that terms i and j give the variance."""
    if not row.differences:
        return np.array([_of_windows(row, terms, k, own) for k, own in zip(m.tolist(), runs, strict=True)])
    C = np.array([lagsums.covariance_of_windows(row, term, m, np.zeros(m.size)) for term in terms]).T
    removed = C == 0
    C = np.where(removed, 1.0, C)
    T = lagsums.products(row, terms, np.repeat(m[:, None], 2, axis=1), runs) / (C[:, :, None] * C[:, None])
    return np.where(removed[:, :, None] | removed[:, None], 0.0, T)


def _of_windows(row: Statistic, terms: Sequence[NoiseTerm], m: int, runs: Runs) -> FloatArray:
    """r_ij of a row whose windows are no difference, shape (t, t)."""
    counts = [int(row.count(size, np.array([m]))[0]) for size, _ in runs]
    whole = sum(count * times for count, (_, times) in zip(counts, runs, strict=True))
    samples = sum(n * times for n, times in runs)
    parts = [
        times * count**2 * windowed.relative(row, terms, m, count, samples)
        for count, (_, times) in zip(counts, runs, strict=True)
        if count
    ]
    return np.asarray(sum(parts) / whole**2)


def grouped(runs: Runs, row: Statistic, m: int) -> list[tuple[int, int]]:
    """The runs that hold a window of m, by their number of windows, each as the shortest run with as many."""
    # With very many different numbers, neighbours within a few per cent share the one nearest to their mean.
    if len(runs) == 1:
        return [(size, times) for size, times in runs if row.count(size, np.array([m]))[0] > 0]
    lengths = Counter[int]()
    for size, times in runs:
        lengths[size] += times
    sizes = np.array(sorted(lengths))
    windows = np.array([int(row.count(int(n), np.array([m]))[0]) for n in sizes])
    sizes, windows = sizes[windows > 0], windows[windows > 0]
    known, first, place = np.unique(windows, return_index=True, return_inverse=True)
    many = np.bincount(place.ravel(), [lengths[int(n)] for n in sizes], known.size).astype(np.int64)
    if known.size <= DISTINCT:
        return [(int(sizes[i]), int(times)) for i, times in zip(first, many, strict=True)]
    bins = np.digitize(known, np.geomspace(known[0], known[-1] + 1, DISTINCT + 1))
    merged = []
    for cell in np.unique(bins):
        here = np.flatnonzero(bins == cell)
        mean = np.average(known[here], weights=many[here])
        merged.append((int(sizes[first[here[np.abs(known[here] - mean).argmin()]]]), int(many[here].sum())))
    return merged


def covariance_by_term(rows: Sequence[Statistic], model: Model, m: IntArray, size: int, rate: float) -> FloatArray:
    """What each pair of terms of a model without sinusoids adds to the covariance of points, shape (k, k, t, t)."""
    # Each point is that of a row, of which none is a hybrid, at an averaging factor; the record has no gaps.
    for row in rows:
        if row.window is None or not row.overlapped or row.parts:
            raise UsageError(f"the covariance between averaging times of {row.name} is not known")
    terms = [t.sampled(rate) for t in model]
    T = _products(rows, terms, m, size)
    tau = [(k * row.tau_factor / rate) ** (2.0 * row.power) for row, k in zip(rows, m.tolist(), strict=True)]
    scale = np.outer(tau, [t.power(rate) for t in model])
    return np.asarray(2 * T * scale[:, None, :, None] * scale[None, :, None, :])


def _products(rows: Sequence[Statistic], terms: Sequence[NoiseTerm], m: IntArray, size: int) -> FloatArray:
    """T_ij of variances of the rate for coefficients of 1 and a unit sample interval, shape (k, k, t, t)."""
    random = np.array([term.waveform is None for term in terms])
    noise = [term for term in terms if term.waveform is None]
    T = np.zeros((m.size, m.size, len(terms), len(terms)))
    if not random.all() and not all(row is rows[0] and row.differences for row in rows):
        T[:, :, random] = crossed(rows, m, size, noise)[..., None] * ~random
        T += T.swapaxes(2, 3)
    pairs = Pairs(noise)
    for i, j in combinations_with_replacement(range(m.size), 2):
        pair, factors = (rows[i], rows[j]), (int(m[i]), int(m[j]))
        if rows[i] is rows[j] and rows[i].differences:
            scale = rows[i].norm(np.array(factors)) * np.array(factors) ** 2.0
            own = lagsums.products(rows[i], terms, np.sort(m[None, [i, j]]), [[(size, 1)]])[0]
            T[i, j] = np.asarray(own / scale.prod())
        else:
            T[i, j][np.ix_(random, random)] = pairs.products(pair, factors, size)
        T[j, i] = T[i, j]
    return T


TIMES = 1e100  # averaging times, s, below which their cubes are numbers


@public
def expected(
    model: ModelLike,
    statistic: str,
    tau: float | Sequence[float] | FloatArray,
    *,
    rate: float | None = None,
    size: int | None = None,
    join: float = 0.2,
    divisor: int = 30,
) -> FloatArray:
    """The exact expectation of a statistic's variance under a model.

    Parameters
    ----------
    model : Model, Term or Fit
    statistic : str
        A name in `STATISTICS`.
    tau : array_like, shape (k,)
        Averaging times, s.
    rate : float, optional
        Sampling rate, Hz; the differences adev, oadev, hdev, ohdev, haar do not need it.
    size : int, optional
        Samples of the record, on which totdev, theobr and theoh depend, and every statistic of a warm-up.
    join, divisor
        As for `deviation`.

    Returns
    -------
    array, shape (k,)
        Variance, SI.

    Raises
    ------
    UsageError
        The rate or the length is required, tau matches neither, or the statistic has no expectation.

    Examples
    --------
    >>> from allanite import N
    >>> expected(N(1.0, "rad/sqrt(s)"), "oadev", [1.0, 4.0]).tolist()
    [1.0, 0.25]
    """
    row = statistic_named(statistic).joined(join)
    model = model_of(model)
    times = np.atleast_1d(np.asarray(tau, dtype=np.float64))
    if not ((times >= 1 / TIMES) & (times < TIMES)).all():
        raise UsageError(f"averaging times must be above 0 s and below {TIMES:g} s, not {given(tau)}")
    if row.differences and not row.summed and not any(t.row.per_sample or t.row.transient for t in model):
        # no time but tau is in these: let it be the sample interval
        return variances(row, model, times, None, 1.0)
    if rate is None:
        raise UsageError(
            f"the expectation of {row.name} depends on the sampling rate: pass " + spelled("--rate HZ", "rate=...")
        )
    if row.parts and size is None:
        raise UsageError(
            f"the expectation of {row.name} depends on the length of the record: pass "
            + spelled("--duration TIME", "size=...")
        )
    m = factors_of(times.tolist(), row, size or 0, rate)
    return expected_at(row, model, m, size, rate, divisor=divisor)


def expected_at(
    row: Statistic, model: Model, m: IntArray, size: int | None, rate: float, *, divisor: int = 30
) -> FloatArray:
    """The expected variance at averaging factors, shape of m."""
    if not row.parts:
        return variances(row, model, m, size, rate)
    which = row.part_of(m, size or 0)
    plain = np.empty(len(m))
    for i in np.unique(which):
        plain[which == i] = variances(row.parts[i], model, m[which == i], size, rate)
    ratio = expected_ratio(row.parts[-1], model, size or 0, rate, divisor)
    return np.asarray(np.where(which == len(row.parts) - 1, ratio, 1.0) * plain)


def expected_ratio(theo1: Statistic, model: Model, size: int, rate: float, divisor: int) -> float:
    """Bias ratio of TheoBR, with each of its ratios at its expectation."""
    last = (size + 1) // divisor - 3
    i = np.unique(np.rint(np.linspace(0, max(last, 0), 60)).astype(np.int64))  # the ratio is smooth in i
    allan = variances(STATISTICS[theo1.target], model, 9 + 3 * i, size, rate)
    theo = variances(theo1, model, 12 + 4 * i, size, rate)
    everywhere = np.arange(max(last, 0) + 1)
    return float(np.mean(np.interp(everywhere, i, allan / theo)))
