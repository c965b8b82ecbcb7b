"""Drift: how far heading, attitude, velocity and position err with time without aid, and what causes it."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.encoding import plain
from allanite.core.errors import UsageError
from allanite.core.model import Term
from allanite.core.names import demand_name
from allanite.core.plain import Value
from allanite.core.ranges import SIZE
from allanite.core.units import Signal, convert
from allanite.phrases.phrase import say
from allanite.planning.drift import Response, drift_variance

from .drift_settings import QUANTITIES, DriftPath, DriftSettings, Requirement

TURN_ON, SCALE = say("turn-on bias"), say("scale factor")  # what causes drift beside the noise


@dataclass(frozen=True, eq=False, repr=False)
class DriftCause(Value):
    """What makes one axis drift: a noise term, or a constant error."""

    name: str  # symbol of the term, "turn-on bias" or "scale factor"
    term: Term | None = None  # with its coefficient; of one that was not identified, its upper limit (`limit`)
    # bias, step: constant error of the rate, and of its integral from the start on, SI
    bias: float = 0.0
    step: float = 0.0
    # low, high: limits of the coefficient as shares of it; NaN if there are none
    low: float = math.nan
    high: float = math.nan
    limit: bool = False

    def variance(self, response: Response, times: FloatArray, calibration: float, rate: float | None) -> FloatArray:
        """What it adds to the variance of a quantity, SI."""
        if self.term is not None:
            return drift_variance(self.term, response, times, calibration=calibration, rate=rate)
        return np.asarray((self.bias * response.bias(times) + self.step * response.step(times)) ** 2)


@dataclass(frozen=True, eq=False, repr=False)
class DriftAxis(Value):
    """The causes of one axis."""

    sensor: str
    channel: str
    causes: tuple[DriftCause, ...]
    rate: float | None = None  # sampling rate, Hz
    # longest averaging time of its curve, s: beyond it the drift is what the terms predict
    longest: float | None = None
    correlation: FloatArray | None = None  # of the estimates of its terms, in the order of the causes

    def __post_init__(self) -> None:
        terms = sum(cause.term is not None and not cause.limit for cause in self.causes)
        if self.correlation is not None and self.correlation.shape != (terms, terms):
            raise UsageError(f"{terms} terms have a correlation of {terms} rows and columns: the data were changed")


@dataclass(frozen=True, eq=False)
class DriftShare:
    """Variance of a quantity from one cause at each time, SI, with its limits; NaN if there are none."""

    # `channels` are the axes whose it is, one for each time; `cause` is that of the last time.
    sensor: str
    channels: tuple[str, ...]
    cause: DriftCause
    variance: FloatArray
    low: FloatArray
    high: FloatArray


@dataclass(frozen=True, eq=False)
class _AxisDrift:
    """Variances of one axis, shape (causes, times)."""

    axis: DriftAxis
    causes: Sequence[DriftCause]
    variance: FloatArray

    @cached_property
    def identified(self) -> FloatArray:
        """Whether a cause is no upper limit, shape (causes, 1)."""
        return np.array([[not cause.limit] for cause in self.causes], dtype=np.float64)

    def squares(self, end: str) -> FloatArray:
        """Square of how far a limit of the variance is from it: of the limits of its terms, with their correlation."""
        # The method of variance estimates recovery (G. Y. Zou and A. Donner, Statistics in Medicine 27 (2008) 1693).
        terms = [i for i, cause in enumerate(self.causes) if cause.term is not None and not cause.limit]
        size = np.array([[getattr(self.causes[i], end) ** 2 - 1] for i in terms]).reshape(-1, 1)
        off = np.nan_to_num(size, posinf=SIZE.high) * self.variance[terms]
        together = np.eye(len(terms)) if self.axis.correlation is None else self.axis.correlation
        return np.asarray(np.maximum(np.einsum("it,ij,jt->t", off, together, off), 0))


@dataclass(frozen=True, eq=False)
class WorstAxis:
    """Of each time the axis of a sensor that drifts most."""

    # `below` and `above` are the squares of the distances of the limits of the variance from it; `most` is the largest
    # upper limit of any axis, with the terms that were not identified at theirs.
    shares: tuple[DriftShare, ...]
    below: FloatArray
    above: FloatArray
    most: FloatArray


def worst_axis(axes: Sequence[DriftAxis], path: DriftPath, settings: DriftSettings, times: FloatArray) -> WorstAxis:
    """The worst axis at each time: by the causes that were found, or by upper limits if nothing was."""
    each = []
    for axis in axes:
        # a turn about the vertical does not tilt
        causes = [cause for cause in axis.causes if not (path.coupled and cause.name == SCALE)]
        of = [cause.variance(settings.response(path), times, settings.averaged, axis.rate) for cause in causes]
        each.append(_AxisDrift(axis, causes, np.array(of).reshape(len(causes), times.size)))
    known = np.array([(drift.variance * drift.identified).sum(axis=0) for drift in each])
    every = np.array([drift.variance.sum(axis=0) for drift in each])
    which = (known if known.any() else every).argmax(axis=0)
    below, above = (np.array([drift.squares(end) for drift in each]) for end in ("low", "high"))
    most = known + np.sqrt(above + (every - known) ** 2)
    chosen = which, np.arange(times.size)
    shares: dict[tuple[str, tuple[float, ...], bool], DriftShare] = {}
    names = tuple(each[i].axis.channel for i in which)
    for i in dict.fromkeys(which.tolist()):
        for cause, variance in zip(each[i].causes, each[i].variance * (which == i), strict=True):
            key = cause.name, cause.term.shape if cause.term and len(each) == 1 else (), cause.limit
            own = np.array([variance, variance * cause.low**2, variance * cause.high**2])
            if key in shares:
                own += [shares[key].variance, shares[key].low, shares[key].high]
            shares[key] = DriftShare(path.sensor, names, cause, *own)
    return WorstAxis(tuple(shares.values()), below[chosen], above[chosen], most.max(axis=0))


PLANNED = ("N", "B", "K")  # the terms that a requirement is divided among, with the turn-on bias


@dataclass(frozen=True, eq=False)
class DriftCourse:
    """A quantity with time."""

    name: str  # in `QUANTITIES`
    times: FloatArray  # s
    # sigma, low, high: standard deviation and its interval, SI; NaN limits if no coefficient has an interval
    sigma: FloatArray
    low: FloatArray
    high: FloatArray
    most: FloatArray  # upper limit with the terms that were not identified at theirs
    # of the axis of each sensor that is the worst at a time, those of upper limits among them
    shares: tuple[DriftShare, ...]

    def to(self, unit: str) -> FloatArray:
        """The standard deviation in a unit."""
        return np.asarray(self.sigma * convert(1.0, QUANTITIES[self.name].si, unit))

    @property
    def title(self) -> str:
        """What it is called."""
        return QUANTITIES[self.name].title

    @property
    def unit(self) -> str:
        """The unit in which it is shown."""
        return QUANTITIES[self.name].unit

    @property
    def scale(self) -> float:
        """What makes numbers in this unit of those in SI."""
        return convert(1.0, QUANTITIES[self.name].si, self.unit)


@dataclass(frozen=True, eq=False)
class AllowedTerm:
    """The coefficient with which a required drift is just kept, SI: alone, and with an equal share of the variance."""

    # `found` is that of the worst axis with its limits as shares of it; None if it is unknown.
    sensor: str
    name: str
    signal: Signal
    alone: float
    shared: float
    found: float | None
    limits: tuple[float, float] = (math.nan, math.nan)

    @property
    def unit(self) -> str:
        """Unit of data sheets."""
        return self.signal.sheet[self.power]

    @property
    def power(self) -> float:
        """Power of time in its unit."""
        return 0.0 if self.name == TURN_ON else Term(self.name, 1.0, self.signal).row.power


@dataclass(frozen=True, eq=False, repr=False)
class Drift(Value):
    """Standard deviation of heading, attitude, velocity and position against time without aid.

    Attributes
    ----------
    axes : tuple of DriftAxis
    settings : DriftSettings
    alerts, notes, rejected : tuple of str
        Why the noise is in doubt, what was found in the data, and channels that were left out.
    recipe, provenance : dict

    Examples
    --------
    >>> import allanite as al
    >>> found = al.drift(al.Model("N 0.3 deg/sqrt(h), B 7 deg/h"), times=(60.0, 600.0), calibration=300.0)
    >>> found["heading"].to("deg").round(3).tolist(), round(found["position"].sigma[0])
    ([0.126, 1.134], 14)
    """

    _also: ClassVar = ("results", "allowed")

    axes: tuple[DriftAxis, ...]
    settings: DriftSettings
    alerts: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    rejected: tuple[str, ...] = ()
    recipe: dict[str, Any] = field(default_factory=dict)
    provenance: dict[str, str] = field(default_factory=dict)

    def __getitem__(self, name: str) -> DriftCourse:
        """A quantity at the times of the settings."""
        return self.course(name, self.settings.times)

    @property
    def quantities(self) -> tuple[str, ...]:
        """The quantities that the sensors give."""
        sensors = {axis.sensor for axis in self.axes}
        return tuple(dict.fromkeys(path.quantity for path in self.settings.paths if path.sensor in sensors))

    def course(self, name: str, times: Sequence[float] | FloatArray) -> DriftCourse:
        """A quantity at any times, s.

        Raises
        ------
        UsageError
            The sensors do not give it.
        """
        demand_name("quantity", name, self.quantities)
        at = np.asarray(times, dtype=np.float64)
        paths = [path for path in self.settings.paths if path.quantity == name]
        worst_axes = list(filter(None, (self._worst(path, at) for path in paths)))
        shares = [share for worst in worst_axes for share in worst.shares]
        known = [share for share in shares if not share.cause.limit]
        nothing = np.zeros_like(at)
        total = sum((share.variance for share in known), nothing)
        squares = (sum((getattr(worst, end) for worst in worst_axes), nothing) for end in ("below", "above"))
        below, above = map(np.sqrt, squares)
        if not any(math.isfinite(share.cause.high) for share in known):
            below = above = np.full_like(at, math.nan)
        most = sum((worst.most for worst in worst_axes), nothing)
        return DriftCourse(name, at, np.sqrt(total), np.sqrt(np.maximum(total - below, 0)), np.sqrt(total + above),
                           np.sqrt(most), tuple(shares))  # fmt: skip

    def _worst(self, path: DriftPath, times: FloatArray) -> WorstAxis | None:
        """The worst axis of a sensor at each time; None if there is none."""
        axes = [axis for axis in self.axes if axis.sensor == path.sensor]
        return worst_axis(axes, path, self.settings, times) if axes else None

    @property
    def allowed(self) -> list[dict[str, Any]]:
        """What every requirement allows, as plain data."""
        requirements = []
        for need in self.settings.requirements:
            terms = [{"sensor": t.sensor, "name": t.name, "alone": t.alone, "shared": t.shared, "found": t.found,
                      "unit": t.signal.si[t.power]} for t in self.allowing(need)]  # fmt: skip
            requirements.append({"require": need.text, "drift": self.reached(need), "terms": terms})
        return requirements

    def reached(self, need: Requirement) -> float | None:
        """The drift at the time of a requirement, SI; None if nothing is known."""
        return float(self.course(need.quantity, [need.time]).sigma[0]) if need.quantity in self.quantities else None

    @property
    def exceeded(self) -> list[str]:
        """Which requirements are not kept, in sentences."""
        drifts = ((need, self.reached(need)) for need in self.settings.requirements)
        return [
            say("{quantity} {size:.3g} {unit}, required: {text}", quantity=need.quantity,
                size=reached / convert(1.0, need.unit, QUANTITIES[need.quantity].si), unit=need.unit, text=need.text)
            for need, reached in drifts if reached is not None and not reached <= need.limit  # nor where it is NaN
        ]  # fmt: skip

    def allowing(self, need: Requirement) -> Iterator[AllowedTerm]:
        """Coefficients with which a required drift is kept: each alone, and all of them with equal shares."""
        at, settings = np.array([need.time]), self.settings
        paths = [path for path in settings.paths if path.quantity == need.quantity]
        if not paths:
            raise UsageError(f"on a platform that is kept level there is no {need.quantity} to require")
        count = len(paths) * (len(PLANNED) + 1)
        for path in paths:
            worst, signal = self._worst(path, at), path.signal
            causes = {s.cause.name: s.cause for s in worst.shares if not s.cause.limit} if worst else {}
            for name in (*PLANNED, TURN_ON):
                unit = DriftCause(name, Term(name, 1.0, signal)) if name in PLANNED else DriftCause(name, bias=1.0)
                unit_size = math.sqrt(unit.variance(settings.response(path), at, settings.averaged, None)[0])
                cause, alone = causes.get(name), need.limit / unit_size if unit_size else math.inf
                known = None if cause is None else cause.term.value if cause.term else cause.bias
                limits = (math.nan, math.nan) if cause is None else (cause.low, cause.high)
                yield AllowedTerm(path.sensor, name, signal, alone, alone / count**0.5, known, limits)

    @property
    def results(self) -> list[dict[str, Any]]:
        """The quantities at the times, as plain data."""
        quantities = []
        for course in (self[name] for name in self.quantities):
            shares = [{"sensor": s.sensor, "channels": list(s.channels), "name": s.cause.name, "limit": s.cause.limit,
                       "sigma": plain(np.sqrt(s.variance))} for s in course.shares]  # fmt: skip
            numbers = {key: plain(getattr(course, key)) for key in ("times", "sigma", "low", "high", "most")}
            unit = QUANTITIES[course.name].si
            quantities.append({"quantity": course.name, "unit": unit, **numbers, "causes": shares})
        return quantities

    def rows(self) -> tuple[list[str], list[list[Any]]]:
        """Headings and rows: the total and each cause of each quantity at each time, and its share of the variance."""
        headings = ["quantity", "time_s", "cause", "sensor", "channel", "sigma", "low", "high", "unit", "share_percent"]
        rows: list[list[Any]] = []
        for course in (self[name] for name in self.quantities):
            si, unit = course.scale, course.unit
            for i, time in enumerate(course.times.tolist()):
                whole = float(course.sigma[i])
                ends = [course.sigma, course.low, course.high]
                rows.append([course.name, time, "all", "", "", *(float(v[i]) * si for v in ends), unit, 100.0])
                rows.append([course.name, time, "all, with limits", "", "", float(course.most[i]) * si, None, None,
                             unit, None])  # fmt: skip
                for s in course.shares:
                    sizes = [math.sqrt(float(v[i])) * si for v in (s.variance, s.low, s.high)]
                    share = None if s.cause.limit or not whole else 100 * float(s.variance[i]) / whole**2
                    name = f"{s.cause.name}, upper limit" if s.cause.limit else s.cause.name
                    rows.append([course.name, time, name, s.sensor, s.channels[i], *sizes, unit, share])
        return headings, rows

    def _summary(self) -> str:
        ends = (self[name] for name in self.quantities)
        last = (f"{c.name} {c.to(c.unit)[-1]:.3g} {c.unit}" for c in ends)
        return f"after {self.settings.times[-1]:g} s: {', '.join(last)}"
