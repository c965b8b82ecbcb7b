"""Motions that a gyro-vertical meets, what its sensors read in them, and all filters tried in all of them."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from allanite.extending import FloatArray, Model, Value, public, say, simulate

from .filters import FILTERS, Setting
from .inertial import Inertial
from .loop import GRAVITY, Loop, SensorNoise
from .optimum import Optimum

Motion = tuple[FloatArray, FloatArray]


@dataclass(frozen=True)
class Scenario:
    """A row of `SCENARIOS`."""

    name: str
    title: str
    angles: Callable[[FloatArray], Motion]
    forward: Callable[[FloatArray], FloatArray]
    lever: float = 0.0  # height of the sensor above the center of rotation, m


def _level(t: FloatArray) -> Motion:
    return np.zeros_like(t), np.zeros_like(t)


SCENARIOS: dict[str, Scenario] = {
    row.name: row
    for row in (Scenario(say("fixed base"), "level and at rest", _level, np.zeros_like),
                Scenario(say("acceleration"), "1 m/s^2 for 20 s and -1 m/s^2 for 20 s, every two minutes",
                         _level, lambda t: np.where(t % 120.0 < 20, 1.0, np.where(t % 120.0 < 40, -1.0, 0.0))),
                Scenario(say("oscillation"), "roll 8 deg at 0.12 Hz and pitch 10 deg at 0.2 Hz, sensor 1 m above the "
                         "center", lambda t: (np.radians(8.0) * np.sin(2 * math.pi * 0.12 * t),
                                              np.radians(10.0) * np.sin(2 * math.pi * 0.2 * t)),
                         np.zeros_like, 1.0))
}  # fmt: skip


@dataclass(frozen=True, repr=False)
class Trial(Value):
    """The sensors that are taken through a scenario, and for how long.

    Attributes
    ----------
    gyro, accelerometer : Model, Term or Fit
        The noise of every axis.
    bias : (x, y, z)
        Constant biases of the gyros, rad/s.
    rate, duration : float
        Sampling rate, Hz, and length, s.
    instant : bool
        Whether the gyros read the rate at the end of each interval, as without a filter before the sampling, instead of
        its mean: the integrated angle then leads by half an interval.

    Raises
    ------
    UsageError, UnitError
        As for `predicted_error`.
    """

    gyro: Model
    accelerometer: Model
    bias: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rate: float = 100.0
    duration: float = 600.0
    instant: bool = False

    def __post_init__(self) -> None:
        noise = SensorNoise.of(self.gyro, self.accelerometer, self.duration, self.rate)
        object.__setattr__(self, "gyro", noise.gyro)
        object.__setattr__(self, "accelerometer", noise.accelerometer)


@public
def simulate_motion(scenario: Scenario, trial: Trial, *, rng: np.random.Generator) -> tuple[Inertial, FloatArray]:
    """Simulate what gyros and accelerometers read in a scenario; the filters start aligned.

    Returns
    -------
    inertial : Inertial
    truth : array, shape (n, 2)
        Roll and pitch at the end of each interval, rad.

    Examples
    --------
    >>> from allanite import N
    >>> trial = Trial(N(0.3, "deg/sqrt(h)"), N(100, "ug/sqrt(Hz)"), duration=60)
    >>> found, truth = simulate_motion(SCENARIOS["oscillation"], trial, rng=np.random.default_rng(1))
    >>> found.gyro.shape, float(np.degrees(truth.max(axis=0))[0].round(1))
    ((6000, 3), 8.0)
    """
    n, rate = round(trial.duration * trial.rate), trial.rate
    t = (np.arange(n) + 1) / rate
    # mean rates over each interval by Simpson's rule
    nodes = ((1.0, 0.0),) if trial.instant else ((1 / 6, 1.0), (4 / 6, 0.5), (1 / 6, 0.0))
    rates = sum(w * _rates(scenario, t - back / rate) for w, back in nodes)
    models = (trial.gyro, trial.accelerometer)
    noise = [np.stack([simulate(m, n, rate, rng=rng).rate_values for _ in range(3)], axis=1) for m in models]
    roll, pitch = scenario.angles(t)
    ahead = scenario.forward(t)
    along, up = ahead * np.cos(pitch) - GRAVITY * np.sin(pitch), ahead * np.sin(pitch) + GRAVITY * np.cos(pitch)
    force = np.stack([along, up * np.sin(roll), up * np.cos(roll)], axis=1)
    if scenario.lever:
        h = 1e-3
        omega, turning = _rates(scenario, t), (_rates(scenario, t + h) - _rates(scenario, t - h)) / (2 * h)
        arm = np.broadcast_to(np.array([0.0, 0.0, scenario.lever]), omega.shape)
        force = np.asarray(force + np.cross(turning, arm) + np.cross(omega, np.cross(omega, arm)))
    start = [float(angle[0]) for angle in scenario.angles(np.zeros(1))]
    gyro = np.asarray(rates) + noise[0] + np.array(trial.bias)
    return Inertial(gyro, force + noise[1], rate, aligned=(start[0], start[1])), np.stack((roll, pitch), axis=1)


def _rates(scenario: Scenario, t: FloatArray) -> FloatArray:
    """Rates in the axes of the body, from differences of the angles."""
    h = 1e-4
    (roll, _), after, before = scenario.angles(t), scenario.angles(t + h), scenario.angles(t - h)
    droll, dpitch = ((a - b) / (2 * h) for a, b in zip(after, before, strict=True))
    return np.stack([droll, dpitch * np.cos(roll), -dpitch * np.sin(roll)], axis=1)


DROPPED = 0.2  # share of the run, from its start, that is not counted: filters settle


def compared() -> dict[str, tuple[str, Setting]]:
    """The filters that are compared: label, name in `FILTERS` and settings."""
    fast, middle, slow = (Setting(Loop.of(tau)) for tau in (1.0, 10.0, 100.0))
    narrow, wide, second = math.radians(1), math.radians(2), Setting(Loop(0.01, 1 / 500**2))
    return {
        say("accelerometer"): ("accelerometer", slow), "bortz": ("bortz", slow),
        say("first order, {time:g} s", time=1): ("complementary", fast),
        say("first order, {time:g} s", time=10): ("complementary", middle),
        say("{time:g} s, angle gate {gate:g} deg", time=10, gate=1): ("complementary", replace(middle, gate=narrow)),
        say("{time:g} s, angle gate {gate:g} deg", time=10, gate=2): ("complementary", replace(middle, gate=wide)),
        say("first order, {time:g} s", time=100): ("complementary", slow),
        say("{time:g} s, norm gate {gate:g} g", time=100, gate=0.02): ("complementary", replace(slow, norm_gate=0.02)),
        say("second order, {time:g} s, {slow:g} s", time=100, slow=500): ("second-order", second),
        "mahony, 50 s": ("mahony", Setting(Loop.of(50.0))),
        "madgwick, beta 0.033": ("madgwick", replace(fast, beta=0.033)),
        "madgwick, beta 0.001": ("madgwick", replace(fast, beta=0.001)),
    }  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class ScenarioErrors(Value):
    """Errors of filters in the scenarios.

    Attributes
    ----------
    trial : Trial
    filters, scenarios : tuple of str
    rms : array, shape (filters, scenarios)
        RMS over roll and pitch after the first fifth of the run, rad.
    worst : array, shape (filters, scenarios)
        Largest error there, rad.
    """

    _alike = ("filters rms worst", "scenarios rms.T worst.T")

    trial: Trial
    filters: tuple[str, ...]
    scenarios: tuple[str, ...]
    rms: FloatArray
    worst: FloatArray

    @property
    def winners(self) -> tuple[str, ...]:
        """The best filter of each scenario."""
        return tuple(self.filters[i] for i in self.rms.argmin(axis=0))

    def _summary(self) -> str:
        return ", ".join(f"{s}: {w}" for s, w in zip(self.scenarios, self.winners, strict=True))


@public
def compare_filters(
    trial: Trial, *, rng: np.random.Generator, filters: Mapping[str, tuple[str, Setting]] | None = None
) -> ScenarioErrors:
    """Run filters through every scenario.

    Parameters
    ----------
    trial : Trial
    rng : numpy.random.Generator
        The source of randomness.
    filters : mapping of label to (name, Setting), optional
        By default those of `compared`.

    Returns
    -------
    ScenarioErrors
    """
    chosen = compared() if filters is None else dict(filters)
    columns = []
    for scenario in SCENARIOS.values():
        data, truth = simulate_motion(scenario, trial, rng=rng)
        first = round(DROPPED * len(truth))
        errors = [FILTERS[name].run(data, setting)[0] - truth for name, setting in chosen.values()]
        columns.append([(math.sqrt((e[first:] ** 2).mean()), np.abs(e[first:]).max()) for e in errors])
    rms, worst = np.array(columns).transpose(2, 1, 0)
    return ScenarioErrors(trial, tuple(chosen), tuple(SCENARIOS), rms, worst)


@dataclass(frozen=True, eq=False, repr=False)
class VerticalDesign(Value):
    """The best filters for given noise, and the errors of all filters in the scenarios if they were asked for."""

    optimum: Optimum
    scenarios: ScenarioErrors | None = None

    def _summary(self) -> str:
        return self.optimum._summary()


AXES = (1.0, -0.7, 0.5)  # biases of the gyros x, y and z, relative to the given one


def design(
    found: Optimum, *, bias: float = 0.0, scenarios: bool = False, rate: float | None = None, seed: int = 1
) -> VerticalDesign:
    """The best filters, with the errors of `compared` filters and of the best one in every scenario."""
    if not scenarios:
        return VerticalDesign(found)
    chosen = {say("best, first order"): ("complementary", Setting(found.first.loop)), **compared()}
    x, y, z = (bias * share for share in AXES)
    trial = Trial(found.first.gyro, found.first.accelerometer, (x, y, z), rate or 100.0)
    return VerticalDesign(found, compare_filters(trial, rng=np.random.default_rng(seed), filters=chosen))
