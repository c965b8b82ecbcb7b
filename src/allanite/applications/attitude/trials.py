"""All filters in all scenarios, and the best one among them."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from allanite.extending import FloatArray, Value, public, say

from .filters import FILTERS, Setting
from .loop import Loop
from .optimum import Optimum
from .scenarios import SCENARIOS, Trial, simulate_motion

DROPPED = 0.2
"""Share of the run, from its start, that is not counted: filters settle."""


def compared() -> dict[str, tuple[str, Setting]]:
    """The filters that are compared: label, name in `FILTERS` and settings."""
    slow = Setting(Loop.of(100.0))
    return {
        say("accelerometer"): ("accelerometer", slow),
        "bortz": ("bortz", slow),
        say("first order, {time:g} s", time=1): ("complementary", Setting(Loop.of(1.0))),
        say("first order, {time:g} s", time=10): ("complementary", Setting(Loop.of(10.0))),
        **{
            say("{time:g} s, angle gate {gate:g} deg", time=10, gate=gate): (
                "complementary",
                Setting(Loop.of(10.0), gate=math.radians(gate)),
            )
            for gate in (1, 2)
        },
        say("first order, {time:g} s", time=100): ("complementary", slow),
        say("{time:g} s, norm gate {gate:g} g", time=100, gate=0.02): ("complementary", replace(slow, norm_gate=0.02)),
        say("second order, {time:g} s, {slow:g} s", time=100, slow=500): (
            "second-order",
            Setting(Loop(0.01, 1 / 500**2)),
        ),
        "mahony, 50 s": ("mahony", Setting(Loop.of(50.0))),
        "madgwick, beta 0.033": ("madgwick", Setting(Loop.of(1.0), beta=0.033)),
        "madgwick, beta 0.001": ("madgwick", Setting(Loop.of(1.0), beta=0.001)),
    }


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


AXES = (1.0, -0.7, 0.5)
"""Biases of the gyros x, y and z, relative to the given one."""


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
