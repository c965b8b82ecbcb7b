"""Which axis a field takes its coefficient from, what replaces one that was not identified, and upper bounds."""

import math
import statistics
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import singledispatch
from typing import Any

import numpy as np

from allanite.core.errors import DataError, UsageError
from allanite.core.estimate import Estimate
from allanite.core.fit import Fit
from allanite.core.model import Model, Term, model_of
from allanite.phrases.phrase import join, say, spelled
from allanite.study.results import Channel, Study
from allanite.terms import TERMS

from .content import Axis
from .target import LONG

ALLAN = ("oadev", "adev")  # statistics that are Allan deviations

Source = Study | Channel | Fit | Model | Term | Mapping[str, Fit] | Sequence["Source"]
"""What can be exported; several are put together, for example a gyro's and an accelerometer's."""


@singledispatch
def axes_of(source: Any) -> Iterator[Axis]:
    """The axes of a source; refused channels are left out."""
    raise UsageError(f"a {type(source).__name__} holds no noise; give a Study, a Channel, a Fit, a Model, or a list of "
                     "these")  # fmt: skip


@axes_of.register
def _(source: Study) -> Iterator[Axis]:
    known = {key: value for key, value in source.provenance.items() if key in ("source", "sha256")}
    for channel in source.channels:
        yield from _of_channel(channel, source.recipe.level, known)


@axes_of.register
def _(source: Channel) -> Iterator[Axis]:
    return _of_channel(source, 0.95, {})


def _of_channel(channel: Channel, level: float, known: Mapping[str, str]) -> Iterator[Axis]:
    if channel.noise is None:
        return
    fit, doubts = channel.noise.fit, channel.noise.doubts
    alerts = (*channel.noise.omitted, *(alert for alert in channel.alerts if alert not in doubts))
    yield Axis(channel.record.name, fit, channel.record.rate, join("; ", doubts) if doubts else "", channel.readings,
               level, alerts, next((curve for curve in channel.curves if curve.statistic in ALLAN), None),
               known)  # fmt: skip


@axes_of.register
def _(source: Fit) -> Iterator[Axis]:
    doubt = "" if source.valid is not None else source.model.doubt
    yield Axis(source.name, source, source.curve.rate if source.curve else None, doubt)


@axes_of.register(Model)
@axes_of.register(Term)
def _(source: Model | Term) -> Iterator[Axis]:
    model = model_of(source)
    given = tuple(Estimate(t.symbol, t.signal, t.value, None, "reported", None, "given", shape=t.shape) for t in model)
    yield Axis("", Fit(given, "given", model.signal, model), None, model.doubt)


@axes_of.register
def _(source: Mapping) -> Iterator[Axis]:  # type: ignore[type-arg]  # dispatch needs the bare class
    for name, fit in source.items():
        for axis in _within(fit):
            yield Axis(name, axis.fit, axis.rate, axis.doubt)


@axes_of.register(list)
@axes_of.register(tuple)
def _(source: Sequence[Any]) -> Iterator[Axis]:
    for part in source:
        yield from _within(part)


def _within(part: Any) -> Iterator[Axis]:
    try:
        yield from axes_of(part)
    except RecursionError:
        raise UsageError("the results given are nested too deeply, or contain themselves") from None


Found = tuple["AxisCoefficient", ...]

COVER = "cover"  # method of estimates that cover what was identified


@dataclass(frozen=True)
class AxisCoefficient:
    """A coefficient of one axis, SI; of one that was not identified, its upper limit (`limit`)."""

    channel: str
    value: float
    low: float
    high: float
    limit: bool = False
    given: bool = False
    note: str = ""
    time: float = LONG
    level: float = 0.95
    covers: bool = False


def worst(coefs: Found) -> Found:
    """The largest; a limit only if no axis has a value."""
    return (max(_identified(coefs), key=lambda c: c.value),)


def median(coefs: Found) -> Found:
    """That of the axis in the middle; of two, the larger."""
    known = _identified(coefs)
    middle = statistics.median_high(c.value for c in known)
    return (next(c for c in known if c.value == middle),)


def _identified(coefs: Found) -> Found:
    return tuple(c for c in coefs if not c.limit) or coefs


POLICIES: dict[str, Callable[[Found], Found]] = {
    "worst": worst, "median": median, **dict.fromkeys(("each", "x", "y", "z"), lambda found: found),
}  # fmt: skip
"""Axis policy: how the values of the axes become the value of a field."""


def demand_policy(policy: str) -> None:
    """Refuse an unknown axis policy."""
    if policy not in POLICIES:
        raise UsageError(f"unknown {spelled('--axis', 'axis')} {policy!r}; choose {', '.join(POLICIES)}")


