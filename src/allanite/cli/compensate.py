"""``allanite compensate``: estimate, test and remove the part of a rate that depends on other channels."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import click

from allanite.applications.choices import CompensationChoices, FitChoices
from allanite.core.errors import UsageError

from .deliver import Extra, Outputs, carry_out, demand_recording, given, outputs, recipe_of, settings_of
from .options import IDENTIFYING, RECORDING, RESULTS, options
from .streams import complain

if TYPE_CHECKING:
    from allanite.exporting.thermal import ThermalTarget


@click.command()
@options(
    "file", *RECORDING, "regressors", "derivative_of", "degree", "lags", "trend", "every", "smooth", "blocks", "least",
    "split_gaps", "beside", "interpolate", "use",
    click.option("--apply", "apply_to", metavar="FILE", type=click.Path(),
        help="Also correct this file, which is not used for the fit."),
    *IDENTIFYING,
    click.option("--save", metavar="PATH", type=click.Path(), help="Write the regressions, to be used with --use."),
    "corrected record",
    "autopilot",
    click.option("--instance", type=int, metavar="N", help="Number of the sensor there.  [default: the first]"),
    "written parameters",
    *RESULTS, settings=(CompensationChoices, FitChoices),
)  # fmt: skip
def compensate(file: str, **choices: Any) -> None:
    """Remove temperature-dependent errors.

    Estimates and removes the part of each channel of FILE that depends on other columns, such as a temperature. Prints
    the coefficients with confidence intervals and p-values, and the Allan deviation before and after. The noise model
    of the fit has the terms Q, N, B and K, or those given by --terms.
    """
    apply_to, autopilot, instance = (choices.pop(key) for key in ("apply_to", "autopilot", "instance"))
    read = [file, apply_to, *(choices[key] for key in ("beside", "use", "recipe"))]
    out = outputs(choices, read, also=("save", "corrected"))
    demand_recording(out.paths.get("corrected"))
    from allanite.applications.compensation.compensating import compensate_file
    from allanite.applications.compensation.regression import to_json
    from allanite.applications.compensation.settings import CompensationSettings, FitSettings
    from allanite.exporting.temperature import MORE, demand_settings, temperature_parameters

    row = _autopilot(autopilot, instance, out)
    recipe = recipe_of(choices)
    usual, beyond = ({}, 0) if row is None else ({"degree": row.order}, row.order + MORE)
    settings = CompensationSettings(fit=settings_of(FitSettings, choices), **usual | given(choices))
    if row is not None:
        demand_settings(row, settings)

    def parameters(study: Any) -> bytes:
        made = temperature_parameters(study, str(autopilot), instance=instance)
        for alert in made.alerts:
            complain(f"allanite: {alert}")
        return made.data

    data: dict[str, Callable[[Any], str | bytes]] = {
        "save": lambda study: to_json(study.regressions),
        "output": parameters,
    }
    extra = Extra(data, {"corrected": lambda study: study.corrected})
    carry_out(
        lambda tell: compensate_file(file, recipe, settings, apply_to=apply_to, beyond=beyond, progress=tell),
        out,
        extra,
    )


def _autopilot(name: str | None, instance: int | None, out: Outputs) -> "ThermalTarget | None":
    """The row of --to, which goes with --output."""
    from allanite.exporting.temperature import thermal_target

    if name is not None and "output" in out.paths:
        return thermal_target(name, instance)
    if name is not None:
        raise UsageError(f"--to {name} writes a file of parameters: name it with --output PATH; - is standard output")
    if "output" in out.paths or instance is not None:
        raise UsageError(
            "--output and --instance are for the parameters of an autopilot: add --to px4 or --to ardupilot; "
            "a corrected record is written with --corrected PATH"
        )
    return None
