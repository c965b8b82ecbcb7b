"""Whitening of a record, white if the model is right; correlations between channels beyond their models."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from allanite.core.aliases import public
from allanite.core.arrays import FloatArray, IntArray
from allanite.core.errors import DataError, UsageError
from allanite.core.fit import Fit
from allanite.core.model import Model, ModelLike, model_of
from allanite.core.record import Record, Recording
from allanite.core.residuals import Shared
from allanite.core.validity import Finding, Scope
from allanite.identification.likelihood.pieces import SHORT_TRANSFORM
from allanite.parallel.processes import spread
from allanite.phrases.phrase import Phrase, say, say_count
from allanite.prepare.gaps import Gaps, joined, whole
from allanite.prepare.outliers import demand_choice, treated

LEAST = 2  # samples that have a difference from their mean
MOST = 1e34  # size of the record over the noise of the model, up to which sums in single precision hold it
BLOCK = 64  # number of coefficients normalized together where the fit does not read

SINGLE_NODES, NODES_PER_OCTAVE = 64, 32
"""Number of coefficients whose variance is computed individually, and number per octave beyond, where it is smooth."""


@public
def whitened(record: Record, model: ModelLike, scope: Scope | None = None) -> NDArray[np.float32]:
    """Whiten a record with its model: white Gaussian noise of variance 1, if the model explains the record.

    Deterministic terms are subtracted. Each coefficient of the orthonormal DCT-II of the rest (missing samples are cut
    out) is divided by its standard deviation under the noise terms, and the result is transformed back.

    Parameters
    ----------
    record : Record
    model : Model, Term or Fit
        For example `Fit.model`.
    scope : Scope, optional
        Scope of the fit: its filter is part of the model, and at excluded frequencies the observed power replaces that
        of the model.

    Returns
    -------
    array of float32, shape (record.size,)
        NaN for missing samples. With quantization it is larger within `memory` samples of an end or a gap.

    Raises
    ------
    UsageError
        The model is of another signal, or has no noise.
    DataError
        Fewer than two samples are not missing.

    Examples
    --------
    >>> from allanite import K, N, simulate
    >>> model = N(1.0, "deg/sqrt(h)") + K(3.0, "deg/h/sqrt(h)")
    >>> u = whitened(simulate(model, 10_000, 10.0, rng=np.random.default_rng(1)), model)
    >>> bool(abs(u.std() - 1) < 0.02)
    True
    """
    model = model_of(model)
    if model.signal is not record.signal:
        raise UsageError(f"a model of a {model.signal.name} does not apply to a {record.signal.name}")
    y, gaps, kept = joined(record)
    if y.size < LEAST:
        raise DataError(f"{record.name!r} has {y.size} samples that are not missing: whitening needs {LEAST} or more")
    unit = record.rate_factor
    for term in model:
        wave = term.sampled(record.rate).waveform
        if wave is not None:
            shape = wave(record.size)
            y -= term.value * record.rate**term.row.power / unit * (shape if kept is None else shape[kept])
    y -= y.mean()
    # slow noise exceeds fast noise by a few thousand at most: single precision halves time and memory
    size, n = float(max(y.max(), -y.min())) or 1.0, y.size
    # reflected at the end, as the transform supposes it to go on, up to a size whose transform is fast
    c = np.empty(n if n < SHORT_TRANSFORM else scipy.fft.next_fast_len(n), np.float32)
    np.divide(y, size, out=c[:n], casting="same_kind")
    c[n:] = c[:n][::-1][: c.size - n]
    del y
    c = scipy.fft.dct(c, norm="ortho", overwrite_x=True)
    at, deviation = deviations(model, replace(gaps, size=c.size), record.rate)
    if scope is None or scope.whole:
        _divide(c, at, deviation, unit * size)
    else:
        step = record.rate / (2 * c.size)
        _divide(c, at, deviation * np.sqrt(np.interp(at * step, scope.frequency, scope.level)), unit * size)
        # scale coefficients that the fit does not use to a mean square of 1, block by block, in place
        low, high = scope.band
        spans = [(0.0, low), *scope.masks, (high, step * c.size)]
        for a, b in ((max(1, math.ceil(f / step)), min(c.size, math.floor(g / step) + 1)) for f, g in spans if f < g):
            starts = np.arange(a, b, BLOCK)
            if starts.size:
                count = np.diff(np.append(starts, b))
                power = np.add.reduceat(np.square(c[a:b], dtype=np.float64), starts - a) / count
                c[a:b] /= np.repeat(np.sqrt(np.maximum(power, np.finfo(np.float32).tiny)), count).astype(np.float32)
    u = scipy.fft.idct(c, norm="ortho", overwrite_x=True)[:n]
    for few in range(1, 17):  # the plans that scipy keeps: that of a long record is as large as the record
        scipy.fft.dct(np.zeros(few, np.float32))
    if kept is None:
        return np.asarray(u)
    everywhere = np.full(record.size, np.nan, dtype=np.float32)
    everywhere[kept] = u
    return everywhere


def levelled(record: Record, steps: Sequence[tuple[float, float]]) -> Record:
    """A record without steps of its bias, whose times in the record, s, and sizes, SI, are given."""
    if not steps:
        return record
    values = np.array(record.steps, dtype=np.float64)
    for time, size in steps:
        values[round(time * record.rate) :] -= size / record.rate_factor
    return replace(record, values=values, kind="increment" if record.integrated else record.kind)


def _divide(c: NDArray[np.float32], k: IntArray, deviation: FloatArray, unit: float) -> None:
    """Divide by the standard deviation in place; its inverse is interpolated linearly between the nodes k."""
    weight = unit / deviation
    if not np.abs(weight).max() < MOST:
        raise DataError(f"the record is more than {MOST:g} times as large as the model's noise; give another model")
    steps = np.arange(np.diff(k).max(initial=0), dtype=np.float64)
    c[0] = 0.0
    for a, b, start, slope in zip(k[:-1], k[1:], weight[:-1], np.diff(weight) / np.diff(k), strict=True):
        c[a:b] *= (start + slope * steps[: b - a]).astype(np.float32)
    c[k[-1] :] *= np.float32(weight[-1])


def deviations(model: Model, gaps: Gaps, rate: float) -> tuple[IntArray, FloatArray]:
    """Some coefficients, the first and the last among them, and their standard deviations in SI."""
    n = gaps.size
    nodes = SINGLE_NODES * 2.0 ** np.arange(0, np.log2(n / SINGLE_NODES), 1 / NODES_PER_OCTAVE)
    k = np.unique(
        np.concatenate((np.arange(1, min(SINGLE_NODES, n - 1) + 1), np.rint(nodes).astype(np.int64), [n - 1]))
    )
    k = k[k < n]
    at = k.astype(np.float64)
    rows = [(t.power(rate), t.sampled(rate)) for t in model]
    noise = [(power, row) for power, row in rows if row.waveform is None and power > 0]
    if not noise:
        raise UsageError(f"whitening needs a model with noise, unlike {model}")
    # the contribution of an open angle at ends and joints is absent in between
    return k, np.sqrt(sum(power * gaps.row(replace(row, edge=0.0, ends=0.0), at) for power, row in noise))


def memory(model: Model, size: int, rate: float) -> int:
    """Distance in samples from an end or a gap within which an open angle matters; 0 without angle noise."""
    # The whitening spreads what quantization has there over as many samples as the standard deviation of the fastest
    # noise exceeds that of the least.
    if not any(t.row.edge or t.row.ends for t in model):
        return 0
    _, deviation = deviations(model, whole(size), rate)
    return math.ceil(2 * float(deviation.max() / deviation.min()))


STRETCHES = 64  # parts of the record over which slow residuals are averaged
SIGMAS, MATTERS = 5.0, 0.05  # standard errors, and size, above which a correlation is reported


@public
def shared(recording: Recording, fits: Mapping[str, Fit], *, outliers: str = "mark", threads: int = 1) -> Shared:
    """Correlations between the residuals of channels, which separate models of the channels cannot describe.

    Parameters
    ----------
    recording : Recording
    fits : name of a channel -> Fit
        At least two, as returned by ``identify(recording)``.
    outliers : {"mark", "keep"}
        How the fits treated outliers.
    threads : int
        Channels that are processed at once; the result is the same.

    Returns
    -------
    Shared
        "fast", of all samples, with standard error 1/sqrt(n); and "slow", of means over 64 stretches of the record,
        with standard error 1/8, which shows common effects over minutes and hours, such as temperature.

    Raises
    ------
    UsageError
        There are fewer than two fits, or their channels differ in length.

    Examples
    --------
    >>> from allanite import N, Record, identify
    >>> noise = np.random.default_rng(1).standard_normal((3, 20_000))
    >>> channels = [Record(noise[i] + noise[2], 100.0, "deg/s", name=name) for i, name in enumerate("xy")]
    >>> recording = Recording(tuple(channels))
    >>> found = shared(recording, identify(recording))
    >>> round(float(found.fast[0, 1]), 1), [finding.name for finding in found.findings]
    (0.5, ['shared'])
    """
    demand_choice(outliers)
    names = [name for name in recording.channels if name in fits]
    if len(names) < 2 or len({recording[name].size for name in names}) > 1:
        raise UsageError(f"correlations need at least two channels of equal length, not {', '.join(names) or 'none'}")

    def left(name: str) -> NDArray[np.float32]:
        record = treated(recording[name], outliers)
        u = whitened(record, fits[name].model, fits[name].scope)
        u[np.isnan(u)] = 0.0  # missing samples do not contribute
        return u

    series = spread(left, names, threads)
    bounds = np.linspace(0, series[0].size, STRETCHES + 1).astype(np.int64)[:-1]
    means = [np.add.reduceat(u, bounds, dtype=np.float64) for u in series]
    fast, slow = _correlations(series), _correlations(means)
    length = series[0].size / recording[names[0]].rate / STRETCHES
    pairs = (
        _finding(names, fast, series[0].size, say("sample by sample")),
        _finding(names, slow, STRETCHES, say("in means over {length:.3g} s", length=length)),
    )
    return Shared(tuple(names), fast, slow, tuple(filter(None, pairs)))


def _finding(names: Sequence[str], correlations: FloatArray, count: int, how: Phrase) -> Finding | None:
    """The pairs of channels with a significant correlation of so many values."""
    size = np.abs(np.triu(correlations, 1))
    z = np.arctanh(np.minimum(size, 0.999999)) * np.sqrt(count - 3)
    pairs = int(((size > MATTERS) & (z > SIGMAS)).sum())
    if not pairs:
        return None
    i, j = divmod(int(size.argmax()), len(names))
    what = say_count(pairs, "the residuals of {channel} and {other} are correlated {how} ({correlation:+.2g})",
                     "the residuals of {count} pairs of channels are correlated {how}, most of all those of "
                     "{channel} and {other} ({correlation:+.2g})",
                     channel=names[i], other=names[j], how=how, correlation=correlations[i, j])  # fmt: skip
    remedy = say("look for vibration, temperature, or a common supply, clock or reference")
    return Finding("shared", what, say("their noises are not independent"), remedy)


def _correlations(series: Sequence[NDArray[Any]]) -> FloatArray:
    products = np.zeros((len(series), len(series)))
    for i, a in enumerate(series):
        products[i, : i + 1] = products[: i + 1, i] = [float(a @ b) for b in series[: i + 1]]
    size = np.sqrt(np.diag(products))
    return np.asarray(products / np.outer(size, size))
