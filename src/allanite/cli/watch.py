"""A live stream: what is known so far while it lasts, and the results when it ends."""

from contextlib import closing
from typing import Any

import click

from allanite.core.files import demand_writable
from allanite.study.recipe import IDENTIFYING, READING, SELECTING

from .deliver import deliver, happened, outputs, recipe_of, settings_of
from .options import RESULTS, options
from .signals import stopping
from .types import Duration

BINARY = ("dtype", "columns", "offset")
"""Choices of a file that has no lines."""


@click.command()
@options(
    click.argument("target", metavar="FILE|PORT|udp://127.0.0.1:9000"),
    *(name for name in READING if name not in BINARY), *SELECTING, "recipe", "statistic", "taus", *IDENTIFYING,
    click.option("--refresh", "every", type=Duration(), metavar="TIME", help="Time between reports.  [default: 10 s]"),
    click.option("--for", "duration", type=Duration(), metavar="TIME", help="Stop after this time.  [default: never]"),
    click.option("--idle", type=Duration(), metavar="TIME", help="Stop after this time without data.  "
        "[default: never]"),
    click.option("--baud", type=int, metavar="N", help="Baud rate of a serial port.  [default: 115200]"),
    click.option("--record", metavar="PATH", type=click.Path(), help="Keep the lines that come in this file."),
    "accuracy", "shown in", "coefficients", *RESULTS,
)  # fmt: skip
def watch(target: str, **choices: Any) -> None:
    """Watch a live stream.

    Reads lines of numbers, a column for each channel, from a file that grows, a serial port, or datagrams sent to this
    machine. Says every few seconds what is known of each channel and how much longer it takes until more is; says at
    once when the sensor is moved, which is left out, or unplugged, which is a gap, and that an outlier came. Ctrl-C,
    SIGTERM, --for or --idle end it, and the results of 'allanite analyze' of these lines are printed and written.
    """
    from allanite.study.watching import Watch, WatchSettings

    kept = choices["record"]
    if kept is not None:
        demand_writable(kept, force=choices["force"])
    out = outputs(choices, [choices["recipe"], target, kept])
    if choices["accuracy"] is not None:
        choices["accuracy"] /= 100
    with stopping() as stopped:
        watched = Watch(target, recipe_of(choices), settings_of(WatchSettings, choices), stopped)
        with closing(watched):
            for words in watched.events():
                if not out.quiet:
                    happened(words, watched)
            study = watched.study()
    deliver(study, out)
