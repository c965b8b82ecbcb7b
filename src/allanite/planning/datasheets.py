"""What data sheets print of the noise of gyros and accelerometers, the models that it makes, and typical sensors."""

import csv
import math
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import ClassVar, NamedTuple

from allanite.core.aliases import public
from allanite.core.errors import UsageError
from allanite.core.model import Model, Term, term
from allanite.core.names import demand_name, row_alike
from allanite.core.plain import Value
from allanite.core.readings import FLICKER, ONE_SIDED
from allanite.phrases.phrase import say
from allanite.plugins import Registry
from allanite.simulation.record import RING_LASERS

SENSOR_TYPES = ("gyro", "accelerometer")


class Conversion(NamedTuple):
    """How a quantity becomes a coefficient: value times factor, over sqrt(2 bandwidth) if `bandwidth`."""

    symbol: str
    factor: float
    meaning: str
    bandwidth: bool = False


QUANTITIES: dict[str, Conversion] = {
    "random walk": Conversion("N", 1.0, say("random walk is N")),
    "noise density": Conversion("N", 1 / ONE_SIDED, say("noise density is one-sided: sqrt(2) N")),
    "rms noise": Conversion("N", 1.0, say("rms noise within a bandwidth is N sqrt(2 bandwidth)"), bandwidth=True),
    "bias stability": Conversion("B", FLICKER, say(
        "bias stability is the minimum of the Allan deviation: 0.664 B, or more where N and K contribute")),
    "bias instability": Conversion("B", 1.0, say("bias instability is the minimum of the Allan deviation over 0.664")),
}  # fmt: skip
"""What is printed, and how a coefficient follows from it; of two that give the same coefficient the first is used."""


@dataclass(frozen=True, repr=False)
class Claim(Value):
    """A line of a data sheet."""

    _checks: ClassVar = {"quantity": lambda name: demand_name("quantity", name, QUANTITIES)}

    sensor: str  # One of "gyro", "accelerometer"
    quantity: str  # a key of `QUANTITIES`
    printed: str  # what the document calls it
    value: float
    unit: str
    limit: str = "typical"  # One of "typical", "nominal", "maximum", ""
    conditions: str = ""
    place: str = ""  # page, and table or section
    bandwidth: float | None = None  # noise bandwidth of an rms value, Hz

    @property
    def term(self) -> Term | None:
        """The coefficient that it means; None for an rms value without its bandwidth."""
        how = QUANTITIES[self.quantity]
        if not how.bandwidth:
            return term(how.symbol, self.value * how.factor, self.unit)
        if self.bandwidth is None:
            return None
        return term(how.symbol, self.value * how.factor / math.sqrt(2 * self.bandwidth), f"{self.unit}/sqrt(Hz)")


@dataclass(frozen=True, repr=False)
class DataSheet(Value):
    """What a data sheet prints of noise.

    Attributes
    ----------
    name, maker : str
        Of the sensor.
    document : str
        Its number or title, and its revision.
    claims : tuple of Claim

    Examples
    --------
    >>> sheet = data_sheet_named("adis16470")
    >>> print(sheet.document, "|", sheet.gyro)
    ADIS16470, Rev. C | N = 0.34 deg/sqrt(h), B = 12.04 deg/h
    """

    _also: ClassVar = ("gyro", "accelerometer")

    name: str
    maker: str
    document: str
    claims: tuple[Claim, ...]

    @property
    def gyro(self) -> Model | None:
        """The noise of its gyro; None if it has none."""
        return self.model("gyro")

    @property
    def accelerometer(self) -> Model | None:
        """The noise of its accelerometer; None if it has none."""
        return self.model("accelerometer")

    @property
    def models(self) -> tuple[Model, ...]:
        """The models that there are, that of the gyro first."""
        return tuple(model for model in map(self.model, SENSOR_TYPES) if model is not None)

    def used(self, sensor: str) -> tuple[Claim, ...]:
        """The lines from which the model of a sensor is made, one for each coefficient.

        Typical values are preferred to maxima, quantities are tried in the order of `QUANTITIES`, and of several axes,
        ranges or modes the largest value is used.
        """
        order, claims = list(QUANTITIES), dict[str, Claim]()
        mine = [claim for claim in self.claims if claim.sensor == sensor and claim.term is not None]
        for claim in sorted(mine, key=lambda c: (c.limit == "maximum", order.index(c.quantity), -c.value)):
            claims.setdefault(QUANTITIES[claim.quantity].symbol, claim)
        symbols = dict.fromkeys(how.symbol for how in QUANTITIES.values())
        return tuple(claims[symbol] for symbol in symbols if symbol in claims)

    def model(self, sensor: str) -> Model | None:
        """The noise of a sensor: N and B, where they are printed; None if nothing is."""
        terms = [term for claim in self.used(sensor) if (term := claim.term) is not None]
        return Model(terms) if terms else None


