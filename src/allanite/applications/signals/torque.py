"""The rate of a gyro whose rotor is held by a measured force: from the current of its torquer."""

import math
from dataclasses import dataclass, fields

import numpy as np

from allanite.extending import Record, UsageError, Value, join, public, say, say_count, spelled, unit_of

from .stage import Stage, demand_unclipped


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
                raise UsageError(
                    f"a constant of the torquer is a name and a number, e.g. turns=100, not {part!r}"
                ) from None
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
    clipped = 0 if stage is None else demand_unclipped(record, stage)
    return converted(record, factor_of(scale), ampere_of(record, sense, stage), clipped)


def converted(record: Record, factor: float, ampere: tuple[float, str], clipped: int) -> Record:
    """The rate of a current, once its clipped samples have been counted; `ampere` is that of `ampere_of`."""
    per_unit, source = ampere
    words = say("rate from {source}: {factor:.6g} rad/s per A", source=source, factor=factor)
    if clipped:
        words = join(", ", (words, say_count(clipped, "{count} reading clipped", "{count} readings clipped")))
    readings = record.values if record.kind == "count" else np.asarray(record.values, dtype=np.float64)
    worth = 1.0 if record.scale is None else record.scale
    return Record(
        readings * (worth * per_unit * factor), record.rate, "rad/s", name=record.name, start=record.start,
        history=(*record.history, words),
    )  # fmt: skip


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
    raise UsageError(
        f"{record.name!r} is in {record.unit!r}: a rate is computed from a current (A), from a voltage (V) with the "
        "gain of its sensor in V per A, or from codes (unit '1') with the bits and full scale of their converter"
    )


def electric(unit: str) -> bool:
    """Whether a unit is that of a current or a voltage."""
    return unit_of(unit).dimension in (unit_of("A").dimension, unit_of("V").dimension)


def gain_of(unit: str, sense: float | None) -> float:
    """V per A of the sensor where the unit is that of a voltage; 1 for a current."""
    if unit_of(unit).dimension != unit_of("V").dimension:
        return 1.0
    if sense is None:
        raise UsageError(
            "converting a voltage to a current needs the gain of its sensor in V per A: pass "
            + spelled("--sense 0.5", "sense=0.5")
        )
    return positive(sense, "sense gain", "V per A")


def factor_of(scale: TorqueScale | float) -> float:
    """Rate of a current, rad/s per A."""
    return scale.factor if isinstance(scale, TorqueScale) else positive(scale, "scale", "rad/s per A")


def positive(value: float, what: str, unit: str = "") -> float:
    """`value`, once it is found to be a positive number."""
    number = isinstance(value, (int, float, np.number)) and not isinstance(value, bool)
    if not (number and math.isfinite(value) and value > 0):
        raise UsageError(f"the {what} must be a positive number{f' of {unit}' * bool(unit)}, not {value!r}")
    return float(value)
