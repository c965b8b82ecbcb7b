"""``allanite compensate``: estimate, test and remove the part of a rate that depends on other channels."""

from typing import Any

import click

from .deliver import Extra, carry_out, demand_recording, given, outputs, recipe_of, settings_of
from .options import IDENTIFYING, RECORDING, RESULTS, options
from .types import NAMES, Separated

SECONDS = Separated(float, "seconds", example="60,300")


@click.command()
@options(
    "file",
    *RECORDING,
    click.option("--regressors", type=NAMES, metavar="A,B,...", help="Columns on which the rate may depend."),
    click.option("--derivative-of", type=NAMES, metavar="A,B,...", help="Columns whose derivative is a regressor."),
    click.option("--degree", type=int, default=1, show_default=True, help="Highest power of a regressor to try."),
    click.option("--lags", type=SECONDS, metavar="S,S,...", help="Lags of the regressors to try, seconds."),
    "trend",
    click.option("--every", is_flag=True, help="Keep all powers and lags; skip cross-validation."),
    click.option(
        "--smooth",
        type=float,
        default=60.0,
        show_default=True,
        metavar="S",
        help="Smoothing window of --derivative-of.",
    ),
    click.option("--blocks", type=int, default=5, show_default=True, help="Number of blocks for cross-validation."),
    click.option(
        "--least", type=float, default=10.0, show_default=True, help="Effective samples required per regressor."
    ),
    "split-gaps",
    click.option(
        "--beside", metavar="FILE", type=click.Path(), help="Read the regressors from this file, with units and times."
    ),
    click.option(
        "--interpolate", is_flag=True, help="Interpolate regressors of another time base to the record's samples."
    ),
    click.option("--use", metavar="FILE", type=click.Path(), help="Apply the regressions that --save wrote; no fit."),
    click.option(
        "--apply",
        "apply_to",
        metavar="FILE",
        type=click.Path(),
        help="Also correct this file, which is not used for the fit.",
    ),
    *IDENTIFYING,
    click.option("--save", metavar="PATH", type=click.Path(), help="Write the regressions, to be used with --use."),
    "corrected record",
    *RESULTS,
)
def compensate(file: str, **choices: Any) -> None:
    """Remove temperature-dependent errors.

    Estimates and removes the part of each channel of FILE that depends on other columns, such as a temperature. Prints
    the coefficients with confidence intervals and p-values, and the Allan deviation before and after. The noise model
    of the fit has the terms Q, N, B and K, or those given by --terms.
    """
    apply_to = choices.pop("apply_to")
    read = [file, apply_to, *(choices[key] for key in ("beside", "use", "recipe"))]
    out = outputs(choices, read, also=("save", "corrected"))
    demand_recording(out.paths.get("corrected"))
    from allanite.applications.compensation.compensating import compensate_file
    from allanite.applications.compensation.regression import to_json
    from allanite.applications.compensation.settings import CompensationSettings, FitSettings

    recipe = recipe_of(choices)
    settings = CompensationSettings(fit=settings_of(FitSettings, choices), **given(choices))
    extra = Extra({"save": lambda study: to_json(study.regressions)}, {"corrected": lambda study: study.corrected})
    carry_out(lambda tell: compensate_file(file, recipe, settings, apply_to=apply_to, progress=tell), out, extra)
