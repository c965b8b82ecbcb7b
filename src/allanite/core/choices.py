"""Choices: what a user may set, each stated once as a field, from which option, key, help and control follow."""

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import MISSING, dataclass, field, fields, replace
from functools import cache
from inspect import cleandoc
from types import UnionType
from typing import Any, Literal, TypeVar, Union, cast, get_args, get_origin

from . import ranges
from .errors import AllaniteError, UsageError, given
from .ranges import Range, demand_pieces, demand_ranges
from .units import A_DURATION, seconds_of

Settings = TypeVar("Settings")

ONE = (str, int, float)
LISTS = (*ONE, list, tuple)  # types of plain data that are one value, and that may be several


@dataclass(frozen=True)
class ChoiceKind:
    """What the value of a choice is."""

    # The help calls it `name` where there is no metavar. `read` makes it from text, or from the plain data of a file or
    # a request, which are of the types that it `takes`; where it raises an error, the message has the `form` that is
    # expected. `demand` checks a value of Python by the name of the choice. It is entered as a `control` of the page:
    # "text", "number", "list", "band" or "flag". The option is repeated for each of `many` parts; `write` makes the
    # text that is read, if `written` does not. `alone` is the value of an option that is given without one, `measure`
    # what the documentation says of its unit in Python. Numbers are `within` a range, unless their choice has another;
    # `unit` is that of text.
    name: str
    read: Callable[[Any], Any]
    demand: Callable[[str, Any], Any] = lambda name, value: value
    control: str = "text"
    many: bool = False
    write: "Callable[[Any], str] | None" = None
    takes: tuple[type, ...] = ONE
    form: str = ""
    alone: str = ""
    measure: str = ""
    within: Range | None = None
    unit: str = ""

    def parse(self, data: Any, within: Range | None = None) -> Any:
        """The value from text or plain data, each number of it within a range."""
        try:
            if not isinstance(data, self.takes) or (isinstance(data, bool) and bool not in self.takes):
                raise TypeError
            value = self.read(data)
        except AllaniteError:
            raise
        except (TypeError, ValueError, OverflowError):
            raise UsageError(f"expected {self.form or f'a {self.name}'}, not {given(data)}") from None
        within = within or self.within
        if within is not None:
            percent = self.unit if isinstance(data, str) else ""
            words = within.words(self.write, percent) if self.write and percent else ""
            within.demand(value, words=words, typed=data if percent else None)
        return value


TYPED = ChoiceKind("value", lambda value: value)  # the kind that the type of the field says

SECONDS = " In s."


def written(value: Any) -> str:
    """A value as it is typed."""
    if isinstance(value, Mapping):
        pairs = ((key, ":".join(map(written, v)) if isinstance(v, (list, tuple)) else v) for key, v in value.items())
        return ",".join(f"{key}={v}" for key, v in pairs)
    if isinstance(value, (list, tuple)):
        return ",".join("..".join(map(written, v)) if isinstance(v, (list, tuple)) else written(v) for v in value)
    return str(value).removesuffix(".0") if isinstance(value, float) else str(value)


def _demanding(words: str, holds: Callable[[Any], bool]) -> Callable[[str, Any], Any]:
    """A check of values of Python."""

    def demand(name: str, value: Any) -> Any:
        if not holds(value):
            raise UsageError(f"{name} must be {words}, not {given(value)}")
        return value

    return demand


A_NUMBER, AN_INTEGER = "a number", "an integer"

_demand_number = _demanding(A_NUMBER, lambda value: isinstance(value, (int, float)) and not isinstance(value, bool))
_demand_integer = _demanding(AN_INTEGER, lambda value: hasattr(value, "__index__") and not isinstance(value, bool))
_demand_word = _demanding("a word", lambda value: isinstance(value, str))


def _demand_times(name: str, value: Any) -> Any:
    try:
        return DURATIONS.read(value.tolist() if hasattr(value, "tolist") else value)
    except UsageError as error:
        raise error.within(name) from None


def _parts(value: Any) -> Any:
    return value.split(",") if isinstance(value, str) else value


def separated(kind: type, name: str, count: int | None = None, example: str = "",
              within: Range | None = None) -> ChoiceKind:  # fmt: skip
    """Words or numbers separated by commas; plain data may hold a list."""

    def read(value: Any) -> tuple[Any, ...]:
        values = tuple(kind(part.strip() if isinstance(part, str) else part) for part in _parts(value))
        if not values or (count is not None and len(values) != count):
            raise ValueError(values)
        return values

    def demand(option: str, value: Any) -> tuple[Any, ...]:
        parts = value.tolist() if hasattr(value, "tolist") else value
        try:
            texts = isinstance(parts, str) or kind is not str or all(isinstance(part, str) for part in parts)
            if not (texts and isinstance(parts, (str, list, tuple))):
                raise TypeError
            return read(parts) if parts not in ((), []) else ()
        except (TypeError, ValueError, OverflowError):
            raise UsageError(f"{option}: expected {name}, e.g. {example}, not {given(value)}") from None

    return ChoiceKind(name, read, demand, control="list", takes=LISTS, form=f"{name}, e.g. {example}", within=within)


