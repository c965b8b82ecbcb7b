"""The errors of allanite. Each message says what was given, what was expected, and what to do."""

from typing import Self

from allanite.phrases.phrase import join

Cure = tuple[str, str]
"""Words that were typed, and what to type instead; if the first are empty, the second are added to the command."""


class AllaniteError(ValueError):
    """The input cannot be used; the message says what to do. `exit_code` is that of the command line.

    `choice` is the name of the choice that cures it, as it stands in a recipe or settings; empty if none does alone.
    `cure` is what to type, from which the command line makes a command that can be copied.
    """

    exit_code = 3

    def __init__(self, *words: object, choice: str = "", cure: Cure = ("", "")) -> None:
        super().__init__(*words)
        self.choice, self.cure = choice, cure

    def within(self, where: str) -> Self:
        """The same error, whose message begins with where it is."""
        return type(self)(join(": ", (where, str(self))), choice=self.choice, cure=self.cure)


class UsageError(AllaniteError):
    """An option, name or unit is wrong, or a required one is missing."""

    exit_code = 2


class UnitError(UsageError):
    """A unit is unknown, or has the wrong dimension."""


class UndrawnError(UsageError):
    """There is nothing in a value that could be drawn."""


class LongJobWarning(UserWarning):
    """The job takes minutes or more; the message says how long, and what is faster."""


class DataError(AllaniteError):
    """The data cannot be read, or cannot support the job."""


SHOWN = 200
"""Characters of a given text that a message shows."""


def given(value: object) -> str:
    """The given value as a message shows it: numbers of NumPy as those of Python, long texts by their beginning."""
    number = value.item() if hasattr(value, "item") and not getattr(value, "shape", ()) else value
    if isinstance(number, str) and len(number) > SHOWN:
        return f"{number[:SHOWN]!r}… ({len(number)} characters)"
    return f"{number:g}" if isinstance(number, float) else repr(number)
