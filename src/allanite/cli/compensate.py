"""``allanite compensate``: the part of a rate that follows other channels, found, judged, taken off."""

from typing import Any

import click

from .deliver import Extra, carry_out, demand_recording, given, outputs, recipe_of, settings_of
from .options import IDENTIFYING, NAMES, RECORDING, RESULTS, Separated, options

SECONDS = Separated(float, "seconds", example="60,300")


@click.command()
@options(
    "file",
    *RECORDING,
    click.option("--regressors", type=NAMES, metavar="A,B,...", help="Columns that the rate may depend on."),
    click.option("--rate-of", type=NAMES, metavar="A,B,...", help="Columns whose rate of change counts."),
    click.option("--degree", type=int, default=1, show_default=True, help="Highest power that may be added."),
    click.option("--lags", type=SECONDS, metavar="S,S,...", help="Earlier readings that may be added, seconds."),
    "trend",
    click.option("--every", is_flag=True, help="Keep all powers and lags, not only what held-back blocks gain from."),
    click.option("--smooth", type=float, default=60.0, show_default=True, metavar="S", help="Window of --rate-of."),
    click.option("--blocks", type=int, default=5, show_default=True, help="Blocks of the cross-validation."),
    click.option("--least", type=float, default=10.0, show_default=True, help="Effective samples for each regressor."),
    "split-gaps",
    click.option(
        "--beside", metavar="FILE", type=click.Path(), help="The regressors are in this file, with units and times."
    ),
    click.option("--interpolate", is_flag=True, help="Bring regressors of another time base onto the record's."),
    click.option("--use", metavar="FILE", type=click.Path(), help="Fit nothing; take what --save wrote."),
    click.option("--apply", "apply_to", metavar="FILE", type=click.Path(), help="Correct this file too, held back."),
    *IDENTIFYING,
    click.option("--save", metavar="PATH", type=click.Path(), help="Write the regressions, for --use."),
    "corrected record",
    *RESULTS,
)
def compensate(file: str, **choices: Any) -> None:
    """Find and remove what follows a temperature.

    Whatever part of the channels of FILE follows other columns is estimated and taken off. Prints the coefficients with
    intervals and p values, and the Allan deviation before and after. The noise of the fit has the terms Q, N, B and K,
    or those of --terms.
    """
    apply_to = choices.pop("apply_to")
    read = [file, apply_to, *(choices[key] for key in ("beside", "use", "recipe"))]
    out = outputs(choices, read, also=("save", "corrected"))
    demand_recording(out.paths.get("corrected"))
    from allanite.compensation.regression import to_json
    from allanite.compensation.settings import CompensationSettings, FitSettings
    from allanite.compensation.study import compensate_file

    recipe = recipe_of(choices)
    settings = CompensationSettings(fit=settings_of(FitSettings, choices), **given(choices))
    extra = Extra({"save": lambda study: to_json(study.regressions)}, {"corrected": lambda study: study.corrected})
    carry_out(lambda tell: compensate_file(file, recipe, settings, apply_to=apply_to, progress=tell), out, extra)
