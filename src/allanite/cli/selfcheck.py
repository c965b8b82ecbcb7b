"""``allanite selfcheck``: does the identification keep its word on this sensor, rate and length."""

import shutil
import sys
from collections.abc import Callable
from functools import partial
from typing import Any

import click

from allanite.reporting.outputs import STDOUT, demand_outputs

from .models import LENGTH, MODEL, OPTIONAL_READING, Several, options, size_of, supposed
from .output import WIDTH, put

EXCEEDED = 4


def _percent(_: click.Context, __: click.Parameter, value: float | None) -> float | None:
    return None if value is None else value / 100


def _told(tell: Callable[[str, float], None], name: str, what: str, share: float) -> None:
    tell(f"{name} {what}".strip(), share)


@click.command()
@options(OPTIONAL_READING, MODEL, LENGTH)
@click.option("--records", type=int, default=100, metavar="N", help="Records that are simulated.  [100]")
@click.option("--seed", type=click.IntRange(min=0), metavar="N", default=1, help="Of the random numbers.  [1]")
@click.option("--terms", metavar="QNBKR", default="auto", help="Terms to look for.  [auto]")
@click.option("--level", type=float, default=0.95, help="Confidence level of intervals.  [0.95]")
@click.option("--max-bias", "bias", type=float, callback=_percent, metavar="PERCENT", help="Of the coefficients.")
@click.option("--min-coverage", "coverage", type=float, callback=_percent, metavar="PERCENT", help="Of the intervals.")
@click.option("--max-false", "false", type=float, callback=_percent, metavar="PERCENT", help="Absent terms claimed.")
@click.option("--max-missed", "missed", type=float, callback=_percent, metavar="PERCENT", help="Terms not found.")
@click.option("--json", metavar="PATH", type=click.Path(), help="Write everything as JSON; - is standard output.")
@click.option("--force", is_flag=True, help="Overwrite files that exist.")
def selfcheck(file: str | None, *, json: str | None, force: bool, **choices: Any) -> None:
    """Simulate records, identify them, and print bias, spread, coverage and errors beside the Cramer-Rao bound.

    The noise is that of --model or --sensor, or what a recording FILE shows, whose length is then taken. Where one of
    the limits is given and exceeded beyond chance, by more than two Monte-Carlo standard errors, the exit code is 4.
    """
    demand_outputs({} if json is None else {"json": json}, inputs=[file] if file else [], force=force)
    import numpy as np

    from allanite.planning.selfcheck import selfcheck as checked
    from allanite.reporting.plain import to_json
    from allanite.reporting.planning import CHECKED, check_text, wrapped
    from allanite.reporting.progress import bar

    limits = {key: value for key in ("bias", "coverage", "false", "missed") if (value := choices.pop(key)) is not None}
    length, rng = (choices["duration"], choices["samples"]), np.random.default_rng(choices["seed"])
    found = {}
    with bar(shown=sys.stderr.isatty()) as progress:
        for item in supposed(file, choices["model"], choices["sensor"], choices, progress):
            own = item.channel is not None and length == (None, None)
            size = item.channel.record.size if own and item.channel else size_of(item.rate, *length)
            found[item.name] = checked(
                item.model,
                size,
                item.rate,
                records=choices["records"],
                rng=rng,
                terms=choices["terms"],
                level=choices["level"],
                progress=partial(_told, progress, item.name),
            )
    if json is not None:
        put(json, to_json(Several("SelfChecks", found)).encode(), force=force)
    if json != STDOUT:
        width = shutil.get_terminal_size().columns if sys.stdout.isatty() else WIDTH
        texts = [check_text(check, name, width=width) for name, check in found.items()]
        click.echo("\n".join([*texts, *wrapped(CHECKED, width)]))
    broken = [f"{name} {what}".strip() for name, check in found.items() for what in check.exceeded(**limits)]
    for sentence in broken:
        click.echo(f"limit exceeded: {sentence}", err=True)
    if broken:
        raise click.exceptions.Exit(EXCEEDED)
