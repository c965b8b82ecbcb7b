"""The regressors of a regression, and the settings of the fit."""

from dataclasses import asdict, dataclass, field
from typing import Any

from allanite.applications.choices import CompensationChoices, FitChoices
from allanite.extending import TERMS, UsageError, Value, described, spelled

from .regressor import TREND

ORDINARY = "QNBK"  # noise terms that may be present if none are named


@described
@dataclass(frozen=True, repr=False)
class FitSettings(FitChoices, Value):
    """How a regression is made.

    Attributes
    ----------
    terms : str
        Noise terms that may be present, for example "NK"; "auto" means QNBK. A ramp is not a noise: see the trend.
    smooth : float
        Length of the Hann window for derivatives, at least 60 s.
    """

    def __post_init__(self) -> None:
        super().__post_init__()
        symbols = self.symbols
        wrong = [s for s in symbols if s not in TERMS or TERMS[s].waveform is not None or TERMS[s].parameters]
        if wrong or not symbols or len(set(symbols)) < len(symbols):
            raise UsageError(f"terms must be different noise terms such as QNBK, not {self.terms!r}; a linear drift "
                             f"is estimated beside the regressors, unless {spelled('--no-trend', 'trend=False')} is "
                             "given")  # fmt: skip

    @property
    def symbols(self) -> str:
        """The noise terms, one letter each."""
        return ORDINARY if self.terms == "auto" else self.terms


@described
@dataclass(frozen=True, repr=False)
class CompensationSettings(CompensationChoices, Value):
    """The regressors and the settings of the fit.

    Attributes
    ----------
    fit : FitSettings
        For files, its noise terms are those of the recipe, unless it names some.
    beside : path or None
        File with the regressors, their units and times; by default the file of the record.
    """

    fit: FitSettings = field(default_factory=FitSettings)

    def __post_init__(self) -> None:
        super().__post_init__()
        named = self.regressors or self.derivative_of
        if self.use is None and not named:
            raise UsageError("name at least one regressor, for example " + spelled("--regressors temp",
                                                                                   "regressors=('temp',)"))  # fmt: skip
        if self.use is not None and named:
            raise UsageError("a saved regression has its own regressors: omit "
                             + spelled("--regressors and --derivative-of", "regressors and derivative_of"))  # fmt: skip
        for names in (self.regressors, self.derivative_of):
            if len(set(names)) < len(names):
                raise UsageError(f"a regressor is named twice: {', '.join(names)}")
        if TREND in self.regressors:
            raise UsageError("a linear drift is estimated beside the regressors, and not subtracted: leave out 'time'")
        if len(set(self.lags)) < len(self.lags):
            raise UsageError(f"lags must be different positive numbers of seconds, not {self.lags!r}")

    def choices(self) -> dict[str, Any]:
        """Plain data, under the names of the command line; the noise terms are the recipe's."""
        own = asdict(self)
        own |= own.pop("fit")
        del own["terms"]
        return {k: list(v) if isinstance(v, tuple) else v for k, v in own.items() if v not in (None, ())}
