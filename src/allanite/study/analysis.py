"""The main analysis: noise coefficients of every channel with intervals, and its curve."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Self

from allanite.core.curve import Curve
from allanite.core.datasheet import DataSheetRow, data_sheet
from allanite.core.display_units import showing
from allanite.core.errors import DataError, UsageError
from allanite.core.finding import Quality
from allanite.core.readings import Readings
from allanite.core.record import Record, Recording
from allanite.core.residuals import Residuals, Shared
from allanite.identification.checks.shared import shared
from allanite.phrases.phrase import say
from allanite.phrases.wording import spelled
from allanite.readers.parts import PartsReader
from allanite.statistics import deviation
from allanite.statistics.readings import readings

from .channels import Inspected, Progress, Source, run
from .gathering import STRIDES, Streams, chosen, demand_grid
from .job import Job
from .meanwhile import IDENTIFICATION, importing
from .noise import ChannelResult, Noise, noise_of
from .parts import Passed, in_parts, run_in_parts
from .recipe import Recipe
from .shares import how_many


@dataclass(frozen=True, eq=False, repr=False)
class Channel(ChannelResult):
    """Result of one channel, or the reason (`refusal`) why there is none."""

    curves: tuple[Curve, ...] = ()
    readings: Readings | None = None

    @property
    def curve(self) -> Curve | None:
        """The curve of the record, with intervals under the identified noise."""
        return self.curves[0] if self.curves else None

    @property
    def residuals(self) -> Residuals | None:
        """The residuals of the model; None without a model of all frequencies, or if the method has none."""
        return None if self.noise is None else self.noise.residuals

    @property
    def explained(self) -> bool:
        """Whether there is a model that is not known to be inadequate."""
        return self.noise is not None and self.noise.explained

    @property
    def verdict(self) -> str:
        """Whether the model explains the record, in a sentence; empty if the method does not test it."""
        return "" if self.noise is None else self.noise.verdict

    @property
    def alerts(self) -> tuple[str, ...]:
        """Warnings to report with the results, including that the model does not explain the record."""
        # not repeated if the residuals name it; removed or excluded lines need no warning
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

    def data_sheet(self, level: float = 0.95) -> list[DataSheetRow]:
        """The quantities and units of data sheets, with limits."""
        return data_sheet(self.fit, self.readings, self.record.rate, level)

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data, with the data sheet."""
        return super().to_dict(level) | {"data_sheet": [entry._asdict() for entry in self.data_sheet(level)]}

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> Self:
        """The value written by `to_dict`."""
        found = super().from_dict(data)
        if found.noise is None:
            return found
        return replace(found, noise=replace(found.noise, fit=replace(found.noise.fit, curve=found.curve)))

    def _summary(self) -> str:
        return f"{self.record.name!r}: {self.refusal or (self.fit.model if self.fit else 'not analyzed')}"


@dataclass(frozen=True, eq=False, repr=False)
class Study(Job[Channel]):
    """Recording, recipe, and the result of each channel."""

    _channel = Channel

    common: Shared | None = field(default=None, compare=False)
    """Correlations between the channels, if they were read and not computed."""

    @cached_property
    def shared(self) -> Shared | None:
        """Correlations between the residuals of the channels; None if fewer than two can be compared."""
        fits = {c.record.name: c.fit for c in self.channels if c.fit is not None and c.noise and c.noise.leftover}
        records = tuple(c.record for c in self.channels if c.record.name in fits and isinstance(c.record, Record))
        if len(records) < 2 or len({record.size for record in records}) > 1:
            return self.common
        threads = how_many(len(records), max(record.size for record in records))
        return shared(Recording(records), fits, outliers=self.recipe.outliers or "mark", threads=threads)

    def choices(self) -> dict[str, Any]:
        """The recipe that was actually used, as plain data."""
        return self.recipe.to_dict()

    def _around(self, level: float, channels: list[Any]) -> dict[str, Any]:
        data = super()._around(level, channels)
        del data["common"]
        return data | {"shared": None if self.shared is None else self.shared.to_dict()}

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> "Study":
        """The value written by `to_dict`."""
        return super().from_dict({**data, "common": data["shared"]})


