"""From the choices of the page to the command line that repeats them, and from an error to the choice that cures it."""

import re
import shlex
from collections.abc import Mapping, Sequence
from typing import Any

import click

from allanite.cli import main
from allanite.cli.front import DEFECT, Failure
from allanite.cli.options import FLAGS, OUTPUTS
from allanite.core.errors import AllaniteError, UsageError
from allanite.reporting.language import ENGLISH

JOBS = ("info", "analyze", "deviation", "spectrum", "dynamic", "compare", "watch")
"""Verbs of the page."""

HIDDEN = {*OUTPUTS, *FLAGS, "coefficients", "recipe", "threads", "limits", "help"}
"""Options that are not choices of a recipe: they say where results go, or read another file."""

Choices = Mapping[str, Any]


def parameters(verb: str) -> dict[str, click.Option]:
    """The options of a verb that the page may set, by their keys in a recipe."""
    if verb not in JOBS:
        raise UsageError(f"unknown job {verb!r}; jobs of the page: {', '.join(JOBS)}")
    with click.Context(main) as context:
        command = main.get_command(context, verb)
    assert command is not None  # noqa: S101 - `VERBS` has every job
    options = (param for param in command.params if isinstance(param, click.Option))
    return {str(o.name): o for o in options if o.name not in HIDDEN and not isinstance(o.type, click.Path)}


def line_of(verb: str, files: Sequence[str], choices: Choices, lang: str = ENGLISH) -> list[str]:
    """The words of a command line after ``allanite``.

    Raises
    ------
    UsageError
        A key is unknown; the message lists the known ones.
    """
    known, words = parameters(verb), list[str]()
    for key, value in choices.items():
        if key not in known:
            raise UsageError(f"unknown key {key!r} in the recipe; known keys: {', '.join(sorted(known))}")
        words += _words(known[key], value)
    words += ["--lang", lang] if lang != ENGLISH else []
    names = ["--", *files] if any(name.startswith("-") for name in files) else [*files]
    return [verb, *words, *names]


def shown_line(verb: str, files: Sequence[str], choices: Choices, lang: str = ENGLISH) -> str:
    """The command line as it can be typed."""
    return shlex.join(["allanite", *line_of(verb, files, choices, lang)])


def _words(option: click.Option, value: Any) -> list[str]:
    """An option with its value, as it is typed; nothing where none is given."""
    if value is None or value in ("", []):
        return []
    if option.is_flag:
        chosen = option.opts if value else option.secondary_opts
        return chosen[:1]
    if option.multiple:
        return [word for one in value for word in (option.opts[0], _text(one))]
    return [option.opts[0], _text(value)]


def _text(value: Any) -> str:
    """A value as it is typed.

    Examples
    --------
    >>> _text([100.0, 1e-3]), _text([[1, 2.5]]), _text({"N": [0.1, 10]}), _text({"gyro": "deg/s"})
    ('100.0,0.001', '1..2.5', 'N=0.1:10', 'gyro=deg/s')
    """
    if isinstance(value, dict):
        return ",".join(f"{key}={_text(v) if not isinstance(v, list) else ':'.join(map(str, v))}"
                        for key, v in value.items())  # fmt: skip
    if isinstance(value, (list, tuple)):
        return ",".join("..".join(map(str, v)) if isinstance(v, (list, tuple)) else _text(v) for v in value)
    return str(value)


def problem_of(error: Exception, verb: str = "", choices: Choices | None = None) -> dict[str, Any]:
    """An error as the page shows it: the sentence of the command line, the choice that cures it, the exit code."""
    choices = choices or {}
    if isinstance(error, click.ClickException):
        message, code = error.format_message(), error.status if isinstance(error, Failure) else error.exit_code
    elif isinstance(error, AllaniteError):
        message, code = str(error), error.exit_code
    else:
        message, code = f"internal error ({type(error).__name__}: {error})", DEFECT
    param = getattr(error, "param", None)
    option = str(param.name) if param is not None else _cure(message, verb, choices)
    return {"error": message, "option": option, "exit": code}


def _cure(message: str, verb: str, choices: Choices) -> str | None:
    """The choice that a message is about: the one whose value it quotes, else the first option that it names."""
    known = parameters(verb) if verb in JOBS else {}
    for key, value in choices.items():
        if value not in (None, "") and key in known and _quotes(message, value):
            return key
    for word in re.findall(r"--[a-z][a-z-]*", message):
        found = next((key for key, option in known.items() if word in (*option.opts, *option.secondary_opts)), None)
        if found is not None or word in ("--limit", "--quota"):
            return found or word[2:]
    return next((key for key in known if re.match(rf"{key}\b", message)), None)


def _quotes(message: str, value: Any) -> bool:
    """Whether a message quotes a value, or a part of it."""
    parts = value if isinstance(value, list) else [value]
    texts = {f"not {part}" for part in parts} | {repr(part) for part in parts if isinstance(part, str)}
    return any(re.search(re.escape(text) + r"(?![\w])", message) for text in texts)
