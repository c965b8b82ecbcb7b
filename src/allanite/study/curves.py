"""Curves of records with intervals under their own noise, and where the bias ratio of hybrids is not that noise's."""

from collections.abc import Iterable, Sequence
from functools import partial
from typing import Literal, Unpack

import numpy as np

from allanite import statistics
from allanite.core.aliases import public
from allanite.core.curve import Curve
from allanite.core.errors import DataError
from allanite.core.model import ModelLike, model_of
from allanite.core.record import Record, Samples, Sampling, as_record
from allanite.identification import identify
from allanite.phrases.phrase import say, spelled
from allanite.prepare.quality import inspect
from allanite.statistics import STATISTICS
from allanite.statistics.confidence.supposed import SupposedNoise, Supposing, supposed
from allanite.statistics.moments.moments import by_term

SEEN = 0.05  # relative error of a deviation above which a note is given


def joints(curves: Iterable[Curve], noise: ModelLike) -> tuple[str, ...]:
    """A note for each curve whose bias ratio is wrong under this noise by more than 5 % of the deviation."""
    notes = list[str]()
    for curve in curves:
        parts = STATISTICS[curve.statistic].parts
        offset = np.abs(curve.tau * curve.rate / curve.m - parts[-1].tau_factor) if parts else np.ones(0)
        late = np.flatnonzero(offset < 1e-6)
        if not late.size:
            continue
        theo1, model, ratios = parts[-1], model_of(noise), list[float]()
        for i in late[[0, -1]].tolist():
            # expected deviation with the bias ratio of the curve over the Allan deviation
            own = by_term(theo1, model, int(curve.m[i]), curve.size, curve.rate).sum()
            aim = by_term(STATISTICS[theo1.target], model, 1, None, 1 / float(curve.tau[i])).sum()
            ratios.append(float(np.sqrt(curve.factor[i] * own / aim)))
        first, last = ratios
        if max(abs(first - 1), abs(last - 1)) < SEEN:
            continue
        notes.append(say(
            "the bias ratio of {statistic} assumes one kind of noise: under the identified noise the deviation is "
            "{first:.2f} times the Allan deviation at {start:g} s and {last:.2f} times at {end:g} s ({cure} "
            "corrects it)", statistic=curve.statistic, start=curve.tau[late[0]], end=curve.tau[late[-1]], first=first,
            last=last, cure=spelled("--bias model", "bias='model'")))  # fmt: skip
        if len(parts) > 1:
            what = say("{statistic} jumps there, where it passes from oadev to TheoBR", statistic=curve.statistic)
            notes.append(what)
    return tuple(notes)


REPEATED = 0.5  # share of samples equal to the previous one above which a record is piecewise constant


