"""Content: what a file says, before it has a form."""

from dataclasses import dataclass

from allanite.core.plain import Value

from .axes import Axis


@dataclass(frozen=True, repr=False)
class Entry(Value):
    """A field with its value.

    Attributes
    ----------
    name, sensor, section, unit, formula : str
        As in the row of the target.
    values : tuple of float
        One value, or one for each axis, in `unit`.
    channels : tuple of str
        The channel whose coefficient each value is.
    remark : str
        Interval, or why the value is a limit; stands in the file.
    measured : bool
        Whether every value comes from an identified coefficient, not from a limit.
    """

    name: str
    sensor: str
    section: str
    unit: str
    formula: str
    values: tuple[float, ...]
    channels: tuple[str, ...]
    remark: str
    measured: bool = True

    @property
    def full(self) -> str:
        """Its name with that of its section."""
        return f"{self.section}.{self.name}".strip(".")

    def _summary(self) -> str:
        return f"{self.full} = {', '.join(map(number, self.values))} {self.unit}"


@dataclass(frozen=True, eq=False)
class Content:
    """What a file says: comments, fields, and for targets that take whole models the axes; `rate` in Hz.

    `inflate` is a factor on the coefficients of whole models; the fields have it already.
    """

    header: tuple[str, ...]
    entries: tuple[Entry, ...]
    axes: tuple[Axis, ...]
    rate: float | None
    inflate: float = 1.0

    def of(self, section: str) -> list[Entry]:
        """The fields of one section."""
        return [entry for entry in self.entries if entry.section == section]


def one_line(text: str) -> str:
    r"""Text that stays on its line and shows what it holds: line breaks and other control characters as escapes.

    Names come from the recording: what follows a line break in one would be a line of the file.

    Examples
    --------
    >>> print(one_line("gx\nkey: 1"))
    gx\nkey: 1
    """
    if text.isprintable():  # so that a phrase stays one
        return text
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def number(value: float) -> str:
    """A number with all its digits and a point, without which YAML reads 1e-05 as text and ROS an integer.

    Examples
    --------
    >>> number(1e-05), number(200), number(0.25)
    ('1.0e-05', '200.0', '0.25')
    """
    text = repr(float(value))
    mantissa, exponent, power = text.partition("e")
    return text if "." in mantissa or not exponent else f"{mantissa}.0e{power}"
