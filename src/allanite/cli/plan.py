"""``allanite plan``: how long to record for a wanted accuracy."""

import shutil
import sys
from typing import Any

import click

from allanite.reporting.outputs import STDOUT, demand_outputs

from .models import MODEL, OPTIONAL_READING, Several, durations, options, supposed
from .output import WIDTH, put


@click.command()
@options(OPTIONAL_READING, MODEL)
@click.option("--durations", callback=durations, metavar="A,B,...", help="Lengths.  [10 min,1 h,6 h,24 h]")
@click.option("--accuracy", type=float, default=10.0, metavar="PERCENT", help="Wanted relative standard error.  [10]")
@click.option("--ramp/--no-ramp", default=None, help="Reckon with a ramp of unknown size.  [if the model has one]")
@click.option("--json", metavar="PATH", type=click.Path(), help="Write everything as JSON; - is standard output.")
@click.option("--force", is_flag=True, help="Overwrite files that exist.")
def plan(file: str | None, *, json: str | None, force: bool, **choices: Any) -> None:
    """Say how accurately each coefficient can be known from a record of some length.

    The noise is that of --model or --sensor, or what a first recording FILE shows. Nothing is simulated.
    """
    demand_outputs({} if json is None else {"json": json}, inputs=[file] if file else [], force=force)
    from allanite.planning.plan import DURATIONS
    from allanite.planning.plan import plan as planned
    from allanite.reporting.plain import to_json
    from allanite.reporting.planning import LEGEND, notes_of, plan_text, wrapped
    from allanite.reporting.progress import bar

    width = shutil.get_terminal_size().columns if sys.stdout.isatty() else WIDTH
    found, texts = {}, []
    with bar(shown=sys.stderr.isatty()) as progress:
        for item in supposed(file, choices["model"], choices["sensor"], choices, progress):
            progress(f"planning {item.name}", 0.9)
            result = planned(
                item.model,
                item.rate,
                durations=choices["durations"] or DURATIONS,
                accuracy=choices["accuracy"] / 100,
                ramp=choices["ramp"],
            )
            found[item.name] = result
            notes = notes_of(item.channel) if item.channel else []
            texts.append(plan_text(result, item.name, notes=notes, width=width))
    if json is not None:
        put(json, to_json(Several("RecordingPlans", found)).encode(), force=force)
    if json != STDOUT:
        click.echo("\n".join([*texts, *wrapped(LEGEND, width)]))
