"""The main job: noise coefficients of every channel with intervals, and the curve that they explain."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Self

from allanite.core.curve import Curve
from allanite.core.datasheet import Entry, data_sheet
from allanite.core.readings import Readings
from allanite.core.record import Record, Recording
from allanite.core.residuals import Residuals, Shared
from allanite.identification.checks.shared import shared
from allanite.statistics import deviation
from allanite.statistics.readings import readings

from .channels import Inspected, Job, Progress, Source, run
from .noise import ChannelResult, noise_of
from .recipe import Recipe


@dataclass(frozen=True, eq=False, repr=False)
class Channel(ChannelResult):
    """Result of one channel, or the reason (`refusal`) why there is none."""

    curves: tuple[Curve, ...] = ()
    readings: Readings | None = None

    @property
    def curve(self) -> Curve | None:
        """The curve that the noise explains."""
        return self.curves[0] if self.curves else None

    @property
    def residuals(self) -> Residuals | None:
        """What the model leaves of the record; None without a model of all frequencies, or by a method without one."""
        return None if self.noise is None else self.noise.residuals

    @property
    def explained(self) -> bool:
        """Whether there is a model, and nothing says that it does not explain the record."""
        return self.noise is not None and self.noise.explained

    @property
    def verdict(self) -> str:
        """Whether the model explains the record, in a sentence; empty where the method does not say."""
        return "" if self.noise is None else self.noise.verdict

    @property
    def alerts(self) -> tuple[str, ...]:
        """What must stand beside its numbers: its warnings, and that the model does not explain it."""
        # what the residuals name is not said twice, nor lines that were taken out or left out of the fit
        settled = {finding.name for finding in self.residuals.findings} if self.residuals else set()
        scope = self.fit.scope if self.fit else None
        met = self.fit is not None and (self.fit.lines or (scope is not None and (scope.masks or scope.limited)))
        settled |= {"lines"} if met and self.explained else set()
        doubts = () if self.noise is None else self.noise.doubts
        return (*doubts, *(str(finding) for finding in self.quality.warnings if finding.name not in settled))

    def to(self, *units: str) -> Self:
        """The same, shown in these units: of the signal (deg/s) or of a coefficient (deg/s/sqrt(Hz))."""
        if self.noise is None:
            return self
        fit = replace(self.noise.fit, estimates=tuple(replace(e, wanted=units) for e in self.noise.fit))
        read = None if self.readings is None else replace(self.readings, wanted=units)
        return replace(self, noise=replace(self.noise, fit=fit), readings=read)

    def data_sheet(self, level: float = 0.95) -> list[Entry]:
        """The quantities and units of data sheets, with limits."""
        return data_sheet(self.fit, self.readings, self.record.rate, level)

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data, with the data sheet."""
        return super().to_dict(level) | {"data_sheet": [entry._asdict() for entry in self.data_sheet(level)]}

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> Self:
        """What `to_dict` has written."""
        found = super().from_dict(data)
        if found.noise is None:
            return found
        return replace(found, noise=replace(found.noise, fit=replace(found.noise.fit, curve=found.curve)))

    def _summary(self) -> str:
        return f"{self.record.name!r}: {self.refusal or (self.fit.model if self.fit else 'not analysed')}"


@dataclass(frozen=True, eq=False, repr=False)
class Study(Job[Channel]):
    """Recording, recipe, and the result of each channel."""

    _channel = Channel

    common: Shared | None = field(default=None, compare=False)
    """What the channels share, where it was read and not worked out."""

    @cached_property
    def shared(self) -> Shared | None:
        """What the channels have in common beyond their models; None where fewer than two can be compared."""
        fits = {c.record.name: c.fit for c in self.channels if c.fit is not None and c.noise and c.noise.leftover}
        records = tuple(c.record for c in self.channels if c.record.name in fits and isinstance(c.record, Record))
        if len(records) < 2 or len({record.size for record in records}) > 1:
            return self.common
        return shared(Recording(records), fits, outliers=self.recipe.outliers or "mark")

    def choices(self) -> dict[str, Any]:
        """The recipe that was really used, as plain data."""
        return self.recipe.to_dict()

    def to_dict(self, level: float | None = None) -> dict[str, Any]:
        """Plain data, with limits at `level`; at the recipe's by default."""
        data = super().to_dict(level)
        del data["common"]
        return data | {"shared": None if self.shared is None else self.shared.to_dict()}

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> "Study":
        """What `to_dict` has written."""
        return super().from_dict({**data, "common": data["shared"]})


def analyze(
    source: Source,
    recipe: Recipe | None = None,
    *,
    progress: Progress | None = None,
) -> Study:
    """The main job: noise coefficients of every channel, with intervals, and the curve they explain.

    Parameters
    ----------
    source : Recording, Record or path
        A path is read with the recipe's options.
    recipe : Recipe, optional
        All choices; the defaults are the ordinary analysis.
    progress : callable, optional
        Called with what is being done and the fraction that is finished.

    Returns
    -------
    Study
        Channels that cannot support the job carry the reason and no numbers.

    Raises
    ------
    DataError
        The file cannot be read, or none of its channels supports the job.
    UsageError
        An option is wrong, or one that is needed is missing.
    """
    recipe = recipe or Recipe()

    def work(seen: Inspected) -> Channel:
        noise = noise_of(seen.record, recipe)
        curve = deviation(seen.record, recipe.statistic, taus=recipe.taus, noise=noise.fit)
        noise = replace(noise, fit=replace(noise.fit, curve=curve))
        usual = curve.statistic == "oadev" and recipe.taus == "log"
        read = readings(seen.record, curve if usual else None)
        return Channel(seen.record, seen.quality, noise, curves=(curve,), readings=read).to(*(recipe.to or ()))

    return run(Study, source, recipe, work, Channel.refused, progress=progress)


def examine(source: Source, recipe: Recipe | None = None, *, progress: Progress | None = None) -> Study:
    """What is in a recording, and whether it is fit for the job: a study without numbers.

    Parameters, errors and result are those of `analyze`; no channel has a curve or a fit.
    """
    recipe = recipe or Recipe()
    return run(
        Study, source, recipe, lambda seen: Channel(seen.record, seen.quality), Channel.refused,
        doing="inspecting", demand=False, progress=progress,
    )  # fmt: skip
