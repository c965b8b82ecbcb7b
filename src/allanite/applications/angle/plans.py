"""Expected accuracy of an experiment, and the best start, without data; a result of the command and its provenance."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, ClassVar

import numpy as np

from allanite.extending import (  # isort: skip
    POSITIVE, STAMP, TIME, Finding, FloatArray, UsageError, Value, constructed, demand_name, provenance_of, public
)  # fmt: skip

from .calibration import Calibration, Prior, caveats, prior_of
from .geometry import QUARTER, Gimbals, gimbals
from .harmonics import USUAL, Harmonics, amplitude_names, design, harmonic_set
from .motion import Ring, Sway, sway_of
from .solve import correlation_of
from .squareroot import batch

MAX_READINGS = 4096  # samples of one window of a scan; more are thinned, their noise averaged
MAX_COUNT = 100_000_000  # samples of an experiment, of which each takes some hundred bytes
START_STEP = 300.0  # between the starts of a scan, s: finer than anybody schedules, and than the total changes


@constructed
@dataclass(frozen=True, repr=False)
class AngleSettings(Value):
    """Every choice of an experiment but its start.

    Attributes
    ----------
    latitude : float
        rad.
    duration, interval : float
        Length of the experiment, and time between samples, s.
    sigma : float
        Standard deviation of a sample's white noise, in any unit; results are in the same.
    q_law, turn_period, sway, ring
        See `gimbals`.
    prior : (amplitudes, rest) or None
        Standard deviations before the samples, in the unit of sigma; None: nothing is known.
    orders, nuisance
        See `estimate`.
    """

    latitude: float
    duration: Annotated[float, TIME]
    interval: Annotated[float, TIME]
    sigma: Annotated[float, POSITIVE] = 1.0
    q_law: str = "exact"
    turn_period: float | None = 300.0
    sway: Sway | tuple[float, float] | None = None
    ring: Ring | None = None
    prior: Prior | None = (3.0, 10.0)
    orders: tuple[int, ...] | dict[str, tuple[int, ...]] = (128, 256)
    nuisance: tuple[str, ...] = USUAL

    def __post_init__(self) -> None:
        object.__setattr__(self, "sway", sway_of(self.sway))
        if self.count > MAX_COUNT:
            raise UsageError(f"{self.duration:g} s at an interval of {self.interval:g} s are {self.count:.3g} samples; "
                             f"at most {MAX_COUNT:.0e} are computed with")  # fmt: skip
        if self.duration < 2 * self.interval:
            raise UsageError(f"{self.duration:g} s contain fewer than 2 samples at an interval of {self.interval:g} s")

    @property
    def count(self) -> int:
        """Number of samples: the first at the start, the last an interval before the end."""
        return round(self.duration / self.interval)

    def thinned(self) -> "AngleSettings":
        """The same with at most `READINGS` samples that carry the same information."""
        stride = max(1, math.ceil(self.count / MAX_READINGS))
        return replace(self, interval=self.interval * stride, sigma=self.sigma / math.sqrt(stride))

    def gimbals(self, start: float) -> Gimbals:
        """Where the gimbals stand at the samples."""
        time = start + self.interval * np.arange(self.count)
        same = {name: getattr(self, name) for name in ("latitude", "q_law", "sway", "turn_period", "ring")}
        return gimbals(time, **same)


@dataclass(frozen=True, eq=False, repr=False)
class AnglePlan(Value):
    """Expected accuracy of an experiment.

    Attributes
    ----------
    names : tuple of str
        Names of the constants; amplitudes first, `amplitudes` of them.
    errors : array, shape (p,)
        Expected standard deviations, in the unit of sigma.
    correlation : array, shape (p, p)
    condition : float
        Condition number of the samples alone, columns scaled.
    start : float
        s after h = 0.
    h : (low, high)
        Range of h of the equatorial gyro, rad.
    settings : AngleSettings
    periods, mean_periods : mapping of harmonic to period
        Of "128 h" and so on, s: at the start, infinite where the angle stands, and over the interval: its length over
        the number of periods that the angle passes, to and fro.
    findings : tuple of Finding
        What is wrong with it.
    """

    _also: ClassVar[tuple[str, ...]] = ("standard_deviations", "total")
    _alike = ("names errors correlation",)

    names: tuple[str, ...]
    amplitudes: int
    errors: FloatArray
    correlation: FloatArray
    condition: float
    start: float
    h: tuple[float, float]
    settings: AngleSettings
    periods: dict[str, float]
    mean_periods: dict[str, float]
    findings: tuple[Finding, ...] = ()

    @property
    def standard_deviations(self) -> dict[str, float]:
        """Expected standard deviations by name."""
        return dict(zip(self.names, self.errors.tolist(), strict=True))

    @property
    def total(self) -> float:
        """Sum of the expected standard deviations of the amplitudes."""
        return float(self.errors[: self.amplitudes].sum())

    def __getitem__(self, name: str) -> float:
        demand_name("constant", name, self.names)
        return float(self.errors[self.names.index(name)])

    def rows(self) -> tuple[list[str], list[list[Any]]]:
        """Headings and rows."""
        return ["constant", "expected standard deviation"], [list(row) for row in self.standard_deviations.items()]

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data; angles in rad, times in s."""
        chosen = {key: getattr(self.settings, key) for key in ("duration", "interval", "latitude", "q_law", "sigma")}
        return super().to_dict(level) | chosen


