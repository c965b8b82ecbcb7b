"""The errors of allanite, and libraries that only some formats need: what was given, expected, and to be done."""

import importlib.util
import re
import sys
from pathlib import Path
from reprlib import Repr
from typing import Any, NamedTuple, Self

from allanite.phrases.phrase import join

SHOWN = 200  # characters of a given text, and digits of a number, that a message shows
_UNBROKEN = re.compile(r"\S{501,}")  # what is too long for the path of a file

Cure = tuple[str, str]
"""Words that were typed, and what to type instead; if the first are empty, the second are added to the command."""


class ColumnRow(NamedTuple):
    """What the numbers of a column show, as text, and what it is proposed as: time, signal, or nothing to leave out."""

    key: str  # by which it is chosen
    label: str
    mean: str
    std: str
    step: str
    looks: str
    use: str = ""
    unit: str = ""  # empty if nothing tells it
    sensor: int = 0  # equal for the axes of one


class AllaniteError(ValueError):
    """The input cannot be used; the message says what to do. `exit_code` is that of the command line.

    `choice` is the name of the choice that cures it, as it stands in a recipe or settings; empty if none does alone.
    `cure` is what to type, from which the command line makes a command that can be copied. `code` is a fixed keyword
    for programs, such as the name of the finding that refuses a record; empty if there is none. `columns` are those of
    a file that does not say what they are. `more` are lines below the message.
    """

    exit_code = 3

    def __init__(self, *words: object, choice: str = "", cure: Cure = ("", ""), code: str = "",
                 columns: tuple[ColumnRow, ...] = (), more: tuple[str, ...] = ()) -> None:  # fmt: skip
        super().__init__(*words)
        self.choice, self.cure, self.code, self.columns, self.more = choice, cure, code, columns, more

    def __str__(self) -> str:
        return "\n  ".join((self.message, *self.more)) if self.more else self.message

    @property
    def message(self) -> str:
        """The message without the lines below it."""
        words = super().__str__()  # the phrase, which can be translated
        if not _UNBROKEN.search(words):
            return words
        return _UNBROKEN.sub(lambda word: f"{word[0][:SHOWN]}… ({len(word[0])} characters)", words)

    def within(self, where: str) -> Self:
        """The same error, whose message begins with where it is."""
        return type(self)(join(": ", (where, self.message)), choice=self.choice, cure=self.cure, code=self.code,
                          columns=self.columns, more=self.more)  # fmt: skip


class UsageError(AllaniteError):
    """An option, name or unit is wrong, or a required one is missing."""

    exit_code = 2


class UnitError(UsageError):
    """A unit is unknown, or has the wrong dimension."""


class WrongTypeError(UsageError, TypeError):
    """An argument is of another type than its function takes."""


class UndrawnError(UsageError):
    """There is nothing in a value that could be drawn."""


class LongJobWarning(UserWarning):
    """The job takes minutes or more; the message says how long, and what is faster."""


class DataError(AllaniteError):
    """The data cannot be read, or cannot support the job."""


_BEGINNING = Repr()
_BEGINNING.maxlevel, _BEGINNING.maxlist, _BEGINNING.maxtuple, _BEGINNING.maxdict = 2, 12, 12, 4
_BEGINNING.maxstring = _BEGINNING.maxlong = _BEGINNING.maxother = SHOWN


def given(value: object) -> str:
    """The given value as a message shows it: numbers of NumPy as those of Python, long texts by their beginning."""
    number = value.item() if hasattr(value, "item") and not getattr(value, "shape", ()) else value
    if isinstance(number, str) and len(number) > SHOWN:
        return f"{number[:SHOWN]!r}… ({len(number)} characters)"
    if isinstance(number, int) and abs(number) > 10**SHOWN:
        return f"a number of more than {SHOWN} digits"
    return f"{number:g}" if isinstance(number, float) else _BEGINNING.repr(number)


class StoredError(UsageError):
    """Stored data are not of the type of their field; the message begins with its path, ``channels[0].fit.method``."""

    def __init__(self, what: str, where: str = "", **more: Any) -> None:
        super().__init__(f"{where.removeprefix('.')}: {what}" if where else what, **more)
        self.what, self.where = what, where

    @classmethod
    def at(cls, step: str, error: AllaniteError) -> Self:
        """An error in what is a step further down."""
        what, where = (error.what, error.where) if isinstance(error, cls) else (str(error), "")
        return cls(what, step + where)


def unfit(data: Any, expected: str) -> StoredError:
    """The error of data that are not what is expected."""
    words = {dict: "a table", list: "a list", tuple: "a list", type(None): "null"}
    return StoredError(f"{expected} is expected, not {words.get(type(data)) or given(data)}")


SOURCE = "git+https://github.com/allanite/allanite"
INSTALLERS = {
    "/pipx/venvs/": "pipx inject allanite {names}", "/pipx/": f"pipx run --with {{each}} --spec {SOURCE} allanite",
    "/uv/tools/": "uv tool install allanite -w {listed}", "/uv/archive-": f"uvx -w {{listed}} --from {SOURCE} allanite",
}  # fmt: skip
"""What adds libraries to an environment, by the folder of the program that made it; others are made by venv or uv."""


def demand_extra(extra: str, *modules: str, what: str = "this format") -> None:
    """Refuse what needs the libraries of an extra, and say how to install those that are missing."""
    if any(importlib.util.find_spec(name) is None for name in modules):
        names = requirements(extra)
        verb = "is" if len(names) == 1 else "are"
        raise UsageError(f"{what} needs {' and '.join(names)}, which {verb} not installed: {cure(names)}")


def requirements(extra: str) -> list[str]:
    """Names of the libraries of an extra."""
    from importlib.metadata import requires

    mark = re.compile(rf"""extra == ["']{extra}["']""")
    return [re.split(r"[\s<>=!~;\[(]", line)[0].lower() for line in requires("allanite") or () if mark.search(line)]


def cure(names: list[str], prefix: Path | None = None) -> str:
    """The command that installs libraries into this environment, or the one at `prefix`."""
    where = Path(sys.prefix) if prefix is None else prefix
    made = where / "pyvenv.cfg"
    by_uv = made.is_file() and re.search(r"^uv\s*=", made.read_text("utf-8"), re.MULTILINE)
    usual = "uv pip install {names}" if by_uv else "pip install {names}"
    command = next((command for folder, command in INSTALLERS.items() if folder in where.as_posix()), usual)
    return command.format(names=" ".join(names), listed=",".join(names), each=" --with ".join(names))


UNIT, RATE, SCALE, COLUMN = "UNIT", "HZ", "SCALE", "COLUMN"

MEANINGS = {UNIT: "the unit (deg/s, rad/s, m/s^2 or g, of time s, ms, us or ns)", RATE: "the sampling rate in Hz",
            SCALE: "the size of one count with its unit (0.01deg/s)",
            COLUMN: "the name or number of a column"}  # fmt: skip
"""What belongs in the place of each."""
