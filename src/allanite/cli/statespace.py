"""``allanite statespace``: a model of the noise for a Kalman filter."""

import shutil
import sys
from typing import Any

import click

from allanite.reporting.outputs import STDOUT, demand_outputs

from .models import MODEL, OPTIONAL_READING, Several, options, supposed
from .output import WIDTH, put


def _range(_: click.Context, __: click.Parameter, text: str) -> tuple[float, float]:
    from .models import seconds_of

    parts = text.split(",")
    if len(parts) != 2:
        raise click.BadParameter(f"two averaging times are wanted, as 1,1000 or '1 s,1 h', not {text!r}")
    return seconds_of(parts[0]), seconds_of(parts[1])


@click.command()
@options(OPTIONAL_READING, MODEL)
@click.option("--tau", callback=_range, default="1,1000", metavar="LO,HI", help="Where flicker is matched.  [1,1000]")
@click.option("--ripple", type=float, default=2.0, metavar="PERCENT", help="Wanted deviation from flicker.  [2]")
@click.option("--order", type=int, metavar="N", help="Gauss-Markov processes for flicker, instead.")
@click.option("--turn-on", metavar="RATE", help="Standard deviation of the bias at switch-on, as '3 deg/h'.")
@click.option("--measurement", default="auto", metavar="NAME", help="auto, mean (exact) or sample.  [auto]")
@click.option("--plot", metavar="PATH", type=click.Path(), help="Write the figure: .png, .svg or .pdf.")
@click.option("--json", metavar="PATH", type=click.Path(), help="Write everything as JSON; - is standard output.")
@click.option("--force", is_flag=True, help="Overwrite files that exist.")
def statespace(file: str | None, *, json: str | None, plot: str | None, force: bool, **choices: Any) -> None:
    """Print the noise as states for a Kalman filter: transition, covariances, measurement.

    The noise is that of --model or --sensor, or what a recording FILE shows. Flicker becomes a sum of Gauss-Markov
    processes that is right between two averaging times. The figure is of the first channel.
    """
    paths = {name: path for name, path in (("json", json), ("plot", plot)) if path is not None}
    demand_outputs(paths, inputs=[file] if file else [], force=force)
    from allanite.reporting import plot as drawn
    from allanite.reporting.equivalent import state_space_text
    from allanite.reporting.plain import to_json
    from allanite.reporting.planning import notes_of
    from allanite.reporting.progress import bar
    from allanite.statespace import state_space

    width = shutil.get_terminal_size().columns if sys.stdout.isatty() else WIDTH
    found, texts, curves = {}, [], []
    with bar(shown=sys.stderr.isatty()) as progress:
        for item in supposed(file, choices["model"], choices["sensor"], choices, progress):
            found[item.name] = space = state_space(
                item.model,
                item.rate,
                tau=choices["tau"],
                ripple=choices["ripple"] / 100,
                order=choices["order"],
                turn_on=_turn_on(choices["turn_on"], item.model.signal.unit),
                measurement=choices["measurement"],
            )
            notes = notes_of(item.channel) if item.channel else []
            texts.append(state_space_text(space, item.name, notes=notes, width=width))
            curves.append(item.channel.curve if item.channel else None)
    if plot is not None:
        first = next(iter(found.values()))
        drawn([first, *([curves[0]] if curves[0] else [])], path=plot, force=force)
    if json is not None:
        put(json, to_json(Several("StateSpaces", found)).encode(), force=force)
    if json != STDOUT:
        click.echo("\n".join(texts), nl=False)


def _turn_on(text: str | None, si: str) -> float:
    from allanite.core.notation import split_quantities
    from allanite.core.units import convert

    if text is None:
        return 0.0
    found = split_quantities(text.split())
    if len(found) != 1 or not found[0][1]:
        raise click.BadParameter(f"a bias is given as '3 deg/h', not {text!r}")
    return convert(*found[0], si)
