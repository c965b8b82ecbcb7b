"""Expected curves of a model, for single rows and for hybrids."""

from collections.abc import Sequence

import numpy as np

from allanite.core.aliases import public
from allanite.core.arrays import FloatArray, IntArray
from allanite.core.errors import UsageError, given
from allanite.core.model import Model, ModelLike, model_of
from allanite.phrases.phrase import spelled
from allanite.statistics.grids import factors_of
from allanite.statistics.row import Statistic
from allanite.statistics.table import STATISTICS, statistic_named

from .moments import variances

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
    if not ((times > 0) & (times < TIMES)).all():
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
