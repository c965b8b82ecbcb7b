"""Statistics of a record over averaging time: the table, the estimates, their expectation and confidence."""

import warnings
from collections.abc import Sequence
from functools import partial
from typing import Literal

import numpy as np

from allanite.core.averaged import Averaged, noise_choice
from allanite.core.curve import Curve, Law
from allanite.core.errors import DataError, LongJobWarning, UsageError
from allanite.core.model import Model, ModelLike, model_of
from allanite.core.record import Record
from allanite.core.units import Signal
from allanite.statistics.confidence.averaged import AveragedLaw
from allanite.statistics.confidence.bias import correction, demand_bias, mean_factors
from allanite.statistics.confidence.limits import AutomaticLaw, ModelLaw, power_laws, unit_term
from allanite.statistics.confidence.sparse import at_nodes, between, sparse, sparse_law
from allanite.statistics.moments.expect import expected as expected
from allanite.statistics.moments.moments import covariance as covariance
from allanite.statistics.moments.moments import edf as edf

from .estimator import Angle, estimate, with_means
from .estimator import integrated as integrated
from .grids import GRIDS as GRIDS
from .grids import checked, factors_of, times
from .row import BoolArray, FloatArray, IntArray, Statistic, seconds
from .table import STATISTICS as STATISTICS
from .table import Points
from .table import statistic_named as statistic_named

HIDDEN = 0.03
"""Variance without gaps over that of means of what is there, below which the latter tells nothing of the former.

Under any of the models that a fit leaves open.
"""

PATIENCE = 60.0
"""Seconds from which on a job is long enough to be warned of."""


