"""``allanite compensate``: estimate, test and remove the part of a rate that depends on other channels."""

from typing import Any

import click

from allanite.applications.choices import CompensationChoices, FitChoices

from .deliver import Extra, carry_out, demand_recording, given, outputs, recipe_of, settings_of
from .options import IDENTIFYING, RECORDING, RESULTS, options


@click.command()
@options(
    "file", *RECORDING, "regressors", "derivative_of", "degree", "lags", "trend", "every", "smooth", "blocks", "least",
    "split_gaps", "beside", "interpolate", "use",
    click.option("--apply", "apply_to", metavar="FILE", type=click.Path(),
        help="Also correct this file, which is not used for the fit."),
    *IDENTIFYING,
    click.option("--save", metavar="PATH", type=click.Path(), help="Write the regressions, to be used with --use."),
    "corrected record", *RESULTS, settings=(CompensationChoices, FitChoices),
)  # fmt: skip
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
