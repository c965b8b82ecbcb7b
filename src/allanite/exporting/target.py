"""Target: a program that takes noise coefficients, as a row of data: its fields, their formulas, its file."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from allanite.core.errors import UsageError
from allanite.core.syntax import YAML
from allanite.core.units import unit_of
from allanite.phrases.phrase import say, spelled
from allanite.terms import TERMS

from .content import LineLayout

if TYPE_CHECKING:
    from allanite.applications.compensation.regressor import Regressor

    from .content import Content


GYRO, ACCELEROMETER = "gyro", "accelerometer"

LONG = 360_000.0  # correlation time, s, with which a Gauss-Markov process replaces a random walk: 100 h


@dataclass(frozen=True)
class TargetField:
    """A field of a target: its value is (coefficient sqrt(weight f^rate T^time))^power, in `unit`."""

    name: str  # as the target spells it
    sensor: str  # One of "gyro", "accelerometer"
    term: str  # symbol of the coefficient; empty if the field is a power of the correlation time alone
    unit: str
    weight: float = 1.0
    # rate, time: powers of the rate f, Hz, and of the correlation time T, s, under the root
    rate: int = 0
    time: int = 0
    power: int = 1
    section: str = ""  # key of the part of the file that holds the field; empty if names are unique
    span: tuple[float, float] = (0.0, math.inf)  # values that the target accepts, in `unit`
    needed: bool = True  # whether the file is useless without it

    def value(self, coefficient: float, rate: float, time: float) -> float:
        """The value for a coefficient in SI, at a rate in Hz, with a correlation time in s."""
        return float((coefficient * self._root(rate, time)) ** self.power / unit_of(self.unit).factor)

    def coefficient(self, value: float, rate: float, time: float) -> float:
        """The coefficient in SI of a value; the inverse of `value`."""
        return float((value * unit_of(self.unit).factor) ** (1 / self.power) / self._root(rate, time))

    def _root(self, rate: float, time: float) -> float:
        return math.sqrt(self.weight * rate**self.rate * time**self.time)

    @property
    def full(self) -> str:
        """Its name with that of its section."""
        return f"{self.section}.{self.name}".strip(".")

    @property
    def absent(self) -> str:
        """That it is not written, for there is no such sensor."""
        if self.sensor == GYRO:
            return say("{field} is not written: no gyro", field=self.full)
        return say("{field} is not written: no accelerometer", field=self.full)

    @property
    def formula(self) -> str:
        """How the value follows from the coefficient: ``N sqrt(2 f)``."""
        if not self.term:
            return "T"
        root = _root_of(self.weight, self.rate, self.time, self.power)
        term = self.term if self.power == 1 else f"{self.term}^{self.power}"
        return f"{term} {root}".strip()

    @property
    def nature(self) -> tuple[str, str, str]:
        """What it is, for what it is mistaken, and the factor by which that is wrong; empty where nothing is known."""
        name, mistake, weight, rate, time = NATURES.get((self.term, self.rate, self.time, self.power), UNKNOWN)
        ratio = weight / self.weight, rate - self.rate, time - self.time
        return name, mistake, _root_of(*ratio, self.power) if mistake else ""


def _root_of(weight: float, rate: int, time: int, power: int) -> str:
    """The power of a root: ``sqrt(2 f)``; empty if it is 1."""
    if not rate and not time:
        return "" if weight == 1 else f"{weight ** (power / 2):.3g}"
    letters = (("f", rate), ("T", time))
    above = [f"{weight:g}"] * (weight > 1) + [letter for letter, power in letters if power > 0]
    below = [f"{1 / weight:g}"] * (weight < 1) + [letter for letter, power in letters if power < 0]
    inner = " ".join(above) or "1"
    inner += f"/{below[0]}" if len(below) == 1 else f"/({' '.join(below)})" if below else ""
    return f"sqrt({inner})" if power == 1 else inner


_DENSITY, _SIGMA, _STEADY = say("density"), say("sigma per sample"), say("steady-state sigma")
_SQUARE, _VARIANCE = say("density squared"), say("variance per sample")

UNKNOWN = "", "", 1.0, 0, 0

NATURES: dict[tuple[str, int, int, int], tuple[str, str, float, int, int]] = {
    ("", 0, 2, 1): (say("correlation time"), "", 1.0, 0, 0), ("N", 0, 0, 1): (_DENSITY, _SIGMA, 1.0, 1, 0),
    ("N", 1, 0, 1): (_SIGMA, _DENSITY, 1.0, 0, 0), ("N", 0, 0, 2): (_SQUARE, _VARIANCE, 1.0, 1, 0),
    ("N", 1, 0, 2): (_VARIANCE, _SQUARE, 1.0, 0, 0), ("K", 0, 0, 1): (_DENSITY, _STEADY, 0.5, 0, 1),
    ("K", 1, 0, 1): (say("sigma of the rate of the bias"), _DENSITY, 1.0, 0, 0),
    ("K", 0, 1, 1): (_STEADY, _DENSITY, 1.0, 0, 0), ("K", 0, 0, 2): (_SQUARE, say("variance of a step"), 1.0, -1, 0),
    ("B", 0, 0, 1): (say("level of flicker"), say("minimum of the curve"), 2 * math.log(2) / math.pi, 0, 0),
}  # fmt: skip
"""By term and powers of rate, time and value: what a field is, what is written instead, and weight and powers of it."""


Write = Callable[["Content"], str | bytes]  # makes the file from its content


@dataclass(frozen=True)
class Target:
    """A row of `EXPORTS`."""

    # name, title: name at the command line, and what it is
    name: str
    title: str
    fields: tuple[TargetField, ...]  # empty for a target that takes whole models
    forms: Mapping[str, Write]  # the forms of its file, the usual one first
    source: str  # where names and formulas come from, and what could not be verified
    notes: tuple[str, ...] = ()  # what users must know; written into the file
    # interval of the filter's steps, s, if the target has its own; otherwise that of the samples
    step: float | None = None
    rated: bool = False  # whether the file states the sampling rate
    # whether an identified Gauss-Markov process may replace a random walk that was not: each sensor has its own
    # correlation time
    markov: bool = False
    each: bool = False  # whether its fields take a value for each axis
    comments: str = YAML.pattern  # regular expression of comments in its file
    inflatable: bool = True  # whether its coefficients may be multiplied by a factor
    simulates: bool = False  # whether it simulates the noise of its file, and does not filter with it
    synonyms: tuple[str, ...] = ()  # other names by which it is asked for; they are suggested, not taken

    @property
    def sensors(self) -> tuple[str, ...]:
        """The sensors without which the file is useless."""
        return tuple(dict.fromkeys(field.sensor for field in self.fields if field.needed))

    @property
    def drifts(self) -> bool:
        """Whether it has a field for slow noise."""
        return any(field.term and TERMS[field.term].slope >= 0 for field in self.fields)

    def rate(self, sampling: float | None, given: float | None) -> float | None:
        """The rate in the formulas: as given, the target's own, or that of the samples, in this order."""
        return given or (1 / self.step if self.step else sampling)

    def form(self, suffix: str) -> str:
        """The suffix of the form to write for a path with this suffix."""
        if suffix in self.forms or not suffix or len(self.forms) == 1:
            return suffix if suffix in self.forms else next(iter(self.forms))
        raise UsageError(f"{self.name} is written as {', '.join(self.forms)}, not as {suffix!r}")


