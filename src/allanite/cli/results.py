"""What verbs share that write a result in several forms: the terminal, standard output, files."""

import os
import shutil
import sys
from collections.abc import Callable, Mapping

import click

from allanite.core.files import write
from allanite.reporting.outputs import STDOUT

WIDTH = 120
"""Columns of text that no terminal bounds."""


def demand_recording(path: str | None) -> None:
    """Refuse before the work begins a recording that no format is written for."""
    from allanite.readers.formats.table import writer_for

    if path is not None:
        writer_for(os.path.splitext(path)[1].lower())


def deliver(
    text: Callable[[int], str],
    writers: Mapping[str, Callable[[], str | bytes]],
    paths: Mapping[str, str],
    *,
    force: bool,
    quiet: bool,
) -> None:
    """Print the text, unless something else goes to standard output, and write what was asked for.

    Parameters
    ----------
    text : width -> text
    writers : name of the option -> what the file holds
    paths : name of the option -> path
    force, quiet : bool
    """
    silent = STDOUT in paths.values()
    if not (quiet or silent):
        width = shutil.get_terminal_size().columns if sys.stdout.isatty() else WIDTH
        encoding = sys.stdout.encoding or "utf-8"
        # a terminal that does not know a letter gets its number, not an error
        click.echo(text(width).encode(encoding, "backslashreplace").decode(encoding), nl=False)
    for name, path in paths.items():
        data = writers[name]()
        raw = data.encode() if isinstance(data, str) else data
        if path == STDOUT:
            click.echo(raw, nl=False)
            continue
        write(path, raw, force=force)
        if not quiet:
            click.echo(f"{name}: {path}", err=silent)
