"""``allanite vertical``: roll and pitch from gyros and accelerometers, with a filter that follows from their noise."""

from typing import TYPE_CHECKING, Any

import click

from allanite.applications.choices import VerticalChoices
from allanite.core.errors import UsageError

from .deliver import carry_out, outputs, recipe_of, settings_of
from .options import IDENTIFYING, RECORDING, RESULTS, options

if TYPE_CHECKING:
    from allanite.applications.attitude.trials import VerticalDesign

DESIGNING = ("duration", "gyro_bias", "accelerometer_bias", "scenarios", "seed")
"""Options that apply without a recording."""

USUAL_DURATION = 3600.0
"""Horizon without a recording, s."""


@click.command()
@options(
    "optional file",
    *RECORDING,
    "gyro", "accelerometer", "filter", "time_constant", "bias_time", "gate",
    click.option("--coning", "samples", type=click.IntRange(1, 4), metavar="N",
                 help="Samples of the coning correction of bortz.  [default: 2]"),
    "axes", "keep_bias",
    "horizon",
    click.option("--gyro-bias", metavar="RATE", help="Constant bias of the gyro without a recording, e.g. '10 deg/h'."),
    click.option("--accelerometer-bias", metavar="BIAS",
                 help="Constant bias of the accelerometer without a recording, e.g. '50 ug'."),
    click.option("--scenarios", is_flag=True,
                 help="Without a recording: simulate all filters at rest, under acceleration and in oscillation."),
    "seed",
    *IDENTIFYING, *RESULTS, settings=(VerticalChoices,),
)  # fmt: skip
def vertical(file: str | None, **choices: Any) -> None:
    """Find roll and pitch.

    Takes three gyros and three accelerometers. The time constant with the least error follows from the noise, which is
    identified from the static recording FILE. Without FILE, --gyro and --accelerometer give the noise; prints the time
    constant, the predicted error by source and the loss against the optimal filter.
    """
    out = outputs(choices, [file, choices["recipe"]])
    if file is None:
        carry_out(lambda tell: _design(choices), out)
        return
    given = [key for key in DESIGNING if key != "seed" and choices.pop(key)]
    if given:
        raise UsageError(f"--{given[0].replace('_', '-')} applies without a recording only; omit it, or FILE")
    choices.pop("seed")
    from allanite.applications.attitude.result import VerticalSettings
    from allanite.applications.attitude.tuning import vertical as job

    identifying, choices["method"] = choices["method"], choices.pop("filter_name")
    settings = settings_of(VerticalSettings, choices)
    recipe = recipe_of({**choices, "method": identifying})
    carry_out(lambda tell: job(file, settings=settings, recipe=recipe, progress=tell), out)


def _design(choices: dict[str, Any]) -> "VerticalDesign":
    """The best filter for the given noise."""
    from allanite.applications.attitude import optimal_time_constant
    from allanite.applications.attitude.prediction import biases
    from allanite.applications.attitude.trials import design
    from allanite.core.model import Model

    if choices["gyro"] is None or choices["accelerometer"] is None:
        raise UsageError(
            "give a recording, or the noise of both sensors with --gyro and --accelerometer, e.g. "
            "--gyro 'N 0.3 deg/sqrt(h), B 10 deg/h' --accelerometer 'N 100 ug/sqrt(Hz)'"
        )
    allowed = {"gyro", "accelerometer", "rate", "level", "recipe", *DESIGNING}
    extra = [key for key, value in choices.items() if value not in (None, False) and key not in allowed]
    if extra:
        name = {"filter_name": "filter", "samples": "coning", "start": "from"}.get(extra[0], extra[0].replace("_", "-"))
        raise UsageError(f"--{name} applies to a recording, but none is given; omit it, or give FILE")
    noise = Model(choices["gyro"]), Model(choices["accelerometer"])
    bias = choices["gyro_bias"] or 0.0, choices["accelerometer_bias"] or 0.0
    found = optimal_time_constant(
        *noise, duration=choices["duration"] or USUAL_DURATION, rate=choices["rate"], gyro_bias=bias[0],
        accelerometer_bias=bias[1],
    )  # fmt: skip
    seed, rate = choices["seed"], choices["rate"]
    return design(found, bias=biases(*bias)[0], scenarios=choices["scenarios"], rate=rate, seed=seed)