def pieces(unit: str) -> ChoiceKind:
    """Pairs of numbers in a unit, as ``100..160,300..310``; plain data may hold a list of them."""
    return ChoiceKind("pieces", lambda value: demand_pieces(value, unit), lambda _, value: demand_pieces(value, unit),
                      takes=LISTS, form=f"pairs of numbers in {unit}, e.g. 100..160,300..310",
                      within={"s": ranges.INSTANT, "Hz": ranges.FREQUENCY}[unit])  # fmt: skip


def _share(value: Any) -> float:
    if not isinstance(value, str):
        return float(value)
    unit, size = next((row for row in (("%", 1e-2), ("ppm", 1e-6)) if value.endswith(row[0])), ("", 1.0))
    return float(value.removesuffix(unit)) * size


def _table(value: Any) -> Any:
    if not isinstance(value, str):
        return value
    pairs = {}
    for part in value.split(","):
        symbol, _, numbers = part.partition("=")
        low, high = map(float, numbers.split(":"))
        pairs[symbol.strip()] = (low, high)
    return pairs


def _either(read: Callable[[Any], Any], other: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """What the one function reads, or else the other."""

    def reading(value: Any) -> Any:
        try:
            return read(value)
        except (TypeError, ValueError):
            return other(value)

    return reading


def _lines(value: Any) -> tuple[str, ...]:
    if isinstance(value, Mapping):
        return tuple(f"{key}={part}" for key, part in value.items())
    return tuple([value] if isinstance(value, str) else value)


def _demand_lines(name: str, value: Any) -> tuple[str, ...]:
    texts = (value,) if isinstance(value, str) else value
    if not isinstance(texts, (tuple, list)) or not all(isinstance(text, str) for text in texts):
        raise UsageError(f"{name} must be a text or a list of texts, not {given(value)}")
    return tuple(texts)


def _model(text: Any) -> Any:
    from .model import Model

    return Model(str(text))


NUMBER = ChoiceKind("float", float, _demand_number, control="number", form=A_NUMBER)
HERTZ = ChoiceKind("float", lambda v: float(re.sub(r"\s*Hz$", "", v, flags=re.I) if isinstance(v, str) else v),
                   _demand_number, control="number", form=A_NUMBER, within=ranges.RATE)  # fmt: skip
INTEGER = ChoiceKind("integer", int, _demand_integer, control="number", form=AN_INTEGER)
PERCENT = ChoiceKind("float", lambda v: float(v) / (100 if isinstance(v, str) else 1), _demand_number,
                     form=A_NUMBER, write=lambda v: f"{100 * v:.12g}", measure=" A share, from 0 to 1.",
                     within=ranges.SHARE, unit="%")  # fmt: skip
"""A share: of text, as it is typed, in percent; of plain data, as in Python, from 0 to 1."""
SHARE = ChoiceKind("share", _share, _demand_number, form="a share such as 0.1%, 1000ppm or 0.001")
WORD = ChoiceKind("text", str, _demand_word, form="a word")
SYMBOLS = ChoiceKind("text", str, form="a word", demand=lambda name, value: _demand_word(
    name, ",".join(value) if isinstance(value, (list, tuple)) else value))  # fmt: skip
FLAG = ChoiceKind("boolean", lambda value: value not in (False, 0, "false", "no", "off", ""), control="flag",
                  takes=(str, int, bool), form="true or false")  # fmt: skip
NAMES = separated(str, "names", example="gx,gy")
NUMBERS = separated(float, "numbers", example="1,10,100")
INTEGERS = separated(int, "integers", example="1,10,100", within=ranges.SAMPLES)
_FREQUENCIES = separated(float, "auto, all, or two frequencies in Hz", 2, "0.01,10")
BAND = ChoiceKind("band", lambda v: v if v in ("auto", "all") else _FREQUENCIES.read(v), control="band", takes=LISTS,
                  form=_FREQUENCIES.form, within=ranges.FREQUENCY)  # fmt: skip
GRID = ChoiceKind("grid", _either(NUMBERS.read, lambda value: value), takes=LISTS,
                  form="octave, decade, log, all, or times in s, e.g. 1,10,100", within=ranges.TIME)  # fmt: skip
RANGES = ChoiceKind("ranges", _table, lambda name, value: demand_ranges(value), takes=(str, dict),
                    form="terms with their ranges, e.g. N=0.1:10,K=100:1000", within=ranges.TIME)  # fmt: skip
WORTH = ChoiceKind("scale", _either(float, str), lambda name, v: v if isinstance(v, str) else _demand_number(name, v),
                   form="a number, or a number with a unit as 0.01deg/s", within=ranges.POSITIVE)  # fmt: skip
DURATION = ChoiceKind("duration", seconds_of, _demand_number, form=A_DURATION, measure=SECONDS, within=ranges.TIME)
INSTANT = ChoiceKind("duration", _either(float, seconds_of), _demand_number, control="number", form=A_DURATION,
                     measure=SECONDS, within=ranges.INSTANT)  # fmt: skip
"""Seconds after the first sample, which may be zero."""
MODEL = ChoiceKind("model", _model, form="a model, e.g. 'N 0.003 deg/sqrt(h), B 0.5 deg/h'")
DURATIONS = ChoiceKind(
    "duration", lambda v: tuple(map(seconds_of, _parts(v) if isinstance(v, (str, list, tuple)) else [v])),
    _demand_times, "list", takes=LISTS, within=ranges.TIME,
    form="times in s, e.g. 600,3600, or with units, e.g. '10 min,1 h'", measure=SECONDS,
)  # fmt: skip
_SPAN = "two averaging times in s, e.g. 1,1000 or '1 s,10 min', or yes, or no"
_ANSWERS = {"yes": True, "no": False}


def _span(value: Any) -> Any:
    if value is None or isinstance(value, bool):
        return value
    if isinstance(value, str) and value in _ANSWERS:
        return _ANSWERS[value]
    try:
        low, high = DURATIONS.read(value)
    except (UsageError, TypeError, ValueError):
        low, high = 0.0, 0.0
    if not 0 < low < high < math.inf:
        form = "the shorter averaging time first, as in 1,1000" if 0 < high < low else _SPAN
        raise UsageError(f"expected {form}, not {given(value)}")
    return low, high


SPAN = ChoiceKind("span", _span, lambda _, value: _span(value), takes=(*LISTS, bool), form=_SPAN, alone="yes",
                  write=lambda value: ("no", "yes")[value] if isinstance(value, bool) else written(value),
                  within=ranges.TIME)  # fmt: skip
LINES = ChoiceKind("text", _lines, _demand_lines, control="list", many=True, takes=(str, list, tuple, dict),
                   form="text, a list of texts, or a table")  # fmt: skip

KINDS: dict[Any, ChoiceKind] = {float: NUMBER, int: INTEGER, str: WORD, bool: FLAG, tuple[str, ...]: NAMES,
                                tuple[float, ...]: NUMBERS, tuple[int, ...]: INTEGERS}  # fmt: skip
"""The kind that a type of a field says."""


def kind_of(hint: Any) -> ChoiceKind:
    """The kind of values of a type, which may be None as well."""
    kinds = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
    return WORD if get_origin(kinds[0]) is Literal else KINDS[kinds[0]]


@dataclass(frozen=True)
class ChoiceRow:
    """A field that a user may set."""

    # metavar, help: the value in the help, and the text of the help
    metavar: str = ""
    help: str = ""
    kind: ChoiceKind = TYPED  # what its value is, by default what the type of the field says
    group: str = ""  # what it is about: "reading", "selecting", "identifying", "curve" or "showing" of a recipe
    flags: tuple[str, ...] = ()  # names of the option, if they are not that of the field
    # what the help says of the default; by default the default itself, if it is a number or words
    told: str | None = None
    # the values that work where only sums of a record are kept; by default all. A choice that is not given always
    # works.
    parts: tuple[Any, ...] | None = None
    # other names of the option by which it is asked for; they are suggested, not taken
    synonyms: tuple[str, ...] = ()
    old: tuple[str, ...] = ()  # names that the option had, which are taken and not shown
    within: Range | None = None  # its numbers, if they are not those of its kind
    unlike: tuple[str, ...] = ()  # those of them whose values are of another unit: they are not put in its place
    # what a value must be beyond its kind: returns the value as it is kept, or raises UsageError
    demand: Callable[[Any], Any] | None = None
    # name, default: those of the field
    name: str = ""
    default: Any = None

    @property
    def options(self) -> tuple[str, ...]:
        """Names of the option; of a flag that can be denied, ``--name/--no-name``."""
        return self.flags or (f"--{self.name.replace('_', '-')}",)

    @property
    def keys(self) -> tuple[str, ...]:
        """Names of the option as keys of a recipe: ``from`` of ``--from``."""
        return tuple(option.lstrip("-").replace("-", "_") for option in self.options)

    @property
    def text(self) -> str:
        """What the help says."""
        usual = self.told
        if usual is None:
            silent = self.default is None or isinstance(self.default, bool)
            usual = "" if silent else (self.kind.write or written)(self.default)
        return self.help + (f"  [default: {usual}]" if usual else "")

    def read(self, data: Any) -> Any:
        """The value from its text or plain data."""
        try:
            return self.kind.parse(data, self.within)
        except UsageError as error:
            names = " / ".join(f"'{option}'" for option in self.options)
            raise UsageError(f"Invalid value for {names}: {error}", choice=self.name, cure=error.cure) from None

    def words(self, value: Any) -> list[str]:
        """The option with a value, as it is typed."""
        if self.kind is FLAG:
            return self.options[0].split("/")[not value :][:1]
        parts = value if self.kind.many else (value,)
        return [word for part in parts for word in (self.options[0], (self.kind.write or written)(part))]


def choice(metavar: str = "", help: str = "", *, default: Any = None, **columns: Any) -> Any:  # noqa: A002 - as click
    """A field of a dataclass that a user may set; `columns` are those of `ChoiceRow`."""
    return field(default=default, metadata={"choice": ChoiceRow(metavar, help, **columns)})


def choices_of(kind: type[Any]) -> dict[str, ChoiceRow]:
    """The choices of a class by the name of their field; they are looked for once, and not to be changed."""
    return _choices_of(cast(Any, kind))


@cache
def _choices_of(kind: Any) -> dict[str, ChoiceRow]:
    rows = ((f, f.metadata.get("choice")) for f in fields(kind))
    return {f.name: replace(row, name=f.name, default=None if f.default is MISSING else f.default,
                            kind=kind_of(f.type) if row.kind is TYPED else row.kind)
            for f, row in rows if row is not None}  # fmt: skip


def described(kind: type[Settings]) -> type[Settings]:
    """The class, whose docstring lists the choices that it does not describe itself by the help of their rows.

    >>> @described
    ... @dataclass
    ... class Smoothing:
    ...     "How it is smoothed."
    ...     window: float = choice("S", "Length of the mean, instead of --taus.", default=60.0)
    >>> Smoothing.__doc__.splitlines()[-1]
    '    Length of the mean, instead of `taus`.'
    """
    text, raises, rest = cleandoc(kind.__doc__ or "").partition("\n\nRaises\n")
    lines = [text] if "\n\nAttributes\n" in text else [text, "", "Attributes", "----------"]
    described_itself = {name for line in text.splitlines() for name in line.partition(" : ")[0].split(", ")}
    for f in fields(kind):  # type: ignore[arg-type]  # decorated as a dataclass before
        row = f.metadata.get("choice")
        if row is None or f.name in described_itself:
            continue
        name = f.type.__name__ if isinstance(f.type, type) and not get_args(f.type) else str(f.type)
        usual = f" By default {row.told}." if row.told and f.default is None else ""
        words = re.sub("--([a-z-]+)", lambda option: f"`{option[1].replace('-', '_')}`",
                       row.help + row.kind.measure + usual)  # fmt: skip
        lines += [f"{f.name} : {name.replace('typing.', '')}", f"    {words}"]
    kind.__doc__ = "\n".join(lines) + raises + rest
    return kind


def read_given(rows: Mapping[str, ChoiceRow], data: Mapping[str, Any]) -> dict[str, Any]:
    """The values of these choices in plain data; what is empty is not given."""
    return {key: row.read(data[key]) for key, row in rows.items() if data.get(key) not in (None, "", [])}


def named(kind: type[Any], *groups: str) -> tuple[str, ...]:
    """Names of the choices of these groups."""
    return tuple(name for name, row in choices_of(kind).items() if row.group in groups)


class Choices:
    """A class of choices: values that are not allowed are refused, others kept as their kind and choice return them."""

    def __post_init__(self) -> None:
        rows = choices_of(type(self))
        if len(rows) < len(fields(self)):  # type: ignore[arg-type]
            from .declared import demand_fields  # with numpy, which help does without

            demand_fields(self, rows)
        for name, row in rows.items():
            value, within = getattr(self, name), row.within or row.kind.within
            if (value is None and row.default is None) or value is row.default:
                continue
            try:
                kept = row.kind.demand(name, value)
                if within is not None:
                    within.demand(kept, name)
                object.__setattr__(self, name, row.demand(kept) if row.demand else kept)
            except UsageError as error:
                error.choice = error.choice or name
                raise
