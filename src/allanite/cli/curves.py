"""Any statistic, spectrum or dynamic curve of a file, as a table, CSV, JSON, figure or page."""

from typing import TYPE_CHECKING, Any

import click

from allanite.study.settings import DensityChoices, DeviationChoices, LengthChoices, NoiseChoices, WindowChoices

from .deliver import carry_out, deliver, outputs, recipe_of, settings_of
from .options import IDENTIFYING, RECORDING, RESULTS, options

if TYPE_CHECKING:
    from allanite.study.survey import Densities, Deviations, Windows


@click.command()
@options(
    "optional file", "model", "sensor", "duration", "samples", *RECORDING, "statistic", "taus", "m", "to", "intervals",
    "bias", "join", "divisor", "edf", "power_law", *IDENTIFYING, *RESULTS,
    settings=(NoiseChoices, LengthChoices, DeviationChoices),
)  # fmt: skip
def deviation(file: str | None, **choices: Any) -> None:
    """Compute Allan and related deviations.

    Tabulates statistics of FILE over averaging time; or without data, what is expected of them and of each term under
    the noise of --model or --sensor, for a record of --duration or --samples at --rate.
    """
    from allanite.study.survey import Deviations
    from allanite.study.theory import TheorySettings, expected_curves

    out = outputs(choices, [file, choices["recipe"]])
    theory = settings_of(TheorySettings, choices)
    settings = settings_of(Deviations, choices)
    recipe = recipe_of(choices)
    if file is None or theory.asked:
        found = expected_curves(file, theory, settings, recipe)
        deliver(found, out)
        return
    from allanite.study.survey import survey

    carry_out(lambda tell: survey(file, settings, recipe, progress=tell), out)


@click.command()
@options(
    "file", *RECORDING, "estimator", "sides", "bins", "segment", "window", "bandwidth", "tapers", "weights", "fit",
    "deviation", "to", *IDENTIFYING, *RESULTS, settings=(DensityChoices,),
)  # fmt: skip
def spectrum(file: str, **choices: Any) -> None:
    """Compute the power spectral density.

    N of IEEE 952 is the square root of the two-sided power spectral density of white noise.
    """
    from allanite.study.survey import Densities

    _survey(file, Densities, choices)


@click.command()
@options(
    "file", *RECORDING, "statistic", "window", "step", "taus", "m", "to", "level", *RESULTS, settings=(WindowChoices,)
)
def dynamic(file: str, **choices: Any) -> None:
    """Compute a deviation in sliding windows.

    Shows how the noise of FILE changes with time.
    """
    from allanite.study.survey import Windows

    _survey(file, Windows, choices)


def _survey(file: str, kind: "type[Deviations | Densities | Windows]", choices: dict[str, Any]) -> None:
    out = outputs(choices, [file, choices["recipe"]])
    from allanite.study.survey import survey

    settings = settings_of(kind, choices)
    carry_out(lambda tell: survey(file, settings, recipe_of(choices), progress=tell), out)
