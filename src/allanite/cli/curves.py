"""Any statistic, spectrum or dynamic curve of a file, as a table, CSV, JSON, figure or page."""

from typing import TYPE_CHECKING, Any

import click

from .deliver import carry_out, deliver, outputs, recipe_of, settings_of
from .options import IDENTIFYING, RECORDING, RESULTS, options

if TYPE_CHECKING:
    from allanite.study.survey import Densities, Deviations, Windows


@click.command()
@options(
    "optional file",
    "model",
    "sensor",
    "duration",
    "samples",
    *RECORDING,
    "several statistics",
    "taus",
    "m",
    "to",
    "intervals",
    "bias",
    "join",
    "divisor",
    "edf",
    "power law",
    *IDENTIFYING,
    *RESULTS,
)
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
    "file",
    *RECORDING,
    click.option(
        "--estimator", metavar="NAME", default="welch", show_default=True, help="Estimator: welch or multitaper."
    ),
    click.option(
        "--sides", metavar="NAME", default="one", show_default=True, help="One- or two-sided power spectral density."
    ),
    click.option("--bins", type=int, default=20, show_default=True, help="Values per decade; 0 keeps all frequencies."),
    click.option(
        "--segment", type=float, metavar="S", help="Length of Welch's segments.  [default: an eighth of the record]"
    ),
    "segment window",
    click.option(
        "--bandwidth", type=float, metavar="NW", help="Time-half-bandwidth product NW of the tapers.  [default: 4]"
    ),
    click.option("--tapers", type=int, metavar="K", help="Number of tapers.  [default: 2 NW - 3]"),
    click.option("--weights", metavar="NAME", help="Weights of the tapers: eigen or equal.  [default: eigen]"),
    click.option("--fit", is_flag=True, help="Identify the noise and draw its terms in the figure."),
    click.option("--deviation", metavar="NAME", help="Integrate the density to this deviation: oadev, mdev, ohdev ..."),
    "to",
    *IDENTIFYING,
    *RESULTS,
)
def spectrum(file: str, **choices: Any) -> None:
    """Compute the power spectral density.

    N of IEEE 952 is the square root of the two-sided power spectral density of white noise.
    """
    from allanite.study.survey import Densities

    _survey(file, Densities, choices)


@click.command()
@options(
    "file",
    *RECORDING,
    "usual statistic",
    "sliding window",
    click.option("--step", type=float, metavar="S", help="Distance between windows.  [default: an eighth of a window]"),
    "taus",
    "m",
    "to",
    "level",
    *RESULTS,
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