def deviation(  # noqa: PLR0913 - each has a default, and is a choice of its own
    record: Record,
    statistic: str = "oadev",
    *,
    taus: str | Sequence[float] = "octave",
    m: Sequence[int] | None = None,
    noise: ModelLike | Literal["auto"] | None = "auto",
    bias: Literal["exact", "published", "model", "plain"] | None = None,
    gaps: Literal["means", "complete"] = "means",
    join: float = 0.2,
    divisor: int = 30,
    threads: int = 1,
) -> Curve:
    """A statistic of a record, for many averaging times at once.

    Parameters
    ----------
    record : Record
        NaN marks lost samples; `Curve.count` says how many windows are left.
    statistic : str
        A name in `STATISTICS`.
    taus : {"octave", "decade", "log", "all"} or sequence of float
        Averaging times: 1, 2, 4, 8 ... samples; 1, 2, 4, 10, 20, 40 ...; about 100, spaced evenly in the logarithm;
        every one; or seconds. The named grids reach to the statistic's largest averaging factor.
    m : sequence of int, optional
        Averaging factors instead of times; of theoh, those of oadev up to the joint and of Theo1 beyond.
    noise : Model, Term, Fit or "auto", optional
        The noise supposed for the confidence limits and for a bias: a fit as ``identify(record)``, over whose models
        they are averaged, a model that is known, or "auto" for the power law that is found at each tau; None for no
        limits.
    bias : {"exact", "published", "model", "plain"}, optional
        None for the plain definition, but of theobr and theoh "model" where a model is given as the noise: their own
        bias ratio supposes one kind of noise, and is 2 to 4 times too low in mixtures. "plain" is the definition in
        either case. "exact" divides the variance by its exact expectation over that of the
        statistic it estimates (totdev: oadev, mtotdev: mdev, theo1: oadev ...), "published" by the published factor;
        for theobr and theoh "model" puts the exact ratio in the place of their own. `Curve.factor` has the factor.
    gaps : {"means", "complete"}
        What a window with lost readings counts for. "means" of adev, oadev, hdev, ohdev and haar: where a tenth of the
        windows or more have lost some, all count in which a reading is left in each part, with the means of what is
        left and weights by their counts, so that white noise of the rate is met at every tau; what that means to other
        noise is divided out under the noise supposed, and is in the limits; where quantization at the joints makes more
        than 30 times the variance, a point is refused, or left out of a named grid. A reading between two lost ones
        does not count. "complete", and every other statistic: nothing.
    join : float
        Share of the record up to which theoh is the overlapped Allan deviation.
    divisor : {30, 6}
        Of the record's length, for the number of ratios that make the bias ratio of theobr and theoh; 6 as Stable32.
    threads : int
        How many to use at most; the numbers are the same but for the last digit.

    Returns
    -------
    Curve
        SI. A constant is removed before integrating, so that a bias costs no digits.

    Warns
    -----
    LongJobWarning
        It takes more than a minute.

    Raises
    ------
    DataError
        No window is complete, or the record is too short for what is asked.
    UsageError
        An unknown statistic or grid; a time that is not a multiple of what the statistic needs, or too long.

    Notes
    -----
    With gaps and means the variance is sum h^2 d^2 / (m sum h), where d is the difference of a window's means and 1/h
    the sum of b^2 / count over its parts, b = (-1, 1) or (1, -2, 1); it is that of complete windows where nothing is
    lost. Its degrees of freedom are those of the same windows, where the readings are.

    Of more than 300 averaging times the confidence limits (and factors of bias) are worked out at 130, evenly in the
    logarithm and closer at the end, and interpolated between them, to 2 % at most. Neighbours in ``taus="all"`` are
    all but the same number: it is for looking at (a vibration, an interval that a data sheet names), not for fitting.

    Of oadev, ohdev, mdev and their relatives every tau takes O(n log^2 n), and so does every run between gaps.

    Examples
    --------
    >>> record = Record([892.0, 809, 823, 798, 671, 644, 883, 903, 677], rate=1.0, unit="1", kind="rate")
    >>> deviation(record, "oadev", m=[1, 2]).deviation.round(5).tolist()
    [91.22945, 85.95287]
    """
    row = statistic_named(statistic)
    demand_bias(bias, row)
    if gaps not in ("means", "complete"):
        raise UsageError(f"of windows with gaps 'means' count or the 'complete' ones alone, not {gaps!r}")
    supposed = noise_choice(noise)
    if bias is None and row.parts and isinstance(supposed, Averaged):
        bias = "model"
    bias = None if bias == "plain" else bias
    if not 0 < join < 1:
        raise UsageError(f"theoh joins at a share of the record between 0 and 1, not {join!r}")
    if threads < 1:
        raise UsageError(f"threads are 1 or more, not {threads!r}")
    asked = factors_of(taus, row, record.size, record.rate, join) if m is None else m
    factors = checked(asked, row, record.size, join)
    _warn_of_long(row, record.size, factors, threads)
    angle = integrated(record, row.order)
    found = estimate(row, angle, factors, join=join, divisor=divisor, threads=threads)
    variance, count, factor = found if gaps == "complete" else with_means(row, angle, factors, found)
    whole = _complete(count, row, factors, named=m is None and isinstance(taus, str))
    factors, variance, count, factor = factors[whole], variance[whole], count[whole], factor[whole]
    places = angle.places if gaps == "means" else ()
    points = Points(row, factors, angle.runs, record.size, record.rate, join, bias != "model", places)
    each = np.ones((1, factors.size))
    if bias is not None:
        each = _corrections(points, bias, supposed, angle, record.signal)
        wanted = supposed.weight @ each if isinstance(supposed, Averaged) else each[0]
        variance, factor, each = variance * wanted / factor, wanted, each / wanted
    elif supposed is not None and len(places) > 1 and row.differences:
        each = _for_means(points, supposed, angle, record.signal)
        factor = supposed.weight @ each if isinstance(supposed, Averaged) else each[0]
        told = _told(each.min(axis=0), row, factors, named=m is None and isinstance(taus, str))
        variance, each, count = (variance * factor)[told], (each / factor)[:, told], count[told]
        factors, factor = factors[told], factor[told]
        points = points._replace(m=factors)
    return Curve(
        statistic=row.name,
        m=factors,
        tau=times(row, factors, record.size, join) / record.rate,
        variance=variance * (angle.scale / record.interval ** (1 - row.power)) ** 2,
        count=count,
        factor=factor,
        unit=record.signal.si[row.power],
        rate=record.rate,
        size=record.size,
        name=record.name,
        history=record.history,
        noise=model_of(noise) if noise is not None and noise != "auto" else None,
        law=_law(points, supposed, each, angle, record.signal),
    )


