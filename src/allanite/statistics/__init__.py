"""Statistics of a record over averaging time: the table, estimates, expectations and confidence intervals."""

import warnings
from collections.abc import Callable, Sequence
from functools import partial
from typing import Literal, NamedTuple

import numpy as np

from allanite.core.arrays import BoolArray, FloatArray, IntArray
from allanite.core.curve import Curve, Law, Surface as Surface
from allanite.core.errors import DataError, LongJobWarning as LongJobWarning, UsageError
from allanite.core.estimate import Averaged
from allanite.core.limits import Remembered
from allanite.core.model import Model
from allanite.core.record import Record
from allanite.core.threads import one_thread
from allanite.core.units import Signal
from allanite.phrases.phrase import join, say, spelled
from allanite.statistics.confidence.bias import BIASES, MEANS, Bias, chosen_bias, corrections
from allanite.statistics.confidence.limits import ModelLaw, PublishedLaw, models_of, power_laws
from allanite.statistics.confidence.sparse import sparse, sparse_law
from allanite.statistics.confidence.supposed import Assumption, AveragedLaw, LaterLaw, SupposedNoise, Supposing

from allanite.statistics.model_curves import (  # isort: skip
    Expectation as Expectation, Expectations as Expectations, expectation as expectation
)  # fmt: skip
from allanite.statistics.moments.moments import covariance as covariance, edf as edf, expected as expected
from allanite.terms import WHITE

from .estimator import AngleRecord, angle_scale, estimated, integrated as integrated
from .grids import GRIDS as GRIDS, agree, checked, factors_of, times
from .row import Statistic, seconds
from .table import STATISTICS as STATISTICS, CurvePoints, statistic_named as statistic_named

MIN_NOISE_SHARE = 0.05
"""Variance of white rate and angle noise without gaps over that of means of the remaining samples.

Below this ratio the joints dominate, and the slow noise could only be guessed.
"""

PATIENCE = 60.0  # duration in seconds above which a warning is given


def deviation(  # noqa: PLR0913 - each has a default, and is a choice of its own
    record: Record,
    statistic: str = "oadev",
    *,
    taus: str | Sequence[float] = "octave",
    m: Sequence[int] | None = None,
    noise: Supposing | None = "auto",
    bias: Literal["exact", "published", "model", "plain"] | None = None,
    gaps: Literal["means", "complete"] = "means",
    join: float = 0.2,
    divisor: int = 30,
    edf: Literal["exact", "published"] = "exact",
    power_law: bool = False,
    threads: int = 1,
    omit: bool = False,
    angle: AngleRecord | None = None,
) -> Curve:
    """Compute a statistic of a record at many averaging times: `allanite.deviation` without identification.

    The intervals assume `noise`; a function that returns it is called when intervals, or a bias correction, need it.
    Points of which gaps leave nothing are omitted from a named grid, and with `omit` from the `m` that are given.

    Examples
    --------
    >>> record = Record([892.0, 809, 823, 798, 671, 644, 883, 903, 677], rate=1.0, unit="1", kind="rate")
    >>> deviation(record, "oadev", m=[1, 2]).deviation.round(5).tolist()
    [91.22945, 85.95287]
    """
    row = statistic_named(statistic)
    assumed = Assumption(noise)
    correction = chosen_bias(bias, row, assumed.given)
    for demanded, reason in (
        (gaps in ("means", "complete"), f"gaps must be 'means' or 'complete', not {gaps!r}"),
        (0 < join < 1, f"join must be a share of the record between 0 and 1, not {join!r}"),
        (edf in ("exact", "published"), f"edf must be 'exact' or 'published', not {edf!r}"),
        (threads >= 1, f"the number of threads must be at least 1, not {threads!r}"),
    ):
        if not demanded:
            raise UsageError(reason)
    row = row.joined(join)
    asked, history = factors_of(taus, row, record.size, record.rate, nearest=True) if m is None else m, record.history
    factors = checked(asked, row, record.size)
    if m is None and not isinstance(taus, str) and not agree(taus, times(row, factors, record.size) / record.rate):
        history = (
            *history,
            say("averaging times rounded to those of {statistic} at {rate:g} Hz", statistic=row.name, rate=record.rate),
        )
    _warn_of_long(row, record.size, factors, threads)
    by_means = gaps == "means"
    with one_thread():
        means, places = estimated(record, row, factors, angle=angle, divisor=divisor, means=by_means, threads=threads)
    own_ratio, runs = correction is None or not correction.hybrid, [(size, 1) for _, size in places]
    points = CurvePoints(row, factors, runs, record.size, record.rate, own_ratio, places if by_means else ())
    later = Remembered((lambda: angle) if angle else partial(integrated, record, row.order))
    named = omit or (m is None and isinstance(taus, str))
    curve = CurveEstimate(points, *means, None, later, record.signal)
    curve = curve.only(_complete(curve.number, row, factors, named=named))
    if correction or (len(points.places) > 1 and row.differences and noise is not None):
        curve = _corrected(curve, correction, assumed.noise, named=named)
    # a maximum has no known distribution, and the RMS angle error only under white noise
    law = None if noise is None or row.order < 2 else _later(curve, assumed, published=edf == "published")
    return Curve(
        statistic=row.name, m=curve.points.m, tau=times(row, curve.points.m, record.size) / record.rate,
        variance=curve.variance * (angle_scale(record) / record.interval ** (1 - row.power)) ** 2, count=curve.number,
        factor=curve.factor, unit=record.signal.si[row.power], rate=record.rate, size=record.size, name=record.name,
        history=history, noise=assumed.model, law=law, supposes=law.words if law else None,
        alpha=_alphas(curve.points, later()) if power_law else None,
    )  # fmt: skip


