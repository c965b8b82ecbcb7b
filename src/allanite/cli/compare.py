"""``allanite compare``: before and after, unit against unit, run against run."""

from typing import Any

import click

from allanite.study.settings import ComparisonChoices

from .options import IDENTIFYING, RECORDING, RESULTS, options
from .tasks import COMPARE, perform


@click.command()
@options(
    "files",
    *RECORDING,
    "against",
    "part",
    "datasheet",
    "pool",
    "statistic",
    "taus",
    *IDENTIFYING,
    *RESULTS,
    settings=(ComparisonChoices,),
)
def compare(files: tuple[str, ...], **choices: Any) -> None:
    """Compare the noise of recordings.

    Two files: before and after. One file: its channels with each other, with --part its beginning with the rest, or
    with --datasheet what was measured with what a data sheet says. Three or more files (or channels of one file): their
    common noise, and which of them differs; with --pool that of two files, too.
    """
    perform(COMPARE, files, choices)
