"""From a recording to its rates: noise, experiment, bias, north. It composes rooms as `study` does."""

import os
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

from allanite.core.errors import DataError, UsageError
from allanite.core.fit import Fit
from allanite.core.model import Model
from allanite.core.record import Record, Recording
from allanite.core.units import Signal
from allanite.core.version import __version__
from allanite.prepare import quiet_window, trim
from allanite.rate import (
    Experiment,
    North,
    Plan,
    RateEstimate,
    by_duration,
    earth_rate,
    estimate,
    experiment,
    north,
    reversal,
    subtract_bias,
)
from allanite.readers import read
from allanite.study.analysis import Recipe

from .noise import identified, supposed

DURATIONS = (1.0, 3.0, 10.0, 30.0, 60.0, 120.0, 300.0, 600.0, 1800.0, 3600.0)
"""Measuring times that are compared, s."""

FEWEST = 20
"""Intervals of a measuring time below which its scatter says little."""

Source = Recording | Record | str | os.PathLike[str]


@dataclass(frozen=True)
class RateChoices:
    """What is measured of a recording.

    Attributes
    ----------
    plan : Plan
        Intervals, methods, target; its `reference` is overruled by `latitude`.
    model : Model or None
        The noise; identified if it is not given.
    signal : Signal or None
        The kind of sensor that `reference` and `bias` of the plan are of, if they are given.
    latitude : float or None
        Degrees. For a vertical axis the earth's rate is the reference, for a horizontal one north is found.
    horizontal : bool
        Whether the axis is horizontal.
    turned, near : float
        Degrees: from the first position to the second, and what is known of the heading.
    method : str
        What measures the whole record, for north and the bias.
    durations : tuple of float
        Measuring times for the accuracy against time, s; none if empty.
    """

    plan: Plan = field(default_factory=Plan)
    model: Model | None = None
    signal: Signal | None = None
    latitude: float | None = None
    horizontal: bool = False
    turned: float = 180.0
    near: float = 90.0
    method: str = "optimal"
    durations: tuple[float, ...] = DURATIONS


@dataclass(frozen=True, eq=False)
class RateChannel:
    """What was measured of one channel; `refusal` says why nothing was."""

    record: Record
    fit: Fit | None = None
    experiment: Experiment | None = None
    by_duration: tuple[Experiment, ...] = ()
    estimates: tuple[RateEstimate, ...] = ()
    bias: RateEstimate | None = None
    north: North | None = None
    alerts: tuple[str, ...] = ()
    refusal: str = ""

    def to_dict(self, level: float) -> dict[str, Any]:
        """Plain data."""
        return {
            "name": self.record.name,
            "rate": self.record.rate,
            "size": self.record.size,
            "unit": self.record.unit,
            "kind": self.record.kind,
            "history": list(self.record.history),
            "fit": None if self.fit is None else self.fit.to_dict(level),
            "experiment": None if self.experiment is None else self.experiment.to_dict(),
            "by_duration": [e.to_dict() for e in self.by_duration],
            "estimates": [e.to_dict(level) for e in self.estimates],
            "bias": None if self.bias is None else self.bias.to_dict(level),
            "north": None if self.north is None else self.north.to_dict(),
            "alerts": list(self.alerts),
            "refusal": self.refusal,
        }


@dataclass(frozen=True, eq=False)
class RateStudy:
    """The rates of a recording, and what they were made of."""

    channels: tuple[RateChannel, ...]
    recipe: Recipe
    choices: RateChoices
    notes: tuple[str, ...]
    provenance: dict[str, str]

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "allanite": 1,
            "type": "RateStudy",
            "channels": [channel.to_dict(self.recipe.level) for channel in self.channels],
            "recipe": self.recipe.to_dict(),
            "notes": list(self.notes),
            "provenance": self.provenance,
        }