@public
def plan(settings: AngleSettings, start: Annotated[float, STAMP]) -> AnglePlan:
    """Expected standard deviations of an experiment with these samples.

    Parameters
    ----------
    settings : AngleSettings
    start : float
        First sample, s after the equatorial gyro's passage of h = 0.

    Raises
    ------
    DataError
        The experiment cannot tell anything of an angle that does not move.
    UnitError, UsageError
        A choice is impossible.

    Examples
    --------
    >>> hour = plan(AngleSettings(np.radians(60), duration=3600.0, interval=10.0, q_law="linear"), start=7200.0)
    >>> round(hour.total, 2), np.degrees(hour.h).round(1).tolist(), round(hour.standard_deviations["S128 h"], 2)
    (1.14, [14.5, 20.7], 0.08)
    """
    angles = settings.gimbals(start)
    harmonics = harmonic_set(settings.orders)
    names, rows = design(angles, harmonics, settings.nuisance)
    before = prior_of(settings.prior, harmonics, len(names))
    alone = known = batch(rows / settings.sigma, np.zeros(len(rows)))  # from the samples alone
    if before is not None:
        known = batch(alone.factor[:, :-1], alone.factor[:, -1], before)
    elif not alone.condition < 1e12:
        raise UsageError("the samples alone do not separate these constants; give prior standard deviations")
    ordered = [(angle, k) for angle, orders in harmonics.items() for k in orders]
    return AnglePlan(names=names, amplitudes=len(amplitude_names(harmonics)), errors=known.errors,
                     correlation=correlation_of(known.covariance), condition=alone.condition, start=float(start),
                     h=(float(angles.h.min()), float(angles.h.max())), settings=settings,
                     periods={f"{k} {angle}": float(angles.period(angle, k)[0]) for angle, k in ordered},
                     mean_periods={f"{k} {angle}": angles.mean_period(angle, k) for angle, k in ordered},
                     findings=caveats(angles, harmonics, names, known, before))  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class Scan(Value):
    """Expected accuracy by the start of the interval.

    Attributes
    ----------
    starts, totals, conditions : arrays, shape (k,)
    h : array, shape (k, 2)
        rad.
    names : tuple of str
        The a amplitudes.
    errors : array, shape (k, a)
        Their standard deviations.
    periods, mean_periods : mapping of harmonic to array, shape (k,)
        See `AnglePlan`.
    best : AnglePlan
        The plan of the window with the smallest total.
    """

    _keys: ClassVar[dict[str, str]] = {"starts": "start", "totals": "total", "conditions": "condition"}

    starts: FloatArray
    totals: FloatArray
    conditions: FloatArray
    h: FloatArray
    names: tuple[str, ...]
    errors: FloatArray
    periods: dict[str, FloatArray]
    mean_periods: dict[str, FloatArray]
    best: AnglePlan

    def rows(self) -> tuple[list[str], list[list[float]]]:
        """Headings and rows."""
        relative = self.totals / self.totals.min()
        columns = (self.starts, *self.h.T, self.totals, self.conditions, relative, *self.errors.T)
        headings = ["start [s]", "h low [rad]", "h high [rad]", "total", "condition", "total over best", *self.names]
        columns += (*self.periods.values(), *self.mean_periods.values())
        headings += [f"{what} {name} [s]" for what in ("period", "mean period") for name in self.periods]
        return headings, [list(row) for row in zip(*(c.tolist() for c in columns), strict=True)]