def _own() -> dict[str, DataSheet]:
    """The sheets of the table in this package, whose lines begin with sheet, maker and document."""
    _, *lines = csv.reader(Path(__file__).with_name("datasheets.csv").read_text("utf-8").splitlines())
    return {name: DataSheet(name, maker, document, tuple(_claim(*cells[3:]) for cells in rows))
            for (name, maker, document), rows in groupby(lines, lambda cells: cells[:3])}  # fmt: skip


def _claim(*cells: str) -> Claim:
    sensor, quantity, printed, value, unit, limit, conditions, place, bandwidth = cells
    size = float(bandwidth) if bandwidth else None
    return Claim(sensor, quantity, printed, float(value), unit, limit, conditions, place, size)


DATASHEETS = Registry(_own(), "allanite.datasheets", kind=DataSheet, key="name")  # data sheets by name


@public
def data_sheet_named(name: str) -> DataSheet:
    """The data sheet of a sensor; upper case, hyphens and spaces do not matter.

    Raises
    ------
    UsageError
        There is none; the message names a similar one.

    Examples
    --------
    >>> data_sheet_named("mpu6050").name
    'MPU-6050'
    """
    return row_alike("data sheet", name, DATASHEETS)


def claimed(text: str) -> tuple[Model, ...]:
    """The noise that a data sheet claims: that of its gyro first, or that of the sensor alone that follows its name."""
    name, _, sensor = text.strip().rpartition(" ") if text.strip().endswith(SENSOR_TYPES) else (text, "", "")
    sheet = data_sheet_named(name)
    models = tuple(filter(None, (sheet.model(sensor),))) if sensor else sheet.models
    if not models:
        raise UsageError(f"the data sheet of the {sheet.name} says nothing of the noise of its {sensor or 'sensors'}")
    return models


SENSORS: dict[str, str] = {"mems": "N 0.005 deg/sqrt(s), B 0.002 deg/s, K 3e-4 deg/s/sqrt(s)",
                           "fog": "Q 0.4 arcsec, N 3 deg/h*sqrt(s), B 1 deg/h, K 0.09 deg/h/sqrt(s), R 0.002 deg/h/s",
                           "rlg": "Q 0.5 arcsec, N 0.18 arcsec/sqrt(s), B 0.05 deg/h"}  # fmt: skip
"""Models of typical gyros: MEMS, fiber-optic, ring laser. Orders of magnitude; not of any specific product."""


@public
def sensor(name: str) -> Model:
    """The model of a typical sensor, or of a known ring laser gyro.

    Parameters
    ----------
    name : str
        A key of `SENSORS` or of `RING_LASERS`, in small or capital letters.

    Raises
    ------
    UsageError
        The name is unknown.

    Examples
    --------
    >>> print(sensor("rlg"))
    Q = 0.5 arcsec, N = 0.003 deg/sqrt(h), B = 0.05 deg/h
    """
    known = name.lower()
    if known in RING_LASERS:
        return RING_LASERS[known].model
    demand_name("sensor", known, (*SENSORS, *RING_LASERS))
    return Model(SENSORS[known])