def selected(axes: Sequence[Axis], policy: str) -> tuple[Axis, ...]:
    """The axes of one sensor that a policy uses: all, or the one of that name or place; a given model is every axis."""
    if policy not in "xyz" or not any(axis.name for axis in axes):
        return tuple(axes)
    place = placed([axis.name for axis in axes], policy)
    if place is None:
        raise UsageError(f"there is no axis {policy} among the channels {', '.join(axis.label for axis in axes)}; "
                         f"choose another one with {spelled('--axis', 'axis')}")  # fmt: skip
    return (axes[place],)


def placed(names: Sequence[str], axis: str) -> int | None:
    """Which channel is an axis: the one whose name ends in x, y or z, or of three that at its place."""
    named = [i for i, name in enumerate(names) if name.lower().endswith(axis)]
    return named[0] if len(named) == 1 else "xyz".index(axis) if len(names) == 3 else None


def coefficients(axes: Sequence[Axis], symbol: str, *, markov: bool, unexplained: bool) -> tuple[Found, list[str]]:
    """The coefficient of each axis, and why others have none; with `markov` GM may replace a K that is absent."""
    chosen: list[AxisCoefficient] = []
    reasons: dict[str, list[str]] = {}
    for axis in axes:
        e = axis.estimate(symbol)
        coefficient = None if e is None else _coefficient(axis, e, unexplained=unexplained)
        if markov and symbol == "K" and (coefficient is None or coefficient.limit):
            coefficient = _markov(axis) or coefficient
        if coefficient is None:
            absent = say("not stated") if axis.fit.method == "given" else say("not looked for")
            why = absent if e is None else e.words(level=axis.level)
            reasons.setdefault(why, []).append(axis.label)
        else:
            chosen.append(coefficient)
    return tuple(chosen), [say("{axis}: {symbol} is {why}", axis=", ".join(names), symbol=symbol, why=why)
                           for why, names in reasons.items()]  # fmt: skip


def _coefficient(axis: Axis, e: Estimate, *, unexplained: bool) -> AxisCoefficient | None:
    forced = unexplained and e.status == "not valid" and e.value is not None
    if (e.valued or forced) and e.value:
        low, high = e.interval(axis.level)
        note = say("the model does not explain the record") if forced else e.reason
        given = axis.fit.method == "given"
        covers = e.method == COVER
        return AxisCoefficient(axis.name, e.value, low, high, False, given, note, level=axis.level, covers=covers)
    if e.value is None and e.upper:
        note = e.reason or say("{symbol} not identified", symbol=e.symbol)
        return AxisCoefficient(axis.name, e.upper, math.nan, math.nan, limit=True, note=note)
    return None


def _markov(axis: Axis) -> AxisCoefficient | None:
    """The random walk from which a Gauss-Markov process is not to be told at times far below its time constant."""
    e = axis.estimate("GM")
    if e is None or not e.valued or not e.value:
        return None
    time = e.shape[0]
    walk = math.sqrt(2 / time)
    low, high = e.interval(axis.level)
    note = say("{name} {words}, T = {time:.4g} s", name=TERMS["GM"].title, words=e.words(level=axis.level), time=time)
    return AxisCoefficient(axis.name, e.value * walk, low * walk, high * walk, False, False, note, time, axis.level,
                           e.method == COVER)  # fmt: skip


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
    missing = {*slow, *(e.symbol for e in axis.fit if asked and e.value is None and not e.upper)} & set(BOUNDED)
    if axis.doubt or not missing or (axis.curve is None and not asked):
        return axis
    known = _estimates(axis, missing)
    return replace(axis, fit=replace(axis.fit, estimates=tuple(known.get(e.symbol, e) for e in axis.fit)))


def _estimates(axis: Axis, symbols: Iterable[str]) -> dict[str, Estimate]:
    """Upper bounds of coefficients by symbol, SI."""
    # Every term adds to the variance: a coefficient is at most that whose line passes through the upper limit of the
    # curve, c < upper(tau) / (sqrt(level) tau^slope). N is read at 1 s; B, whose line is level, at the lowest limit,
    # and K where it bounds most, which is near the longest averaging time.
    curve, signal = axis.curve, axis.fit.signal
    if curve is None or curve.law is None:
        raise DataError(say("{axis}: there is no Allan deviation with intervals to read bounds off; analyze it with "
                            "{option}",
                            axis=axis.label, option=spelled("--statistic oadev", "statistic='oadev'")))  # fmt: skip
    tau, upper = curve.tau, curve.to(signal.unit).interval(axis.level)[1]
    late = tau >= min(ONCE, tau[-1])
    limits = {}
    for row in (TERMS[symbol] for symbol in symbols):
        through = upper / (np.sqrt(row.level) * tau**row.slope)
        most = through[late].min() if row.slope >= 0 else through[np.abs(np.log(tau / ONCE)).argmin()]
        limits[row.symbol] = Estimate(row.symbol, signal, None, None, "absent", float(most), READ, reason=BOUND)
    return limits
