"""Any statistic, spectrum or dynamic curve of a file, as a table, CSV, JSON, figure or page."""

from typing import Any

import click

from allanite.study.settings import DensityChoices, DeviationChoices, LengthChoices, NoiseChoices, WindowChoices

from .deliver import deliver, outputs, recipe_of, settings_of
from .options import IDENTIFYING, RECORDING, RESULTS, options
from .tasks import DEVIATION, DYNAMIC, SPECTRUM, perform


@click.command()
@options(
    "some files", "models", "sensor", "datasheet", "duration", "samples", *RECORDING, "statistic", "taus", "m", "to",
    "intervals", "bias", "join", "divisor", "edf", "power_law", *IDENTIFYING, *RESULTS,
    settings=(NoiseChoices, LengthChoices, DeviationChoices),
)  # fmt: skip
def deviation(files: tuple[str, ...], models: tuple[str, ...], **choices: Any) -> None:
    """Compute Allan and related deviations.

    Tabulates statistics of FILES over averaging time; or without data, what is expected of them and of each term under
    the noise of --model, --sensor or --datasheet, for a record of --duration or --samples at --rate. Channels of
    several files, and several models, are in one figure.
    """
    from allanite.study.survey import Deviations
    from allanite.study.theory import TheorySettings, expected_of_models

    theory = settings_of(TheorySettings, choices)
    if files and not (models or theory.asked):
        perform(DEVIATION, files, choices)
        return
    out = outputs(choices, [*files, choices["recipe"]])
    wanted, recipe = settings_of(Deviations, choices), recipe_of(choices)
    deliver(expected_of_models(next(iter(files), None), models, theory, wanted, recipe), out)


@click.command()
@options(
    "files", *RECORDING, "estimator", "sides", "bins", "segment", "window", "bandwidth", "tapers", "weights", "fit",
    "deviation", "to", *IDENTIFYING, *RESULTS, settings=(DensityChoices,),
)  # fmt: skip
def spectrum(files: tuple[str, ...], **choices: Any) -> None:
    """Compute the power spectral density.

    N of IEEE 952 is the square root of the two-sided power spectral density of white noise. Channels of several FILES
    are in one figure.
    """
    perform(SPECTRUM, files, choices)


@click.command()
@options(
    "file", *RECORDING, "statistic", "window", "step", "taus", "m", "to", "level", *RESULTS, settings=(WindowChoices,)
)
def dynamic(file: str, **choices: Any) -> None:
    """Compute a deviation in sliding windows.

    Shows how the noise of FILE changes with time.
    """
    perform(DYNAMIC, [file], choices)
