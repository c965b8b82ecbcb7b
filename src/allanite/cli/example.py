"""``allanite example``: a paper by the commands that anybody can type, and its numbers beside ours."""

import contextlib
import os
import shlex
import textwrap
from pathlib import Path
from typing import Any

import click

from .deliver import deliver, outputs
from .front import DATA
from .options import SHOWN, options
from .streams import show

WRITTEN = {"report": "page.html", "json": "paper.json"}
"""Files of the comparison: option -> name."""


@click.command()
@options(
    click.argument("paper", required=False),
    click.argument("folder", required=False, default=".", type=click.Path(file_okay=False)),
    click.option("--commands", is_flag=True, help="Print the commands only."),
    *SHOWN,
)  # fmt: skip
def example(paper: str | None, folder: str, commands: bool, **shared: Any) -> None:
    """Reproduce the tables and figures of a paper.

    Writes simulated input, tables, figures and a page into FOLDER, by commands that are printed and that can be
    repeated one by one, and prints what the paper says beside what was found. Without PAPER, lists the papers.
    """
    from allanite.papers.paper import PAPERS
    from allanite.papers.paper import paper as paper_of
    from allanite.papers.reproduction import compare

    if paper is None:
        for row in map(paper_of, PAPERS):
            source = textwrap.wrap(row.source, 95, initial_indent="     ", subsequent_indent="     ")
            show("\n".join([f"{row.name}  {row.title}", *source]))
        return
    row = paper_of(paper)
    lines = [shlex.split(command) for command in row.commands]
    shown = [shlex.join(["allanite", *line]) for line in lines]
    if commands:
        show("\n".join(shown))
        return
    os.makedirs(folder, exist_ok=True)
    own = {name: os.path.join(folder, path) for name, path in WRITTEN.items()}
    out = outputs(shared | own, [])
    with contextlib.chdir(folder):
        for line, text in zip(lines, shown, strict=True):
            if not shared["quiet"]:
                show(f"$ {text}")
            _run(line, shared | {"quiet": not shared["details"]})
    deliver(compare(row.within(out.lang), Path(folder)), out)


def _run(line: list[str], shared: dict[str, Any]) -> None:
    from . import VERBS, main

    defaults = shared | dict.fromkeys(ANGLE, shared)
    with main.make_context("allanite", line, default_map=dict.fromkeys(VERBS, defaults)) as context:
        try:
            main.invoke(context)
        except click.exceptions.Exit as done:
            if done.exit_code != DATA:  # a part of a record need not be fit for analysis
                raise


ANGLE = ("calibrate", "estimate", "plan", "simulate")
"""Verbs of the group angle."""
