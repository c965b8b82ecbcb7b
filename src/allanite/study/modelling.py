"""Settings of the uses of a noise model: plans, checks and state spaces."""

from dataclasses import dataclass
from typing import ClassVar

from allanite.core.errors import UsageError
from allanite.core.model import Model
from allanite.core.notation import split_quantities
from allanite.core.plain import Value
from allanite.core.units import convert
from allanite.phrases.wording import spelled
from allanite.planning.datasheets import claimed
from allanite.planning.plan import DURATIONS
from allanite.planning.sensors import sensor as typical

from .recipe import IDENTIFYING, READING, SELECTING
from .settings import CheckChoices, NoiseChoices, PlanChoices, StateSpaceChoices


def ways() -> str:
    """The choices that give a noise without a recording."""
    return spelled("--model, --sensor or --datasheet", "model, sensor or datasheet")


@dataclass(frozen=True, repr=False)
class NoiseSettings(NoiseChoices, Value):
    """The source of the noise if there is no recording.

    Attributes
    ----------
    model : str, optional
        Terms as `Model` reads them.
    sensor : str, optional
        Or a name in `SENSORS`.
    datasheet : str, optional
        Or a name in `DATASHEETS`, followed by accelerometer if it is not its gyro that is meant.
    unexplained : bool
        Whether the best model of a recording is used although it does not explain the record.
    """

    identifies: ClassVar[bool] = False
    """Whether the options of the identification also apply to a given model."""

    def given(self) -> Model | None:
        """The given model, or that of the sensor or of the data sheet; None if there is none of them."""
        makers = ((self.model, Model), (self.sensor, typical), (self.datasheet, lambda text: claimed(text)[0]))
        found = [(text, make) for text, make in makers if text is not None]
        if len(found) > 1:
            raise UsageError(f"the noise is given twice: use only one of {ways()}")
        return found[0][1](found[0][0]) if found else None

    def instead_of(self, source: object) -> Model | None:
        """The given model; None if there is a `source` in its place."""
        model = self.given()
        if (model is None) == (source is None):
            raise UsageError(f"give either a recording, or the noise with {ways()}")
        return model

    @property
    def name(self) -> str:
        """What the given model is called."""
        return self.sensor or self.datasheet or ""

    def counting(self, *, recorded: bool) -> tuple[str, ...]:
        """The keys of a recipe that apply, for a recording or a given model."""
        if recorded:
            return (*READING, *SELECTING, *IDENTIFYING)
        return ("rate", *(IDENTIFYING if self.identifies else ()))


@dataclass(frozen=True, repr=False)
class PlanSettings(PlanChoices, NoiseSettings):
    """Choices of a plan: `durations` in s, `accuracy` as a share, `ramp` as for `plan`."""

    durations: tuple[float, ...] = DURATIONS


@dataclass(frozen=True, repr=False)
class SelfCheckSettings(CheckChoices, NoiseSettings):
    """Choices of a check.

    Attributes
    ----------
    duration, samples : float, int, optional
        Length of the simulated records, given by one of the two; by default that of the recording.
    records, seed : int
        Number of records to simulate, and the seed of the random number generator.
    max_bias, min_coverage, max_false, max_missed : float, optional
        Limits as shares, see `SelfCheck.exceeded`.
    """

    identifies: ClassVar[bool] = True

    @property
    def limits(self) -> dict[str, float]:
        """The given limits, as shares, by the names used by `SelfCheck.exceeded`."""
        named = {
            "bias": self.max_bias, "coverage": self.min_coverage, "false": self.max_false, "missed": self.max_missed
        }  # fmt: skip
        return {name: value for name, value in named.items() if value is not None}


@dataclass(frozen=True, repr=False)
class StateSpaceSettings(StateSpaceChoices, NoiseSettings):
    """Choices of a state space: `ripple` as a share, `turn_on` with its unit, others as for `state_space`."""

    def __post_init__(self) -> None:
        if len(self.tau) != 2:
            raise UsageError(f"expected two averaging times, e.g. 1,1000 or '1 s,1 h', not {self.tau!r}")

    def bias(self, si: str) -> float:
        """The turn-on bias in the unit `si`."""
        if self.turn_on is None:
            return 0.0
        found = split_quantities(self.turn_on.split())
        if len(found) != 1 or not found[0][1]:
            raise UsageError(f"a bias has the form '3 deg/h', not {self.turn_on!r}")
        return convert(*found[0], si)


Use = PlanSettings | SelfCheckSettings | StateSpaceSettings
"""What a noise model is used for."""
