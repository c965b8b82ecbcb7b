"""What a gyro-vertical finds in a recording, and the choices it is found with."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np

from allanite.applications.choices import VerticalChoices

from allanite.extending import (  # isort: skip
    ChannelResult, DataError, Estimate, FloatArray, Header, Job, Model, Record, UsageError, Value, chosen, described,
    row_of, say, spelled)  # fmt: skip

from .filters import FILTERS, AttitudeFilter
from .inertial import Axes
from .loop import Loop, SensorNoise
from .optimum import Optimum
from .prediction import Prediction

PAIRS = ((0, 1), (1, 0))  # the gyro and the accelerometer, among x, y, z, that an angle is found from
SLOWER = 5.0  # time of the bias estimate over the time constant, where only the latter is given


@described
@dataclass(frozen=True, repr=False)
class VerticalSettings(VerticalChoices, Value):
    """Choices of a gyro-vertical.

    Attributes
    ----------
    method : str
        A key of `FILTERS`.
    bias_time : float, optional
        1 / sqrt(k2), s, of a filter that estimates the gyro bias; by default five time constants where one is given.
    axes : str, optional
        Axes of the file that are forward, sideways and vertical, such as "y,-x,z"; by default "x,y,z", and a recording
        with gravity along another axis than z is refused.
    """

    def __post_init__(self) -> None:
        super().__post_init__()
        row_of("filter", self.method, FILTERS)
        if self.axes is not None:
            Axes.of(self.axes)

    @property
    def row(self) -> AttitudeFilter:
        """The filter."""
        return FILTERS[self.method]

    @property
    def turned(self) -> Axes | None:
        """The given axes."""
        return None if self.axes is None else Axes.of(self.axes)

    def model(self, record: Record | Header) -> Model | None:
        """The given noise of a sensor."""
        text = self.gyro if record.signal.name == "gyro" else self.accelerometer
        return None if text is None else Model(text)

    def noises(self, channels: Sequence["VerticalChannel"], duration: float, rate: float) -> list[SensorNoise]:
        """The noise of roll and of pitch, given or identified; empty where that of one is not known."""
        models = [self.model(c.record) or c.model for c in channels]
        pairs = [(models[g], models[2 + a]) for g, a in PAIRS]
        noises = [SensorNoise.of(g, a, duration, rate) for g, a in pairs if g and a]
        return noises if len(noises) == len(pairs) else []

    def loop(self, noises: Sequence[SensorNoise], reasons: Iterable[str]) -> Loop:
        """The filter, as given or the best for the noise; if that is not known, an error gives the reasons."""
        if self.time_constant is not None:
            slow = self.bias_time or (SLOWER * self.time_constant if self.row.estimates else None)
            return Loop(1 / self.time_constant, 0.0 if slow is None else slow**-2)
        if not noises:
            why = "; ".join(dict.fromkeys(filter(None, reasons))) or "the noise is not known"
            cure = spelled("--time-constant S, or the noise with --gyro and --accelerometer", "time_constant=...")
            raise DataError(f"no time constant follows from the noise: {why}; give it with {cure}")
        first = self.row.best(noises)
        return first if self.bias_time is None else replace(first, k2=self.bias_time**-2)


@dataclass(frozen=True, eq=False, repr=False)
class VerticalChannel(ChannelResult):
    """A sensor of the gyro-vertical and its noise; `bias` is its mean, SI, which a gyro has had subtracted."""

    bias: float = 0.0
    alerts: tuple[str, ...] = ()

    @property
    def model(self) -> Model | None:
        """The noise of the prediction: the valid terms; None where no model explains the record."""
        return None if self.noise is None or not self.noise.explained else self.noise.usable()

    @property
    def unknown(self) -> str:
        """Why there is no model; empty if there is one, or it was given."""
        return self.refusal or ("" if self.noise is None else self.noise.rejection)

    @property
    def wrong(self) -> tuple[Estimate, ...]:
        """Terms that the prediction lacks because their coefficients are not valid."""
        if self.noise is None or not self.noise.explained:
            return ()
        return tuple(e for e in self.noise.fit if e.status == "not valid")

    @property
    def fitted(self) -> Model | None:
        """`model` and the terms that it lacks, as they were fitted."""
        if self.model is None or self.fit is None:
            return None
        symbols = {e.symbol for e in self.wrong}
        return Model((*self.model, *(t for t in self.fit.model if t.symbol in symbols)))

    @property
    def left_out(self) -> tuple[str, ...]:
        """`wrong` in sentences."""
        return tuple(say("{symbol} is left out of the prediction because its coefficient is not valid: {reason}",
                         symbol=e.symbol, reason=e.reason) for e in self.wrong)  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class Angle(Value):
    """Roll or pitch.

    Attributes
    ----------
    name : str
    record : Record or Header
        The angle, deg.
    mean, deviation : float
        Over the recording, rad.
    prediction : Prediction or None
        With the filter that was used; None without models, or for a filter that is not linear.
    optimum : Optimum or None
        The best filters for this angle.
    gyro, accelerometer : str
        Names of its sensors.
    doubts : tuple of str
        Warnings about the prediction: no model explains the noise of a sensor, or terms of it are left out.
    """

    name: str
    record: Record | Header
    mean: float
    deviation: float
    prediction: Prediction | None
    optimum: Optimum | None
    gyro: str
    accelerometer: str
    doubts: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False, repr=False)
class VerticalStudy(Job[VerticalChannel]):
    """Roll and pitch of a recording.

    Attributes
    ----------
    settings : VerticalSettings
    angles : tuple of Angle
        Roll and pitch.
    loop : Loop
        The filter that was used.
    rate : float
        Sampling rate, Hz.
    held : int
        Samples in which the accelerometers were ignored.
    falling : int
        Of these, samples in free fall.
    downward : bool
        Whether the vertical axis points down.
    remarks : tuple of str
    """

    _channel: ClassVar = VerticalChannel

    settings: VerticalSettings
    angles: tuple[Angle, ...]
    loop: Loop
    rate: float
    held: int = 0
    falling: int = 0
    downward: bool = False
    remarks: tuple[str, ...] = field(default=())

    @property
    def roll(self) -> FloatArray:
        """Roll, rad."""
        return _values(self.angles[0])

    @property
    def pitch(self) -> FloatArray:
        """Pitch, rad."""
        return _values(self.angles[1])

    def choices(self) -> dict[str, Any]:
        """The recipe and the settings that were actually used, as plain data."""
        return super().choices() | chosen(self.settings)


def _values(angle: Angle) -> FloatArray:
    if not isinstance(angle.record, Record):
        raise UsageError("a stored result has no samples; compute it again from the recording")
    return np.asarray(angle.record.values * math.pi / 180)
