"""What a gyro-vertical finds in a recording, and the choices it is found with."""

import math
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from allanite.extending import (
    ChannelResult,
    Estimate,
    FloatArray,
    Header,
    Job,
    Model,
    Record,
    UsageError,
    Value,
    chosen,
    given,
    parse_model,
    say,
    spelled,
)

from .axes import Axes
from .filters import FILTERS, AttitudeFilter, filter_named
from .loop import Loop
from .optimum import Optimum
from .prediction import Prediction


@dataclass(frozen=True, repr=False)
class VerticalSettings(Value):
    """Choices of a gyro-vertical.

    Attributes
    ----------
    method : str
        A key of `FILTERS`.
    time_constant : float, optional
        s; by default the best for the identified noise.
    bias_time : float, optional
        1 / sqrt(k2), s, of a filter that estimates the gyro bias; by default five time constants where one is given.
    gyro, accelerometer : str, optional
        Noise models as `parse_model` reads them, instead of identified ones.
    gate : float, optional
        Innovation of the angle, deg, above which the accelerometers are ignored.
    samples : int
        Samples of the coning correction, 1 to 4.
    keep_bias : bool
        Whether the mean rates are kept; those of a static recording are subtracted otherwise.
    axes : str, optional
        Axes of the file that are forward, sideways and vertical, such as "y,-x,z"; by default "x,y,z", and a recording
        with gravity along another axis than z is refused.
    """

    method: str = "complementary"
    time_constant: float | None = None
    bias_time: float | None = None
    gyro: str | None = None
    accelerometer: str | None = None
    gate: float | None = None
    samples: int = 2
    keep_bias: bool = False
    axes: str | None = None

    def __post_init__(self) -> None:
        filter_named(self.method)
        if self.axes is not None:
            Axes.of(self.axes)
        for name in ("time_constant", "bias_time", "gate"):
            value = getattr(self, name)
            if value is not None and not (math.isfinite(value) and value > 0):
                option = spelled("--" + name.replace("_", "-"), name)
                raise UsageError(f"{option} must be above 0, not {given(value)}")

    @property
    def row(self) -> AttitudeFilter:
        """The filter."""
        return FILTERS[self.method]

    @property
    def turned(self) -> Axes | None:
        """The given axes."""
        return None if self.axes is None else Axes.of(self.axes)

    @property
    def models(self) -> tuple[Model | None, Model | None]:
        """The given noise of gyro and accelerometer."""
        gyro, accelerometer = (None if t is None else parse_model(t) for t in (self.gyro, self.accelerometer))
        return gyro, accelerometer


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
        return tuple(
            say("{symbol} is left out of the prediction because its coefficient is not valid: {reason}",
                symbol=e.symbol, reason=e.reason) for e in self.wrong
        )  # fmt: skip


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
