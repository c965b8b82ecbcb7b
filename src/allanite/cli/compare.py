"""Before and after, unit against unit, run against run."""

import sys
from typing import TYPE_CHECKING, Any

import click

from allanite.reporting.outputs import STDOUT, demand_outputs

from .output import print_table, put
from .reading import READING, band, names, outliers, taus

if TYPE_CHECKING:
    from collections.abc import Callable

    from allanite.comparison.comparison import Comparison
    from allanite.comparison.pooled import Pool
    from allanite.study.analysis import Recipe

    Progress = Callable[[str, float], None]

KINDS = ("report", "plot", "json", "csv")


@click.command()
@click.argument("files", nargs=-1, required=True, type=click.Path(), metavar="FILE...")
@click.option("--against", callback=names, metavar="A,B,...", help="Channels of the second file, for --channels.")
@click.option("--part", type=float, metavar="S", help="Hold the first S seconds of one file against the rest.")
@click.option("--statistic", metavar="NAME", help="Statistic of the curves.  [oadev]")
@click.option("--taus", callback=taus, metavar="GRID", help="octave, decade, log, or seconds as 1,10,100.  [octave]")
@click.option("--terms", metavar="QNBKR", help="Terms to compare.  [auto]")
@click.option("--band", callback=band, metavar="LO,HI", help="Frequencies that are used, Hz.")
@outliers
@click.option("--level", type=float, help="Confidence level; a change has p below 1 - level.  [0.95]")
@click.option("--report", metavar="PATH", type=click.Path(), help="Write the HTML page.")
@click.option("--plot", metavar="PATH", type=click.Path(), help="Write the figure: .png, .svg or .pdf.")
@click.option("--json", metavar="PATH", type=click.Path(), help="Write everything as JSON; - is standard output.")
@click.option("--csv", metavar="PATH", type=click.Path(), help="Write all values as CSV; - is standard output.")
@click.option("--force", is_flag=True, help="Overwrite files that exist.")
@click.option(
    "--quiet", is_flag=True, help="Print nothing but errors, and what goes to standard output by --json or --csv."
)
def compare(files: tuple[str, ...], *, force: bool, quiet: bool, **choices: Any) -> None:
    """Say what has changed between recordings, and whether that is more than chance.

    Two files: before and after. One file: its channels against each other, or with --part its beginning against the
    rest. Three files or more (or channels of one file): what they have in common, and which lies apart.
    """
    paths = {name: path for name in KINDS if (path := choices.pop(name)) is not None}
    demand_outputs(paths, inputs=list(files), force=force)
    from allanite.reporting.comparison.outputs import OUTPUTS
    from allanite.reporting.progress import bar
    from allanite.study.analysis import Recipe

    against, part = choices.pop("against"), choices.pop("part")
    chosen = {key: value for key, value in choices.items() if value is not None}
    recipe = Recipe.from_dict({"taus": "octave"} | chosen)
    with bar(shown=sys.stderr.isatty() and not quiet) as progress:
        found = _found(files, recipe, (against, part), progress)
    silent = STDOUT in paths.values()
    if not (quiet or silent):
        print_table(found)
    for name, path in paths.items():
        put(path, OUTPUTS[name](found, path), force=force)
        if path != STDOUT and not quiet:
            click.echo(f"{name}: {path}", err=silent)


for _option in reversed(READING[1:]):  # all but the one file
    compare = _option(compare)


def _found(
    files: tuple[str, ...], recipe: "Recipe", how: "tuple[tuple[str, ...] | None, float | None]", progress: "Progress"
) -> "Comparison | Pool":
    from dataclasses import replace

    from allanite.comparison.pooling import pool, truncation
    from allanite.comparison.study import compare as compared
    from allanite.core.errors import UsageError
    from allanite.study.analysis import Recipe, recording_of

    against, part = how
    if part is not None and len(files) > 1:
        raise UsageError(f"--part cuts one file, and {len(files)} came")
    if against is not None and len(files) != 2:
        raise UsageError(f"--against names channels of the second of two files, and {len(files)} came")
    if part is not None:
        return truncation(files[0], part, recipe, progress=progress)
    if len(files) == 2:
        return compared(files[0], files[1], recipe, against=against, progress=progress)
    if len(files) > 2:
        return pool(files, recipe, progress=progress)
    recording = recording_of(files[0], recipe)
    channels = [replace(recording, records=(record,)) for record in recording]
    if len(channels) == 1:
        raise UsageError(
            f"{files[0]!r} has one channel, {recording[0].name!r}, and nothing to compare it with; give a second file, "
            "more channels, or --part to hold its beginning against the rest"
        )
    plain = Recipe(**{key: getattr(recipe, key) for key in ("statistic", "taus", "terms", "band", "level", "outliers")})
    if len(channels) == 2:
        return compared(channels[0], channels[1], plain, progress=progress)
    return pool(channels, plain, progress=progress)