@public
def scan(settings: AngleSettings, starts: Sequence[float] | None = None) -> Scan:
    """Expected accuracy of every start of the interval, and the best one.

    Parameters
    ----------
    settings : AngleSettings
    starts : sequence of float, optional
        s after h = 0; if omitted, every five minutes (half a duration, if that is less) from there until the interval
        reaches the extreme of h, or begins there if it is longer than a quarter of the earth's turn.

    Raises
    ------
    DataError, UnitError, UsageError
        As for `plan`.

    Examples
    --------
    >>> day = scan(AngleSettings(np.radians(60), duration=3600.0, interval=10.0, q_law="linear"))
    >>> np.degrees(day.best.h).round(1).tolist()
    [13.4, 19.8]
    """
    if starts is None:
        duration, step = settings.duration, min(START_STEP, settings.duration / 2)
        # the last window is the first that reaches the extreme of h
        last = math.ceil((QUARTER - duration) / step) if duration < QUARTER else math.ceil(QUARTER / step)
        starts = (step * np.arange(last + 1)).tolist()
    grid = np.asarray(starts, dtype=np.float64)
    if grid.ndim != 1 or not grid.size:
        raise UsageError(f"starts must be times in s after h = 0, not {starts!r}")
    thin = settings.thinned()
    plans = [plan(thin, float(start)) for start in grid]
    totals = np.array([p.total for p in plans])
    return Scan(starts=grid,
                totals=totals, conditions=np.array([p.condition for p in plans]), h=np.array([p.h for p in plans]),
                names=plans[0].names[: plans[0].amplitudes], errors=np.array([p.errors[: p.amplitudes] for p in plans]),
                periods={name: np.array([p.periods[name] for p in plans]) for name in plans[0].periods},
                mean_periods={name: np.array([p.mean_periods[name] for p in plans]) for name in plans[0].periods},
                best=plan(settings, float(grid[int(totals.argmin())])))  # fmt: skip


@dataclass(frozen=True, eq=False)
class AngleStudy:
    """A result, and its provenance."""

    result: Harmonics | Calibration | AnglePlan | Scan
    settings: dict[str, Any]  # every choice as plain data, under the names of the command line
    level: float = 0.95  # confidence level of intervals
    notes: tuple[str, ...] = ()  # assumptions made when reading
    provenance: dict[str, str] = field(default_factory=provenance_of)  # version and inputs

    def choices(self) -> dict[str, Any]:
        """The recipe that was actually used, as plain data."""
        own = {key: list(v) if isinstance(v, tuple) else v for key, v in self.settings.items()}
        return dict(sorted((own | {"level": self.level}).items()))

    def to_dict(self) -> dict[str, Any]:
        """Plain data of the result, with the recipe and the provenance."""
        made = {"recipe": self.choices(), "notes": list(self.notes), "provenance": self.provenance}
        return self.result.to_dict(self.level) | made
