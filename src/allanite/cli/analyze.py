"""The main analysis, and the check of a file before it."""

from typing import Any

import click

from .deliver import carry_out, outputs, recipe_of
from .front import DATA
from .options import IDENTIFYING, RECORDING, RESULTS, options


@click.command()
@options("file", *RECORDING, "json", "force", "quiet")
def info(file: str, **choices: Any) -> None:
    """Summarize FILE and check its quality."""
    out = outputs(choices, [file])
    from allanite.study.analysis import examine

    study = carry_out(lambda tell: examine(file, recipe_of(choices), progress=tell), out)
    if all(channel.refusal for channel in study.channels):
        raise click.exceptions.Exit(DATA)


@click.command()
@options("file", *RECORDING, "statistic", "taus", *IDENTIFYING, "coefficients", *RESULTS)
def analyze(file: str, **choices: Any) -> None:
    """Identify the noise coefficients of FILE.

    Prints a table for each channel, with confidence intervals; --report writes a page with the figures.
    """
    out = outputs(choices, [file, choices["recipe"]])
    from allanite.study.analysis import analyze as run

    carry_out(lambda tell: run(file, recipe_of(choices), progress=tell), out)
