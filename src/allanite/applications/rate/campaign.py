"""From a recording to its rates: noise, experiment, bias, north."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, Self

from allanite.applications.rate import (
    Experiment,
    ExperimentSettings,
    North,
    RateEstimate,
    by_duration,
    earth_rate,
    estimate,
    experiment,
    north,
    reversal,
    subtract_bias,
)
from allanite.extending import (
    DataError,
    Fit,
    Header,
    Inspected,
    Job,
    Model,
    Noise,
    Progress,
    Quality,
    Recipe,
    Record,
    Signal,
    Source,
    UsageError,
    Value,
    demand_result,
    each_channel,
    header_dict,
    header_from,
    noise_dict,
    noise_from,
    open_recording,
    provenance_of,
    say,
    spelled,
    stored_fields,
    written,
)
from allanite.extending import read_plain as read
from allanite.extending import write_plain as write

from .noise import noise_of_rates

DURATIONS = (1.0, 3.0, 10.0, 30.0, 60.0, 120.0, 300.0, 600.0, 1800.0, 3600.0)
"""Measuring times that are compared, s."""

FEWEST = 20
"""Intervals of a measuring time below which its scatter says little."""


@dataclass(frozen=True, repr=False)
class RateSettings(Value):
    """What is measured of a recording.

    Attributes
    ----------
    experiment : ExperimentSettings
        Intervals, methods, target; its `reference` is overruled by `latitude`.
    noise : Model or None
        The noise; identified if it is not given.
    signal : Signal or None
        The kind of sensor that `reference` and `bias` are of, if they are given.
    latitude : float or None
        Degrees. For a vertical axis the earth's rate is the reference, for a horizontal one north is found.
    horizontal : bool
        Whether the axis is horizontal.
    turned, near : float
        Degrees: from the first position to the second, and the approximate heading.
    position_method : str
        Estimator of the whole record, for north and the bias.
    durations : tuple of float
        Measuring times for the accuracy against time, s; none if empty.
    """

    experiment: ExperimentSettings = field(default_factory=ExperimentSettings)
    noise: Model | None = None
    signal: Signal | None = None
    latitude: float | None = None
    horizontal: bool = False
    turned: float = 180.0
    near: float = 90.0
    position_method: str = "optimal"
    durations: tuple[float, ...] = DURATIONS

    def __post_init__(self) -> None:
        if self.horizontal and self.latitude is None:
            raise UsageError(f"finding north needs the latitude: give {spelled('--latitude', 'latitude=...')}")

    @property
    def vertical(self) -> bool:
        """Whether the earth's rate at the latitude is the true rate."""
        return self.latitude is not None and not self.horizontal

    def choices(self, unit: str) -> dict[str, Any]:
        """The choices under the names of the command line; rates in the SI unit `unit`."""
        chosen, options = self.experiment, self.experiment.options
        plain = {**vars(self), **vars(chosen), **vars(options), "bias": chosen.bias or None}
        plain["reference"] = None if self.vertical else chosen.reference
        plain["noise"] = None if self.noise is None else written(self.noise)
        for key in ("reference", "bias", "allowed"):
            plain[key] = None if plain[key] is None else f"{float(plain[key])!r} {unit}"
        for key in ("methods", "dither", "durations"):
            plain[key] = list(plain[key]) or None
        plain |= {"split_gaps": chosen.gaps == "split", "no_times": not self.durations}
        return {
            k: v for k, v in plain.items() if k not in ("experiment", "options", "signal", "gaps") and v is not None
        }


