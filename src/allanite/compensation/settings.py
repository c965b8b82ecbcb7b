"""What a regression is made of, and how."""

import math
from dataclasses import asdict, dataclass, field
from typing import Any

from allanite.core.errors import UsageError
from allanite.core.plain import Value
from allanite.terms import TERMS

from .regressor import TREND

ORDINARY = "QNBK"
"""Noise terms that may be there where none are named."""


@dataclass(frozen=True, repr=False)
class FitSettings(Value):
    """How a regression is made.

    Attributes
    ----------
    terms : str
        Noise terms that may be there, for example "NK"; "auto" stands for QNBK. A ramp is no noise, see `trend`.
    smooth : float
        Seconds of the Hann window in which a rate of change is taken, 60 or more.
    blocks : int
        Blocks of the cross-validation.
    every : bool
        Keep every column, whether held-back blocks gain from it or not.
    split_gaps : bool
        Where readings are lost, fit the stretches between them, each with its own constant.
    least : float
        Effective samples that a regressor needs.
    """

    terms: str = "auto"
    smooth: float = 60.0
    blocks: int = 5
    every: bool = False
    split_gaps: bool = False
    least: float = 10.0

    def __post_init__(self) -> None:
        symbols = self.symbols
        wrong = [s for s in symbols if s not in TERMS or TERMS[s].waveform is not None or TERMS[s].parameters]
        if wrong or not symbols or len(set(symbols)) < len(symbols):
            raise UsageError(
                f"terms are different noise terms such as QNBK, not {self.terms!r}; a steady drift is estimated with "
                "trend=True (--trend)"
            )
        if not _whole(self.blocks, 3, 50):
            raise UsageError(f"blocks of the cross-validation are a whole number from 3 to 50, not {self.blocks!r}")
        if not (math.isfinite(self.least) and self.least > 0):
            raise UsageError(f"the least number of effective samples is positive, not {self.least!r}")

    @property
    def symbols(self) -> str:
        """The noise terms, one letter each."""
        return ORDINARY if self.terms == "auto" else self.terms


@dataclass(frozen=True, repr=False)
class CompensationSettings(Value):
    """What is fitted on what.

    Attributes
    ----------
    regressors : tuple of str
        Channels whose readings enter in the first power.
    degree : int
        Highest power that may be added.
    lags : tuple of float
        Seconds by which earlier readings may be added.
    rate_of : tuple of str
        Channels whose rate of change enters.
    trend : bool
        Estimate a steady drift along, which is never taken off.
    fit : FitSettings
        For files, its noise terms are those of the recipe, unless it names some.
    beside : path or None
        File that holds the regressors, and says their units and times itself; the file of the record if left out.
    interpolate : bool
        Bring regressors of another time base onto the record's.
    use : path or None
        A saved regression, which is taken instead of a new fit.
    """

    regressors: tuple[str, ...] = ()
    degree: int = 1
    lags: tuple[float, ...] = ()
    rate_of: tuple[str, ...] = ()
    trend: bool = False
    fit: FitSettings = field(default_factory=FitSettings)
    beside: str | None = None
    interpolate: bool = False
    use: str | None = None

    def __post_init__(self) -> None:
        named = self.regressors or self.rate_of
        if self.use is None and not named:
            raise UsageError("name at least one regressor, for example regressors=('temp',) (--regressors temp)")
        if self.use is not None and named:
            raise UsageError(
                "a saved regression (--use) has its own regressors: leave out regressors and rate_of (--regressors, "
                "--rate-of)"
            )
        for names in (self.regressors, self.rate_of):
            if len(set(names)) < len(names):
                raise UsageError(f"a regressor is named twice: {', '.join(names)}")
        if TREND in self.regressors:
            raise UsageError("a steady drift is not taken off; it is estimated along with trend=True (--trend)")
        if not _whole(self.degree, 1, 6):
            raise UsageError(f"a degree is a whole number from 1 to 6, not {self.degree!r}")
        if len(set(self.lags)) < len(self.lags) or not all(math.isfinite(lag) and lag > 0 for lag in self.lags):
            raise UsageError(f"lags are different positive numbers of seconds, not {self.lags!r}")

    def choices(self) -> dict[str, Any]:
        """Plain data, under the names of the command line; the noise terms are the recipe's."""
        own = asdict(self)
        own |= own.pop("fit")
        del own["terms"]
        return {k: list(v) if isinstance(v, tuple) else v for k, v in own.items() if v not in (None, ())}


def _whole(value: object, low: int, high: int) -> bool:
    """Whether it is a whole number from `low` to `high`."""
    return isinstance(value, int) and not isinstance(value, bool) and low <= value <= high