def _warn_of_long(row: Statistic, size: int, m: IntArray, threads: int) -> None:
    wait = seconds(row, size, m) / threads
    if wait > PATIENCE:
        warnings.warn(
            f"{row.name} at {m.size} averaging times of {size} samples takes about {wait / 60:.0f} min; "
            "taus='log' takes 100 of them",
            LongJobWarning,
            stacklevel=3,
        )


def _law(points: Points, noise: Averaged | str | None, bias: FloatArray, angle: Angle, signal: Signal) -> Law | None:
    """The confidence law, where there is one: a maximum has none, and the angle's own error only under white noise."""
    if noise is None or points.row.order < 2:
        return None
    if not isinstance(noise, Averaged):
        return sparse_law(points, lambda few: AutomaticLaw(few, angle, signal))
    if len(noise) == 1:
        return sparse_law(points, lambda few: ModelLaw(few, (noise.terms,)))
    place = {int(m): i for i, m in enumerate(points.m)}
    return sparse_law(points, lambda few: AveragedLaw(few, noise, bias[:, [place[int(m)] for m in few.m]]))


def _corrections(points: Points, bias: str, noise: Averaged | str | None, angle: Angle, signal: Signal) -> FloatArray:
    """What the plain variance is multiplied with under each model, shape (models, points)."""
    if noise is None:
        raise UsageError("a bias depends on the noise: pass noise=allanite.identify(record), or noise='auto'")
    if isinstance(noise, Averaged):
        under = [model for model, _ in noise]
        return np.array([sparse(points, partial(correction, bias=bias, models=[m], alpha=None)) for m in under])

    def automatically(few: Points) -> FloatArray:
        models, alpha = _by_power_law(few, angle, signal)
        return correction(few, bias, models, alpha)

    return sparse(points, automatically)[None]


def _by_power_law(points: Points, angle: Angle, signal: Signal) -> tuple[list[Model], list[int]]:
    """Unit models of the power laws found at the points, and their exponents."""
    laws = power_laws(points, angle)
    return [Model((unit_term(law.symbol, signal),)) for law in laws], [law.alpha for law in laws]


def _for_means(points: Points, noise: Averaged | str, angle: Angle, signal: Signal) -> FloatArray:
    """What a variance from means of what is there is multiplied with under each model, shape (models, points)."""
    if not isinstance(noise, Averaged):
        return sparse(points, lambda few: mean_factors(few, _by_power_law(few, angle, signal)[0])[0])[None]
    at = at_nodes(points)
    found = mean_factors(at, [noise.terms], noise.scale)
    return np.array([between(points, values) for values in found])


def _complete(count: IntArray, row: Statistic, m: IntArray, *, named: bool) -> BoolArray:
    """Which points have a window; a named grid leaves the others out, for a point that was asked for it is an error."""
    whole = count > 0
    if (named and whole.any()) or whole.all():
        return whole
    largest = f"; the largest with one is {m[whole].max()}" if whole.any() else ""
    raise DataError(f"the gaps leave no complete window of {row.name} at averaging factor {m[~whole].min()}{largest}")


def _told(factor: FloatArray, row: Statistic, m: IntArray, *, named: bool) -> BoolArray:
    """Which points tell of the noise and not of the joints alone; left out or refused as those without a window."""
    told = factor >= HIDDEN
    if named or told.all():
        return told
    first = int(np.flatnonzero(~told)[0])
    raise DataError(
        f"where readings were lost the angle is open, and noise of the angle makes {row.name} {1 / factor[first]:.3g} "
        f"times that of the record without gaps at averaging factor {m[first]}: it tells nothing there; take shorter "
        "times, or a record of the angle"
    )