def pair(gyro: str, accelerometer: str, like: TargetField, unit: str, **own: Any) -> tuple[TargetField, TargetField]:
    """The fields of both sensors for one term: names, that of the gyro without its name, the accelerometer's unit."""
    return replace(like, name=gyro), replace(like, name=accelerometer, sensor=ACCELEROMETER, unit=unit, **own)


def sectioned(gyro: str, accelerometer: str, *fields: tuple[str, TargetField, str]) -> tuple[TargetField, ...]:
    """Fields with the same names in the sections of both sensors: name, that of the gyro, the accelerometer's unit."""
    own, other = zip(*(pair(name, name, like, unit) for name, like, unit in fields), strict=True)
    return *(replace(f, section=gyro) for f in own), *(replace(f, section=accelerometer) for f in other)


DENSITY = TargetField("", GYRO, "N", "rad/s/sqrt(Hz)"), "m/s^2/sqrt(Hz)"
"""A field that is N itself, in SI, and its unit for accelerometers."""

WALK = TargetField("", GYRO, "K", "rad/s^2/sqrt(Hz)"), "m/s^3/sqrt(Hz)"
"""A field that is K itself, in SI, and its unit for accelerometers."""

TIME = TargetField("", GYRO, "", "s", time=2), "s"  # a field that is a correlation time


