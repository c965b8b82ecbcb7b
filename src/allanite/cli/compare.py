"""Before and after, unit against unit, run against run."""

from typing import TYPE_CHECKING, Any

import click

from .deliver import carry_out, outputs, recipe_of
from .options import IDENTIFYING, NAMES, RECORDING, RESULTS, options

if TYPE_CHECKING:
    from allanite.comparison.comparison import Comparison
    from allanite.comparison.pooled import Pool
    from allanite.study.channels import Progress
    from allanite.study.recipe import Recipe


@click.command()
@options(
    "files",
    *RECORDING,
    click.option("--against", type=NAMES, metavar="A,B,...", help="Channels of the second file, for --channels."),
    click.option("--part", type=float, metavar="S", help="Compare the first S seconds of one file with the rest."),
    "statistic",
    "taus",
    *IDENTIFYING,
    *RESULTS,
)
def compare(files: tuple[str, ...], **choices: Any) -> None:
    """Say what has changed between recordings.

    Two files: before and after. One file: its channels against each other, or with --part its beginning against the
    rest. Three files or more (or channels of one file): what they have in common, and which one differs.
    """
    out = outputs(choices, [*files, choices["recipe"]])
    how = choices.pop("against"), choices.pop("part")
    carry_out(lambda tell: _compare(files, recipe_of(choices, taus="octave"), how, tell), out)


def _compare(
    files: tuple[str, ...], recipe: "Recipe", how: "tuple[tuple[str, ...] | None, float | None]", tell: "Progress"
) -> "Comparison | Pool":
    from allanite.comparison import study
    from allanite.core.errors import UsageError

    against, part = how
    if part is not None and len(files) > 1:
        raise UsageError(f"--part cuts one file, and {len(files)} were given")
    if against is not None and len(files) != 2:
        raise UsageError(f"--against names channels of the second of two files, and {len(files)} were given")
    if part is not None:
        return study.truncation(files[0], part, recipe, progress=tell)
    if len(files) == 1:
        return study.compare_channels(files[0], recipe, progress=tell)
    if len(files) == 2:
        return study.compare(files[0], files[1], recipe, against=against, progress=tell)
    return study.pool(files, recipe, progress=tell)
