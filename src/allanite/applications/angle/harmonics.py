"""Harmonics: the periodic error of one angle sensor, its correction, and how the measured cosine depends on it."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from allanite.extending import (  # isort: skip
    Correction, FloatArray, Record, Recording, UsageError, demand_name, public, read_key, readout_noise, say, spelled
)  # fmt: skip

from .geometry import ANGLES, EARTH_RATE, Gimbals, demand_angles, demand_motion
from .solve import Solution, quantile

Orders = Sequence[int] | Mapping[str, Sequence[int]]

EQUATORIAL = ("h", "q")  # the sensors that are estimated unless others are named
MAX_P = 0.01  # p-value below which an amplitude is called identified
COLUMNS = {"orders": "order", "sine": "S", "cosine": "C"}  # keys of a stored term, by the attribute


class Nuisance(NamedTuple):
    """A constant that is estimated jointly: its meaning, its power of time beyond an angle, and its column."""

    meaning: str
    per_time: int
    column: Callable[[Gimbals], FloatArray]


def _turning(g: Gimbals) -> tuple[FloatArray, FloatArray]:
    if g.rho is None:
        raise UsageError(spelled("ax and az need the angle rho of the auto-compensating rotation (--rho or "
                                 "--turn-period); without one omit them: --nuisance A1,A2,A3",
                                 "ax and az need the angle rho of the auto-compensating rotation (turn_period=...); "
                                 "without one omit them: nuisance=('A1', 'A2', 'A3')"))  # fmt: skip
    return np.sin(g.rho), np.cos(g.rho)


NUISANCES: dict[str, Nuisance] = {
    "ax": Nuisance(say("misalignment of the rotor's optical sensor in the rotating frame, x"),
                   0, lambda g: g.partials["h"] * _turning(g)[1] + g.g * _turning(g)[0]),
    "az": Nuisance(say("the same, z"), 0, lambda g: g.g * _turning(g)[1] - g.partials["h"] * _turning(g)[0]),
    "A1": Nuisance(say("daily sine of the gyros' unknown drift"), 0, lambda g: np.sin(EARTH_RATE * g.time)),
    "A2": Nuisance(say("daily cosine of it"), 0, lambda g: np.cos(EARTH_RATE * g.time)),
    "A3": Nuisance(say("linear growth of it"), 1, lambda g: g.time),
    "A0": Nuisance(say("a constant"), 0, lambda g: np.ones(g.time.size)),
}  # fmt: skip
"""Constants estimated jointly with the harmonics; by default all but A0.

