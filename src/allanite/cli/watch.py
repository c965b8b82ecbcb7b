"""A live stream: what is known so far while it lasts, and the results when it ends."""

from typing import Any

import click

from allanite.core.files import demand_writable
from allanite.study.recipe import IDENTIFYING, READING, SELECTING
from allanite.study.settings import WatchChoices

from .deliver import deliver, outputs, recipe_of, settings_of
from .options import RESULTS, options
from .tasks import WATCH, Reports

BINARY = ("dtype", "columns", "offset")
"""Choices of a file that has no lines."""


@click.command()
@options(
    click.argument("target", metavar="FILE|PORT|udp://127.0.0.1:9000"),
    *(name for name in READING if name not in BINARY), *SELECTING, "recipe", "statistic", "taus", *IDENTIFYING,
    "every", "duration", "idle", "baud", "record", "accuracy", "to", "coefficients", *RESULTS, settings=(WatchChoices,),
)  # fmt: skip
def watch(target: str, **choices: Any) -> None:
    """Watch a live stream.

    Reads lines of numbers, a column for each channel, from a file that grows, a serial port, or datagrams sent to this
    machine. Says every few seconds what is known of each channel and how much longer it takes until more is; says at
    once when the sensor is moved, which is left out, or unplugged, which is a gap, and that an outlier came. Ctrl-C,
    SIGTERM, --for or --idle end it, and the results of 'allanite analyze' of these lines are printed and written.
    """
    from allanite.study.watching import WatchSettings

    if choices["record"] is not None:
        demand_writable(choices["record"], force=choices["force"])
    out = outputs(choices, [choices["recipe"], target, choices["record"]])
    settings, recipe = settings_of(WatchSettings, choices), recipe_of(choices)
    reports = Reports(event=lambda words, _: None if out.quiet else click.echo(words, err=True))
    deliver(WATCH.run([target], recipe, settings, reports), out)
