"""Roll and pitch of a recording, with a filter that follows from the identified noise."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.errors import DataError, UsageError, given
from allanite.core.header import Header
from allanite.core.language import say
from allanite.core.model import Model
from allanite.core.notation import parse_model
from allanite.core.plain import Value
from allanite.core.record import Record, Recording
from allanite.core.wording import spelled
from allanite.study.channels import Inspected, Job, Progress, Source, each_channel, open_recording, provenance_of
from allanite.study.noise import ChannelResult, noise_of
from allanite.study.recipe import Recipe, chosen

from .density import GRAVITY, Densities
from .filters import FILTERS, AttitudeFilter, Setting, filter_named
from .inertial import Inertial, demand_whole, inertial, six_channels
from .loop import Loop, kalman
from .optimum import Optimum, best_loop, best_second, optimum
from .prediction import Prediction, predict

ANGLES = ("roll", "pitch")
PAIRS = ((0, 1), (1, 0))
"""The gyro and the accelerometer, among x, y, z, that an angle is found from."""

SLOWER = 5.0
"""Time of the bias estimate over the time constant, where only the latter is given."""


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
    accelerometer_unit : str, optional
        Unit of the accelerometers of a file whose header has no units.
    """

    method: str = "complementary"
    time_constant: float | None = None
    bias_time: float | None = None
    gyro: str | None = None
    accelerometer: str | None = None
    gate: float | None = None
    samples: int = 2
    keep_bias: bool = False
    accelerometer_unit: str | None = None

    def __post_init__(self) -> None:
        filter_named(self.method)
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
    def left_out(self) -> tuple[str, ...]:
        """Terms that the prediction lacks because their coefficients are not valid."""
        if self.noise is None or not self.noise.explained:
            return ()
        wrong = [e for e in self.noise.fit if e.status == "not valid"]
        return tuple(
            say("{symbol} is left out of the prediction because its coefficient is not valid: {reason}",
                symbol=e.symbol, reason=e.reason) for e in wrong
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
    """

    name: str
    record: Record | Header
    mean: float
    deviation: float
    prediction: Prediction | None
    optimum: Optimum | None
    gyro: str
    accelerometer: str


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
        Whether z points down.
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


def vertical(
    source: Source,
    method: str = "complementary",
    time_constant: float | None = None,
    *,
    settings: VerticalSettings | None = None,
    recipe: Recipe | None = None,
    progress: Progress | None = None,
) -> VerticalStudy:
    """Find roll and pitch of a recording, with the time constant that its identified noise asks for.

    Parameters
    ----------
    source : Recording or path
        Three gyros and three accelerometers along x, y and z, in this order.
    method : str
        A key of `attitude.FILTERS`.
    time_constant : float, optional
        s; by default the one with the least sum of squares of both angles.
    settings : VerticalSettings, optional
        Instead of `method` and `time_constant`.
    recipe : Recipe, optional
        How the file is read, and how its noise is identified.
    progress : callable, optional
        Called with a description of the current step and the fraction completed.

    Raises
    ------
    DataError
        There are not three gyros and three accelerometers, samples are missing, the units are implausible, no time
        constant follows from the noise, or the pitch is near 90 degrees.
    UsageError
        An option is wrong; the time constant is not above the sample interval.
    """
    settings = settings or VerticalSettings(method, time_constant)
    recipe = recipe or Recipe()
    recording = _opened(source, recipe, settings)
    gyros, accelerometers = six_channels(recording)
    for record in (*gyros, *accelerometers):
        demand_whole(record)
    used = [*gyros[:2], *accelerometers[:2]]
    channels = _identified(recording, used, recipe, (settings, progress))
    data = inertial(recording)
    models = [_model(channel, settings) for channel in channels]
    static = not any(channel.refusal for channel in channels[:2]) and not settings.keep_bias
    bias = data.gyro.mean(axis=0) if static else np.zeros(3)
    noises = _noises(models, data)
    loop = _loop(settings, noises, [c.refusal for c in channels])
    if settings.row.looped:
        loop.demand_sampled(data.interval)
    moved = replace(data, gyro=data.gyro - bias)
    gate = None if settings.gate is None else math.radians(settings.gate)
    found, held = settings.row.run(moved, Setting(loop, gate=gate, samples=settings.samples))
    falling = int((np.linalg.norm(data.force, axis=1) <= 0.1 * data.gravity).sum())
    angles = tuple(_angle(i, found[:, i], (settings, loop, noises), channels) for i in range(2))
    channels = tuple(replace(c, bias=float(b)) for c, b in zip(channels, (*bias[:2], 0.0, 0.0), strict=True))
    return VerticalStudy(
        channels, recipe, recording.findings, recording.notes, provenance_of(recording), settings, angles, loop,
        data.rate, held, falling, data.downward, (*_remarks(data, bias, static=static), *_beyond(channels, loop)),
    )  # fmt: skip


def _opened(source: Source, recipe: Recipe, settings: VerticalSettings) -> Recording:
    """The recording; of a file without units, gyros and accelerometers are read one after the other."""
    first = open_recording(source, recipe)
    if settings.accelerometer_unit is None or len(first) > 3 or isinstance(source, Recording | Record):
        return first
    second = open_recording(source, replace(recipe, unit=settings.accelerometer_unit, scale=None))
    return replace(first, records=(*first.records, *second.records), notes=_joined(first, second))


def _joined(first: Recording, second: Recording) -> tuple[str, ...]:
    """The notes of both, without those on what the other has read."""
    return tuple(dict.fromkeys(n for n in (*first.notes, *second.notes) if not n.startswith("left out, ")))


def _identified(
    recording: Recording, used: Sequence[Record], recipe: Recipe, how: tuple[VerticalSettings, Progress | None]
) -> tuple[VerticalChannel, ...]:
    """Gyros x, y and accelerometers x, y with their noise, where no model is given."""
    settings, progress = how
    given = [m is not None for m in settings.models for _ in range(2)]
    names = {record.name: known for record, known in zip(used, given, strict=True)}

    def work(seen: Inspected) -> VerticalChannel:
        noise = None if names[seen.name] else noise_of(seen.record, recipe)
        doubts = () if noise is None else noise.doubts
        return VerticalChannel(seen.record, seen.quality, noise, alerts=(*doubts, *seen.alerts))

    return each_channel(
        [(record.name, (record,)) for record in used], work, VerticalChannel.refused, findings=recording.findings,
        doing="identifying", progress=progress,
    )  # fmt: skip


def _model(channel: VerticalChannel, settings: VerticalSettings) -> Model | None:
    gyro, accelerometer = settings.models
    known = gyro if channel.record.signal.name == "gyro" else accelerometer
    if known is not None or channel.fit is None:
        return known
    return channel.fit.valid or channel.fit.model


def _noises(models: Sequence[Model | None], data: Inertial) -> list[Densities]:
    """The noise of roll and of pitch; empty where that of one is not known."""
    duration = len(data.gyro) * data.interval
    pairs = [(models[g], models[2 + a]) for g, a in PAIRS]
    known = [(g, a) for g, a in pairs if g is not None and a is not None]
    return [Densities.of(g, a, duration, data.rate) for g, a in known] if len(known) == len(pairs) else []


def _loop(settings: VerticalSettings, noises: list[Densities], refusals: Sequence[str]) -> Loop:
    """The filter, as given or the best for the noise."""
    estimates = settings.method in ("second-order", "kalman")
    if settings.time_constant is not None:
        slow = settings.bias_time or (SLOWER * settings.time_constant if estimates else None)
        return Loop(1 / settings.time_constant, 0.0 if slow is None else slow**-2)
    if not noises:
        reasons = "; ".join(dict.fromkeys(r for r in refusals if r)) or "the noise is not known"
        raise DataError(
            f"no time constant follows from the noise: {reasons}; give it with "
            + spelled("--time-constant S, or the noise with --gyro and --accelerometer", "time_constant=...")
        )
    first = best_loop(noises, [(0.0, 0.0)] * 2)
    if settings.method == "second-order":
        first = best_second(noises, [(0.0, 0.0)] * 2, first) or first
    if settings.method == "kalman":
        first = _kalman(noises)
    return first if settings.bias_time is None else replace(first, k2=settings.bias_time**-2)


def _kalman(noises: Sequence[Densities]) -> Loop:
    """The steady Kalman filter for the mean power of both angles."""

    def size(models: Sequence[Model], symbol: str) -> float:
        return math.sqrt(sum(t.value**2 for m in models for t in m if t.symbol == symbol) / len(models))

    gyros = [n.gyro for n in noises]
    tilt = size([n.accelerometer for n in noises], "N") / GRAVITY
    if not tilt:
        raise DataError("the Kalman filter needs white noise (N) of the accelerometers, and none was identified; use "
                        + spelled("--method second-order", "method='second-order'"))  # fmt: skip
    return kalman(size(gyros, "N"), tilt, size(gyros, "K"))


def _angle(
    i: int, values: FloatArray, how: tuple[VerticalSettings, Loop, list[Densities]], channels: Sequence[VerticalChannel]
) -> Angle:
    settings, loop, noises = how
    gyro, accelerometer = (channels[PAIRS[i][0]].record, channels[2 + PAIRS[i][1]].record)
    record = Record(np.degrees(values), gyro.rate, "deg", "angle", name=ANGLES[i], cut=getattr(gyro, "cut", 0.0))
    prediction = predict(noises[i], loop) if noises and settings.row.looped else None
    return Angle(
        ANGLES[i], record, float(values.mean()), float(values.std()), prediction,
        optimum(noises[i]) if noises else None, gyro.name, accelerometer.name,
    )  # fmt: skip


def _beyond(channels: Sequence[VerticalChannel], loop: Loop) -> list[str]:
    """Sensors whose noise is not known at the corner frequency of the filter."""
    corner = loop.k1 / (2 * math.pi)
    bands = [(c.record.name, c.fit.scope.band[1]) for c in channels if c.fit and c.fit.scope and c.fit.scope.limited]
    return [
        say("the corner of the filter is at {corner:.3g} Hz, but the noise of {name} was identified up to "
            "{highest:.3g} Hz only: above, it is extrapolated", corner=corner, name=name, highest=highest)
        for name, highest in bands if highest < corner
    ]  # fmt: skip


def _remarks(data: Inertial, bias: FloatArray, *, static: bool) -> tuple[str, ...]:
    found = []
    if data.downward:
        found.append(say("the z axis points down: specific forces are turned around"))
    if static:
        rates = ", ".join(f"{b:.4g}" for b in np.degrees(bias) * 3600)
        found.append(say("the mean rates of the gyros were subtracted: {rates} deg/h", rates=rates))
    return tuple(found)
