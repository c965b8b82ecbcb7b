"""A result about angle sensors, and its provenance."""

from dataclasses import dataclass, field
from typing import Any

from allanite.extending import provenance_of

from .calibration import Calibration
from .harmonics import Harmonics
from .plans import AnglePlan, Scan


@dataclass(frozen=True, eq=False)
class AngleStudy:
    """A result, and its provenance."""

    result: Harmonics | Calibration | AnglePlan | Scan
    settings: dict[str, Any]  # every choice as plain data, under the names of the command line
    level: float = 0.95  # confidence level of intervals
    notes: tuple[str, ...] = ()  # assumptions made when reading
    provenance: dict[str, str] = field(default_factory=provenance_of)  # version and inputs

    def choices(self) -> dict[str, Any]:
        """The recipe that was actually used, as plain data."""
        own = {key: list(v) if isinstance(v, tuple) else v for key, v in self.settings.items()}
        return dict(sorted((own | {"level": self.level}).items()))

    def to_dict(self) -> dict[str, Any]:
        """Plain data of the result, with the recipe and the provenance."""
        made = {"recipe": self.choices(), "notes": list(self.notes), "provenance": self.provenance}
        return self.result.to_dict(self.level) | made
