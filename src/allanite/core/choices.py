"""Choices: what a user may set, each stated once as a field of a dataclass, from which option, key and help follow."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import MISSING, dataclass, field, fields, replace
from types import UnionType
from typing import Any, Literal, Union, get_args, get_origin

from .errors import UsageError
from .ranges import demand_pieces, demand_ranges


@dataclass(frozen=True)
class Kind:
    """What the value of a choice is.

    The help calls it `name` where there is no metavar; `read` makes it from text, or from the plain data of a file or a
    request, and `demand` from the name of the choice and a value of Python: both refuse what is no such value. It is
    entered as a `control` of the page: "text", "number", "list", "band" or "flag". The option is repeated for each of
    `many` parts; `write` makes the text that is read, if `written` does not.
    """

    name: str
    read: Callable[[Any], Any]
    demand: Callable[[str, Any], Any] = lambda name, value: value
    control: str = "text"
    many: bool = False
    write: "Callable[[Any], str] | None" = None


TYPED = Kind("value", lambda value: value)
"""The kind that the type of the field says."""


@dataclass(frozen=True)
class Choice:
    """A field that a user may set.

    Attributes
    ----------
    metavar, help : str
        The value in the help, and the text of the help.
    kind : Kind
        What its value is, by default what the type of the field says.
    group : str
        What it is about: "reading", "selecting", "identifying", "curve" or "showing" of a recipe.
    flags : tuple of str
        Names of the option, if they are not that of the field.
    told : str, optional
        What the help says of the default; by default the default itself, if it is a number or words.
    parts : tuple, optional
        The values that work where only sums of a record are kept; by default all. A choice that is not given always
        works.
    demand : callable, optional
        What a value must be beyond its kind: returns the value as it is kept, or raises UsageError.
    name, default
        Those of the field.
    """

    metavar: str = ""
    help: str = ""
    kind: Kind = TYPED
    group: str = ""
    flags: tuple[str, ...] = ()
    told: str | None = None
    parts: tuple[Any, ...] | None = None
    demand: Callable[[Any], Any] | None = None
    name: str = ""
    default: Any = None

    @property
    def options(self) -> tuple[str, ...]:
        """Names of the option; of a flag that can be denied, ``--name/--no-name``."""
        return self.flags or (f"--{self.name.replace('_', '-')}",)

    @property
    def text(self) -> str:
        """What the help says."""
        usual = self.told
        if usual is None:
            usual = "" if self.default is None or isinstance(self.default, bool) else written(self.default)
        return self.help + (f"  [default: {usual}]" if usual else "")

    def read(self, data: Any) -> Any:
        """The value from its text or plain data.

        Raises
        ------
        UsageError
            It is none, in the words of the command line.
        """
        try:
            return self.kind.read(data)
        except UsageError as error:
            names = " / ".join(f"'{option}'" for option in self.options)
            raise UsageError(f"Invalid value for {names}: {error}", choice=self.name) from None

    def words(self, value: Any) -> list[str]:
        """The option with a value, as it is typed."""
        if self.kind is FLAG:
            return self.options[0].split("/")[not value :][:1]
        parts = value if self.kind.many else (value,)
        return [word for part in parts for word in (self.options[0], (self.kind.write or written)(part))]


def choice(metavar: str = "", help: str = "", *, default: Any = None, **columns: Any) -> Any:  # noqa: A002 - as click
    """A field of a dataclass that a user may set; `columns` are those of `Choice`."""
    return field(default=default, metadata={"choice": Choice(metavar, help, **columns)})


def choices_of(kind: type[Any]) -> dict[str, Choice]:
    """The choices of a class by the name of their field.

    Examples
    --------
    >>> @dataclass
    ... class Smoothing:
    ...     window: float = choice("S", "Length of the mean.", default=60.0)
    >>> row = choices_of(Smoothing)["window"]
    >>> row.options, row.text, row.read("5"), row.words(5.0)
    (('--window',), 'Length of the mean.  [default: 60]', 5.0, ['--window', '5'])
    """
    return {
        f.name: replace(
            row, name=f.name, default=None if f.default is MISSING else f.default,
            kind=_kind_of(f.type) if row.kind is TYPED else row.kind,
        )
        for f in fields(kind) for row in (f.metadata.get("choice"),) if row is not None
    }  # fmt: skip


def _kind_of(hint: Any) -> Kind:
    """The kind of values of a type, which may be None as well."""
    kinds = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
    return WORD if get_origin(kinds[0]) is Literal else KINDS[kinds[0]]


def named(kind: type[Any], *groups: str) -> tuple[str, ...]:
    """Names of the choices of these groups."""
    return tuple(name for name, row in choices_of(kind).items() if row.group in groups)


def demand_choices(settings: Any) -> None:
    """Refuse a value that its choice does not allow, and keep the others as their kind and choice return them."""
    for name, row in choices_of(type(settings)).items():
        value = getattr(settings, name)
        if value is None and row.default is None:
            continue
        try:
            kept = row.kind.demand(name, value)
            object.__setattr__(settings, name, row.demand(kept) if row.demand else kept)
        except UsageError as error:
            error.choice = error.choice or name
            raise


def needing_all(settings: Any) -> Iterator[tuple[Choice, Any]]:
    """The choices with their values that do not work where only sums of a record are kept."""
    for name, row in choices_of(type(settings)).items():
        value = getattr(settings, name)
        if row.parts is not None and value is not None and value not in row.parts:
            yield row, value


def written(value: Any) -> str:
    """A value as it is typed.

    Examples
    --------
    >>> written((100.0, 1e-3)), written(((1, 2.5),)), written({"N": (0.1, 10)}), written({"gyro": "deg/s"})
    ('100,0.001', '1..2.5', 'N=0.1:10', 'gyro=deg/s')
    """
    if isinstance(value, Mapping):
        pairs = ((key, ":".join(map(written, v)) if isinstance(v, (list, tuple)) else v) for key, v in value.items())
        return ",".join(f"{key}={v}" for key, v in pairs)
    if isinstance(value, (list, tuple)):
        return ",".join("..".join(map(written, v)) if isinstance(v, (list, tuple)) else written(v) for v in value)
    return str(value).removesuffix(".0") if isinstance(value, float) else str(value)


def _parsed(number: type[float] | type[int]) -> Callable[[Any], Any]:
    def read(value: Any) -> float | int:
        try:
            return number(value)
        except (TypeError, ValueError):
            raise UsageError(f"{value!r} is not a valid {'float' if number is float else 'integer'}.") from None

    return read


def _demand_number(name: str, value: Any) -> Any:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise UsageError(f"{name} must be a number, not {value!r}")
    return value


def _demand_word(name: str, value: Any) -> Any:
    if not isinstance(value, str):
        raise UsageError(f"{name} must be a word, not {value!r}")
    return value


def separated(kind: type, name: str, count: int | None = None, example: str = "") -> Kind:
    """Words or numbers separated by commas; plain data may hold a list."""

    def read(value: Any) -> tuple[Any, ...]:
        parts = value.split(",") if isinstance(value, str) else value
        try:
            values = tuple(kind(part.strip() if isinstance(part, str) else part) for part in parts)
        except (TypeError, ValueError):
            values = ()
        if not values or (count is not None and len(values) != count):
            raise UsageError(f"expected {name}, e.g. {example}, not {value!r}")
        return values

    return Kind(name, read, control="list")


def pieces(unit: str) -> Kind:
    """Pairs of numbers in a unit, as ``100..160,300..310``; plain data may hold a list of them."""
    return Kind("pieces", lambda value: demand_pieces(value, unit), lambda name, value: demand_pieces(value, unit))


def _table(value: Any) -> Any:
    if not isinstance(value, str):
        return value
    found = {}
    for part in value.split(","):
        symbol, _, numbers = part.partition("=")
        try:
            low, high = (float(number) for number in numbers.split(":"))
        except ValueError:
            raise UsageError(f"expected terms with their ranges, e.g. N=0.1:10,K=100:1000, not {part!r}") from None
        found[symbol.strip()] = (low, high)
    return found


def _worth(value: Any) -> float | str:
    try:
        return float(value)
    except (TypeError, ValueError):
        return str(value)


def _grid(value: Any) -> Any:
    try:
        return NUMBERS.read(value)
    except UsageError:
        return value


def seconds_of(text: Any) -> float:
    """Seconds of ``600``, ``10 min`` or ``1h``; days are ``d``."""
    from .notation import split_quantities
    from .units import convert

    if isinstance(text, (int, float)):
        return float(text)
    found = split_quantities(str(text).split())
    if len(found) != 1 or not found[0][0] > 0:
        raise UsageError(f"a duration has the form 3600, '10 min' or 24h, not {text!r}")
    value, unit = found[0]
    return 86400 * value if unit == "d" else convert(value, unit or "s", "s")


NUMBER = Kind("float", _parsed(float), _demand_number, control="number")
INTEGER = Kind("integer", _parsed(int), _demand_number, control="number")
PERCENT = Kind("float", lambda v: NUMBER.read(v) / 100, control="number", write=lambda v: f"{100 * v:.12g}")
WORD = Kind("text", str, _demand_word)
FLAG = Kind("boolean", lambda value: value not in (False, 0, "false", "no", "off", ""), control="flag")
NAMES = separated(str, "names", example="gx,gy")
NUMBERS = separated(float, "numbers", example="1,10,100")
INTEGERS = separated(int, "integers", example="1,10,100")
_FREQUENCIES = separated(float, "auto, all, or two frequencies in Hz", 2, "0.01,10")
BAND = Kind("band", lambda v: v if v in ("auto", "all") else _FREQUENCIES.read(v), control="band")
GRID = Kind("grid", _grid)
RANGES = Kind("ranges", _table, lambda name, value: demand_ranges(value))
WORTH = Kind("scale", _worth, lambda name, v: v if isinstance(v, str) else _demand_number(name, v))
DURATION = Kind("duration", seconds_of)
DURATIONS = Kind(
    "duration", lambda v: tuple(map(seconds_of, v.split(",") if isinstance(v, str) else v)), control="list"
)
LINES = Kind("text", lambda v: tuple([v] if isinstance(v, str) else v), control="list", many=True)

KINDS: dict[Any, Kind] = {
    float: NUMBER, int: INTEGER, str: WORD, bool: FLAG,
    tuple[str, ...]: NAMES, tuple[float, ...]: NUMBERS, tuple[int, ...]: INTEGERS,
}  # fmt: skip
"""The kind that a type of a field says."""
