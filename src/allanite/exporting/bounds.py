"""Upper bounds of coefficients, read off the measured Allan deviation where the model has no values.

Every term adds to the variance: a coefficient is at most that whose line passes through the upper limit of the curve,
at any averaging time. N is read at 1 s; B, whose line is level, at the lowest limit, and K where it bounds most, which
is near the longest averaging time: c < upper(tau) / (sqrt(level) tau^slope).
"""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from allanite.core.errors import DataError
from allanite.core.estimate import Estimate
from allanite.core.fit import Fit
from allanite.core.model import Model, Term
from allanite.phrases.phrase import say, spelled
from allanite.terms import TERMS

from .content import Axis

READ = "curve"  # method of estimates that are such bounds

BOUND = say("upper bound read off the Allan deviation")

BOUNDED = ("N", "B", "K")  # terms that have fields, or stand in for others that have none
ONCE = 1.0  # averaging time of N, and the shortest of the others, s: below, a filter or vibration may bend the curve


def remedy() -> str:
    """How a file is written where no model explains the records."""
    return say("for upper bounds: {option}", option=spelled("--from-curve", "from_curve=True"))


def bounded(axis: Axis, *, asked: bool) -> Axis:
    """The axis with upper bounds of terms struck out, and if `asked` of all where no model explains the record."""
    if asked and axis.doubt:  # nothing but bounds; a model of them is one of too much noise
        estimates = tuple(_estimates(axis, BOUNDED).values())
        model = Model(tuple(Term(e.symbol, e.upper or 0.0, e.signal) for e in estimates))
        words = say("{why}: every value is an {bound}", why=axis.doubt.partition(";")[0], bound=BOUND)
        fit = Fit(estimates, READ, axis.fit.signal, model, name=axis.fit.name)
        return replace(axis, fit=fit, doubt="", alerts=(words, *axis.alerts))
    slow = [e.symbol for e in axis.fit if e.status == "not valid" and TERMS[e.symbol].slope >= 0]
    empty = [e.symbol for e in axis.fit if asked and e.value is None and not e.upper]
    missing = {*slow, *empty} & set(BOUNDED)
    if axis.doubt or not missing or (axis.curve is None and not asked):
        return axis
    known = _estimates(axis, missing)
    return replace(axis, fit=replace(axis.fit, estimates=tuple(known.get(e.symbol, e) for e in axis.fit)))


def _estimates(axis: Axis, symbols: Iterable[str]) -> dict[str, Estimate]:
    """Upper bounds of coefficients by symbol, SI."""
    curve, signal = axis.curve, axis.fit.signal
    if curve is None or curve.law is None:
        raise DataError(
            say(
                "{axis}: there is no Allan deviation with intervals to read bounds off; analyze it with {option}",
                axis=axis.label, option=spelled("--statistic oadev", "statistic='oadev'"),
            )
        )  # fmt: skip
    tau, upper = curve.tau, curve.to(signal.unit).interval(axis.level)[1]
    late = tau >= min(ONCE, tau[-1])
    limits = {}
    for row in (TERMS[symbol] for symbol in symbols):
        through = upper / (np.sqrt(row.level) * tau**row.slope)
        most = through[late].min() if row.slope >= 0 else through[np.abs(np.log(tau / ONCE)).argmin()]
        limits[row.symbol] = Estimate(row.symbol, signal, None, None, "absent", float(most), READ, reason=BOUND)
    return limits
