"""Where results go: the terminal, standard output, files."""

import os
import shutil
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from allanite.core.errors import LongJobWarning, UsageError
from allanite.core.files import demand_writable, write

from .front import DATA, LINE

if TYPE_CHECKING:
    from allanite.core.record import Recording
    from allanite.study.recipe import Recipe

Settings = TypeVar("Settings")
Result = TypeVar("Result")
Progress = Callable[[str, float], None]

STDOUT = "-"
WIDTH = 120
"""Columns of text that no terminal bounds."""

PRINTED = ("json", "csv", "coefficients")
"""What may go to standard output."""


@dataclass(frozen=True)
class Outputs:
    """Where a result is to go: name of the option -> path, and how."""

    paths: Mapping[str, str]
    force: bool = False
    quiet: bool = False
    strict: bool = False

    @property
    def piped(self) -> bool:
        """Whether standard output is taken."""
        return STDOUT in self.paths.values()


def outputs(choices: dict[str, Any], inputs: Sequence[str | None], *, also: Sequence[str] = ()) -> Outputs:
    """Take the options of results out of `choices`, and refuse before the work what could not be written after it.

    Parameters
    ----------
    choices : dict
        Options of a verb; those of its results are removed.
    inputs : sequence of path or None
        Files that are read; they are never overwritten.
    also : sequence of str
        Other options that name a file to write.

    Raises
    ------
    UsageError
        A file exists, cannot be written, or two things would go to the same place.
    """
    named = ((name, choices.pop(name, None)) for name in ("report", "plot", *PRINTED, *also))
    paths = {name: path for name, path in named if path is not None}
    found = Outputs(paths, *(choices.pop(name, False) for name in ("force", "quiet", "strict")))
    if list(paths.values()).count(STDOUT) > 1:
        raise UsageError("only one thing can go to standard output; give the other one a file")
    taken = {os.path.realpath(path): "the input" for path in inputs if path is not None}
    for name, path in paths.items():
        if path == STDOUT and name in PRINTED:
            continue
        where = os.path.realpath(path)
        if where in taken:
            raise UsageError(f"--{name} would overwrite {taken[where]} {path!r}; give it another name")
        taken[where] = f"--{name}"
        _demand_place(name, path, force=found.force)
    return found


def _demand_place(name: str, path: str, *, force: bool) -> None:
    if name == "plot":
        from allanite.reporting.style import demand_figure_path

        demand_figure_path(path, force=force)
    else:
        demand_writable(path, force=force)


def demand_recording(path: str | None) -> None:
    """Refuse before the work begins a recording that no format is written for."""
    from allanite.readers.formats.table import writer_for

    if path is not None:
        writer_for(os.path.splitext(path)[1].lower())


def recipe_of(choices: dict[str, Any], **usual: Any) -> "Recipe":
    """Take the keys of a recipe out of `choices`; `usual` are other defaults than the recipe's."""
    from allanite.study.recipe import Recipe

    choices.pop("recipe", None)
    known = {key: choices.pop(key) for key in [f.name for f in fields(Recipe)] if key in choices}
    return Recipe.from_dict(usual | given(known))


def settings_of(kind: "type[Settings]", choices: dict[str, Any]) -> "Settings":
    """Take the settings of this kind out of `choices`; those left open keep their defaults."""
    named = [f.name for f in fields(kind) if f.name in choices]  # type: ignore[arg-type]  # a dataclass
    return kind(**given({name: choices.pop(name) for name in named}))


def given(choices: dict[str, Any]) -> dict[str, Any]:
    """What was not left open."""
    return {key: value for key, value in choices.items() if value is not None}


def carry_out(job: "Callable[[Progress], Result]", out: Outputs, extra: "Extra | None" = None) -> "Result":
    """Do a job that tells its progress, and deliver its result."""
    with progress(out) as tell:
        found = job(tell)
    deliver(found, out, extra)
    if out.strict:
        _demand_explained(found)
    return found


def _demand_explained(found: Any) -> None:
    """End with the exit code of bad data where a channel has no result, or no model explains its noise."""
    if found.rejected:
        names = ", ".join(name or "the record" for name in found.rejected)
        click.echo(f"not explained, or without a result: {names}", err=True)
        raise click.exceptions.Exit(DATA)


@contextmanager
def progress(out: Outputs | None = None) -> Iterator[Callable[[str, float], None]]:
    """A bar on stderr where it is a terminal, and warnings as sentences when they arise."""
    from allanite.reporting.progress import bar

    shown = sys.stderr.isatty() and not (out is not None and out.quiet)
    with warnings.catch_warnings(), bar(shown=shown) as tell:
        warnings.simplefilter("always", LongJobWarning)
        warnings.showwarning = lambda message, *_, **__: click.echo(f"allanite: {message}", err=True)
        yield tell


@dataclass(frozen=True)
class Extra:
    """What a verb writes of its result besides the forms that each has: name of the option -> what makes it."""

    data: Mapping[str, Callable[[Any], str | bytes]] = field(default_factory=dict)
    recordings: "Mapping[str, Callable[[Any], Recording]]" = field(default_factory=dict)


def deliver(value: Any, out: Outputs, extra: Extra | None = None) -> None:
    """Print a result, unless standard output is taken or quiet was asked for, and write what was asked for."""
    extra = extra or Extra()
    if not (out.quiet or out.piped):
        print_result(value)
    for name, path in out.paths.items():
        if name in extra.recordings:
            from allanite.readers import write as write_recording

            write_recording(extra.recordings[name](value), path, force=out.force)
        else:
            data = extra.data[name](value) if name in extra.data else encoded(value, name, path)
            put(path, data, force=out.force)
        if path != STDOUT and not out.quiet:
            click.echo(f"{name}: {path}", err=out.piped)


def encoded(value: Any, name: str, path: str) -> str | bytes:
    """A result as the option `name` writes it."""
    from allanite import reporting
    from allanite.reporting.json import to_json

    if name == "json":
        return to_json(value)
    if name in ("csv", "coefficients"):
        return reporting.to_csv(value, coefficients=name == "coefficients")
    if name == "plot":
        from allanite.reporting.style import encode

        return encode(reporting.plot(value), Path(path).suffix.lower().lstrip("."))
    context = click.get_current_context(silent=True)
    return reporting.page(value, command="" if context is None else context.meta.get(LINE, ""))


def put(path: str, data: str | bytes, *, force: bool) -> None:
    """Write `data` to a file or to standard output."""
    raw = data.encode() if isinstance(data, str) else data
    if path == STDOUT:
        click.echo(raw, nl=False)
    else:
        write(path, raw, force=force)


def print_result(value: Any) -> None:
    """Print a result as wide as the terminal is."""
    from allanite.reporting import table

    terminal = sys.stdout.isatty()
    width = shutil.get_terminal_size().columns if terminal else WIDTH
    text = table(value, width=width, color=terminal and "NO_COLOR" not in os.environ)
    # a terminal that does not know a letter gets its number, not an error
    encoding = sys.stdout.encoding or "utf-8"
    click.echo(text.encode(encoding, "backslashreplace").decode(encoding), nl=False)
