"""Requests of the page: the choices of a job as a recipe and settings, and the command line that repeats it."""

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import click

from allanite.cli import main, task_of
from allanite.cli.front import DEFECT, Failure
from allanite.cli.tasks import VerbTask
from allanite.core.choices import ChoiceRow, choices_of, read_given
from allanite.core.errors import AllaniteError, UsageError
from allanite.core.files import encoded
from allanite.core.names import demand_name
from allanite.reporting.language import ENGLISH, tr
from allanite.study.recipe import Recipe

PROBLEM = "problem"  # kind of the message that a request was refused


def accepted(verb: str) -> dict[str, ChoiceRow]:
    """The choices of a verb that the page may set: those of the recipe and of the settings that its command has."""
    kind = task_of(verb).kind
    with click.Context(main) as context:
        command = main.get_command(context, verb)
    assert command is not None  # noqa: S101 - every task is that of a verb
    rows = choices_of(Recipe) | (choices_of(kind) if kind else {})
    return {str(param.name): rows[param.name] for param in command.params if param.name in rows}


@dataclass(frozen=True)
class Request:
    """A job that the page asks for."""

    verb: str
    recipe: Recipe
    settings: Any = None

    @property
    def task(self) -> VerbTask:
        """What does it."""
        task: VerbTask = task_of(self.verb)
        return task

    @classmethod
    def of(cls, verb: str, data: Mapping[str, Any]) -> "Request":
        """The job with these choices, as plain data; what is empty is not given."""
        rows, task = accepted(verb), task_of(verb)
        for key in data:
            demand_name("key", key, rows, where=" in the recipe")
        given = read_given(rows, data)
        kind, own = task.kind, choices_of(task.kind) if task.kind else {}
        recipe = Recipe(**{**task.usual, **{key: value for key, value in given.items() if key not in own}})
        return cls(verb, recipe, kind and kind(**{key: value for key, value in given.items() if key in own}))

    def words(self, files: Sequence[str], lang: str = ENGLISH) -> list[str]:
        """The words of the command line after ``allanite`` that does the same."""
        usual, words = self.task.usual, [self.verb]
        for values, defaults in ((self.recipe, usual), (self.settings, {})):
            for name, row in choices_of(type(values)).items() if values is not None else ():
                value = getattr(values, name)
                if value != defaults.get(name, row.default):
                    words += row.words(value)
        words += ["--lang", lang] if lang != ENGLISH else []
        return [*words, *(["--"] if any(name.startswith("-") for name in files) else []), *files]

    def line(self, files: Sequence[str], lang: str = ENGLISH) -> str:
        """The command line as it can be typed."""
        return shlex.join(["allanite", *self.words(files, lang)])

    def demand_files(self, files: Sequence[str]) -> None:
        """Refuse a number of files that the job does not take."""
        most = self.task.most
        if not files:
            raise UsageError(f"{self.verb} needs a file: give one")
        if most is not None and len(files) > most:
            raise UsageError(f"{self.verb} takes one file, but {len(files)} files were given")


def problem_of(error: Exception) -> dict[str, Any]:
    """An error as the page shows it: the sentence, the choice that cures it, the exit code, and what to type."""
    words, option, code = f"internal error ({type(error).__name__}: {error})", None, DEFECT
    more: dict[str, Any] = {}
    if isinstance(error, click.ClickException):
        words, code = error.format_message(), error.status if isinstance(error, Failure) else error.exit_code
    if isinstance(error, AllaniteError):
        words, option, code = str(error), error.choice or None, error.exit_code
        more = {"cure": encoded(error.cure[1]).decode()} if error.cure[1] else {}
        rows = [row._asdict() | {"label": encoded(row.label).decode(), "looks": tr(row.looks)} for row in error.columns]
        more |= {"columns": rows} if rows else {}
    return {"error": encoded(words).decode(), "option": option, "exit": code, **more}