def measure_rates(
    source: Source,
    recipe: Recipe | None = None,
    choices: RateChoices | None = None,
    *,
    second: Source | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> RateStudy:
    """Measure the constant rate of every channel of a recording, by every method.

    Parameters
    ----------
    source : Recording, Record or path
    recipe : Recipe, optional
        How to read, which terms to look for, the level of intervals.
    choices : RateChoices, optional
    second : Recording, Record or path, optional
        The same gyro after it was turned; read with the same options. Removes the bias.
    progress : callable, optional
        Called with what is being done and the fraction that is finished.

    Raises
    ------
    DataError
        No channel can be measured.
    UsageError
        An option is wrong, or one that is needed is missing.
    """
    recipe, choices = recipe or Recipe(), choices or RateChoices()
    if choices.horizontal and choices.latitude is None:
        raise UsageError("north is found at a latitude: give it (latitude=, --latitude)")
    tell = progress or (lambda what, fraction: None)
    tell("reading", 0.0)
    recording = _recording(source, recipe)
    other = None if second is None else _recording(second, recipe)
    channels = []
    for i, record in enumerate(recording):
        tell(f"measuring {record.name}", (i + 0.3) / (len(recording) + 0.3))
        try:
            channels.append(_channel(record, None if other is None else other[record.name], recipe, choices))
        except DataError as error:
            channels.append(RateChannel(record, refusal=str(error)))
    if all(channel.refusal for channel in channels):
        raise DataError("; ".join(f"{c.record.name or 'the record'}: {c.refusal}" for c in channels))
    tell("done", 1.0)
    made = {"allanite": __version__, "source": recording.source, "sha256": recording.digest}
    return RateStudy(tuple(channels), recipe, choices, recording.notes, made)


def _recording(source: Source, recipe: Recipe) -> Recording:
    if isinstance(source, Record):
        source = Recording((source,))
    if not isinstance(source, Recording):
        options = {key: getattr(recipe, key) for key in ("rate", "unit", "kind", "scale", "channels", "time")}
        source = read(source, **options)
    whole = trim(source, recipe.start, recipe.until)
    return whole if recipe.quiet_window is None else quiet_window(whole, recipe.quiet_window)


def _channel(record: Record, second: Record | None, recipe: Recipe, choices: RateChoices) -> RateChannel:
    if choices.signal is not None and choices.signal is not record.signal:
        raise DataError(f"the true rate or bias that was given belongs to another sensor: {choices.signal.name}")
    fit, alerts = (None, ()) if choices.model is not None else identified(record, recipe)
    plan, model = choices.plan, choices.model
    if fit is not None:
        size = min(round(plan.interval * record.rate), record.size)
        model, said = supposed(fit, size, record.rate)
        alerts += said
    if choices.latitude is not None and not choices.horizontal and record.signal.name == "gyro":
        plan = replace(plan, reference=earth_rate(choices.latitude))
    found = experiment(record, model, plan)
    alerts += tuple(map(str, found.findings))
    durations = tuple(d for d in choices.durations if d * FEWEST <= record.duration)
    channel = RateChannel(record, fit, found, by_duration(record, durations, model, plan), alerts=alerts)
    if found.start.size == 1:
        channel = replace(channel, estimates=tuple(_whole(record, m, model, plan) for m in found.methods))
    if second is None and not choices.horizontal:
        return channel
    return _positions(channel, second, model, choices)


def _positions(channel: RateChannel, second: Record | None, model: Model | None, choices: RateChoices) -> RateChannel:
    """Bias and north."""
    method = choices.method if model is not None else "mean"
    first = _whole(channel.record, method, model, choices.plan)
    other = None if second is None else _whole(second, method, model, choices.plan)
    heading = None
    if choices.horizontal and choices.latitude is not None:
        heading = north(first, choices.latitude, second=other, turned=choices.turned, near=choices.near)
    if other is None or choices.turned != 180:
        return replace(channel, north=heading, estimates=channel.estimates or (first,))
    rate, bias = reversal(first, other)
    return replace(channel, north=heading, estimates=(rate,), bias=bias)


def _whole(record: Record, method: str, model: Model | None, plan: Plan) -> RateEstimate:
    found = estimate(record, method, model=model, target=plan.target, dither=plan.dither, options=plan.options)
    return subtract_bias(found, plan.bias, record.signal.unit) if plan.bias else found
