"""``allanite compare``: before and after, unit against unit, run against run."""

from typing import TYPE_CHECKING, Any

import click

from allanite.study.settings import ComparisonChoices

from .deliver import carry_out, outputs, recipe_of
from .options import IDENTIFYING, RECORDING, RESULTS, options

if TYPE_CHECKING:
    from allanite.comparison.comparison import Comparison
    from allanite.comparison.pooled import Pool
    from allanite.study.channels import Progress
    from allanite.study.recipe import Recipe


@click.command()
@options(
    "files", *RECORDING, "against", "part", "statistic", "taus", *IDENTIFYING, *RESULTS, settings=(ComparisonChoices,)
)
def compare(files: tuple[str, ...], **choices: Any) -> None:
    """Compare the noise of recordings.

    Two files: before and after. One file: its channels with each other, or with --part its beginning with the rest.
    Three or more files (or channels of one file): their common noise, and which of them differs.
    """
    out = outputs(choices, [*files, choices["recipe"]])
    how = choices.pop("against"), choices.pop("part")
    carry_out(lambda tell: _compare(files, recipe_of(choices, taus="octave"), how, tell), out)


def _compare(
    files: tuple[str, ...], recipe: "Recipe", how: "tuple[tuple[str, ...] | None, float | None]", tell: "Progress"
) -> "Comparison | Pool":
    from allanite.comparison import comparing as study
    from allanite.core.errors import UsageError

    against, part = how
    if part is not None and len(files) > 1:
        raise UsageError(f"--part splits a single file, but {len(files)} files were given")
    if against is not None and len(files) != 2:
        raise UsageError(f"--against names channels of the second of two files, but {len(files)} files were given")
    if part is not None:
        return study.truncation(files[0], part, recipe, progress=tell)
    if len(files) == 1:
        return study.compare_channels(files[0], recipe, progress=tell)
    if len(files) == 2:
        return study.compare(files[0], files[1], recipe, against=against, progress=tell)
    return study.pool(files, recipe, progress=tell)
