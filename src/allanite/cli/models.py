"""The options of verbs that need a model: written out, a typical sensor, or what a recording shows."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import click

from .output import recipe_of
from .reading import READING

if TYPE_CHECKING:
    from allanite.core.model import Model
    from allanite.study.analysis import Channel

MODEL = (
    click.option("--model", metavar="TERMS", help="The noise, as 'N 0.01 deg/sqrt(h), GM 0.1 deg/h 20 s'."),
    click.option("--sensor", metavar="NAME", help="Or a typical gyro: mems, fog or rlg."),
)

OPTIONAL_READING = (click.argument("file", required=False, type=click.Path()), *READING[1:])
"""A file instead of a model, and what is in it."""

FROM_FILE = (
    *("rate", "unit", "kind", "scale", "channels", "time", "dtype", "columns", "offset"),
    *("start", "until", "quiet_window"),
)
"""Names of these options that are the recipe's."""


def options(*groups: tuple[Callable[..., Any], ...]) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Give a command these options, in this order."""

    def decorate(command: Callable[..., Any]) -> Callable[..., Any]:
        for option in reversed([option for group in groups for option in group]):
            command = option(command)
        return command

    return decorate


def model_of(model: str | None, sensor: str | None) -> "Model | None":
    """The model that is written out, or the sensor's; None where there is neither."""
    from allanite.core.errors import UsageError
    from allanite.core.notation import parse_model
    from allanite.planning.sensors import sensor as typical

    if model is not None and sensor is not None:
        raise UsageError("the noise is given twice: by --model and by --sensor")
    if model is not None:
        return parse_model(model)
    return None if sensor is None else typical(sensor)


@dataclass(frozen=True, eq=False)
class Supposed:
    """A model with its sampling rate, and the channel that it was found in, if it was found in one."""

    model: "Model"
    rate: float
    name: str = ""
    channel: "Channel | None" = None


def supposed(
    file: str | None, model: str | None, sensor: str | None, choices: dict[str, Any], tell: Callable[[str, float], None]
) -> list[Supposed]:
    """The model that was given, or those that are identified in the channels of a file."""
    from allanite.core.errors import UsageError

    given = model_of(model, sensor)
    if (given is None) == (file is None):
        raise UsageError("give either a recording, or the noise by --model or --sensor")
    if given is not None:
        rate = choices["rate"]
        if rate is None or not rate > 0:
            raise UsageError(f"a model needs the sampling rate, above 0: --rate HZ, not {rate!r}")
        return [Supposed(given, rate, sensor or "")]
    assert file is not None  # noqa: S101 - one of them was given
    from allanite.study.analysis import analyze

    study = analyze(file, recipe_of(None, {key: choices[key] for key in choices if key in FROM_FILE}), progress=tell)
    return [Supposed(c.fit.model, c.record.rate, c.record.name, c) for c in study.channels if c.fit is not None]


@dataclass(frozen=True, eq=False)
class Several:
    """Results by the name of the channel, as plain data."""

    type: str
    results: dict[str, Any]

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        channels = [{"name": name, **result.to_dict()} for name, result in self.results.items()]
        return {"allanite": 1, "type": self.type, "channels": channels}


def seconds(_: click.Context, __: click.Parameter, text: str | None) -> float | None:
    """A duration: a number of seconds, or with a unit of time."""
    return None if text is None else seconds_of(text)


def durations(_: click.Context, __: click.Parameter, text: str | None) -> tuple[float, ...] | None:
    """Durations between commas."""
    return None if text is None else tuple(seconds_of(part) for part in text.split(","))


def seconds_of(text: str) -> float:
    """Seconds of ``600``, ``10 min`` or ``1h``; days are ``d``."""
    from allanite.core.notation import split_quantities
    from allanite.core.units import convert

    found = split_quantities(text.split())
    if len(found) != 1 or not found[0][0] > 0:
        raise click.BadParameter(f"a duration is wanted, as 3600, '10 min' or 24h, not {text!r}")
    value, unit = found[0]
    return 86400 * value if unit == "d" else convert(value, unit or "s", "s")


LENGTH = (
    click.option("--duration", callback=seconds, metavar="TIME", help="Length: 3600, '10 min', 24h."),
    click.option("--samples", type=int, metavar="N", help="Or the number of readings."),
)


def size_of(rate: float, duration: float | None, samples: int | None) -> int:
    """Number of readings, by one of the options of `LENGTH`."""
    from allanite.core.errors import UsageError

    if (duration is None) == (samples is None):
        raise UsageError("give the length either by --duration or by --samples")
    if not 0 < rate < float("inf"):
        raise UsageError(f"the sampling rate must be a positive number of Hz, not {rate!r}")
    return samples if samples is not None else round((duration or 0.0) * rate)
