"""``allanite budget``: a torquer's current as a rate, and what rounding adds to the noise of a rate."""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from allanite.reporting.outputs import demand_outputs

from .results import deliver, demand_recording

if TYPE_CHECKING:
    from allanite.signals import TorqueScale
    from allanite.signals.study import BudgetStudy

READ = (
    *("rate", "unit", "kind", "scale", "channels", "time", "dtype", "columns", "offset"),
    *("start", "until", "quiet_window", "level"),
)
"""Options that are the recipe's."""

OUTPUTS = ("rates", "report", "plot", "json", "csv")

OPTIONS = (
    click.option(
        "--stage", "stages", multiple=True, metavar="'NAME BITS SCALE'",
        help="A place where numbers are rounded, as 'ADC 12 5V' or 'output 16 100deg/s'; may be given again.",
    ),
    click.option(
        "--torquer", metavar="A=X,...",
        help="Constants of the torquer in SI: turns, field (T), span (m), radius (m), inertia (kg m^2), spin (rad/s), "
        "sides.",
    ),
    click.option("--scale-factor", type=float, metavar="K", help="Its scale factor instead, rad/s per A."),
    click.option("--sense", type=float, metavar="V/A", help="Gain of the current's sensor, for voltages."),
    click.option("--rates", metavar="PATH", type=click.Path(), help="Write the rates as a recording: .csv, .npz ..."),
    click.option("--level", type=float, help="Confidence level of intervals.  [0.95]"),
    click.option("--report", metavar="PATH", type=click.Path(), help="Write the HTML page."),
    click.option("--plot", metavar="PATH", type=click.Path(), help="Write the figure: .png, .svg or .pdf."),
    click.option("--json", metavar="PATH", type=click.Path(), help="Write everything as JSON; - is standard output."),
    click.option("--csv", metavar="PATH", type=click.Path(), help="Write the table as CSV; - is standard output."),
    click.option("--force", is_flag=True, help="Overwrite files that exist."),
    click.option("--quiet", is_flag=True, help="Print nothing but errors, and what goes to standard output."),
)  # fmt: skip


def options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the options of this verb."""
    for option in reversed(OPTIONS):
        command = option(command)
    return command


@options
def budget(file: str, *, stages: tuple[str, ...], force: bool, quiet: bool, **choices: Any) -> None:
    """Say what each stage of a signal path adds to the noise of the channels of FILE by rounding.

    A current (--unit A), a voltage or codes (--unit 1) become rates by the constants of the torquer.
    """
    paths = {name: path for name in OUTPUTS if (path := choices.pop(name)) is not None}
    demand_outputs(paths, inputs=[file], force=force)
    demand_recording(paths.get("rates"))
    from allanite.reporting.budget import render
    from allanite.reporting.progress import bar
    from allanite.signals import Stage
    from allanite.signals.study import SignalPath, budget_file
    from allanite.study.analysis import Recipe

    recipe = Recipe.from_dict({key: choices[key] for key in READ if choices.get(key) is not None})
    scale = _scale(choices["torquer"], choices["scale_factor"])
    path = SignalPath(tuple(Stage.parse(text) for text in stages), scale, choices["sense"])
    with bar(shown=sys.stderr.isatty() and not quiet) as progress:
        study = budget_file(file, recipe, path, progress=progress)
    rates = paths.pop("rates", None)
    deliver(lambda width: render(study, width), _writers(study, paths), paths, force=force, quiet=quiet)
    if rates is not None:
        _write_rates(study, rates, force=force)
        if not quiet:
            click.echo(f"rates: {rates}", err="-" in paths.values())


def _scale(torquer: str | None, factor: float | None) -> "TorqueScale | float | None":
    from dataclasses import fields

    from allanite.core.errors import UsageError
    from allanite.signals import TorqueScale

    if torquer is None:
        return factor
    if factor is not None:
        raise UsageError("the scale is given twice: by --torquer and by --scale-factor")
    known = [f.name for f in fields(TorqueScale)]
    constants: dict[str, float] = {}
    for part in torquer.split(","):
        name, _, text = (word.strip() for word in part.partition("="))
        try:
            constants[name] = float(text)
        except ValueError:
            raise UsageError(f"a constant of the torquer is a name and a number, as turns=100, not {part!r}") from None
    missing = [name for name in known[:-1] if name not in constants]
    strange = [name for name in constants if name not in known]
    if missing or strange:
        wrong = "; ".join(
            f"{what} {', '.join(names)}" for what, names in (("missing", missing), ("unknown", strange)) if names
        )
        raise UsageError(f"--torquer wants {', '.join(known)} ({wrong})")
    return TorqueScale(**constants)


def _writers(study: "BudgetStudy", paths: dict[str, str]) -> dict[str, Callable[[], str | bytes]]:
    from allanite.reporting import budget as report
    from allanite.reporting.plain import to_json

    return {
        "report": lambda: report.page(study),
        "plot": lambda: report.figure(study, Path(paths["plot"]).suffix),
        "json": lambda: to_json(study),
        "csv": lambda: report.to_csv(study),
    }


def _write_rates(study: "BudgetStudy", path: str, *, force: bool) -> None:
    from allanite.core.record import Recording
    from allanite.readers import write

    kept = tuple(channel.budget.record for channel in study.channels if channel.budget is not None)
    write(Recording(kept), path, force=force)
