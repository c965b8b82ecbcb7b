"""Roll and pitch of a recording, with a filter that follows from the identified noise."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from allanite.extending import (
    DataError,
    FloatArray,
    Inspected,
    Model,
    Progress,
    Recipe,
    Record,
    Recording,
    Source,
    UsageError,
    each_channel,
    join,
    noise_of,
    open_recording,
    provenance_of,
    say,
    spelled,
)

from .axes import Axes
from .density import SensorNoise
from .filters import Setting
from .inertial import Inertial, inertial, six_channels
from .loop import Loop
from .optimum import Optimum, optimum
from .prediction import Prediction, predict
from .result import Angle, VerticalChannel, VerticalSettings, VerticalStudy

ANGLES = (say("roll"), say("pitch"))
PAIRS = ((0, 1), (1, 0))
"""The gyro and the accelerometer, among x, y, z, that an angle is found from."""

TURNING = 10.0
"""Mean rate, deg/s, that is no bias of a gyro."""

SLOWER = 5.0
"""Time of the bias estimate over the time constant, where only the latter is given."""


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
    recording = open_recording(source, recipe)
    axes = settings.turned or Axes()
    data = inertial(recording, settings.turned)
    gyros, accelerometers = map(axes.ordered, six_channels(recording))
    used = [*gyros[:2], *accelerometers[:2]]
    channels = _identified(recording, used, recipe, (settings, progress))
    models = [_model(channel, settings) for channel in channels]
    static = not any(channel.refusal for channel in channels[:2]) and not settings.keep_bias
    bias = data.gyro.mean(axis=0) if static else np.zeros(3)
    noises = _noises(models, data)
    loop = _loop(settings, noises, [c.refusal or _rejection(c) for c in channels])
    if settings.row.looped:
        loop.demand_sampled(data.interval)
    moved = replace(data, gyro=data.gyro - bias)
    gate = None if settings.gate is None else math.radians(settings.gate)
    found, held = settings.row.run(moved, Setting(loop, gate=gate, samples=settings.samples))
    falling = int((np.linalg.norm(data.force, axis=1) <= 0.1 * data.gravity).sum())
    angles = tuple(_angle(i, found[:, i], (settings, loop, noises), channels) for i in range(2))
    biases = (*(bias * np.array(axes.sign))[:2].tolist(), 0.0, 0.0)
    channels = tuple(replace(c, bias=b) for c, b in zip(channels, biases, strict=True))
    return VerticalStudy(
        channels, recipe, recording.findings, recording.notes, provenance_of(recording), settings, angles, loop,
        data.rate, held, falling, data.downward,
        (*_remarks(data, bias, settings, static=static), *_beyond(channels, loop)),
    )  # fmt: skip


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


def _rejection(channel: VerticalChannel) -> str:
    return "" if channel.noise is None else channel.noise.rejection


def _model(channel: VerticalChannel, settings: VerticalSettings) -> Model | None:
    gyro, accelerometer = settings.models
    known = gyro if channel.record.signal.name == "gyro" else accelerometer
    return channel.model if known is None else known


def _noises(models: Sequence[Model | None], data: Inertial) -> list[SensorNoise]:
    """The noise of roll and of pitch; empty where that of one is not known."""
    duration = len(data.gyro) * data.interval
    pairs = [(models[g], models[2 + a]) for g, a in PAIRS]
    known = [(g, a) for g, a in pairs if g is not None and a is not None]
    return [SensorNoise.of(g, a, duration, data.rate) for g, a in known] if len(known) == len(pairs) else []


def _loop(settings: VerticalSettings, noises: list[SensorNoise], refusals: Sequence[str]) -> Loop:
    """The filter, as given or the best for the noise."""
    if settings.time_constant is not None:
        slow = settings.bias_time or (SLOWER * settings.time_constant if settings.row.estimates else None)
        return Loop(1 / settings.time_constant, 0.0 if slow is None else slow**-2)
    if not noises:
        reasons = "; ".join(dict.fromkeys(r for r in refusals if r)) or "the noise is not known"
        raise DataError(
            f"no time constant follows from the noise: {reasons}; give it with "
            + spelled("--time-constant S, or the noise with --gyro and --accelerometer", "time_constant=...")
        )
    first = settings.row.best(noises)
    return first if settings.bias_time is None else replace(first, k2=settings.bias_time**-2)


def _angle(
    i: int,
    values: FloatArray,
    how: tuple[VerticalSettings, Loop, list[SensorNoise]],
    channels: Sequence[VerticalChannel],
) -> Angle:
    settings, loop, noises = how
    pair = channels[PAIRS[i][0]], channels[2 + PAIRS[i][1]]
    gyro, accelerometer = (channel.record for channel in pair)
    record = Record(np.degrees(values), gyro.rate, "deg", "angle", name=ANGLES[i], cut=getattr(gyro, "cut", 0.0))
    prediction = predict(noises[i], loop) if noises and settings.row.looped else None
    best, doubts = _best(noises[i]) if noises else (None, [])
    return Angle(
        ANGLES[i], record, float(values.mean()), float(values.std()), prediction, best, gyro.name, accelerometer.name,
        (*_doubts(pair, prediction), *doubts),
    )  # fmt: skip


def _best(noise: SensorNoise) -> tuple[Optimum | None, list[str]]:
    """The best filters for an angle, or why there are none: a given time constant does not need them."""
    try:
        return optimum(noise), []
    except UsageError as error:
        return None, [say("there is no best filter for this angle: {reason}", reason=str(error))]


def _doubts(pair: Sequence[VerticalChannel], prediction: Prediction | None) -> Iterator[str]:
    """What the noise that was identified leaves open."""
    for channel in pair:
        if channel.noise is not None and not channel.noise.explained:
            yield say("no model explains the noise of {name}: no error is predicted", name=channel.record.name)
    lacking = [join(" ", (", ".join(e.symbol for e in c.wrong), c.record.name)) for c in pair if c.wrong]
    if lacking and prediction is not None:
        gyro, tilt = (channel.fitted for channel in pair)
        noise = SensorNoise.of(
            gyro or prediction.gyro, tilt or prediction.accelerometer, prediction.duration, prediction.rate
        )
        yield say("the prediction is a lower bound: it lacks terms whose coefficients are not valid ({terms}); with "
                  "these as they were fitted it would be {error:.3g} arcsec", terms=join("; ", lacking),
                  error=predict(noise, prediction.loop).to("arcsec"))  # fmt: skip


def _beyond(channels: Sequence[VerticalChannel], loop: Loop) -> list[str]:
    """A time constant longer than the recording, and sensors whose noise is not known at the filter's corner."""
    corner = loop.k1 / (2 * math.pi)
    length = max((channel.record.size / channel.record.rate for channel in channels), default=math.inf)
    notes: list[str] = []
    if loop.time_constant > length:
        notes.append(
            say("the time constant is {tau:.3g} s, but the recording lasts {length:.3g} s only: the angles are in "
                "effect those of the gyros alone", tau=loop.time_constant, length=length)
        )  # fmt: skip
    bands: dict[float, list[str]] = {}
    for c in channels:
        if c.fit and c.fit.scope and c.fit.scope.limited and c.fit.scope.band[1] < corner:
            bands.setdefault(c.fit.scope.band[1], []).append(c.record.name)
    return notes + [
        say("the corner of the filter is at {corner:.3g} Hz, but the noise of {name} was identified up to "
            "{highest:.3g} Hz only: above, it is extrapolated", corner=corner, name=", ".join(names), highest=highest)
        for highest, names in bands.items()
    ]  # fmt: skip


def _remarks(data: Inertial, bias: FloatArray, settings: VerticalSettings, *, static: bool) -> tuple[str, ...]:
    found = []
    if settings.turned is not None:
        found.append(say("forward, sideways and vertical are the axes {axes} of the file", axes=settings.turned))
    if data.downward:
        found.append(say("the vertical axis points down: specific forces are turned around"))
    if static:
        rates = ", ".join(f"{b:.4g}" for b in np.degrees(bias) * 3600)
        found.append(say("the mean rates of the gyros were subtracted: {rates} deg/h", rates=rates))
    fastest = float(np.abs(np.degrees(bias)).max())
    if fastest > TURNING:
        kept = spelled("--keep-bias", "keep_bias=True")
        found.append(say("a mean rate of {rate:.3g} deg/s is no bias: the body turned; choose a static part, or keep "
                         "the mean rates ({option})", rate=fastest, option=kept))  # fmt: skip
    return tuple(found)
