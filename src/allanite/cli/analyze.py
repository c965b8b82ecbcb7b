"""Analyses: of a file, of many, of a live stream, and any statistic or spectrum alone."""

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import click

from allanite.core.errors import UsageError
from allanite.study.recipe import IDENTIFYING as IDENTIFIES, READING, SELECTING

from allanite.study.settings import (  # isort: skip
    DensityChoices, DeviationChoices, LengthChoices, NoiseChoices, WatchChoices, WindowChoices
)  # fmt: skip

from .deliver import Progress, carry_out, deliver, outputs, progress, recipe_of, settings_of
from .front import DATA, PARTLY
from .helping import command
from .options import IDENTIFYING, RECORDING, RESULTS, SHOWN, Option, integer, options
from .streams import complain, show
from .tasks import ANALYZE, DEVIATION, DYNAMIC, INFO, SPECTRUM, WATCH, Reports, ends_of_units, perform

if TYPE_CHECKING:
    from allanite.batch.batch import Batch


@command()
@options("file", *RECORDING, "report", "plot", "json", *SHOWN)
def info(file: str, **choices: Any) -> None:
    """Summarize FILE and check its quality.

    --plot draws the samples over time.
    """
    study = perform(INFO, [file], choices)
    if INFO.code(study):
        raise click.exceptions.Exit(DATA)


@command()
@options("files", *RECORDING, "statistic", "taus", *IDENTIFYING, "device", "limits file", "to", "about", "coefficients",
         *RESULTS)  # fmt: skip
def analyze(files: tuple[str, ...], limits: str | None, **choices: Any) -> None:
    """Identify the noise coefficients of FILES.

    Prints a table for each channel, with confidence intervals; --report writes a page with the figures. FILE is a
    recording, or - for standard input. Several files, a folder, or a pattern in quotes ('units/*.csv') are many units:
    one table with a row for each channel of each unit, mean, spread and worst over the units, one figure and one page.
    A file that cannot be analyzed is named, and the others are analyzed all the same. A folder with --out RESULTS is
    analyzed by batch, and RESULTS are shown by lot.

    --limits FILE.toml holds lines such as N = { max = "0.15 deg/sqrt(h)" } below [limits], or below [channels.gz] for
    one channel; B, K, Q, R, GM and minimum (of the Allan deviation) are limited likewise. A term passes if its interval
    lies below the limit and fails if it lies above; otherwise it is not decided. A term that was not identified passes
    if its 95 % upper limit does not exceed the limit.

    Exit codes: 4 if a unit exceeds a limit, else 5 if some files could not be analyzed, else with --strict 3 if a
    channel is not explained or a limit is not decided.
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


@command()
@options(
    click.argument("source", type=click.Path(), metavar="FOLDER_OR_MANIFEST"),
    click.option("--out", "results", required=True, metavar="RESULTS", type=click.Path(),
        help="Folder of the results; one of an earlier run is continued.", cls=Option, old=("--output", "-o")),
    click.option("--workers", type=integer(1, 10_000), metavar="N",
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
    from allanite.batch.executor import Dask, Processes, Serial
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
        parts = [f"{len(run.files)} file{'s' * (len(run.files) != 1)}: {run.analyzed} analyzed now"]
        parts += [f"{run.before} done before"] * bool(run.before) + [f"{len(run.failed)} failed"] * bool(run.failed)
        show(f"{', '.join(parts)}; tables in {results}")
    for file in run.failed:
        complain(f"{file.file}: {file.error}")
    if run.failed:
        raise click.exceptions.Exit(PARTLY if len(run.failed) < len(run.files) else DATA)
    if out.strict and run.rejected:
        complain(f"not explained, or without a result: {'; '.join(run.rejected)}")
        raise click.exceptions.Exit(DATA)


@command()
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


BINARY = ("dtype", "columns", "offset")  # choices of a file that has no lines


@command()
@options(click.argument("target", metavar="FILE|PORT|udp://127.0.0.1:9000"),
         *(name for name in READING if name not in BINARY), *SELECTING, "recipe", "statistic", "taus", *IDENTIFIES,
         "every", "duration", "idle", "baud", "lines that come", "accuracy", "to", "coefficients", *RESULTS,
         settings=(WatchChoices,))  # fmt: skip
def watch(target: str, **choices: Any) -> None:
    """Watch a live stream.

    Reads lines of numbers, a column for each channel, from a file that grows, a serial port, or datagrams sent to this
    machine. Says every few seconds what is known of each channel and how much longer it takes until more is; says at
    once when the sensor is moved, which is left out, or unplugged, which is a gap, and that an outlier came. Ctrl-C,
    SIGTERM, --for or --idle end it, and the results of 'allanite analyze' of these lines are printed and written.
    """
    from allanite.study.watching import WatchSettings

    out = outputs(choices, [choices["recipe"], target], also=("record",))
    record = {"record": out.paths.get("record"), "force": out.force}
    out = replace(out, paths={name: path for name, path in out.paths.items() if name != "record"})
    settings, recipe = settings_of(WatchSettings, choices | record), recipe_of(choices)
    reports = Reports(event=lambda words, _: None if out.quiet else complain(*words.split("\n")),
                      deliver=lambda study: deliver(study, out))  # fmt: skip
    WATCH.run([target], recipe, settings, reports)


@command()
@options("some files", "models", "sensor", "datasheet", "duration", "samples", *RECORDING, "statistic",
         "taus", "m", "to", "intervals", "bias", "join", "divisor", "edf", "power_law", *IDENTIFYING, *RESULTS,
         settings=(NoiseChoices, LengthChoices, DeviationChoices))  # fmt: skip
def deviation(files: tuple[str, ...], models: tuple[str, ...], **choices: Any) -> None:
    """Compute Allan and related deviations.

    Tabulates statistics of FILES over averaging time; or without data, what is expected of them and of each term under
    the noise of --model, --sensor or --datasheet, for a record of --duration or --samples at --rate. Channels of
    several files, and several models, are in one figure. With --window, the deviation in sliding windows (dynamic).
    """
    from allanite.study.survey import Deviations, TheorySettings, expected_of_models

    theory = settings_of(TheorySettings, choices)
    if files and not (models or theory.asked):
        perform(DEVIATION, files, choices)
        return
    out = outputs(choices, [*files, choices["recipe"]])
    wanted, recipe = settings_of(Deviations, choices), recipe_of(choices)
    deliver(expected_of_models(next(iter(files), None), models, theory, wanted, recipe), out)


@command()
@options("files", *RECORDING, "estimator", "sides", "bins", "segment", "window", "bandwidth", "tapers", "weights",
         "fit", "deviation", "to", *IDENTIFYING, *RESULTS, settings=(DensityChoices,))  # fmt: skip
def spectrum(files: tuple[str, ...], **choices: Any) -> None:
    """Compute the power spectral density.

    N of IEEE 952 is the square root of the two-sided power spectral density of white noise. Channels of several FILES
    are in one figure.
    """
    perform(SPECTRUM, files, choices)


@command()
@options("file", *RECORDING, "statistic", "window", "step", "taus", "m", "to", "level", *RESULTS,
         settings=(WindowChoices,))  # fmt: skip
def dynamic(file: str, **choices: Any) -> None:
    """Compute a deviation in sliding windows.

    Shows how the noise of FILE changes with time.
    """
    perform(DYNAMIC, [file], choices)
