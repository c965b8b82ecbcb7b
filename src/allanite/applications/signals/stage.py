"""A quantizer in the signal path, the noise that it adds, its clipping and codes; rates from a torquer's current."""

import math
from dataclasses import dataclass, fields

import numpy as np

from allanite.extending import (  # isort: skip
    POSITIVE, DataError, FloatArray, Record, UnitError, UsageError, Value, constructed, convert, join, public, say,
    say_count, signal_with, spelled, unit_of, windowing)  # fmt: skip

MAX_CLIPPED = 1e-3  # share of clipped samples above which noise coefficients are meaningless
MAX_OFF_GRID = 0.05  # distance from the grid, in steps, up to which a reading printed with rounding lies on it

MIN_OCCURRENCES = 20
"""Occurrences of the codes on both sides of one that never occurs, from which it is missing: by chance once in 1e8."""

MAX_CODES = 1 << 24  # codes between the least and the largest up to which they are counted out


@constructed
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
        if not 1 <= self.bits <= 64:
            raise UsageError(f"the bits of {self.name!r} must be a whole number from 1 to 64, not {self.bits!r}")
        positive(self.full_scale, f"full scale of {self.name!r}")
        positive(self.gain, f"gain before {self.name!r}")
        dimension = unit_of(self.unit).dimension
        signals = signal_with(dimension), signal_with(dimension, 1)
        if not (signals[0] or (signals[1] and signals[1].inertial)):
            raise UnitError(f"the full scale of {self.name!r} is in {self.unit!r} instead of a unit of rate, angle, "
                            "current or voltage")  # fmt: skip

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
        except UsageError:
            raise
        except ValueError:
            raise UsageError("a stage is a name, its bits and its full scale with a unit, e.g. 'ADC "
                             "12 5V' or 'output 16 100deg/s', and the gain before it, e.g. 'ADC 12 5V gain=10', not "
                             f"{text!r}") from None  # fmt: skip

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


def demand_in_range(record: Record, stage: Stage) -> int:
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


@constructed
@dataclass(frozen=True, repr=False)
class TorqueScale(Value):
    r"""Scale factor of a Lorentz-force torquer: the rate that a current means.

    The torque of the coils, k_L n B L l_m i, turns the angular momentum J_z Omega of the rotor at the rate w, so that
    w = K_i i with

        K_i = k_L n B L l_m / (J_z Omega)        rad/s per A.

    Attributes
    ----------
    turns : float
        n, of a coil.
    field : float
        B at the coils, T.
    span : float
        L, length of a coil side in the field, m.
    radius : float
        l_m, of the torquer, m.
    inertia : float
        J_z, polar moment of inertia of the rotor, kg m^2.
    spin : float
        Omega, rotor speed, rad/s.
    sides : float
        k_L: active coil sides of an axis, or twice as many where two coils push; 1 if the other constants hold for all
        of them together.

    Raises
    ------
    UsageError
        A constant is not a positive number.

    References
    ----------
    Technical equation of the gyro and force of the Lorentz-force magnetic bearing, as for the magnetically suspended
    control and sensing gyro (Ren, Chen et al., IEEE Trans. Ind. Electron. 65 (2018) 4921).

    Examples
    --------
    >>> scale = TorqueScale(turns=100, field=0.4, span=0.05, radius=0.05, inertia=2e-3, spin=1000.0, sides=4)
    >>> round(scale.factor, 12)
    0.2
    """

    _also = ("factor",)

    turns: float
    field: float
    span: float
    radius: float
    inertia: float
    spin: float
    sides: float = 1.0

    def __post_init__(self) -> None:
        for constant in fields(self):
            positive(getattr(self, constant.name), f"{constant.name} of a torquer")

    @classmethod
    def parse(cls, text: str) -> "TorqueScale":
        """The constants as they are written on the command line: ``turns=100,field=0.4,...``."""
        constants: dict[str, float] = {}
        for part in text.split(","):
            name, _, number = (word.strip() for word in part.partition("="))
            try:
                constants[name] = float(number)
            except ValueError:
                raise UsageError("a constant of the torquer is a name and a number, e.g. turns=100, not "
                                 f"{part!r}") from None  # fmt: skip
        known = [constant.name for constant in fields(cls)]
        missing = [name for name in known[:-1] if name not in constants]
        strange = [name for name in constants if name not in known]
        if missing or strange:
            named = (("missing", missing), ("unknown", strange))
            wrong = "; ".join(f"{what} {', '.join(names)}" for what, names in named if names)
            raise UsageError(f"a torquer needs {', '.join(known)} ({wrong})")
        return cls(**constants)

    @property
    def text(self) -> str:
        """As `parse` reads it."""
        return ",".join(f"{constant.name}={float(getattr(self, constant.name))!r}" for constant in fields(self))

    @property
    def factor(self) -> float:
        """K_i, rad/s per A."""
        force = self.sides * self.turns * self.field * self.span  # N per A
        return force * self.radius / (self.inertia * self.spin)

    def __str__(self) -> str:
        return say("K_i = {factor:.6g} rad/s per A", factor=self.factor)


