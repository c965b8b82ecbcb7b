"""A result about angle sensors, and its provenance."""

from dataclasses import dataclass, field
from typing import Any

from allanite.extending import provenance_of

from .calibration import Calibration
from .harmonics import Harmonics
from .plans import AnglePlan, Scan


@dataclass(frozen=True, eq=False)
class AngleStudy:
    """A result, and its provenance.

    Attributes
    ----------
    result : Harmonics, Calibration, AnglePlan or Scan
    settings : dict
        Every choice as plain data, under the names of the command line.
    level : float
        Confidence level of intervals.
    notes : tuple of str
        Assumptions made when reading.
    provenance : dict
        Version and inputs.
    """

    result: Harmonics | Calibration | AnglePlan | Scan
    settings: dict[str, Any]
    level: float = 0.95
    notes: tuple[str, ...] = ()
    provenance: dict[str, str] = field(default_factory=provenance_of)

    def choices(self) -> dict[str, Any]:
        """The recipe that was actually used, as plain data."""
        own = {key: list(v) if isinstance(v, tuple) else v for key, v in self.settings.items()}
        return dict(sorted((own | {"level": self.level}).items()))

    def to_dict(self) -> dict[str, Any]:
        """Plain data of the result, with the recipe and the provenance."""
        made = {"recipe": self.choices(), "notes": list(self.notes), "provenance": self.provenance}
        return self.result.to_dict(self.level) | made
