"""Results of a compensation of files."""

from dataclasses import dataclass
from typing import Any

from allanite.extending import Curve, DataError, Header, Job, Noise, Record, Recording, RecordResult

from .gain import Gain
from .regression import Regression
from .restricted import FloatArray
from .settings import CompensationSettings


@dataclass(frozen=True, eq=False, repr=False)
class Compensated(RecordResult):
    """A channel before and after its correction; `refusal` says why there is none.

    Attributes
    ----------
    record : Record
    regression : Regression or None
    corrected : Record or None
    before, after : Curve or None
    noise : Noise or None
        Noise of the uncorrected record, assumed by the intervals of `before`.
    gain : Gain or None
        Gain on a record that was not used for the fit.
    alerts : tuple of str
    refusal : str
    """

    regression: Regression | None = None
    corrected: Record | Header | None = None
    before: Curve | None = None
    after: Curve | None = None
    noise: Noise | None = None
    gain: Gain | None = None
    alerts: tuple[str, ...] = ()
    refusal: str = ""

    @property
    def rates(self) -> tuple[FloatArray, FloatArray] | None:
        """Rate before and after, SI; None without a correction, or without samples, which are not stored."""
        if not (isinstance(self.record, Record) and isinstance(self.corrected, Record)):
            return None
        return self.record.rate_values, self.corrected.rate_values


@dataclass(frozen=True, eq=False, repr=False)
class CompensationStudy(Job[Compensated]):
    """The channels that were fitted, and in `applied` those of another file that were corrected."""

    _channel = Compensated

    applied: tuple[Compensated, ...]
    settings: CompensationSettings

    @property
    def regressions(self) -> tuple[Regression, ...]:
        """All that there are."""
        return tuple(channel.regression for channel in self.channels if channel.regression is not None)

    @property
    def corrected(self) -> Recording:
        """The corrected records, of the other file if there is one.

        Raises
        ------
        DataError
            There are none.
        """
        kept = tuple(c.corrected for c in self.applied or self.channels if isinstance(c.corrected, Record))
        if not kept:
            raise DataError("no channel was corrected: there is nothing to write")
        return Recording(kept)

    def choices(self) -> dict[str, Any]:
        """The recipe and the settings that were actually used, as plain data."""
        other = self.provenance.get("applied to")
        return super().choices() | self.settings.choices() | ({"apply_to": other} if other else {})