def _warn_of_long(row: Statistic, size: int, m: IntArray, threads: int) -> None:
    wait = seconds(row, size, m) / threads
    if wait > PATIENCE:
        warnings.warn(
            f"{row.name} at {m.size} averaging times of {size} samples takes about {wait / 60:.0f} min; "
            + spelled("--taus log computes 100 of them", "taus='log' computes 100 of them"),
            LongJobWarning,
            stacklevel=3,
        )


class CurveEstimate(NamedTuple):
    """Points of a curve with their variances, numbers of windows and what the plain variances were multiplied with."""

    # Where there is a bias, under `each` model, shape (models, points).
    points: CurvePoints
    variance: FloatArray
    number: IntArray
    factor: FloatArray
    each: FloatArray | None
    angle: Callable[[], AngleRecord]
    signal: Signal

    def only(self, which: BoolArray) -> "CurveEstimate":
        """Some of the points."""
        points = self.points._replace(m=self.points.m[which])
        each = None if self.each is None else self.each[:, which]
        return self._replace(points=points, variance=self.variance[which], number=self.number[which],
                             factor=self.factor[which], each=each)  # fmt: skip


def _later(curve: CurveEstimate, assumed: Assumption, *, published: bool) -> LaterLaw:
    """The law under what is assumed of the noise, made when it is needed."""
    if published:
        return LaterLaw(Remembered(partial(_published, assumed.suppose)), partial(_published_law, curve))
    return LaterLaw(assumed.suppose, partial(_law, curve, corrected=assumed.late and bool(curve.points.row.parts)))


def _law(curve: CurveEstimate, noise: Averaged | Literal["auto"], *, corrected: bool) -> Law:
    """The confidence law; of a hybrid that is `corrected` by what the models expect, not by its own bias ratio."""
    points, each = curve.points, curve.each
    if not isinstance(noise, Averaged):
        return sparse_law(points, lambda few: ModelLaw(few, models_of(
            (law.symbol for law in power_laws(few, curve.angle())), curve.signal)))  # fmt: skip
    if each is None and corrected:
        points, each = points._replace(scattered=False), _corrections(curve, BIASES["model"], noise)
    bias = np.ones((len(noise), points.m.size)) if each is None else each / curve.factor
    if len(noise) == 1 and np.allclose(bias, 1):
        return sparse_law(points, lambda few: ModelLaw(few, (noise.terms,)))
    place = {int(m): i for i, m in enumerate(points.m)}
    return sparse_law(points, lambda few: AveragedLaw(few, noise, bias[:, [place[int(m)] for m in few.m]]))


