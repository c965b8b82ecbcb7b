"""``allanite drift``: how far heading, attitude, velocity and position drift without aid."""

from typing import Any

import click

from allanite.study.settings import DriftChoices, NoiseChoices

from .deliver import carry_out, outputs, recipe_of, settings_of
from .options import IDENTIFYING, RECORDING, RESULTS, options
from .plan import demand_kept


@click.command()
@options(
    "some files", "models", "sensor", "datasheet", "claimed",
    "times", "calibration", "turn_on", "scale_factor", "maneuver", "platform", "schuler", "require",
    "unexplained", "from_curve",
    *RECORDING, *IDENTIFYING, *RESULTS, settings=(NoiseChoices, DriftChoices),
)  # fmt: skip
def drift(files: tuple[str, ...], models: tuple[str, ...], claims: tuple[str, ...], **choices: Any) -> None:
    """Predict navigation errors without aid.

    FILES are recordings of gyros, accelerometers or both, or results that analyze has written with --json; --model,
    --sensor, --datasheet and --claims give the noise without a recording. Prints the standard deviation of each
    quantity with time without aid, and which noise causes it. With --require, the coefficients that are allowed; if a
    drift is larger, the exit code is 4.
    """
    from allanite.claims.claim import claim_of
    from allanite.claims.drift_settings import DriftSettings
    from allanite.claims.drifting import drift_of
    from allanite.exporting.conversion import load
    from allanite.planning.sensors import sensor as typical

    sensor, datasheet = choices.pop("sensor"), choices.pop("datasheet")
    models = (*models, datasheet) if datasheet else models
    out = outputs(choices, [*files, choices["recipe"]])
    settings = settings_of(DriftSettings, choices)
    recipe = recipe_of(choices)
    given = [model for one in claims for model in claim_of(one, rate=recipe.rate).models]
    given += [] if sensor is None else [typical(sensor)]
    found = carry_out(lambda tell: drift_of([*load(files, recipe, models, tell), *given], settings), out)
    demand_kept(found)
