"""The errors of allanite: each says what came, what was expected, and what to do next."""


class AllaniteError(ValueError):
    """Something the user gave cannot be used; the message says what to do. The command line ends with `exit_code`."""

    exit_code = 3


class UsageError(AllaniteError):
    """An option, name or unit is wrong, or one that is needed is missing."""

    exit_code = 2


class UnitError(UsageError):
    """A unit is unknown, or measures something else than is wanted here."""


class LongJobWarning(UserWarning):
    """What was asked takes minutes or more; the message says how long, and what takes less."""


class DataError(AllaniteError):
    """The data cannot be read, or cannot support the job."""


def given(value: object) -> str:
    """What came, as a message says it: numbers of NumPy look like those of Python."""
    number = value.item() if hasattr(value, "item") and not getattr(value, "shape", ()) else value
    return f"{number:g}" if isinstance(number, float) else repr(number)
