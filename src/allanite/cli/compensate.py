"""``allanite compensate``: the part of a rate that follows other channels, found, judged, taken off."""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from allanite.reporting.outputs import demand_outputs

from .results import deliver, demand_recording

if TYPE_CHECKING:
    from allanite.compensation.study import CompensationStudy

READ = (
    *("rate", "unit", "kind", "scale", "channels", "time", "dtype", "columns", "offset"),
    *("start", "until", "quiet_window", "level"),
)
"""Options that are the recipe's."""

OUTPUTS = ("save", "report", "plot", "json", "csv", "corrected")


def _names(_: click.Context, __: click.Parameter, text: str | None) -> tuple[str, ...]:
    return () if text is None else tuple(part.strip() for part in text.split(",") if part.strip())


def _seconds(context: click.Context, parameter: click.Parameter, text: str | None) -> tuple[float, ...]:
    try:
        return tuple(float(part) for part in _names(context, parameter, text))
    except ValueError:
        raise click.BadParameter(f"seconds are wanted, as 60,300, not {text!r}") from None


OPTIONS = (
    click.option("--regressors", callback=_names, metavar="A,B,...", help="Columns that the rate may depend on."),
    click.option("--rate-of", callback=_names, metavar="A,B,...", help="Columns whose rate of change counts."),
    click.option("--degree", type=int, default=1, show_default=True, help="Highest power that may be added."),
    click.option("--lags", callback=_seconds, metavar="S,S,...", help="Earlier readings that may be added, seconds."),
    click.option("--trend", is_flag=True, help="Estimate a steady drift along; it is not taken off."),
    click.option("--every", is_flag=True, help="Keep all powers and lags, not only what held-back blocks gain from."),
    click.option("--smooth", type=float, default=60.0, show_default=True, metavar="S", help="Window of --rate-of."),
    click.option("--terms", default="QNBK", show_default=True, metavar="QNBK", help="Noise terms to look for."),
    click.option("--blocks", type=int, default=5, show_default=True, help="Of the cross-validation."),
    click.option("--least", type=float, default=10.0, show_default=True, help="Effective samples for each regressor."),
    click.option("--split-gaps", is_flag=True, help="Fit between lost readings, each stretch with its own constant."),
    click.option("--beside", metavar="FILE", type=click.Path(), help="The regressors are in this file."),
    click.option("--interpolate", is_flag=True, help="Bring regressors of another time base onto the record's."),
    click.option("--use", metavar="FILE", type=click.Path(), help="Fit nothing, take what was saved."),
    click.option("--apply", "apply_to", metavar="FILE", type=click.Path(), help="Correct this file too, held back."),
    click.option("--level", type=float, help="Confidence level of intervals.  [0.95]"),
    click.option("--save", metavar="PATH", type=click.Path(), help="Write the regressions, for --use."),
    click.option(
        "--corrected", metavar="PATH", type=click.Path(), help="Write the corrected record, of --apply if given."
    ),
    click.option("--report", metavar="PATH", type=click.Path(), help="Write the HTML page."),
    click.option("--plot", metavar="PATH", type=click.Path(), help="Write the figure: .png, .svg or .pdf."),
    click.option("--json", metavar="PATH", type=click.Path(), help="Write everything as JSON; - is standard output."),
    click.option("--csv", metavar="PATH", type=click.Path(), help="Write the curves as CSV; - is standard output."),
    click.option("--force", is_flag=True, help="Overwrite files that exist."),
    click.option("--quiet", is_flag=True, help="Print nothing but errors, and what goes to standard output."),
)


def options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the options of this verb."""
    for option in reversed(OPTIONS):
        command = option(command)
    return command


@options
def compensate(file: str, *, force: bool, quiet: bool, **choices: Any) -> None:
    """Find what of the channels of FILE follows a temperature or any other column, and take it off.

    Prints the coefficients with intervals and p values, and the Allan deviation before and after.
    """
    paths = {name: path for name in OUTPUTS if (path := choices.pop(name)) is not None}
    read = [path for path in (file, choices["beside"], choices["use"], choices["apply_to"]) if path is not None]
    demand_outputs(paths, inputs=read, force=force)
    demand_recording(paths.get("corrected"))
    from allanite.compensation.study import compensate_file
    from allanite.reporting.compensation.text import render
    from allanite.reporting.progress import bar
    from allanite.study.analysis import Recipe

    recipe = Recipe.from_dict({key: choices[key] for key in READ if choices.get(key) is not None})
    with bar(shown=sys.stderr.isatty() and not quiet) as progress:
        study = compensate_file(file, recipe, _choices(choices), apply_to=choices["apply_to"], progress=progress)
    corrected = paths.pop("corrected", None)
    deliver(lambda width: render(study, width), _writers(study, paths), paths, force=force, quiet=quiet)
    if corrected is not None:
        _write_corrected(study, corrected, force=force)
        if not quiet:
            click.echo(f"corrected: {corrected}", err="-" in paths.values())


def _choices(choices: dict[str, Any]) -> Any:
    from allanite.compensation import Handling
    from allanite.compensation.study import CompensationChoices
    from allanite.core.errors import UsageError

    if choices["use"] is not None and (choices["regressors"] or choices["rate_of"]):
        raise UsageError("--use takes a saved regression with its own regressors: leave out --regressors and --rate-of")
    return CompensationChoices(
        regressors=choices["regressors"],
        degree=choices["degree"],
        lags=choices["lags"],
        rate_of=choices["rate_of"],
        trend=choices["trend"],
        handling=Handling(
            terms=choices["terms"],
            smooth=choices["smooth"],
            blocks=choices["blocks"],
            every=choices["every"],
            gaps="split" if choices["split_gaps"] else "error",
            least=choices["least"],
        ),
        beside=choices["beside"],
        interpolate=choices["interpolate"],
        use=choices["use"],
    )


def _writers(study: "CompensationStudy", paths: dict[str, str]) -> dict[str, Callable[[], str | bytes]]:
    from allanite.compensation.regression import to_json as saved
    from allanite.reporting.plain import to_json

    return {
        "save": lambda: saved(study.regressions),
        "report": lambda: _page(study),
        "plot": lambda: _figure(study, paths["plot"]),
        "json": lambda: to_json(study),
        "csv": lambda: _csv(study),
    }


def _page(study: "CompensationStudy") -> str:
    from allanite.reporting.compensation.html import page

    return page(study)


def _csv(study: "CompensationStudy") -> str:
    from allanite.reporting.compensation.plain import to_csv

    return to_csv(study)


def _figure(study: "CompensationStudy", path: str) -> bytes:
    from allanite.reporting.compensation.figures import plot
    from allanite.reporting.style import encode

    shown = next(c for c in (*study.applied, *study.fitted) if c.regression is not None)
    return encode(plot(shown, study.recipe.level), Path(path).suffix.lower().lstrip("."))


def _write_corrected(study: "CompensationStudy", path: str, *, force: bool) -> None:
    from allanite.core.errors import DataError
    from allanite.core.record import Recording
    from allanite.readers import write

    channels = study.applied or study.fitted
    kept = tuple(c.corrected for c in channels if c.corrected is not None)
    if not kept:
        raise DataError("no channel was corrected: there is nothing to write")
    write(Recording(kept), path, force=force)
