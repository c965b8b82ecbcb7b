"""What is done with estimates: a known bias subtracted, the bias removed by turning the gyro about."""

import math
from dataclasses import replace

from allanite.extending import UsageError, say

from .estimates import RateEstimate, rate_factor


def subtract_bias(estimate: RateEstimate, bias: float, unit: str, standard_error: float = 0.0) -> RateEstimate:
    """The estimate less a bias known beforehand, for example from the gyro's passport.

    The reading is the true rate and the bias: a passport bias of -0.0948 deg/h raises the result by 0.0948 deg/h.

    Parameters
    ----------
    estimate : RateEstimate
    bias, unit, standard_error
        The bias and how well it is known, in `unit`.

    Examples
    --------
    >>> from allanite.core.units import SIGNALS
    >>> raw = RateEstimate(12.335042 * 4.84813681e-6, 0.0, "mean", "", SIGNALS[0], "mean", 120.0)
    >>> round(subtract_bias(raw, -0.0948, "deg/h").to("deg/h"), 4)
    12.4298
    """
    factor = rate_factor(unit, estimate.signal)
    if not (math.isfinite(bias) and math.isfinite(standard_error) and standard_error >= 0):
        raise UsageError(f"a bias and its standard error are finite numbers, not {bias!r} and {standard_error!r}")
    limits = estimate.limits if standard_error == 0 else None
    return replace(
        estimate,
        value=estimate.value - bias * factor,
        standard_error=math.hypot(estimate.standard_error, standard_error * factor),
        limits=None if limits is None else (limits[0] - bias * factor, limits[1] - bias * factor),
        history=(*estimate.history, say("bias of {bias:g} {unit} subtracted", bias=bias, unit=unit)),
    )


def reversal(first: RateEstimate, second: RateEstimate) -> tuple[RateEstimate, RateEstimate]:
    """The rate and the bias from two measurements, the gyro's axis turned about between them.

    Half the difference is the rate along the axis of the first, half the sum the bias. What the bias does from one
    measurement to the next is not in the standard error: a model of one interval knows nothing of it.

    Returns
    -------
    (rate, bias)

    Examples
    --------
    >>> from allanite.core.units import SIGNALS
    >>> up, down = (RateEstimate(v, 0.3, "mean", "", SIGNALS[0], "mean", 120.0) for v in (11.0, -9.0))
    >>> [e.value for e in reversal(up, down)]
    [10.0, 1.0]
    """
    if first.signal is not second.signal or first.target != second.target:
        raise UsageError("the two positions of a reversal must be measured by sensors of one kind, with one target")
    error = math.hypot(first.standard_error, second.standard_error) / 2
    both = replace(
        first,
        standard_error=error,
        limits=None,
        details={},
        duration=first.duration + second.duration,
        findings=(*first.findings, *second.findings),
    )
    difference, total = first.value - second.value, first.value + second.value
    return (
        replace(both, value=difference / 2, history=(*first.history, say("half the difference of two positions"))),
        replace(both, value=total / 2, history=(*first.history, say("half the sum of two positions"))),
    )
