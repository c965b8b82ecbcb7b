"""Many records: ``allanite batch`` analyzes them and stores the results, ``allanite lot`` shows them."""

from dataclasses import replace
from typing import Any

import click

from allanite.core.errors import UsageError

from .analyze import end_of_units
from .deliver import carry_out, outputs, progress, recipe_of
from .front import DATA, PARTLY
from .options import IDENTIFYING, RECORDING, RESULTS, options
from .streams import complain, show


@click.command()
@options(
    click.argument("source", type=click.Path(), metavar="FOLDER_OR_MANIFEST"),
    click.option("--out", "results", required=True, metavar="RESULTS", type=click.Path(),
        help="Folder of the results; one of an earlier run is continued."),
    click.option("--workers", type=click.IntRange(1), metavar="N",
        help="Processes of this machine.  [default: one for each core]"),
    click.option("--scheduler", metavar="ADDRESS",
        help="Dask scheduler, e.g. tcp://10.0.0.5:8786, whose workers are used instead."),
    *(name for name in RECORDING if name != "threads"), "statistic", "taus", *IDENTIFYING, "quiet",
)  # fmt: skip
def batch(source: str, results: str, workers: int | None, scheduler: str | None, **choices: Any) -> None:
    """Analyze many records and store the results.

    FOLDER_OR_MANIFEST is a folder, a pattern in quotes, a text file with a path in each line, or a CSV file with the
    columns file, unit_id, temperature, date and any others. RESULTS gets the tables files.parquet,
    coefficients.parquet, curves.parquet and findings.parquet, and a part for each file as soon as it is analyzed. A
    run that was interrupted is continued by the same command: what is stored for the same content, options and
    version is not done again.

    Exit codes: 5 if some files could not be analyzed, 3 if none could; each is named on stderr. With --strict 3 if a
    channel is not explained.
    """
    from allanite.batch.cluster import Dask
    from allanite.batch.executor import Processes, Serial
    from allanite.batch.job import run_batch
    from allanite.parallel.processors import processors

    recipe = choices["recipe"]
    out = outputs(choices, [recipe])
    if scheduler is not None and workers is not None:
        raise UsageError("--workers is for this machine, --scheduler has workers of its own; give one of them")
    count = workers or processors()
    with progress(out) as tell:
        executor = Dask(scheduler) if scheduler is not None else Serial() if count == 1 else Processes(count)
        run = run_batch(source, results, recipe_of(choices), executor=executor, besides=[recipe], progress=tell)
    if not out.quiet:
        for note in run.notes:
            show(note)
        show(
            f"{len(run.files)} files, {len(run.failed)} failed; {run.analyzed} analyzed now, {run.before} done "
            f"before; tables in {results}"
        )
    for file in run.failed:
        complain(f"{file.file}: {file.error}")
    if run.failed:
        raise click.exceptions.Exit(PARTLY if len(run.failed) < len(run.files) else DATA)
    if out.strict and run.rejected:
        complain(f"not explained, or without a result: {'; '.join(run.rejected)}")
        raise click.exceptions.Exit(DATA)


@click.command()
@options(click.argument("results", type=click.Path()), "limits file", "coefficients", *RESULTS, "strict")
def lot(results: str, limits: str | None, **choices: Any) -> None:
    """Show the stored results of a batch.

    RESULTS is a folder that 'allanite batch' has written. Shows what 'allanite analyze' shows of many units, and the
    quantiles of each coefficient, its trends over the temperature and date of the manifest, and units that differ from
    the others. --limits holds the coefficients against limits; exit codes are those of 'allanite analyze'.
    """
    from allanite.batch.lot import read_lot

    out = outputs(choices, [limits])
    stored = carry_out(lambda tell: read_lot(results, limits), replace(out, strict=False))
    end_of_units(stored.batch, strict=out.strict)
