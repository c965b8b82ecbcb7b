"""``allanite drift``: how far heading, attitude, velocity and position drift without aid."""

from typing import Any

import click

from allanite.study.settings import DriftChoices, NoiseChoices

from .deliver import carry_out, outputs, recipe_of, settings_of
from .options import IDENTIFYING, RECORDING, RESULTS, options
from .plan import EXCEEDED


@click.command()
@options(
    "some files", "models", "sensor", "configuration",
    "times", "calibration", "turn_on", "scale_factor", "maneuver", "platform", "schuler", "require",
    "unexplained", "from_curve",
    *RECORDING, *IDENTIFYING, *RESULTS, settings=(NoiseChoices, DriftChoices),
)  # fmt: skip
def drift(
    files: tuple[str, ...], models: tuple[str, ...], sensor: str | None, configuration: str | None, **choices: Any
) -> None:
    """Predict the drift of heading, attitude, velocity and position.

    FILES are recordings of gyros, accelerometers or both, results that analyze has written with --json, or with
    --config configurations of a filter; --model and --sensor give the noise without a file. Prints the standard
    deviation of each quantity with time without aid, and which noise term causes it. With --require, the coefficients
    that are allowed; if a drift is larger, the exit code is 4.
    """
    from allanite.claims.drift_settings import DriftSettings
    from allanite.claims.drifting import drift_of
    from allanite.exporting.conversion import load
    from allanite.exporting.imported import read_noise
    from allanite.planning.sensors import sensor as typical

    out = outputs(choices, [*files, choices["recipe"]])
    settings = settings_of(DriftSettings, choices)
    recipe = recipe_of(choices)
    known = [] if sensor is None else [typical(sensor)]
    known += [read_noise(file, configuration, rate=recipe.rate) for file in files] if configuration else []
    read = () if configuration else files
    found = carry_out(lambda tell: drift_of([*load(read, recipe, models, tell), *known], settings), out)
    for sentence in found.exceeded:
        click.echo(f"limit exceeded: {sentence}", err=True)
    if found.exceeded:
        raise click.exceptions.Exit(EXCEEDED)
