"""The main job, and the look at a file before it."""

from typing import Any

import click

from .deliver import carry_out, outputs, recipe_of
from .front import DATA
from .options import IDENTIFYING, RECORDING, RESULTS, options


@click.command()
@options("file", *RECORDING, "report", "json", "force", "quiet")
def info(file: str, **choices: Any) -> None:
    """Say what is in FILE, and whether it is fit for the job."""
    out = outputs(choices, [file])
    from allanite.study.analysis import examine

    study = carry_out(lambda tell: examine(file, recipe_of(choices), progress=tell), out)
    if all(channel.refusal for channel in study.channels):
        raise click.exceptions.Exit(DATA)


@click.command()
@options("file", *RECORDING, "statistic", "taus", *IDENTIFYING, "shown in", "about", "coefficients", *RESULTS)
def analyze(file: str, **choices: Any) -> None:
    """Find the noise coefficients of FILE, with intervals.

    Prints a table for each channel; --report writes the page with the figures.
    """
    out = outputs(choices, [file, choices["recipe"]])
    from allanite.study.analysis import analyze as run

    carry_out(lambda tell: run(file, recipe_of(choices), progress=tell), out)