def demand_rate(target: Target, rate: float | None) -> None:
    """Check that a target that needs the sampling rate gets it."""
    needed = target.rated or (target.step is None and any(field.rate for field in target.fields))
    if needed and rate is None:
        raise UsageError(f"{target.name} needs the sampling rate: {spelled('--rate HZ', 'rate=...')}, since its "
                         "fields are discrete or its file states it")  # fmt: skip


@dataclass(frozen=True)
class ThermalTarget(Target):
    """A row of `TEMPERATURE`: an autopilot that subtracts sum_k c_k (T - T0)^k in SI units, T within a range."""

    forms: Mapping[str, LineLayout]
    # template of what the names of the fields of each sensor begin with, with `sensor`; the usual instance first
    prefixes: Mapping[int, str] = field(default_factory=dict)
    letters: Mapping[str, str] = field(default_factory=dict)
    coefficient: str = ""  # template of the rest of the name of a coefficient, with `sensor`, `power` and `axis`
    axes: tuple[str, ...] = ()  # names of the axes x, y and z
    order: int = 3  # highest power
    reference: float | None = None  # T0, degC; None if it is a field, for the middle of the range
    # whether c_0 has a field; otherwise the correction is zero at the temperature of the autopilot's calibration
    constant: bool = True
    scale: float = 1.0  # factor on the coefficients
    together: bool = False  # whether the sensors of an instance share the range
    enable: str = ""  # line that enables the correction, a template with `prefix` and `sensor`

    def demand(self, regressors: "Iterable[Regressor]") -> None:
        """Refuse what is no polynomial in one temperature, or one of too high a degree."""
        kept = [r for r in regressors if not r.is_trend]
        wrong = [r.label for r in kept if r.smooth is not None or r.lag]
        wrong = wrong or [r.label for r in kept if r.channel != kept[0].channel][:1]
        if wrong:
            raise UsageError(f"{self.program} takes the powers of one temperature, not {', '.join(wrong)} as well; fit "
                             "the temperature of the sensor alone, for example "
                             + spelled("--regressors temp", "regressors=('temp',)"))  # fmt: skip
        most = max((r.power for r in kept), default=1)
        if most > self.order:
            raise UsageError(f"{self.program} takes powers up to {self.order}, not {most}: "
                             + spelled(f"--degree {self.order}", f"degree={self.order}"))  # fmt: skip

    @property
    def program(self) -> str:
        """The first word of its name: that of the autopilot."""
        return self.name.partition("-")[0]

    def prefix(self, sensor: str, instance: int | None = None) -> str:
        """What the names of the fields of a sensor begin with."""
        chosen = next(iter(self.prefixes)) if instance is None else instance
        if chosen not in self.prefixes:
            raise UsageError(f"{self.program} numbers its sensors from {min(self.prefixes)} to {max(self.prefixes)}; "
                             "there is no " + spelled(f"--instance {chosen}", f"instance={chosen}"))  # fmt: skip
        return self.prefixes[chosen].format(sensor=self.letters[sensor])
