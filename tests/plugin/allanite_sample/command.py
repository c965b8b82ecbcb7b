"""The command line of the verb."""

from typing import Any

import click

from allanite.cli.deliver import carry_out, outputs, recipe_of
from allanite.cli.options import RECORDING, options


@click.command()
@options("file", *RECORDING, "report", "csv", "json", "lang", "force", "quiet")
def extent(file: str, **choices: Any) -> None:
    """Show the least and the greatest sample."""
    out = outputs(choices, [file, choices["recipe"]])
    from .job import extents

    carry_out(lambda tell: extents(file, recipe_of(choices), tell), out)
