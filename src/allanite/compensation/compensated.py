"""What a compensation of files is made of, and what comes of it."""

from dataclasses import asdict, dataclass, field
from typing import Any

from allanite.core.curve import Curve
from allanite.core.errors import DataError, UsageError
from allanite.core.record import Record, Recording
from allanite.study.channels import Job
from allanite.study.noise import Noise

from .design import DesignSettings
from .fit import FitSettings
from .gain import Gain
from .regression import Regression
from .restricted import FloatArray


@dataclass(frozen=True)
class CompensationSettings(DesignSettings):
    """What is fitted on what.

    Attributes
    ----------
    regressors, degree, lags, rate_of, trend
        As of `compensate`.
    fit : FitSettings
        Its noise terms are those of the recipe, unless it names some.
    beside : path or None
        File that holds the regressors, and says their units and times itself; the file of the record if left out.
    interpolate : bool
        Bring regressors of another time base onto the record's.
    use : path or None
        A saved regression, which is taken instead of a new fit.
    """

    regressors: tuple[str, ...] = ()
    fit: FitSettings = field(default_factory=FitSettings)
    beside: str | None = None
    interpolate: bool = False
    use: str | None = None

    def __post_init__(self) -> None:
        if self.use is None:
            super().__post_init__()
        elif self.regressors or self.rate_of:
            raise UsageError(
                "a saved regression (--use) has its own regressors: leave out regressors and rate_of (--regressors, "
                "--rate-of)"
            )

    def to_dict(self) -> dict[str, Any]:
        """Plain data, under the names of the command line; the noise terms are the recipe's."""
        own = asdict(self)
        own |= own.pop("fit")
        del own["terms"]
        return {k: list(v) if isinstance(v, tuple) else v for k, v in own.items() if v not in (None, ())}


@dataclass(frozen=True, eq=False)
class Compensated:
    """A channel before and after its correction; `refusal` says why there is none.

    Attributes
    ----------
    record : Record
    regression : Regression or None
    corrected : Record or None
    error : array or None
        What was taken off: rate, SI.
    before, after : Curve or None
    noise : Noise or None
        Of the record before, on which the limits of `before` rest.
    gain : Gain or None
        What it brought on a record that was not fitted.
    alerts : tuple of str
    refusal : str
    """

    record: Record
    regression: Regression | None = None
    corrected: Record | None = None
    error: FloatArray | None = None
    before: Curve | None = None
    after: Curve | None = None
    noise: Noise | None = None
    gain: Gain | None = None
    alerts: tuple[str, ...] = ()
    refusal: str = ""

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data; the regression stands once, with the channel it was fitted on."""
        noise = self.noise
        return {
            "name": self.record.name,
            "rate": self.record.rate,
            "size": self.record.size,
            "history": list((self.corrected or self.record).history),
            "before": None if self.before is None else self.before.to_dict(level),
            "after": None if self.after is None else self.after.to_dict(level),
            "fit": None if noise is None else noise.fit.to_dict(level),
            "explained": None if noise is None else noise.explained,
            "gain": None if self.gain is None else self.gain.to_dict() | {"met": self.gain.met},
            "alerts": list(self.alerts),
            "refusal": self.refusal,
        }


@dataclass(frozen=True, eq=False)
class CompensationStudy(Job[Compensated]):
    """The channels that were fitted, and in `applied` those of another file that were corrected."""

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
        kept = tuple(c.corrected for c in self.applied or self.channels if c.corrected is not None)
        if not kept:
            raise DataError("no channel was corrected: there is nothing to write")
        return Recording(kept)

    def choices(self) -> dict[str, Any]:
        """The recipe and the settings that were really used, as plain data."""
        other = self.provenance.get("applied to")
        return super().choices() | self.settings.to_dict() | ({"apply_to": other} if other else {})

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        level = self.recipe.level
        return super().to_dict() | {
            "regressions": [regression.to_dict(level) for regression in self.regressions],
            "applied": [channel.to_dict(level) for channel in self.applied],
        }
