"""Choices: what a user may set, each stated once as a field of a dataclass, from which option, key and help follow."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import MISSING, dataclass, field, fields, replace
from typing import Any

from .choice_kinds import FLAG, TYPED, ChoiceKind, kind_of, written
from .errors import UsageError


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
            return self.kind.parse(data)
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
            kind=kind_of(f.type) if row.kind is TYPED else row.kind,
        )
        for f in fields(kind) for row in (f.metadata.get("choice"),) if row is not None
    }  # fmt: skip


def read_given(rows: Mapping[str, ChoiceRow], data: Mapping[str, Any]) -> dict[str, Any]:
    """The values of these choices in plain data; what is empty is not given."""
    return {key: row.read(data[key]) for key, row in rows.items() if data.get(key) not in (None, "", [])}


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


def needing_all(settings: Any) -> Iterator[tuple[ChoiceRow, Any]]:
    """The choices with their values that do not work where only sums of a record are kept."""
    for name, row in choices_of(type(settings)).items():
        value = getattr(settings, name)
        if row.parts is not None and value is not None and value not in row.parts:
            yield row, value
