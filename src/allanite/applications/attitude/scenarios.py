"""Motions that a gyro-vertical meets, and what its sensors read in them, with any noise."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from allanite.extending import FloatArray, Model, Value, public, say, simulate

from .density import GRAVITY, SensorNoise
from .inertial import Inertial

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
    for row in (
        Scenario(say("fixed base"), "level and at rest", _level, np.zeros_like),
        Scenario(say("acceleration"), "1 m/s^2 for 20 s and -1 m/s^2 for 20 s, every two minutes", _level,
                 lambda t: np.where(t % 120.0 < 20, 1.0, np.where(t % 120.0 < 40, -1.0, 0.0))),
        Scenario(
            say("oscillation"), "roll 8 deg at 0.12 Hz and pitch 10 deg at 0.2 Hz, sensor 1 m above the center",
            lambda t: (np.radians(8.0) * np.sin(2 * math.pi * 0.12 * t),
                       np.radians(10.0) * np.sin(2 * math.pi * 0.2 * t)),
            np.zeros_like, 1.0,
        ),
    )
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
    noise = [
        np.stack([simulate(model, n, rate, rng=rng).rate_values for _ in range(3)], axis=1)
        for model in (trial.gyro, trial.accelerometer)
    ]
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