The rows of ax and az, ``f1 cos(rho) + g sin(rho)`` and ``-f1 sin(rho) + g cos(rho)``, are an assumption: a small vector
fixed in the turning frame, seen along the measured direction. The literature names the two constants only.
"""

POLAR = ("The polar gyro's gimbals do not move on a fixed base (they stay at the latitude and 0): its sensors can be "
         "estimated under sway only")  # fmt: skip
EARTHLY = "Choose a longer interval, another part of the day, a latitude off the pole, or sway the base"
REMEDIES = {"h_polar": POLAR, "q_polar": POLAR, "mu": "Turn the outer ring"}
"""What makes an angle move: of the equatorial gyro, and of those that do not move with the earth."""

USUAL = ("ax", "az", "A1", "A2", "A3")


def harmonic_set(orders: Orders) -> dict[str, tuple[int, ...]]:
    """Angle: orders, from a mapping or from orders for both sensors of the equatorial gyro."""
    if isinstance(orders, Mapping):
        chosen = {angle: orders_of(k, f"orders of {angle}") for angle, k in orders.items()}
    else:
        chosen = dict.fromkeys(EQUATORIAL, orders_of(orders))
    demand_angles(chosen)
    if not chosen:
        raise UsageError(f"no angle is selected; angles: {', '.join(ANGLES)}")
    return chosen


def amplitude_names(harmonics: Mapping[str, tuple[int, ...]]) -> tuple[str, ...]:
    """``S128 h``, ``C128 h``, ...: sine and cosine amplitudes in the order of the columns."""
    return tuple(f"{wave}{k} {angle}" for angle, orders in harmonics.items() for k in orders for wave in "SC")


def design(
    gimbals: Gimbals, harmonics: Mapping[str, tuple[int, ...]], nuisance: Sequence[str], *, still: bool = False
) -> tuple[tuple[str, ...], FloatArray]:
    """Names of the constants, and the rows by which the measured cosine depends on them, shape (n, p).

    Refuses angles that do not move, unless they may be `still`.
    """
    for name in nuisance:
        demand_name("nuisance", name, NUISANCES)
    if len(set(nuisance)) < len(nuisance):
        raise UsageError(f"a nuisance is given twice: {', '.join(nuisance)}")
    for angle, orders in () if still else harmonics.items():
        demand_motion(f"the angle {angle}", gimbals.span(angle), orders, REMEDIES.get(angle, EARTHLY))
    f = gimbals.partials
    blocks = [f[a][:, None] * waves(getattr(gimbals, a), orders) for a, orders in harmonics.items()]
    columns = [NUISANCES[name].column(gimbals) for name in nuisance]
    return (*amplitude_names(harmonics), *nuisance), np.column_stack([*blocks, *columns])


def waves(angle: FloatArray, orders: tuple[int, ...]) -> FloatArray:
    """``sin k a, cos k a`` for each order k, shape (n, 2 len(orders))."""
    return np.column_stack([wave(k * angle) for k in orders for wave in (np.sin, np.cos)])


def orders_of(orders: Any, what: str = "orders") -> tuple[int, ...]:
    """Orders of harmonics: different positive whole numbers."""
    try:
        whole = tuple(int(k) for k in orders)
        fine = all(k == given and k > 0 for k, given in zip(whole, orders, strict=True))
    except (TypeError, ValueError):
        whole, fine = (), False
    if not fine or not whole or len(set(whole)) < len(whole):
        raise UsageError(f"{what} must be different positive whole numbers such as [128, 256], not {orders!r}")
    return whole


@dataclass(frozen=True, eq=False, repr=False)
class Harmonics(Correction):
    """``error(a) = sum of S_k sin(k a) + C_k cos(k a)`` of an angle sensor, a being its sample.

    Attributes
    ----------
    orders : tuple of int
        The k.
    sine, cosine : arrays, shape (len(orders),)
        S and C, rad.
    covariance : array, shape (2 len(orders), 2 len(orders))
        Covariance of S, C, S, C, ..., rad^2; zero where the amplitudes are known.
    freedom : float
        Degrees of freedom that intervals have.
    name : str
        Name of the angle.
    solution : Solution, optional
        How they were estimated, with what else was.

    Examples
    --------
    >>> known = Harmonics.of({128: (3e-5, 0.0), 256: (0.0, 1e-5)})
    >>> known.amplitude.tolist(), bool(abs(known.at(np.pi / 256)[()] - 3e-5 + 1e-5) < 1e-18)
    ([3e-05, 1e-05], True)
    >>> record = Record(np.arange(4) * np.pi / 256, rate=1.0, unit="rad", kind="angle", name="encoder")
    >>> known.apply(record).history
    ('corrected: harmonics 128, 256 of the angle',)
    """

    _alike = ("orders sine cosine",)

    orders: tuple[int, ...]
    sine: FloatArray
    cosine: FloatArray
    covariance: FloatArray
    freedom: float = math.inf
    name: str = ""
    solution: Solution | None = None

    @classmethod
    def of(cls, amplitudes: dict[int, tuple[float, float]], name: str = "") -> "Harmonics":
        """Known harmonics, as order: (S, C) in rad."""
        orders = orders_of(list(amplitudes))
        sine, cosine = np.array(list(amplitudes.values()), dtype=np.float64).T
        return cls(orders, sine, cosine, np.zeros((2 * len(orders),) * 2), name=name)

    @property
    def what(self) -> str:
        """Which harmonics, for the record's history."""
        return say("harmonics {orders} of the angle", orders=", ".join(map(str, self.orders)))

    def at(self, angle: ArrayLike) -> FloatArray:
        """The error at an angle, rad, of the shape of `angle`."""
        a = np.asarray(angle, dtype=np.float64)
        total = np.zeros(a.shape)
        for k, s, c in zip(self.orders, self.sine, self.cosine, strict=True):
            total += s * np.sin(k * a) + c * np.cos(k * a)
        return total

    def read(self, angle: FloatArray) -> FloatArray:
        """The output of the sensor at a true angle, rad: the r for which ``r - at(r)`` is that angle.

        Raises
        ------
        UsageError
            The errors are so large relative to their periods that one output represents several angles.
        """
        if float((self.amplitude * np.array(self.orders)).sum()) >= 1:
            raise UsageError("errors this large relative to their periods make the output of the sensor ambiguous")
        reading, step = angle, np.inf
        while step > 1e-15:
            before, reading = reading, angle + self.at(reading)
            step = min(float(np.abs(reading - before).max()), 0.999 * step)
        return reading

    def error(self, record: Record, along: Recording | None = None) -> FloatArray:
        """The error of each reading of a record of angles, rad.

        Raises
        ------
        UsageError
            The record does not contain angles: rates and increments do not determine the position of the sensor.
        """
        if record.kind != "angle" or record.signal.name != "gyro":
            raise UsageError(f"harmonics of an angle correct a record of kind 'angle' in rad or deg, but "
                             f"{record.name!r} is of kind {record.kind!r} in {record.unit}")  # fmt: skip
        return self.at(record.values * record.factor)

    @property
    def amplitude(self) -> FloatArray:
        """``sqrt(S^2 + C^2)`` of each order, rad."""
        return np.hypot(self.sine, self.cosine)

    @property
    def phase(self) -> FloatArray:
        """``atan2(C, S)`` of each order, rad: the error is amplitude times sin(k a + phase)."""
        return np.arctan2(self.cosine, self.sine)

    @property
    def amplitude_error(self) -> FloatArray:
        """Standard error of each amplitude, rad: of its projection on the estimated direction."""
        size = np.where(self.amplitude > 0, self.amplitude, 1.0)
        along = np.stack([np.where(self.amplitude > 0, self.sine / size, 1.0), self.cosine / size])
        return np.array([math.sqrt(along[:, i] @ self._part(i) @ along[:, i]) for i in range(len(self.orders))])

    def _part(self, i: int) -> FloatArray:
        return self.covariance[2 * i : 2 * i + 2, 2 * i : 2 * i + 2]

    def p(self, order: int) -> float:
        """p-value of each amplitude (chi-square or F of S and C together)."""
        from scipy.special import fdtrc

        i = self._index(order)
        pair = np.array([self.sine[i], self.cosine[i]])
        if not self._part(i).any():
            return 0.0 if pair.any() else 1.0
        square = float(pair @ np.linalg.solve(self._part(i), pair))
        return math.exp(-square / 2) if math.isinf(self.freedom) else float(fdtrc(2, self.freedom, square / 2))

    def found(self, order: int) -> bool:
        """Whether the harmonic is significant (p below 1 %)."""
        return self.p(order) < MAX_P

    def status(self, order: int) -> str:
        """Whether it is "identified", "absent", or "weak": significant, but the noise is not as assumed."""
        solution = self.solution
        if not self.found(order) and (solution is None or solution.complete):
            return "absent"
        sound = solution is None or (solution.complete and all(check.passed for check in solution.checks))
        return "identified" if sound else "weak"

    def upper(self, order: int) -> float:
        """95 % upper limit of an amplitude, rad, for a flat prior of S and C."""
        from scipy.special import chndtrix

        i = self._index(order)
        variance = float(np.linalg.eigvalsh(self._part(i))[-1])
        if variance == 0:
            return float(self.amplitude[i])
        return math.sqrt(variance * float(chndtrix(0.95, 2.0, self.amplitude[i] ** 2 / variance)))

    def interval(self, order: int, level: float = 0.95) -> tuple[float, float]:
        """Two-sided confidence interval of an amplitude, rad."""
        i = self._index(order)
        half = quantile(level, self.freedom) * float(self.amplitude_error[i])
        return max(0.0, float(self.amplitude[i]) - half), float(self.amplitude[i]) + half

    def limits(self, order: int, level: float = 0.95) -> tuple[float | None, float | None]:
        """The interval of an amplitude, rad; None where the model is not complete, so that it would not hold."""
        return self.interval(order, level) if self.solution is None or self.solution.complete else (None, None)

    def _index(self, order: int) -> int:
        if order not in self.orders:
            raise UsageError(f"order {order!r} was not estimated; orders: {', '.join(map(str, self.orders))}")
        return self.orders.index(order)

    def rows(self, level: float = 0.95) -> tuple[list[str], list[list[Any]]]:
        """Headings and rows, rad."""
        headings = ["angle", "order", "S", "S error", "C", "C error", "amplitude", "low", "high", "phase", "status"]
        errors = np.sqrt(np.diag(self.covariance))
        columns = (self.sine, errors[::2], self.cosine, errors[1::2], self.amplitude)
        rows = [[self.name, k, *numbers, *self.limits(k, level), phase, self.status(k)]
                for k, phase, *numbers in zip(self.orders, self.phase.tolist(),
                                              *(column.tolist() for column in columns), strict=True)]  # fmt: skip
        return headings, rows

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data, SI."""
        headings, rows = self.rows(level)
        keys = [heading.replace(" ", "_") for heading in headings]
        terms = [dict(zip(keys, row, strict=True)) for row in rows]
        for term in terms:
            limited = term["status"] == "absent" and term["low"] is not None
            term["upper"] = self.upper(term["order"]) if limited else None
        data: dict[str, Any] = {"allanite": 1, "type": "Harmonics", "name": self.name, "unit": "rad", "level": level,
                                "terms": terms, "covariance": self.covariance.tolist(),
                                "freedom": None if math.isinf(self.freedom) else self.freedom}  # fmt: skip
        return data | ({} if self.solution is None else {"solution": self.solution.shown(level)})

    @classmethod
    def _stored(cls, data: dict[str, Any]) -> "Harmonics":
        """The harmonics written by `to_dict`, without their solution."""
        terms = read_key(data, "terms", tuple[dict[str, Any], ...])
        columns = {name: [term.get(key) for term in terms] for name, key in COLUMNS.items()}
        freedom = "inf" if data.get("freedom") is None else data["freedom"]
        read = super()._stored(data | columns | {"freedom": freedom, "solution": None})
        C, size = read.covariance, 2 * len(read.orders)
        if C.shape != (size, size) or not np.isfinite(C).all() or not np.allclose(C, C.T, atol=0.0):
            raise UsageError("covariance must have two equal rows and columns for each order: the data were changed")
        if (np.linalg.eigvalsh(C) < -1e-9 * np.trace(C)).any() or (np.diag(C) < 0).any():
            raise UsageError("covariance must not be negative in any direction: the data were changed")
        return read


@public
def simulate(
    gimbals: Gimbals, harmonics: Mapping[str, Harmonics], *, nuisance: Mapping[str, float] | None = None, sigma: float,
    walk: float = 0.0, rng: "np.random.Generator",
) -> FloatArray:  # fmt: skip
    """Measured minus computed cosine of the angle between the momentum vectors, with known errors of the sensors.

    The errors are added to the angles and the cosine is computed of them, without linearising.

    Parameters
    ----------
    gimbals : Gimbals
        Where the gimbals stand.
    harmonics : mapping of angle to Harmonics
        The errors of their sensors, rad.
    nuisance : mapping of name to value, optional
        Keys of `design.NUISANCES`, rad (rad/s for A3).
    sigma : float
        Standard deviation of the white noise of a sample, rad.
    walk : float
        Step of a random walk from sample to sample, rad.
    rng : numpy.random.Generator
        The source of randomness.

    Returns
    -------
    array, shape (n,)
    """
    z = readings(gimbals, harmonics).cosine - gimbals.cosine
    for name, value in (nuisance or {}).items():
        demand_name("nuisance", name, NUISANCES)
        z += value * NUISANCES[name].column(gimbals)
    return z + readout_noise(z.size, sigma=sigma, walk=walk, rng=rng)


@public
def readings(gimbals: Gimbals, harmonics: Mapping[str, Harmonics]) -> Gimbals:
    """The angles as sensors with these errors read them."""
    demand_angles(harmonics)
    return gimbals.moved(**{angle: h.read(getattr(gimbals, angle)) for angle, h in harmonics.items()})
