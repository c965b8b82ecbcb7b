"""Types of the values of options: how their text is parsed."""

from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    ParamType = click.ParamType[Any]
else:
    ParamType = click.ParamType  # generic only in newer versions


class Separated(ParamType):
    """Words or numbers separated by commas; a recipe may hold a list."""

    def __init__(self, kind: type, name: str, count: int | None = None, example: str = "") -> None:
        self.kind, self.name, self.count, self.example = kind, name, count, example

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[Any, ...]:
        """The parts of the text, or the list of a recipe."""
        parts = value.split(",") if isinstance(value, str) else value
        try:
            found = tuple(self.kind(part.strip() if isinstance(part, str) else part) for part in parts)
        except (TypeError, ValueError):
            found = ()
        if not found or (self.count is not None and len(found) != self.count):
            self.fail(f"expected {self.name}, e.g. {self.example}, not {value!r}", param, ctx)
        return found


NAMES = Separated(str, "names", example="gx,gy")
NUMBERS = Separated(float, "numbers", example="1,10,100")
INTEGERS = Separated(int, "integers", example="1,10,100")


class Taus(ParamType):
    """The name of a grid, or seconds separated by commas."""

    name = "grid"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Seconds if they are numbers, otherwise a name."""
        try:
            return NUMBERS.convert(value, param, ctx)
        except click.BadParameter:
            return value


class Band(ParamType):
    """A word, or two frequencies."""

    name = "band"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The word, or two numbers."""
        if value in ("auto", "all"):
            return value
        return _FREQUENCIES.convert(value, param, ctx)


_FREQUENCIES = Separated(float, "auto, all, or two frequencies in Hz", 2, "0.01,10")


class Units(ParamType):
    """A unit, or several by sensor or channel; a recipe may hold a table."""

    name = "unit"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """The text, checked where a table is given."""
        from allanite.readers.options import stated_unit

        return stated_unit(value)


class Ranges(ParamType):
    """A pair of numbers for each of several terms; a recipe holds a table of pairs."""

    name = "ranges"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Symbol -> (low, high)."""
        if not isinstance(value, str):
            return value
        found = {}
        for part in value.split(","):
            symbol, _, numbers = part.partition("=")
            try:
                low, high = (float(number) for number in numbers.split(":"))
            except ValueError:
                self.fail(f"expected terms with their ranges, e.g. N=0.1:10,K=100:1000, not {part!r}", param, ctx)
            found[symbol.strip()] = (low, high)
        return found


class Pieces(ParamType):
    """Pairs of numbers in a unit; a recipe may hold a list of them."""

    name = "pieces"

    def __init__(self, unit: str = "s") -> None:
        self.unit = unit

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Pairs of floats."""
        from allanite.core.errors import UsageError
        from allanite.core.ranges import demand_pieces

        try:
            return demand_pieces(value, self.unit)
        except UsageError as error:
            self.fail(str(error), param, ctx)


class Scale(ParamType):
    """A number, or a number with its unit."""

    name = "scale"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float | str:
        """A float if it is one."""
        try:
            return float(value)
        except ValueError:
            return str(value)


class Duration(ParamType):
    """Seconds, or a duration with its unit; several separated by commas if `several`."""

    name = "duration"

    def __init__(self, several: bool = False) -> None:
        self.several = several

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Seconds."""
        if isinstance(value, (int, float)):
            return float(value)
        if not self.several:
            return seconds_of(value)
        return tuple(part if isinstance(part, float) else seconds_of(str(part)) for part in _parts(value))


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


def _parts(value: Any) -> Any:
    return value.split(",") if isinstance(value, str) else value


def seconds_of(text: str) -> float:
    """Seconds of ``600``, ``10 min`` or ``1h``; days are ``d``."""
    from allanite.core.notation import split_quantities
    from allanite.core.units import convert

    found = split_quantities(text.split())
    if len(found) != 1 or not found[0][0] > 0:
        raise click.BadParameter(f"a duration has the form 3600, '10 min' or 24h, not {text!r}")
    value, unit = found[0]
    return 86400 * value if unit == "d" else convert(value, unit or "s", "s")
