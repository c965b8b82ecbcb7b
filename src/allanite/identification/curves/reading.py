"""What the methods that fit a curve have in common."""

from collections.abc import Sequence

import numpy as np

from allanite.core.arrays import BoolArray, FloatArray
from allanite.core.curve import Curve
from allanite.core.errors import DataError, UsageError
from allanite.core.estimate import Estimate
from allanite.core.fit import Fit
from allanite.core.model import Model, Term
from allanite.core.units import SIGNALS, Signal
from allanite.phrases.phrase import join, say
from allanite.statistics.row import Statistic
from allanite.statistics.table import STATISTICS


def signal_of(curve: Curve, points: int) -> Signal:
    """The signal of a curve."""
    if curve.tau.size < points or not np.all(curve.variance > 0):
        raise DataError(
            say(
                "this method needs at least {points} points, none of them zero; there are {size}",
                points=points,
                size=curve.tau.size,
            )
        )
    for signal in SIGNALS:
        if signal.unit == curve.unit:
            return signal
    raise UsageError(f"this method needs a curve in SI, not in {curve.unit}; omit .to()")


def rows_of(curve: Curve) -> tuple[Statistic, ...]:
    """The statistic that makes each point: of theoh oadev up to the joint and Theo1 beyond, of others the same."""
    row = STATISTICS[curve.statistic]
    parts = row.parts or (row,)
    factor = curve.tau * curve.rate / curve.m
    nearest = np.abs(factor[:, None] - [part.tau_factor for part in parts]).argmin(axis=1)
    return tuple(parts[i] for i in nearest.tolist())


def early(curve: Curve, share: float) -> BoolArray:
    """Which points average over at most this share of the record, shape of tau."""
    if not curve.size:
        raise UsageError("this method needs the length of the record, but the curve's size is 0")
    return np.asarray(curve.tau <= share * curve.size / curve.rate * (1 + 1e-9))


def reported(
    symbols: Sequence[str], squares: FloatArray, columns: FloatArray, *, signal: Signal, method: str
) -> list[Estimate]:
    """Roots of squares that are not negative, without evidence for any term; one whose column is empty is absent."""
    found = zip(symbols, np.sqrt(squares).tolist(), np.abs(columns).max(axis=0) > 0, strict=True)
    return [
        Estimate(s, signal, v, None, "reported", None, method)
        if visible
        else Estimate(s, signal, None, None, "absent", None, method)
        for s, v, visible in found
    ]


def result(
    curve: Curve, estimates: Sequence[Estimate], method: str, *, notes: Sequence[str], model: Model | None = None
) -> Fit:
    """The fit; its model, unless given, contains the terms estimated above zero."""
    signal = estimates[0].signal
    terms = tuple(Term(e.symbol, e.value, signal) for e in estimates if e.value is not None and e.value > 0)
    if model is None and not terms:
        raise DataError(
            say("method {method!r} finds none of the terms: {reasons}", method=method, reasons=join("; ", notes))
        )
    return Fit(
        tuple(estimates), method, signal, model or Model(terms), name=curve.name, curve=curve, notes=tuple(notes)
    )
