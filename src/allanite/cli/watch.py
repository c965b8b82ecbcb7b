"""A live stream: what is known so far while it lasts, and the results when it ends."""

import os
from dataclasses import replace
from typing import Any

import click

from allanite.study.recipe import IDENTIFYING, READING, SELECTING
from allanite.study.settings import WatchChoices

from .deliver import deliver, outputs, recipe_of, settings_of
from .options import RESULTS, options
from .streams import complain
from .tasks import WATCH, Reports

BINARY = ("dtype", "columns", "offset")
"""Choices of a file that has no lines."""


@click.command()
@options(
    click.argument("target", metavar="FILE|PORT|udp://127.0.0.1:9000"),
    *(name for name in READING if name not in BINARY), *SELECTING, "recipe", "statistic", "taus", *IDENTIFYING,
    "every", "duration", "idle", "baud", "lines that come", "accuracy", "to", "coefficients", *RESULTS,
    settings=(WatchChoices,),
)  # fmt: skip
def watch(target: str, **choices: Any) -> None:
    """Watch a live stream.

    Reads lines of numbers, a column for each channel, from a file that grows, a serial port, or datagrams sent to this
    machine. Says every few seconds what is known of each channel and how much longer it takes until more is; says at
    once when the sensor is moved, which is left out, or unplugged, which is a gap, and that an outlier came. Ctrl-C,
    SIGTERM, --for or --idle end it, and the results of 'allanite analyze' of these lines are printed and written.
    """
    from allanite.study.watching import WatchSettings

    out = outputs(choices, [choices["recipe"], target], also=("record",))
    record = out.paths.get("record")
    if record is not None and os.path.isfile(record):  # --force was given
        os.remove(record)
    out = replace(out, paths={name: path for name, path in out.paths.items() if name != "record"})
    settings, recipe = settings_of(WatchSettings, choices | {"record": record}), recipe_of(choices)
    reports = Reports(event=lambda words, _: None if out.quiet else complain(words))
    deliver(WATCH.run([target], recipe, settings, reports), out)