def _published(suppose: Callable[[], SupposedNoise]) -> SupposedNoise:
    """The power law at each averaging time, or the one term of a model; UsageError for a mixture."""
    noise, words = suppose()
    laws = [] if not isinstance(noise, Averaged) else [t.row.alpha for t in noise.terms]
    if isinstance(noise, Averaged) and (len(laws) > 1 or None in laws):
        raise UsageError("published degrees of freedom assume a power law at each tau: use noise='auto', or one term")
    return SupposedNoise(noise, say("{intervals}, with published degrees of freedom", intervals=words))


def _published_law(curve: CurveEstimate, noise: Averaged | Literal["auto"]) -> Law:
    if not isinstance(noise, Averaged):
        return PublishedLaw(curve.points, _alphas(curve.points, curve.angle()))
    return PublishedLaw(curve.points, np.full(curve.points.m.size, noise.terms.terms[0].row.alpha))


def _alphas(points: CurvePoints, angle: AngleRecord) -> IntArray:
    """The exponent of the power law found at each point."""
    return np.array([law.alpha for law in power_laws(points, angle)], dtype=np.int64)


def _corrected(
    curve: CurveEstimate, bias: Bias | None, noise: Averaged | Literal["auto"] | None, *, named: bool
) -> CurveEstimate:
    """Without the bias, or that of means of what is there, and then without the points that tell nothing."""
    each = _corrections(curve, bias or MEANS, noise)
    wanted = noise.weight @ each if isinstance(noise, Averaged) else each[0]
    curve = curve._replace(variance=curve.variance * wanted / curve.factor, factor=wanted, each=each)
    return curve if bias else curve.only(_told(curve, noise, named=named))


def _corrections(curve: CurveEstimate, bias: Bias, noise: Averaged | Literal["auto"] | None) -> FloatArray:
    """What the plain variance is multiplied with under each model, or the power laws, shape (models, points)."""
    if noise is None:
        raise UsageError(
            "a bias correction depends on the noise: pass noise=allanite.identify(record), or noise='auto'"
        )
    if isinstance(noise, Averaged):
        return sparse(curve.points, partial(corrections, bias=bias, models=[noise.terms], scale=noise.scale))

    def automatically(few: CurvePoints) -> FloatArray:
        laws = power_laws(few, curve.angle())
        models = models_of((law.symbol for law in laws), curve.signal)
        return corrections(few, bias, models, np.ones((1, 1)), [law.alpha for law in laws])

    return sparse(curve.points, automatically)


def _complete(count: IntArray, row: Statistic, m: IntArray, *, named: bool) -> BoolArray:
    """Which points have a window; a named grid omits the others, but a requested point without a window is an error."""
    whole = count > 0
    if (named and whole.any()) or whole.all():
        return whole
    none = say("the gaps leave no complete window of {statistic} at averaging factor {m}", statistic=row.name,
               m=m[~whole].min())  # fmt: skip
    largest = [say("the largest with one is {m}", m=m[whole].max())] if whole.any() else []
    raise DataError(join("; ", (none, *largest)))


def _told(curve: CurveEstimate, noise: Averaged | Literal["auto"] | None, *, named: bool) -> BoolArray:
    """Which points tell of the noise and not of the joints alone; omitted or refused as those without a window."""
    # Slow noise has no voice: where the joints rule, it is known from the supposed models only.
    row, m, factor = curve.points.row, curve.points.m, curve.factor
    if isinstance(noise, Averaged):
        fast = [i for i, t in enumerate(noise.terms) if t.row.edge or t.row.slope == WHITE]
        if not fast:
            return np.ones(m.size, dtype=np.bool_)
        part = Averaged(Model(tuple(noise.terms.terms[i] for i in fast)), noise.scale[:, fast], noise.weight)
        factor = noise.weight @ _corrections(curve, MEANS, part)
    told = np.asarray(factor >= MIN_NOISE_SHARE)
    if named or told.all():
        return told
    first = int(np.flatnonzero(~told)[0])
    raise DataError(say("where samples are missing the angle is open, and angle noise makes {statistic} {factor:.3g} "
                        "times that of the record without gaps at averaging factor {m}, so that it carries no "
                        "information; use shorter times, or a record of the angle", statistic=row.name,
                        factor=1 / factor[first], m=m[first]))  # fmt: skip
