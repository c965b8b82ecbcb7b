"""Roll and pitch of a recording, with a filter that follows from the identified noise."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from allanite.extending import (  # isort: skip
    FloatArray, Inspected, Progress, Recipe, Record, Source, UsageError, each_channel, join, noise_of, open_recording,
    provenance_of, public, say, spelled)  # fmt: skip

from .filters import Setting
from .inertial import Axes, Inertial, inertial, six_channels
from .loop import Loop, SensorNoise
from .optimum import optimum
from .prediction import Prediction, predict
from .result import PAIRS, Angle, VerticalChannel, VerticalSettings, VerticalStudy

ANGLES = (say("roll"), say("pitch"))
TURNING = 10.0  # mean rate, deg/s, that is no bias of a gyro


@public
def vertical(
    source: Source, method: str = "complementary", time_constant: float | None = None, *,
    settings: VerticalSettings | None = None, recipe: Recipe | None = None, progress: Progress | None = None,
) -> VerticalStudy:  # fmt: skip
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
    settings, recipe = settings or VerticalSettings(method, time_constant), recipe or Recipe()
    recording = open_recording(source, recipe)
    axes = settings.turned or Axes()
    data = inertial(recording, settings.turned)
    gyros, accelerometers = map(axes.ordered, six_channels(recording))
    channels = each_channel([(record.name, (record,)) for record in (*gyros[:2], *accelerometers[:2])],
                            partial(_identified, settings=settings, recipe=recipe), VerticalChannel.refused,
                            findings=recording.findings, doing="identifying", progress=progress)  # fmt: skip
    noises = settings.noises(channels, len(data.gyro) * data.interval, data.rate)
    static = not (settings.keep_bias or any(channel.refusal for channel in channels[:2]))
    bias = data.gyro.mean(axis=0) if static else np.zeros(3)
    loop = settings.loop(noises, [c.unknown for c in channels])
    if settings.row.looped:
        loop.demand_sampled(data.interval)
    setting = Setting(loop, gate=None if settings.gate is None else math.radians(settings.gate))
    values, held = settings.row.run(replace(data, gyro=data.gyro - bias), setting)
    predictions = [predict(noise, loop) for noise in noises if settings.row.looped]
    angles = tuple(_angle(i, values[:, i], channels, noises, predictions) for i in range(2))
    falling = int((np.linalg.norm(data.force, axis=1) <= 0.1 * data.gravity).sum())
    biases = (*(bias * np.array(axes.sign))[:2].tolist(), 0.0, 0.0)
    channels = tuple(replace(c, bias=b) for c, b in zip(channels, biases, strict=True))
    remarks = _remarks(data, bias, settings, channels, loop, static=static)
    return VerticalStudy(channels, recipe, recording.findings, recording.notes, provenance_of(recording), settings,
                         angles, loop, data.rate, held, falling, data.downward, tuple(remarks))  # fmt: skip


def _identified(seen: Inspected, settings: VerticalSettings, recipe: Recipe) -> VerticalChannel:
    noise = noise_of(seen.record, recipe) if settings.model(seen.record) is None else None
    doubts = () if noise is None else noise.doubts
    return VerticalChannel(seen.record, seen.quality, noise, alerts=(*doubts, *seen.alerts))


def _angle(
    i: int, values: FloatArray, channels: Sequence[VerticalChannel], noises: Sequence[SensorNoise],
    predictions: Sequence[Prediction],
) -> Angle:  # fmt: skip
    """Roll or pitch; the best filters are left out where there are none: a given time constant does not need them."""
    pair = channels[PAIRS[i][0]], channels[2 + PAIRS[i][1]]
    gyro, accelerometer = (channel.record for channel in pair)
    record = Record(np.degrees(values), gyro.rate, "deg", "angle", name=ANGLES[i], cut=getattr(gyro, "cut", 0.0))
    prediction, best = predictions[i] if predictions else None, None
    doubts = [*_doubts(pair, prediction)]
    try:
        best = optimum(noises[i]) if noises else None
    except UsageError as error:
        doubts.append(say("there is no best filter for this angle: {reason}", reason=str(error)))
    return Angle(ANGLES[i], record, float(values.mean()), float(values.std()), prediction, best, gyro.name,
                 accelerometer.name, tuple(doubts))  # fmt: skip


def _doubts(pair: Sequence[VerticalChannel], prediction: Prediction | None) -> Iterator[str]:
    """What the noise that was identified leaves open."""
    for channel in pair:
        if channel.noise is not None and not channel.noise.explained:
            yield say("no model explains the noise of {name}: no error is predicted", name=channel.record.name)
    lacking = [join(" ", (", ".join(e.symbol for e in c.wrong), c.record.name)) for c in pair if c.wrong]
    if lacking and prediction is not None:
        gyro, tilt = (channel.fitted for channel in pair)
        models = gyro or prediction.gyro, tilt or prediction.accelerometer
        noise = SensorNoise.of(*models, prediction.duration, prediction.rate)
        yield say("the prediction is a lower bound: it lacks terms whose coefficients are not valid ({terms}); with "
                  "these as they were fitted it would be {error:.3g} arcsec", terms=join("; ", lacking),
                  error=predict(noise, prediction.loop).to("arcsec"))  # fmt: skip


def _remarks(
    data: Inertial, bias: FloatArray, settings: VerticalSettings, channels: Sequence[VerticalChannel], loop: Loop, *,
    static: bool,
) -> Iterator[str]:  # fmt: skip
    """What was done to the axes and the bias, and where the filter leaves the recording or the bands of its noise."""
    if settings.turned is not None:
        yield say("forward, sideways and vertical are the axes {axes} of the file", axes=settings.turned)
    if data.downward:
        yield say("the vertical axis points down: specific forces are turned around")
    if static:
        rates = ", ".join(f"{b:.4g}" for b in np.degrees(bias) * 3600)
        yield say("the mean rates of the gyros were subtracted: {rates} deg/h", rates=rates)
    fastest = float(np.abs(np.degrees(bias)).max())
    if fastest > TURNING:
        kept = spelled("--keep-bias", "keep_bias=True")
        yield say("a mean rate of {rate:.3g} deg/s is no bias: the body turned; choose a static part, or keep "
                  "the mean rates ({option})", rate=fastest, option=kept)  # fmt: skip
    length = max(channel.record.size / channel.record.rate for channel in channels)
    if loop.time_constant > length:
        yield say("the time constant is {tau:.3g} s, but the recording lasts {length:.3g} s only: the angles are in "
                  "effect those of the gyros alone", tau=loop.time_constant, length=length)  # fmt: skip
    corner = loop.k1 / (2 * math.pi)
    bands: dict[float, list[str]] = {}
    for c in channels:
        if c.fit and c.fit.scope and c.fit.scope.limited and c.fit.scope.band[1] < corner:
            bands.setdefault(c.fit.scope.band[1], []).append(c.record.name)
    for highest, names in bands.items():
        yield say("the corner of the filter is at {corner:.3g} Hz, but the noise of {name} was identified up to "
                  "{highest:.3g} Hz only: above, it is extrapolated", corner=corner, name=", ".join(names),
                  highest=highest)  # fmt: skip
