"""Any statistic, spectrum or dynamic curve of a file, as a table, CSV, JSON, figure or page."""

from typing import Any

import click

from allanite.study.settings import DensityChoices, DeviationChoices, LengthChoices, NoiseChoices, WindowChoices

from .deliver import deliver, outputs, recipe_of, settings_of
from .options import IDENTIFYING, RECORDING, RESULTS, options
from .tasks import DEVIATION, DYNAMIC, SPECTRUM, perform


@click.command()
@options(
    "optional file", "model", "sensor", "datasheet", "duration", "samples", *RECORDING, "statistic", "taus", "m", "to",
    "intervals", "bias", "join", "divisor", "edf", "power_law", *IDENTIFYING, *RESULTS,
    settings=(NoiseChoices, LengthChoices, DeviationChoices),
)  # fmt: skip
def deviation(file: str | None, **choices: Any) -> None:
    """Compute Allan and related deviations.

    Tabulates statistics of FILE over averaging time; or without data, what is expected of them and of each term under
    the noise of --model, --sensor or --datasheet, for a record of --duration or --samples at --rate.
    """
    from allanite.study.survey import Deviations
    from allanite.study.theory import TheorySettings, expected_curves

    theory = settings_of(TheorySettings, choices)
    if file is not None and not theory.asked:
        perform(DEVIATION, [file], choices)
        return
    out = outputs(choices, [file, choices["recipe"]])
    deliver(expected_curves(file, theory, settings_of(Deviations, choices), recipe_of(choices)), out)


@click.command()
@options(
    "file", *RECORDING, "estimator", "sides", "bins", "segment", "window", "bandwidth", "tapers", "weights", "fit",
    "deviation", "to", *IDENTIFYING, *RESULTS, settings=(DensityChoices,),
)  # fmt: skip
def spectrum(file: str, **choices: Any) -> None:
    """Compute the power spectral density.

    N of IEEE 952 is the square root of the two-sided power spectral density of white noise.
    """
    perform(SPECTRUM, [file], choices)


@click.command()
@options(
    "file", *RECORDING, "statistic", "window", "step", "taus", "m", "to", "level", *RESULTS, settings=(WindowChoices,)
)
def dynamic(file: str, **choices: Any) -> None:
    """Compute a deviation in sliding windows.

    Shows how the noise of FILE changes with time.
    """
    perform(DYNAMIC, [file], choices)
