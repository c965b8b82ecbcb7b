"""Stage: a quantizer in the signal path, the noise that it adds, clipping, and which of its codes occur."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from allanite.extending import (
    DataError,
    Record,
    UnitError,
    UsageError,
    Value,
    convert,
    say,
    say_count,
    signal_with,
    unit_of,
    windowing,
)

FloatArray = NDArray[np.float64]

MAX_CLIPPED = 1e-3  # share of clipped samples above which noise coefficients are meaningless
MAX_OFF_GRID = 0.05  # distance from the grid, in steps, up to which a reading printed with rounding lies on it

MIN_OCCURRENCES = 20
"""Occurrences of the codes on both sides of one that never occurs, from which it is missing: by chance once in 1e8."""

MAX_CODES = 1 << 24  # codes between the least and the largest up to which they are counted out


@dataclass(frozen=True, repr=False)
class Stage(Value):
    """A converter or register of so many bits over -full_scale to +full_scale.

    What it rounds is a rate, or what is proportional to one (A, V): its rounding errors are white rate noise; or
    an angle (velocity), whose rounding errors are quantization noise.

    Attributes
    ----------
    name : str
    bits : int
    full_scale : float
    unit : str
        Of the full scale.
    gain : float
        Gain before the stage.

    Raises
    ------
    UsageError
        A number is not positive.
    UnitError
        The unit is that of no signal, and of no integral of one.

    Examples
    --------
    >>> Stage("ADC", 12, 5.0, "V").step
    0.00244140625
    >>> str(Stage.parse("ADC 12 5V"))
    'ADC, 12 bits over +-5 V'

    A gain before it makes its steps smaller, referred to the signal.

    >>> Stage.parse("ADC 12 5V gain=10").step
    0.000244140625
    """

    _also = ("step",)

    name: str
    bits: int
    full_scale: float
    unit: str
    gain: float = 1.0

    def __post_init__(self) -> None:
        if isinstance(self.bits, bool) or not isinstance(self.bits, (int, np.integer)) or not 1 <= self.bits <= 64:
            raise UsageError(f"the bits of {self.name!r} must be a whole number from 1 to 64, not {self.bits!r}")
        if not (math.isfinite(self.full_scale) and self.full_scale > 0):
            raise UsageError(f"the full scale of {self.name!r} must be a positive number, not {self.full_scale!r}")
        if not (math.isfinite(self.gain) and self.gain > 0):
            raise UsageError(f"the gain before {self.name!r} must be a positive number, not {self.gain!r}")
        dimension = unit_of(self.unit).dimension
        signals = signal_with(dimension), signal_with(dimension, 1)
        if not (signals[0] or (signals[1] and signals[1].inertial)):
            raise UnitError(
                f"the full scale of {self.name!r} is in {self.unit!r} instead of a unit of rate, angle, current or "
                "voltage"
            )

    @classmethod
    def parse(cls, text: str) -> "Stage":
        """A stage as it is written on the command line: name, bits, full scale with its unit, gain before it."""
        whole, _, gain = text.partition("gain=")
        name, bits, scale = ([*whole.split(maxsplit=2), "", "", ""])[:3]
        number = scale.lstrip("+-±").strip()
        at = next((i for i, c in enumerate(number) if not (c.isdigit() or c in ".eE-+")), len(number))
        at -= number[:at][-1:] in ("e", "E")
        try:
            return cls(name, int(bits), float(number[:at]), number[at:].strip() or "1", float(gain or 1))
        except (UsageError, UnitError):
            raise
        except ValueError:
            raise UsageError(
                "a stage is a name, its bits and its full scale with a unit, e.g. 'ADC 12 5V' or 'output 16 "
                f"100deg/s', and the gain before it, e.g. 'ADC 12 5V gain=10', not {text!r}"
            ) from None

    @property
    def text(self) -> str:
        """As `parse` reads it; blanks in the name become underscores."""
        gain = "" if self.gain == 1 else f" gain={self.gain!r}"
        return f"{'_'.join(self.name.split())} {self.bits} {self.full_scale!r} {self.unit}{gain}"

    @property
    def reach(self) -> float:
        """Full scale of the signal before the gain, in `unit`."""
        return self.full_scale / self.gain

    @property
    def step(self) -> float:
        """Worth of the last bit of the signal before the gain, in `unit`."""
        return float(2.0 * self.reach / 2.0**self.bits)

    @property
    def rounds_angle(self) -> bool:
        """Whether it rounds the integral of a rate."""
        return signal_with(unit_of(self.unit).dimension) is None

    def __str__(self) -> str:
        told = say_count(self.bits, "{name}, {count} bit over +-{full_scale:g} {unit}",
                         "{name}, {count} bits over +-{full_scale:g} {unit}", name=self.name,
                         full_scale=self.full_scale, unit=self.unit)  # fmt: skip
        return told if self.gain == 1 else say("{stage}, behind a gain of {gain:g}", stage=told, gain=self.gain)


def limits_of(record: Record, stage: Stage) -> tuple[float, float] | None:
    """Samples of the record at and beyond which they are clipped; None if the stage is not in the record's unit."""
    # A converter's largest code represents the full scale less one step, or less half a step, its smallest for the
    # negative full scale, or that plus half a step.
    worth = 1.0 if record.scale is None else record.scale
    if record.signal.name == "dimensionless":
        half = 2.0 ** (stage.bits - 1)
        return (-half + 0.51) / worth, (half - 1.01) / worth
    if unit_of(stage.unit).dimension != unit_of(record.unit).dimension:
        return None
    scale, step = (convert(v, stage.unit, record.unit) / worth for v in (stage.reach, stage.step))
    return -scale + 0.51 * step, scale - 1.01 * step


def demand_unclipped(record: Record, stage: Stage) -> int:
    """How many samples lie at the ends of the stage's range."""
    limits = limits_of(record, stage)
    if limits is None:
        return 0
    values = record.values
    with np.errstate(invalid="ignore"):
        count = int(((values <= limits[0]) | (values >= limits[1])).sum())
    if count > MAX_CLIPPED * values.size:
        raise DataError(say("{clipped} of {samples} samples of {name!r} ({percent:.2g} %) are clipped at the ends of "
                            "{stage}: values beyond are missing, and the noise comes out too small. Use a larger "
                            "range, or a window without them ({option})", clipped=count, samples=values.size,
                            name=record.name, percent=100 * count / values.size, stage=str(stage),
                            option=windowing()))  # fmt: skip
    return count


@dataclass(frozen=True, repr=False)
class Codes(Value):
    """How many different codes occur, between how many there are, and how many are missing among frequent ones."""

    distinct: int
    span: int
    missing: int


def codes(readings: FloatArray) -> Codes | None:
    """Codes of samples in steps, which may share an offset; None if they lie on no grid of one step."""
    x = readings[np.isfinite(readings)]
    if not x.size:
        return None
    x = x - x[0]
    grid = np.rint(x)
    if np.mean(np.abs(x - grid) > MAX_OFF_GRID) > 1e-3 or np.ptp(grid) > MAX_CODES:
        return None
    count = np.bincount((grid - grid.min()).astype(np.int64))
    occurring = np.flatnonzero(count)
    gaps = np.diff(occurring) - 1
    beside = np.minimum(count[occurring[:-1]], count[occurring[1:]])
    return Codes(occurring.size, count.size, int(gaps[beside >= MIN_OCCURRENCES].sum()))
