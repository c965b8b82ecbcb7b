"""Any statistic, spectrum or dynamic curve of a file, as a table, CSV, JSON or a figure."""

import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import click

from allanite.core.errors import LongJobWarning
from allanite.reporting.outputs import OUTPUTS, STDOUT, demand_outputs

from .output import print_table, put, recipe_of
from .reading import factors, names, reading, results, taus

if TYPE_CHECKING:
    from allanite.core.fit import Fit
    from allanite.core.record import Record
    from allanite.study.survey import Measure, Value


@click.command()
@reading
@click.option("--statistic", callback=names, metavar="A,B,...", default="oadev", help="Statistics.  [oadev]")
@click.option("--taus", callback=taus, metavar="GRID", help="octave, decade, log, all, or seconds as 1,10.  [octave]")
@click.option("--m", callback=factors, metavar="A,B,...", help="Averaging factors instead.")
@click.option("--threads", type=click.IntRange(1), default=1, help="Threads to use at most.  [1]")
@click.option("--no-limits", is_flag=True, help="No confidence limits: the noise need not be identified for them.")
@results
def deviation(file: str, *, statistic: tuple[str, ...], no_limits: bool, m: Any, threads: int, **choices: Any) -> None:
    """Tabulate any statistic of every channel of FILE over averaging time."""
    from allanite.statistics import deviation as measured
    from allanite.statistics import statistic_named

    rows = [statistic_named(name).name for name in statistic]
    grid = choices.pop("taus") or "octave"

    def measure(record: "Record", fit: "Fit | None") -> "Iterator[Value]":
        for name in rows:
            yield measured(record, name, taus=grid, m=m, noise=fit.model if fit else None, threads=threads)

    _survey(file, measure, fitted=not no_limits, **choices)


@click.command()
@reading
@click.option("--method", metavar="NAME", default="welch", help="welch or multitaper.  [welch]")
@click.option("--sides", metavar="NAME", default="one", help="one- or two-sided density.  [one]")
@click.option("--bins", type=int, default=20, help="Values per decade; 0 keeps every frequency.  [20]")
@click.option("--segment", type=float, metavar="S", help="Length of Welch's segments.  [an eighth of the record]")
@click.option("--window", metavar="NAME", help="Welch's window.  [hann]")
@click.option("--bandwidth", type=float, metavar="NW", help="Half bandwidth of the tapers, in 1/T.  [4]")
@click.option("--tapers", type=int, metavar="K", help="Number of tapers.  [2 NW - 3]")
@click.option("--weights", metavar="NAME", help="Weights of the tapers: eigen or equal.  [eigen]")
@click.option("--fit", "fitted", is_flag=True, help="Identify the noise, and draw its terms into the figure.")
@results
def spectrum(file: str, *, fitted: bool, **choices: Any) -> None:
    """Tabulate the power spectral density of every channel of FILE.

    N of IEEE 952 is the square root of the two-sided density of white noise.
    """
    from allanite.core.spectrum import side_factor
    from allanite.statistics.spectra.spectrum import method_named
    from allanite.statistics.spectra.spectrum import spectrum as measured

    name, sides, bins = (choices.pop(key) for key in ("method", "sides", "bins"))
    settings = {key: choices.pop(key) for key in ("segment", "window", "bandwidth", "tapers", "weights")}
    method = method_named(name, **{key: value for key, value in settings.items() if value is not None})
    side_factor(sides)

    def measure(record: "Record", _: "Fit | None") -> "Iterator[Value]":
        yield measured(record, method, sides=sides, bins=bins or None)

    _survey(file, measure, fitted=fitted, **choices)


@click.command()
@reading
@click.option("--statistic", metavar="NAME", default="oadev", help="Statistic.  [oadev]")
@click.option("--window", type=float, metavar="S", help="Length of a window.  [a tenth of the record]")
@click.option("--step", type=float, metavar="S", help="Distance of windows.  [an eighth of a window]")
@click.option("--taus", callback=taus, metavar="GRID", help="octave, decade, log, all, or seconds as 1,10.  [octave]")
@click.option("--m", callback=factors, metavar="A,B,...", help="Averaging factors instead.")
@results
def dynamic(file: str, **choices: Any) -> None:
    """Tabulate a statistic in windows that slide along every channel of FILE."""
    from allanite.statistics import statistic_named
    from allanite.statistics.dynamic import dynamic as measured

    name = statistic_named(choices.pop("statistic")).name
    grid = choices.pop("taus") or "octave"
    options = {key: choices.pop(key) for key in ("window", "step", "m")}

    def measure(record: "Record", _: "Fit | None") -> "Iterator[Value]":
        yield measured(record, name, taus=grid, **options)

    _survey(file, measure, fitted=False, **choices)


@contextmanager
def _told() -> Iterator[None]:
    """Warnings as sentences on stderr, when they arise."""
    with warnings.catch_warnings():
        warnings.simplefilter("always", LongJobWarning)
        warnings.showwarning = lambda message, *_, **__: click.echo(f"allanite: {message}", err=True)
        yield


def _survey(
    file: str, measure: "Measure", *, fitted: bool, unit_shown: str | None, force: bool, quiet: bool, **choices: Any
) -> None:
    """Measure every channel, print the table, write the files."""
    paths = {name: path for name in OUTPUTS if (path := choices.pop(name, None)) is not None}
    demand_outputs(paths, inputs=[file], force=force)
    from allanite.reporting.progress import bar
    from allanite.reporting.words import readable_unit
    from allanite.study.survey import survey

    def in_unit(record: "Record", fit: "Fit | None") -> "Iterator[Value]":
        for value in measure(record, fit):
            yield value.to(unit_shown or readable_unit(value.unit))

    with _told(), bar(shown=sys.stderr.isatty() and not quiet) as progress:
        found = survey(file, in_unit, recipe_of(None, choices), fitted=fitted, progress=progress)
    silent = STDOUT in paths.values()
    if not (quiet or silent):
        print_table(found)
    for name, path in paths.items():
        put(path, OUTPUTS[name](found, path), force=force)
        if path != STDOUT and not quiet:
            click.echo(f"{name}: {path}", err=silent)
