"""ThermalTarget: an autopilot that takes temperature polynomials, as a row of data."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from allanite.core.errors import UsageError
from allanite.phrases.phrase import spelled

from .layouts import LineLayout
from .target import Target

if TYPE_CHECKING:
    from allanite.applications.compensation.regressor import Regressor


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
            raise UsageError(
                f"{self.program} takes the powers of one temperature, not {', '.join(wrong)} as well; fit the "
                "temperature of the sensor alone, for example " + spelled("--regressors temp", "regressors=('temp',)")
            )
        most = max((r.power for r in kept), default=1)
        if most > self.order:
            raise UsageError(
                f"{self.program} takes powers up to {self.order}, not {most}: "
                + spelled(f"--degree {self.order}", f"degree={self.order}")
            )

    @property
    def program(self) -> str:
        """The first word of its name: that of the autopilot."""
        return self.name.partition("-")[0]

    def prefix(self, sensor: str, instance: int | None = None) -> str:
        """What the names of the fields of a sensor begin with."""
        chosen = next(iter(self.prefixes)) if instance is None else instance
        if chosen not in self.prefixes:
            raise UsageError(
                f"{self.program} numbers its sensors from {min(self.prefixes)} to {max(self.prefixes)}; there is no "
                + spelled(f"--instance {chosen}", f"instance={chosen}")
            )
        return self.prefixes[chosen].format(sensor=self.letters[sensor])