@public
def deviation(  # noqa: PLR0913 - each has a default, and is a choice of its own
    record: Samples, statistic: str = "oadev", taus: str | Sequence[float] = "octave", *,
    m: Sequence[int] | None = None, noise: ModelLike | Literal["identified", "auto"] | None = "identified",
    bias: Literal["exact", "published", "model", "plain"] | None = None, gaps: Literal["means", "complete"] = "means",
    join: float = 0.2, divisor: int = 30, edf: Literal["exact", "published"] = "exact", power_law: bool = False,
    threads: int = 1, **sampling: Unpack[Sampling],
) -> Curve:  # fmt: skip
    """Compute a statistic of a record, such as the Allan deviation, at many averaging times.

    Parameters
    ----------
    record : Record or array, shape (n,)
        NaN marks missing samples; `Curve.count` is the number of remaining windows.
    statistic : str
        A name in `STATISTICS`.
    taus : {"octave", "decade", "log", "all"} or sequence of float
        Averaging times: 1, 2, 4, 8 ... samples; 1, 2, 4, 10, 20, 40 ...; about 100, logarithmically spaced; all; or
        seconds, rounded to multiples of the sample interval. The named grids extend to the largest averaging factor of
        the statistic.
    m : sequence of int, optional
        Averaging factors instead of times; for theoh, those of oadev up to the joint and of Theo1 beyond.
    noise : {"identified", "auto"}, Model, Term or Fit, optional
        The noise assumed for confidence intervals and bias corrections; `Curve.supposed` describes it. "identified",
        the default, averages over the models that ``identify(record)`` finds consistent with the record; the noise is
        identified when intervals are first requested. A fit does the same with its models, a model or term is taken as
        known. "auto" uses the power law identified at each tau, which is also the fallback if the noise cannot be
        identified (short or unsuitable records, frequency stability data). None for no intervals.
    bias : {"exact", "published", "model", "plain"}, optional
        None for the plain definition, except for theobr and theoh with a model as the noise, where it means "model":
        their own bias ratio assumes a single power law and is 2 to 4 times too low for mixtures. "plain" is the
        definition in either case. Under the identified noise their intervals are those of the true value and need not
        contain the plain value. "exact" divides the variance by its exact expectation over that of the statistic it
        estimates (totdev: oadev, mtotdev: mdev, theo1: oadev ...), "published" by the published factor; for theobr and
        theoh "model" replaces their own ratio by the exact one. `Curve.factor` is the factor.
    gaps : {"means", "complete"}
        Treatment of windows with missing samples. "means", for adev, oadev, hdev, ohdev and haar: if at least a tenth
        of the windows have missing samples, every window with a sample in each part is used, with the means of the
        remaining samples and weights by their counts, so that white rate noise is unbiased at every tau. The effect on
        other noise is divided out under the assumed noise and included in the intervals. If quantization at the joints
        makes most of the variance, a point is refused, or omitted from a named grid. A sample between two missing ones
        does not count. "complete", and every other statistic: such windows are omitted.
    join : float
        Share of the record up to which theoh is the overlapping Allan deviation.
    divisor : {30, 6}
        Divisor of the record length for the number of ratios in the bias ratio of theobr and theoh; 6 as in Stable32.
    edf : {"exact", "published"}
        Degrees of freedom of the intervals: exact ones under the noise, or for comparison those of the literature, for
        a single power law at each tau (NIST SP 1065; Greenhall and Riley 2003, Tasset, Howe and Percival 2004). The
        published ones of Theo1 fall below 1 under random walk, where 1 is taken; those of theobr and theoh are Theo1's.
    power_law : bool
        Whether to determine the power law of the noise at each tau, `Curve.alpha`: 2 and 1 for white and flicker angle
        noise, 0, -1, -2 for white, flicker and random walk rate noise. A ramp is taken out first, so that the curve may
        rise with slope +1 where the noise is white, but at the longest tau, where fewer than 30 points decide.
    threads : int
        Maximum number of threads; the results are the same except for the last digit.
    **sampling
        `rate`, `unit`, `kind`, `scale` and `name` of a `Record`, for an array or a column of a table. Samples without a
        unit are dimensionless, as frequency stability data.

    Returns
    -------
    Curve
        In SI. A constant is removed before integrating, so that a bias costs no precision.

    Warns
    -----
    LongJobWarning
        The computation takes more than a minute.

    Raises
    ------
    DataError
        No window is complete, or the record is too short.
    UsageError
        The statistic or grid is unknown; an averaging time is too long.

    Notes
    -----
    With gaps and means the variance is sum h^2 d^2 / (m sum h), where d is the difference of a window's means and
    1/h the sum of b^2 / count over its parts, b = (-1, 1) or (1, -2, 1); without missing samples it is that of
    complete windows. Its degrees of freedom are those of the same windows, with the remaining samples.

    For many averaging times the confidence intervals (and bias factors) are computed at a few up to 1/64 of the record
    and at up to 80 beyond, and interpolated, on the grid "log" to within 0.2 %; in a record with gaps, and if windows
    do not overlap, at 130 of more than 300 times, to within 2 %. Adjacent values with ``taus="all"`` are almost
    identical: use it for inspection (a vibration, an interval named in a data sheet), not for fitting.

    With ``taus="all"``, oadev, ohdev, mdev and related statistics take O(n log^2 n) for all tau together, for each run
    between gaps.

    Examples
    --------
    >>> samples = [892.0, 809, 823, 798, 671, 644, 883, 903, 677]
    >>> deviation(samples, "oadev", rate=1.0, m=[1, 2]).deviation.round(5).tolist()
    [91.22945, 85.95287]
    """
    record = as_record(record, "deviation", sampling, unit="1")
    own: Supposing = "auto" if "published" in (bias, edf) else partial(of_record, record)  # a single power law each
    supposing = own if isinstance(noise, str) and noise == "identified" else noise
    return statistics.deviation(record, statistic, taus=taus, m=m, noise=supposing, bias=bias, gaps=gaps, join=join,
                                divisor=divisor, edf=edf, power_law=power_law, threads=threads)  # fmt: skip


def of_record(record: Record) -> SupposedNoise:
    """The noise identified from a record; if that is not possible, the power law at each tau, and why."""
    why = ""
    if record.signal.name == "dimensionless" and record.kind != "value":
        why = say("as these are frequency stability data")
    elif (quality := inspect(record)).refusal:
        why = quality.refusal
    elif not record.integrated and np.mean(record.steps[1:] == record.steps[:-1]) > REPEATED:
        why = say("as most samples repeat the previous one")
    else:
        why = next((finding.what for finding in quality.findings if finding.name == "resampled"), "")
    if not why:
        try:
            return supposed(identify(record))
        except DataError as error:
            why = str(error)
    noise, words = supposed("auto")
    return SupposedNoise(noise, say("{intervals}: the noise was not identified, {reason}", intervals=words, reason=why))
