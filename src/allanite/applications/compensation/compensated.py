"""Results of a compensation of files."""

import math
from dataclasses import dataclass
from typing import Any

from allanite.extending import (
    Curve,
    DataError,
    Header,
    Job,
    Noise,
    Record,
    Recording,
    RecordResult,
    join,
    say,
    unit_of,
)

from .gain import Gain
from .order import Order
from .regression import Regression
from .regressor import SIGNIFICANT
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
    orders : tuple of Order
        What higher powers than were asked for would remove.
    """

    regression: Regression | None = None
    corrected: Record | Header | None = None
    before: Curve | None = None
    after: Curve | None = None
    noise: Noise | None = None
    gain: Gain | None = None
    alerts: tuple[str, ...] = ()
    refusal: str = ""
    orders: tuple[Order, ...] = ()

    @property
    def rates(self) -> tuple[FloatArray, FloatArray] | None:
        """Rate before and after, SI; None without a correction, or without samples, which are not stored."""
        if not (isinstance(self.record, Record) and isinstance(self.corrected, Record)):
            return None
        return self.record.rate_values, self.corrected.rate_values

    @property
    def further(self) -> list[Order]:
        """The higher powers that are significant, p being multiplied by the number of those examined."""
        return [o for o in self.orders if o.p * len(self.orders) < SIGNIFICANT]

    @property
    def prospect(self) -> str:
        """What higher powers would remove, as a sentence; empty if none was examined."""
        if not self.orders or self.regression is None:
            return ""
        regressor, unit = self.regression.regressors[0], self.record.signal.sheet[0]
        scale, (low, high) = unit_of(unit).factor, regressor.span or (math.nan, math.nan)
        if found := self.further:
            numbers = ((o.power, o.rms / scale, o.low / scale, o.high / scale) for o in found)
            sizes = [f"{regressor.channel}^{n} {rms:.3g} ({a:.3g} .. {b:.3g}) {unit}" for n, rms, a, b in numbers]
            held = self.regression.held
            gained = held is None or any((o.explained or math.inf) > held.explained for o in found)
            taken = say("higher powers would remove more: {sizes}, RMS over {low:.4g} to {high:.4g} {degrees}",
                        sizes=", ".join(sizes), low=low, high=high, degrees=regressor.unit)  # fmt: skip
            return join("; ", (taken, *([] if gained else [say("cross-validation does not gain from them")])))
        powers, most = ", ".join(str(o.power) for o in self.orders), max(o.high for o in self.orders) / scale
        return say("powers {powers} would remove at most {most:.2g} {unit}, RMS over {low:.4g} to {high:.4g} {degrees}",
                   powers=powers, most=most, unit=unit, low=low, high=high, degrees=regressor.unit)  # fmt: skip


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
        """The corrected records, of the other file if there is one."""
        kept = tuple(c.corrected for c in self.applied or self.channels if isinstance(c.corrected, Record))
        if not kept:
            raise DataError("no channel was corrected: there is nothing to write")
        return Recording(kept)

    def choices(self) -> dict[str, Any]:
        """The recipe and the settings that were actually used, as plain data."""
        other = self.provenance.get("applied to")
        return super().choices() | self.settings.choices() | ({"apply_to": other} if other else {})
