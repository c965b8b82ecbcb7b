"""Any statistic, spectrum or dynamic curve of a file, as a table, CSV, JSON, a figure or a page."""

from typing import TYPE_CHECKING, Any

import click

from .deliver import deliver, outputs, progress, recipe_of
from .options import IDENTIFYING, NAMES, RECORDING, RESULTS, options

if TYPE_CHECKING:
    from allanite.study.survey import Densities, Deviations, Windows


@click.command()
@options(
    "file",
    *RECORDING,
    click.option("--statistic", type=NAMES, metavar="A,B,...", default="oadev", show_default=True, help="Statistics."),
    "taus",
    "m",
    "to",
    "threads",
    click.option("--limits/--no-limits", default=True, help="Confidence limits; without, no noise is identified."),
    *IDENTIFYING,
    *RESULTS,
)
def deviation(file: str, **choices: Any) -> None:
    """Tabulate any statistic of every channel of FILE over averaging time."""
    from allanite.study.survey import Deviations

    keys = ("statistic", "taus", "m", "limits", "threads", "to")
    _survey(file, Deviations(**_own(choices, keys)), choices)


@click.command()
@options(
    "file",
    *RECORDING,
    click.option("--estimator", metavar="NAME", default="welch", show_default=True, help="welch or multitaper."),
    click.option("--sides", metavar="NAME", default="one", show_default=True, help="one- or two-sided density."),
    click.option("--bins", type=int, default=20, show_default=True, help="Values per decade; 0 keeps every frequency."),
    click.option("--segment", type=float, metavar="S", help="Length of Welch's segments.  [an eighth of the record]"),
    click.option("--window", metavar="NAME", help="Welch's window.  [hann]"),
    click.option("--bandwidth", type=float, metavar="NW", help="Half bandwidth of the tapers, in 1/T.  [4]"),
    click.option("--tapers", type=int, metavar="K", help="Number of tapers.  [2 NW - 3]"),
    click.option("--weights", metavar="NAME", help="Weights of the tapers: eigen or equal.  [eigen]"),
    click.option("--fit", is_flag=True, help="Identify the noise, and draw its terms into the figure."),
    "to",
    *IDENTIFYING,
    *RESULTS,
)
def spectrum(file: str, **choices: Any) -> None:
    """Tabulate the power spectral density of every channel of FILE.

    N of IEEE 952 is the square root of the two-sided density of white noise.
    """
    from allanite.study.survey import Densities

    keys = ("estimator", "sides", "bins", "segment", "window", "bandwidth", "tapers", "weights", "fit", "to")
    _survey(file, Densities(**_own(choices, keys)), choices)


@click.command()
@options(
    "file",
    *RECORDING,
    click.option("--statistic", metavar="NAME", default="oadev", show_default=True, help="Statistic."),
    click.option("--window", type=float, metavar="S", help="Length of a window.  [a tenth of the record]"),
    click.option("--step", type=float, metavar="S", help="Distance of windows.  [an eighth of a window]"),
    "taus",
    "m",
    "to",
    "level",
    *RESULTS,
)
def dynamic(file: str, **choices: Any) -> None:
    """Tabulate a statistic in windows that slide along every channel of FILE."""
    from allanite.study.survey import Windows

    _survey(file, Windows(**_own(choices, ("statistic", "window", "step", "taus", "m", "to"))), choices)


def _own(choices: dict[str, Any], keys: tuple[str, ...]) -> dict[str, Any]:
    """Take the verb's own settings out of its options; those left open keep their defaults."""
    return {key: value for key in keys if (value := choices.pop(key)) is not None}


def _survey(file: str, settings: "Deviations | Densities | Windows", choices: dict[str, Any]) -> None:
    out = outputs(choices, [file, choices["recipe"]])
    from allanite.study.survey import survey

    with progress(out) as tell:
        found = survey(file, settings, recipe_of(choices), progress=tell)
    deliver(found, out)