@dataclass(frozen=True, eq=False, repr=False)
class RateChannel(Value):
    """The measurement of one channel; `refusal` says why there is none."""

    record: Record | Header
    quality: Quality
    noise: Noise | None = None
    experiment: Experiment | None = None
    by_duration: tuple[Experiment, ...] = ()
    estimates: tuple[RateEstimate, ...] = ()
    bias: RateEstimate | None = None
    north: North | None = None
    alerts: tuple[str, ...] = ()
    refusal: str = ""

    @property
    def fit(self) -> Fit | None:
        """The identified noise; None where it was given."""
        return None if self.noise is None else self.noise.fit

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data."""
        own = {name: write(getattr(self, name), hint, level) for name, hint in self._own()}
        fit = {"fit": None if self.fit is None else self.fit.to_dict(level)}
        return header_dict(self.record, "RateChannel") | own | noise_dict(self.noise, level) | fit

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> Self:
        """The value written by `to_dict`; the record has no samples."""
        own = {name: read(data[name], hint) for name, hint in cls._own()}
        return cls(header_from(data), noise=noise_from(data), **own)

    @classmethod
    def _own(cls) -> list[tuple[str, Any]]:
        """Fields that are written by their types."""
        return [(name, hint) for name, hint in stored_fields(cls) if name not in ("record", "noise")]

    def _summary(self) -> str:
        return f"{self.record.name!r}: {self.refusal or self.experiment}"


@dataclass(frozen=True, eq=False, repr=False)
class RateStudy(Job[RateChannel]):
    """The rates of a recording, and the settings that they were measured with."""

    _channel = RateChannel

    settings: RateSettings = field(default_factory=RateSettings)

    def _explained(self, channel: RateChannel) -> bool:
        """Whether a model explains the noise of a channel, if none was given."""
        return self.settings.noise is not None or (channel.noise is not None and channel.noise.explained)

    def choices(self) -> dict[str, Any]:
        """The recipe that was actually used, as plain data."""
        signal = self.settings.signal or self.channels[0].record.signal
        second = self.provenance.get("source 2")
        return super().choices() | self.settings.choices(signal.unit) | ({"second": second} if second else {})


def measure_rates(
    source: Source,
    recipe: Recipe | None = None,
    settings: RateSettings | None = None,
    *,
    second: Source | None = None,
    progress: Progress | None = None,
) -> RateStudy:
    """Measure the constant rate of every channel of a recording with every method.

    Parameters
    ----------
    source : Recording, Record or path
    recipe : Recipe, optional
        How to read, how the noise is identified, the level of intervals.
    settings : RateSettings, optional
    second : Recording, Record or path, optional
        The same gyro after it was turned; read with the same recipe. Removes the bias.
    progress : callable, optional
        Called with a description of the current step and the fraction completed.

    Raises
    ------
    DataError
        No channel can be measured.
    UsageError
        An option is wrong, or a required one is missing.
    """
    recipe, settings = recipe or Recipe(), settings or RateSettings()
    recordings = [open_recording(s, recipe, progress=progress) for s in (source, second) if s is not None]
    first = recordings[0]
    groups = [(name, tuple(recording[name] for recording in recordings)) for name in first.channels]
    findings = tuple(finding for recording in recordings for finding in recording.findings)
    work = partial(_measured, recipe=recipe, settings=settings)
    channels = each_channel(groups, work, _refused, findings=findings, doing="measuring", progress=progress)
    demand_result(first.channels, channels)
    notes = tuple(dict.fromkeys(note for recording in recordings for note in recording.notes))
    return RateStudy(channels, recipe, findings, notes, provenance_of(*recordings), settings)


def _refused(seen: Inspected, why: str) -> RateChannel:
    return RateChannel(seen.record, seen.quality, refusal=why)


def _measured(seen: Inspected, recipe: Recipe, settings: RateSettings) -> RateChannel:
    record, chosen = seen.record, settings.experiment
    if settings.signal is not None and settings.signal is not record.signal:
        raise DataError(
            say(
                "the given true rate or bias belongs to another type of sensor: {sensor}",
                sensor=settings.signal.name,
            )
        )
    noise, model, alerts, settled = noise_of_rates(record, recipe, chosen.interval, settings.noise)
    if settings.latitude is not None and settings.vertical and record.signal.name == "gyro":
        chosen = replace(chosen, reference=earth_rate(settings.latitude))
    found = experiment(record, model, chosen)
    durations = tuple(d for d in settings.durations if d * FEWEST <= record.duration)
    alone = found.methods if found.start.size == 1 else ()
    channel = RateChannel(
        record,
        seen.quality,
        noise,
        found,
        by_duration(record, durations, model, chosen),
        tuple(_whole(record, method, model, chosen) for method in alone),
        alerts=(*alerts, *map(str, found.findings), *_alerts(seen, settled)),
    )
    if len(seen.records) == 1 and not settings.horizontal:
        return channel
    return _positions(channel, seen.records, model, (settings, recipe.level))


def _alerts(seen: Inspected, settled: tuple[str, ...]) -> Iterator[str]:
    yield from (str(finding) for finding in seen.quality.warnings if finding.name not in settled)
    for quality in seen.qualities[1:]:
        others = (str(finding) for finding in quality.warnings if finding.name not in settled)
        yield from (say("second recording: {finding}", finding=other) for other in others)


def _positions(
    channel: RateChannel, records: tuple[Record, ...], model: Model | None, chosen: tuple[RateSettings, float]
) -> RateChannel:
    """Bias and north."""
    settings, level = chosen
    method = settings.position_method if model is not None else "mean"
    first, *rest = (_whole(record, method, model, settings.experiment) for record in records)
    other = rest[0] if rest else None
    heading = None
    if settings.horizontal and settings.latitude is not None:
        near, turned = settings.near, settings.turned
        heading = north(first, settings.latitude, second=other, turned=turned, near=near, level=level)
    if other is None or settings.turned != 180:
        return replace(channel, north=heading, estimates=channel.estimates or (first,))
    rate, bias = reversal(first, other)
    return replace(channel, north=heading, estimates=(rate,), bias=bias)


def _whole(record: Record, method: str, model: Model | None, chosen: ExperimentSettings) -> RateEstimate:
    found = estimate(record, method, model=model, target=chosen.target, dither=chosen.dither, options=chosen.options)
    return subtract_bias(found, chosen.bias, record.signal.unit) if chosen.bias else found
