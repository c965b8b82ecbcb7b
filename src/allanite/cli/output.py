"""Where results go: the terminal, standard output, files."""

import os
import shutil
import sys
from typing import TYPE_CHECKING, Any

import click

from allanite.core.files import write
from allanite.reporting.outputs import STDOUT

if TYPE_CHECKING:
    from allanite.comparison.comparison import Comparison
    from allanite.comparison.pooled import Pool
    from allanite.study.analysis import Recipe, Study
    from allanite.study.survey import Survey

WIDTH = 120
"""Columns of text that no terminal bounds."""


def put(path: str, data: bytes, *, force: bool) -> None:
    """Write `data` to a file or to standard output."""
    if path == STDOUT:
        click.echo(data, nl=False)
    else:
        write(path, data, force=force)


def recipe_of(path: str | None, choices: dict[str, Any]) -> "Recipe":
    """What the recipe file says, and over it what the command line says."""
    from allanite.study.analysis import Recipe

    base = Recipe.load(path).to_dict() if path else {}
    return Recipe.from_dict(base | {key: value for key, value in choices.items() if value is not None})


def print_table(value: "Study | Survey | Comparison | Pool") -> None:
    """Print a result as wide as the terminal is."""
    from allanite.reporting import table

    terminal = sys.stdout.isatty()
    width = shutil.get_terminal_size().columns if terminal else WIDTH
    text = table(value, width=width, color=terminal and "NO_COLOR" not in os.environ)
    # a terminal that does not know a letter gets its number, not an error
    encoding = sys.stdout.encoding or "utf-8"
    click.echo(text.encode(encoding, "backslashreplace").decode(encoding), nl=False)
