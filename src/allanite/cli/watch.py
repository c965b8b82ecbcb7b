"""A live stream: what is known so far while it lasts, and the results when it ends."""

from typing import Any

import click

from .deliver import deliver, happened, outputs, recipe_of, settings_of
from .options import RESULTS, options
from .signals import stopping
from .types import Duration


@click.command()
@options(
    click.argument("target", metavar="FILE|PORT|udp://127.0.0.1:9000"),
    "rate", "unit", "kind", "scale", "channels", "time", "recipe", "statistic", "terms", "band", "level",
    click.option("--refresh", "every", type=Duration(), metavar="TIME", help="Time between reports.  [default: 10 s]"),
    click.option("--for", "duration", type=Duration(), metavar="TIME", help="Stop after this time.  [default: never]"),
    click.option("--idle", type=Duration(), metavar="TIME", help="Stop after this time without data.  "
        "[default: never]"),
    click.option("--baud", type=int, metavar="N", help="Baud rate of a serial port.  [default: 115200]"),
    "accuracy", "shown in", "coefficients", *RESULTS,
)  # fmt: skip
def watch(target: str, **choices: Any) -> None:
    """Watch a live stream.

    Reads lines of numbers, a column for each channel, from a file that grows, a serial port, or datagrams sent to this
    machine, at --rate Hz and in --unit. Says every few seconds what is known of each channel and how much longer it
    takes until more is; says at once when the sensor is moved, which is left out, or unplugged, which is a gap; when
    its mean jumps; and that an outlier came, which is replaced. Ctrl-C, SIGTERM, --for or --idle end it, and the
    results of 'allanite analyze' are printed and written.
    """
    from allanite.live.watching import Watch, WatchSettings

    out = outputs(choices, [choices["recipe"]])
    if choices["accuracy"] is not None:
        choices["accuracy"] /= 100
    with stopping() as stopped:
        found = Watch(target, recipe_of(choices), settings_of(WatchSettings, choices), stopped)
        for words in found.events():
            if not out.quiet:
                happened(words, found)
    deliver(found.study(), out)
