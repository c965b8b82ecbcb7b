"""The curve of a record with limits under its own noise, which is identified when they are asked for."""

from collections.abc import Sequence
from functools import partial
from typing import Literal

import numpy as np

from allanite import statistics
from allanite.core.curve import Curve
from allanite.core.errors import DataError
from allanite.core.model import ModelLike
from allanite.core.record import Record
from allanite.identification import identify
from allanite.prepare.quality import inspect
from allanite.statistics.confidence.supposed import Supposed, Supposing, supposed

REPEATED = 0.5
"""Share of readings equal to the one before from which on a record is piecewise constant."""


def deviation(  # noqa: PLR0913 - each has a default, and is a choice of its own
    record: Record,
    statistic: str = "oadev",
    *,
    taus: str | Sequence[float] = "octave",
    m: Sequence[int] | None = None,
    noise: ModelLike | Literal["identified", "auto"] | None = "identified",
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
    noise : {"identified", "auto"}, Model, Term or Fit, optional
        The noise supposed for the confidence limits and for a bias; `Curve.supposed` says it in words. "identified",
        the default, averages over the models that ``identify(record)`` leaves open; the noise is identified when
        limits are first asked for. A fit does the same with its models, a model or term is taken as known. "auto" is
        the power law that is found at each tau, which is also what is left where the noise cannot be identified (short
        or unfit records, frequency stability data). None for no limits.
    bias : {"exact", "published", "model", "plain"}, optional
        None for the plain definition, but of theobr and theoh "model" where a model is given as the noise: their own
        bias ratio supposes one kind of noise, and is 2 to 4 times too low in mixtures. "plain" is the definition in
        either case. Under the identified noise their limits are those of the truth, and need not hold the plain value.
        "exact" divides the variance by its exact expectation over that of the statistic it estimates (totdev: oadev,
        mtotdev: mdev, theo1: oadev ...), "published" by the published factor; for theobr and theoh "model" puts the
        exact ratio in the place of their own. `Curve.factor` has the factor.
    gaps : {"means", "complete"}
        What a window with lost readings counts for. "means" of adev, oadev, hdev, ohdev and haar: where a tenth of the
        windows or more have lost some, all count in which a reading is left in each part, with the means of what is
        left and weights by their counts, so that white noise of the rate is met at every tau; what that means to other
        noise is divided out under the noise supposed, and is in the limits; where quantization at the joints makes
        most of the variance, a point is refused, or left out of a named grid. A reading between two lost ones does not
        count. "complete", and every other statistic: nothing.
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

    Of many averaging times the confidence limits (and factors of bias) are worked out at a few dozen, closer where few
    windows are left, and interpolated between them, to 1 % at most; in a record with gaps, and where windows do not
    overlap, at 130 of more than 300 times, to 2 %. Neighbours in ``taus="all"`` are all but the same number: it is for
    looking at (a vibration, an interval that a data sheet names), not for fitting.

    Of oadev, ohdev, mdev and their relatives every tau takes O(n log^2 n), and so does every run between gaps.

    Examples
    --------
    >>> record = Record([892.0, 809, 823, 798, 671, 644, 883, 903, 677], rate=1.0, unit="1", kind="rate")
    >>> deviation(record, "oadev", m=[1, 2]).deviation.round(5).tolist()
    [91.22945, 85.95287]
    """
    own: Supposing = "auto" if bias == "published" else partial(of_record, record)  # published: of a power law each
    supposing = own if noise == "identified" else noise
    return statistics.deviation(
        record,
        statistic,
        taus=taus,
        m=m,
        noise=supposing,
        bias=bias,
        gaps=gaps,
        join=join,
        divisor=divisor,
        threads=threads,
    )


def of_record(record: Record) -> Supposed:
    """The noise identified from a record; the power law found at each tau where that cannot be, and why.

    Examples
    --------
    >>> of_record(Record([1.0, 3.0, 2.0, 5.0], rate=1.0, unit="deg/h")).words.partition(":")[0]
    'limits of the power law found at each averaging time'
    """
    why = _unfit(record)
    if not why:
        try:
            return supposed(identify(record))
        except DataError as error:
            why = str(error)
    noise, words = supposed("auto")
    return Supposed(noise, f"{words}: the noise was not identified, {why}")


def _unfit(record: Record) -> str:
    """Why the noise of a record is not identified; empty if it can be tried."""
    if record.signal.name == "dimensionless":
        return "as these are data of frequency stability"
    quality = inspect(record)
    if quality.refusal:
        return quality.refusal
    steps = record.steps
    if record.kind == "rate" and np.mean(steps[1:] == steps[:-1]) > REPEATED:
        return "as most readings repeat the one before"
    return next((finding.what for finding in quality.findings if finding.name == "resampled"), "")
