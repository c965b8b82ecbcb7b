"""The main analysis, and the check of a file before it."""

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import click

from .deliver import Progress, carry_out, outputs, recipe_of
from .front import DATA
from .options import IDENTIFYING, RECORDING, RESULTS, SHOWN, options
from .streams import complain
from .tasks import ANALYZE, INFO, ends_of_units, perform

if TYPE_CHECKING:
    from allanite.batch.batch import Batch


@click.command()
@options("file", *RECORDING, "report", "plot", "json", *SHOWN)
def info(file: str, **choices: Any) -> None:
    """Summarize FILE and check its quality.

    --plot draws the samples over time.
    """
    study = perform(INFO, [file], choices)
    if INFO.code(study):
        raise click.exceptions.Exit(DATA)


@click.command()
@options(
    "files", *RECORDING, "statistic", "taus", *IDENTIFYING, "device", "limits file", "to", "about",
    "coefficients", *RESULTS,
)  # fmt: skip
def analyze(files: tuple[str, ...], limits: str | None, **choices: Any) -> None:
    """Identify the noise coefficients of FILES.

    Prints a table for each channel, with confidence intervals; --report writes a page with the figures. FILE is a
    recording, or - for standard input. Several files, a folder, or a pattern in quotes ('units/*.csv') are many units:
    one table with a row for each channel of each unit, mean, spread and worst over the units, one figure and one page.
    A file that cannot be analyzed is named, and the others are analyzed all the same.

    --limits FILE.toml holds lines such as N = { max = "0.15 deg/sqrt(h)" } below [limits], or below [channels.gz] for
    one channel; B, K, Q, R, GM and minimum (of the Allan deviation) are limited likewise. A term passes if its value
    does not exceed the limit; with judge = "upper", if the upper end of its interval does not. A term that was not
    identified passes if its 95 % upper limit does not exceed the limit. What neither passes nor fails is "not shown".

    Exit codes: 4 if a unit exceeds a limit, else 5 if some files could not be analyzed, else with --strict 3 if a
    channel is not explained or a limit is not shown.
    """
    from allanite.batch.sources import several

    if limits is None and not several(files):
        perform(ANALYZE, files, choices)
        return
    from allanite.batch.job import analyze_files

    recipe = choices["recipe"]
    out = outputs(choices, [*files, recipe, limits])
    besides = (*out.paths.values(), recipe, limits)

    def job(tell: Progress) -> "Batch":
        return analyze_files(files, recipe_of(choices), limits=limits, besides=besides, progress=tell)

    end_of_units(carry_out(job, replace(out, strict=False)), strict=out.strict)


def end_of_units(batch: "Batch", *, strict: bool) -> None:
    """End with the exit code of the worst that was found, and say on stderr which units it is."""
    ends = ends_of_units(batch, strict=strict)
    for _, words in ends:
        complain(words)
    if ends:
        raise click.exceptions.Exit(ends[0][0])
