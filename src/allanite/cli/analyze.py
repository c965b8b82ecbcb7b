"""The main job, and the look at a file before it."""

import sys
from typing import Any

import click

from allanite.reporting.outputs import OUTPUTS, STDOUT, demand_outputs

from .front import DATA
from .output import print_table, put, recipe_of
from .reading import band, outliers, reading, taus


@click.command()
@reading
@click.option("--json", metavar="PATH", type=click.Path(), help="Write everything as JSON; - is standard output.")
@click.option("--force", is_flag=True, help="Overwrite files that exist.")
def info(file: str, *, json: str | None, force: bool, **choices: Any) -> None:
    """Say what is in FILE, and whether it is fit for the job."""
    paths = {} if json is None else {"json": json}
    demand_outputs(paths, inputs=[file], force=force)
    from allanite.reporting.progress import bar
    from allanite.study.analysis import examine

    with bar(shown=sys.stderr.isatty()) as progress:
        study = examine(file, recipe_of(None, choices), progress=progress)
    if json != STDOUT:
        print_table(study)
    if json is not None:
        put(json, OUTPUTS["json"](study, json), force=force)
    if all(channel.refusal for channel in study.channels):
        raise click.exceptions.Exit(DATA)


@click.command()
@reading
@click.option("--statistic", metavar="NAME", help="Statistic of the curve.  [oadev]")
@click.option("--taus", callback=taus, metavar="GRID", help="octave, decade, log, all, or seconds as 1,10,100.  [log]")
@click.option("--terms", metavar="QNBKR", help="Terms to look for.  [auto]")
@click.option(
    "--method", metavar="NAME", help="whittle, or for comparison gls, joint, nnls, piecewise, ls, slopes.  [whittle]"
)
@click.option("--band", callback=band, metavar="LO,HI", help="Frequencies that are used, Hz.")
@outliers
@click.option("--level", type=float, help="Confidence level of intervals.  [0.95]")
@click.option("--recipe", metavar="TOML", type=click.Path(), help="All of these choices from a file; options here win.")
@click.option("--report", metavar="PATH", type=click.Path(), help="Write the HTML page.")
@click.option("--plot", metavar="PATH", type=click.Path(), help="Write the figure: .png, .svg or .pdf.")
@click.option("--json", metavar="PATH", type=click.Path(), help="Write everything as JSON; - is standard output.")
@click.option("--csv", metavar="PATH", type=click.Path(), help="Write the curves as CSV; - is standard output.")
@click.option("--force", is_flag=True, help="Overwrite files that exist.")
@click.option(
    "--quiet", is_flag=True, help="Print nothing but errors, and what goes to standard output by --json or --csv."
)
def analyze(file: str, *, recipe: str | None, force: bool, quiet: bool, **choices: Any) -> None:
    """Find the noise coefficients of every channel of FILE, with intervals.

    Prints a table for each channel; --report writes the page with the figures.
    """
    paths = {name: path for name in OUTPUTS if (path := choices.pop(name)) is not None}
    demand_outputs(paths, inputs=[file, *([recipe] if recipe else [])], force=force)
    from allanite.reporting.progress import bar
    from allanite.study.analysis import analyze as run

    plan = recipe_of(recipe, choices)
    with bar(shown=sys.stderr.isatty() and not quiet) as progress:
        study = run(file, plan, progress=progress)
    silent = STDOUT in paths.values()
    if not (quiet or silent):
        print_table(study)
    for name, path in paths.items():
        put(path, OUTPUTS[name](study, path), force=force)
        if path != STDOUT and not quiet:
            click.echo(f"{name}: {path}", err=silent)
