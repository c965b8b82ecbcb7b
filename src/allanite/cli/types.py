"""Types of the values of options: how their text is parsed."""

from typing import TYPE_CHECKING, Any

import click

from allanite.core import choice_kinds
from allanite.core.choice_kinds import ChoiceKind
from allanite.core.errors import UsageError

if TYPE_CHECKING:
    ParamType = click.ParamType[Any]
else:
    ParamType = click.ParamType  # generic only in newer versions


class Converted(ParamType):
    """The kind of a choice as a type of click."""

    def __init__(self, kind: ChoiceKind) -> None:
        self.kind, self.name = kind, kind.name

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The value, from its text or what a recipe holds."""
        try:
            return self.kind.parse(value)
        except UsageError as error:
            raise error.within(f"Invalid value for {param.get_error_hint(ctx)}" if param else self.name) from None


class Threads(ParamType):
    """A number of processors; "auto", all of them, is None."""

    name = "threads"

    def convert(self, value: Any, param: Any, ctx: Any) -> int | None:
        """A number as it is, a word by its meaning."""
        if value == "auto":
            return None
        try:
            count = int(value)
        except (TypeError, ValueError):
            count = 0
        if count < 1:
            self.fail(f"expected a number of processors, at least 1, or auto, not {value!r}", param, ctx)
        return count


NAMES, NUMBERS, INTEGERS = map(Converted, (choice_kinds.NAMES, choice_kinds.NUMBERS, choice_kinds.INTEGERS))