@public
def rate_from_current(
    record: Record, scale: TorqueScale | float, *, sense: float | None = None, stage: Stage | None = None
) -> Record:
    """The rate record that a record of a torquer's current means.

    Parameters
    ----------
    record : Record
        The current (A, mA); or the voltage of a sense resistor or amplifier, with `sense`; or the codes of a converter
        (unit "1"), with its `stage`.
    scale : TorqueScale or float
        The torquer, or rad/s per A.
    sense : float, optional
        V per A.
    stage : Stage, optional
        The converter: its full scale says which samples are clipped, and what a code is worth.

    Returns
    -------
    Record
        Rate in rad/s, with what was done in its history. NaN stays NaN.

    Raises
    ------
    UsageError
        A constant is not positive, or one that is needed is missing.
    DataError
        More than 0.1 % of the samples are clipped.

    Examples
    --------
    >>> current = Record([1.0, -2.0, 0.5], rate=1000.0, unit="mA", name="ix")
    >>> rate = rate_from_current(current, 0.2)
    >>> rate.values.round(12).tolist(), rate.unit, rate.history
    ([0.0002, -0.0004, 0.0001], 'rad/s', ('rate from current: 0.2 rad/s per A',))
    """
    clipped = 0 if stage is None else demand_in_range(record, stage)
    return converted(record, factor_of(scale), ampere_of(record, sense, stage), clipped)


def converted(record: Record, factor: float, ampere: tuple[float, str], clipped: int) -> Record:
    """The rate of a current, once its clipped samples have been counted; `ampere` is that of `ampere_of`."""
    per_unit, source = ampere
    words = say("rate from {source}: {factor:.6g} rad/s per A", source=source, factor=factor)
    if clipped:
        words = join(", ", (words, say_count(clipped, "{count} reading clipped", "{count} readings clipped")))
    readings = record.values if record.kind == "count" else np.asarray(record.values, dtype=np.float64)
    worth = 1.0 if record.scale is None else record.scale
    return Record(readings * (worth * per_unit * factor), record.rate, "rad/s", name=record.name, start=record.start,
                  history=(*record.history, words))  # fmt: skip


def ampere_of(record: Record, sense: float | None, stage: Stage | None) -> tuple[float, str]:
    """A per unit of the samples, and where that is known from."""
    if record.signal.name in ("current", "voltage"):
        per = unit_of(record.unit).factor / gain_of(record.unit, sense)
        current = record.signal.name == "current"
        return per, say("current") if current else say("voltage at {sense:g} V per A", sense=sense)
    if record.signal.name == "dimensionless" and stage is not None:
        if not electric(stage.unit):
            raise UsageError(f"converting codes to a current needs a full scale in A or V, not in {stage.unit}")
        per = stage.step * unit_of(stage.unit).factor / gain_of(stage.unit, sense)
        return per, say("codes of {stage}", stage=str(stage))
    raise UsageError(f"{record.name!r} is in {record.unit!r}: a rate is computed from a current (A), from a voltage "
                     "(V) with the gain of its sensor in V per A, or from codes (unit '1') with the bits and full "
                     "scale of their converter")  # fmt: skip


def electric(unit: str) -> bool:
    """Whether a unit is that of a current or a voltage."""
    return unit_of(unit).dimension in (unit_of("A").dimension, unit_of("V").dimension)


def gain_of(unit: str, sense: float | None) -> float:
    """V per A of the sensor where the unit is that of a voltage; 1 for a current."""
    if unit_of(unit).dimension != unit_of("V").dimension:
        return 1.0
    if sense is None:
        raise UsageError("converting a voltage to a current needs the gain of its sensor in V per A: pass "
                         + spelled("--sense 0.5", "sense=0.5"))  # fmt: skip
    return positive(sense, "sense gain", "V per A")


def factor_of(scale: TorqueScale | float) -> float:
    """Rate of a current, rad/s per A."""
    return scale.factor if isinstance(scale, TorqueScale) else positive(scale, "scale", "rad/s per A")


def positive(value: float, what: str, unit: str = "") -> float:
    """`value`, once it is found to be a positive number."""
    if not (math.isfinite(value) and value > 0):
        raise UsageError(f"the {what} must be a positive number{f' of {unit}' * bool(unit)}, not {value!r}")
    return float(POSITIVE.demand(value, f"the {what}"))
