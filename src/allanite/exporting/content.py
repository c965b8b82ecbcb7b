"""Content: what a file says, before it has a form, and the noise of the axes that it is made of."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from allanite.core.curve import Curve
from allanite.core.estimate import Estimate
from allanite.core.fit import Fit
from allanite.core.plain import Value
from allanite.core.readings import Readings
from allanite.phrases.phrase import say


@dataclass(frozen=True, eq=False)
class Axis:
    """The noise of one axis.

    Attributes
    ----------
    name : str
        Name of the channel; empty for a given model.
    fit : Fit
    rate : float or None
        Sampling rate, Hz.
    doubt : str
        Why the coefficients are not to be used; empty if the model explains the record.
    readings : Readings or None
    level : float
        Confidence level of the intervals.
    alerts : tuple of str
    curve : Curve or None
        The measured Allan deviation, with intervals.
    source : dict
        Name and digest of its file.
    """

    name: str
    fit: Fit
    rate: float | None = None
    doubt: str = ""
    readings: Readings | None = None
    level: float = 0.95
    alerts: tuple[str, ...] = ()
    curve: Curve | None = None
    source: Mapping[str, str] = field(default_factory=dict)

    @property
    def sensor(self) -> str:
        """Type of sensor."""
        return self.fit.signal.name

    @property
    def label(self) -> str:
        """Its name, also of a given model."""
        return self.name or (say("given gyro") if self.sensor == "gyro" else say("given accelerometer"))

    def estimate(self, symbol: str) -> Estimate | None:
        """The estimate of a term; None if it was not looked for."""
        return next((e for e in self.fit if e.symbol == symbol), None)


def by_sensor(axes: Sequence[Axis]) -> dict[str, list[Axis]]:
    """The axes of each sensor."""
    return {sensor: [a for a in axes if a.sensor == sensor] for sensor in dict.fromkeys(a.sensor for a in axes)}


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
    covers : bool
        Whether the value is that of a model that covers what was identified.
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
    covers: bool = False

    @property
    def full(self) -> str:
        """Its name with that of its section."""
        return f"{self.section}.{self.name}".strip(".")

    def _summary(self) -> str:
        return f"{self.full} = {', '.join(map(number, self.values))} {self.unit}"


@dataclass(frozen=True, eq=False)
class Content:
    """What a file says: comments, fields, and for targets that take whole models the axes; `rate` in Hz.

    Comments and names are as the recording has them: a form writes them by the `Syntax` of its file.
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
