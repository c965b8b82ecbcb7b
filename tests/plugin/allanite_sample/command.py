"""The command line of the verb, and what it does, on the page, too."""

from collections.abc import Sequence
from typing import Any

import click

from allanite.cli.options import RECORDING, options
from allanite.cli.tasks import Reports, VerbTask, perform
from allanite.study.recipe import Recipe


def _run(files: Sequence[str], recipe: Recipe, _: Any, reports: Reports) -> Any:
    from .job import extents

    return extents(files[0], recipe, progress=reports.tell)


EXTENT = VerbTask(_run)


@click.command()
@options("file", *RECORDING, "report", "csv", "json", "lang", "force", "quiet")
def extent(file: str, **choices: Any) -> None:
    """Show the least and the greatest sample."""
    perform(EXTENT, [file], choices)