def analyze(
    source: Source,
    recipe: Recipe | None = None,
    *,
    progress: Progress | None = None,
) -> Study:
    """Analyze a recording: noise coefficients of every channel, with intervals, and its curve.

    Parameters
    ----------
    source : Recording, Record or path
        A path is read with the recipe's options.
    recipe : Recipe, optional
        All choices; the defaults are the standard analysis.
    progress : callable, optional
        Called with a description of the current step and the fraction completed.

    Returns
    -------
    Study
        Channels that cannot be analyzed have a reason instead of results.

    Raises
    ------
    DataError
        The file cannot be read, or none of its channels can be analyzed.
    UsageError
        An option is wrong, or a required one is missing.
    """
    recipe = recipe or Recipe()
    study = analyzed(source, recipe, progress)
    demand_shown(recipe, study.channels)
    return study


def demand_shown(recipe: Recipe, channels: Iterable[Channel]) -> None:
    """Refuse a unit of the recipe in which no coefficient of any channel can be shown."""
    signals = {channel.record.signal.name: channel.record.signal for channel in channels}
    for unit in recipe.to or ():
        if not any(signal.name in signals for signal in showing(unit)):
            units = ", ".join(signal.sheet[0] for signal in signals.values())
            wanted = spelled("--to", "to=")
            raise UsageError(
                f"no channel has a coefficient in {unit!r} ({wanted}); the channels are in {units}", choice="to"
            )


def analyzed(source: Source, recipe: Recipe, progress: Progress | None = None) -> Study:
    """The study of a recording, as `analyze` returns it; not every unit of the recipe need fit it."""

    def work(seen: Inspected) -> Channel:
        return _channel(seen.record, seen.quality, recipe)

    with importing(IDENTIFICATION, kernels=recipe.method == "whittle"), in_parts(source, recipe) as reader:
        if reader is not None:
            return _analyzed_in_parts(reader, recipe, progress)
        return run(Study, source, recipe, work, Channel.refused, progress=progress)


def _channel(record: Record, quality: Quality, recipe: Recipe) -> Channel:
    """The result of one channel."""
    noise = noise_of(record, recipe)
    curve = deviation(record, recipe.statistic, taus=recipe.taus, noise=noise.fit)
    if curve.law is not None:
        curve.interval(recipe.level)  # which every form of the result shows, and is remembered
    noise = replace(noise, fit=replace(noise.fit, curve=curve))
    usual = curve.statistic == "oadev" and recipe.taus == "log"
    read = readings(record, curve if usual else None)
    return Channel(record, quality, noise, curves=(curve,), readings=read).to(*(recipe.to or ()))


def refitted(channel: Channel, recipe: Recipe) -> Channel:
    """A channel of a study analyzed once more with other choices of the identification or curve.

    Raises
    ------
    DataError
        The study has no samples of it, since it was read in parts, or read from a file of results.
    """
    if not isinstance(channel.record, Record):
        raise DataError(say("the samples of {channel!r} are not in memory: analyze the file once more",
                            channel=channel.record.name))  # fmt: skip
    return _channel(channel.record, channel.quality, recipe)


def _analyzed_in_parts(reader: PartsReader, recipe: Recipe, progress: Progress | None) -> Study:
    """The study of a file that does not fit into memory."""
    demand_grid(recipe.taus, None, reader.heads[0].rate)

    def work(passed: Passed) -> Channel:
        rate, streams = passed.header.rate, passed.gathered
        fit = streams.fit(rate, recipe)
        curve = chosen(streams.curves(rate, fit)[0], recipe.taus)
        noise = Noise(replace(fit, curve=curve))
        return Channel(passed.header, passed.quality, noise, curves=(curve,)).to(*(recipe.to or ()))

    return run_in_parts(
        Study, reader, recipe, lambda head: Streams(head, (recipe.statistic,), recipe.outliers), work,
        lambda passed, why: Channel(passed.header, passed.quality, refusal=why), notes=(STRIDES,), progress=progress,
    )  # fmt: skip


def examine(source: Source, recipe: Recipe | None = None, *, progress: Progress | None = None) -> Study:
    """Summarize a recording and check its quality: a study without results.

    Parameters, exceptions and result are those of `analyze`, but no channel has a curve or a fit.
    """
    recipe = recipe or Recipe()
    return run(
        Study, source, recipe, lambda seen: Channel(seen.record, seen.quality), Channel.refused,
        doing="inspecting", demand=False, progress=progress,
    )  # fmt: skip
