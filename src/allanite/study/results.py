"""Results of an analysis: the noise of a record, of a channel, and of all channels."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Self

from allanite.core.curve import Curve
from allanite.core.encoding import plain, read_key, write_plain
from allanite.core.errors import DataError, UsageError
from allanite.core.estimate import Estimate
from allanite.core.fit import Fit
from allanite.core.limits import Stored
from allanite.core.model import Model, nevertheless
from allanite.core.plain import Header, Portable, Value, header_from, read_fields, stored_fields
from allanite.core.readings import DataSheetRow, Readings, data_sheet
from allanite.core.record import Record, Recording, header_dict
from allanite.core.residuals import Residuals, Shared, Statement, statement
from allanite.core.validity import UNEXPLAINED, Finding, Quality, worst
from allanite.identification.checks.whitening import shared
from allanite.parallel.processors import how_many
from allanite.phrases.phrase import join, say, spelled
from allanite.terms import TERMS

from .job import Job

if TYPE_CHECKING:
    from .keeper import Inspected


@dataclass(frozen=True, eq=False, repr=False)
class Noise(Portable):
    """A fit with graded coefficients, and its residuals; no `leftover` if the method has no test."""

    fit: Fit
    leftover: Callable[[], Residuals] | None = None

    @cached_property
    def residuals(self) -> Residuals | None:
        """The residuals of the model; None if the method does not give them."""
        return None if self.leftover is None else self.leftover()

    @property
    def validity(self) -> str:
        """Grade of the model, one of `GRADES`; empty if the method does not test it."""
        return worst(self.fit.validity, "" if self.residuals is None else self.residuals.grade)

    @property
    def explained(self) -> bool:
        """Whether the results are not known to be wrong: the model explains the record, at least approximately."""
        return self.validity != UNEXPLAINED

    @property
    def statement(self) -> Statement:
        """How well the model explains the record, as text."""
        return statement(self.validity, self.fit, self.residuals)

    @property
    def verdict(self) -> str:
        """The same in a sentence; empty if the method does not test it."""
        return str(self.statement)

    @property
    def rejection(self) -> str:
        """The grade with the first of its reasons; empty if the model explains the record."""
        return "" if self.explained else join("; ", (self.statement.head, *self.statement.points[:1]))

    def usable(self, *, unexplained: bool = False) -> Model:
        """The model from which a job may go on; DataError if none explains the record or none was identified."""
        if not (self.explained or unexplained):
            raise DataError(rejected(self.rejection))
        model = self.fit.usable(unexplained=True)
        if not any(t.row.waveform is None and t.value for t in model):
            raise DataError(say("no noise was identified"))
        return model

    @property
    def doubts(self) -> tuple[str, ...]:
        """A warning to report with every result that uses this noise if the model does not explain the record."""
        return () if self.explained else (self.verdict,)

    @property
    def omitted(self) -> tuple[str, ...]:
        """Slow behaviour that is not in a model which explains the record, to report with what follows from it."""
        return tuple(map(str, self.fit.findings)) if self.explained else ()


def rejected(why: str) -> str:
    """Why the coefficients of a model that does not explain its record are not used, and how they are nevertheless."""
    return nevertheless(why, spelled("--unexplained", "unexplained=True"))


def noise_dict(noise: Noise | None, level: float) -> dict[str, Any]:
    """The stored data of a channel's noise: the fit, its residuals, and whether it explains the record."""
    if noise is None:
        return dict.fromkeys(("fit", "residuals", "explained", "validity", "verdict"))
    fit = replace(noise.fit, curve=None)  # the channel has its curves
    residuals = None if noise.residuals is None else noise.residuals.to_dict(level)
    judgement = {"explained": noise.explained, "validity": noise.validity or None, "verdict": noise.verdict}
    return {"fit": fit.to_dict(level), "residuals": residuals} | judgement


def noise_from(data: dict[str, Any]) -> Noise | None:
    """The noise written by `noise_dict`."""
    fit, residuals = read_key(data, "fit", Fit | None), read_key(data, "residuals", Residuals | None)
    return None if fit is None else Noise(fit, None if residuals is None else Stored(residuals))


@dataclass(frozen=True, eq=False, repr=False)
class RecordResult(Value):
    """Results for one record; a subclass adds its fields. Stored, `noise` becomes the keys of `noise_dict`."""

    record: Record | Header

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data."""
        data = header_dict(self.record, type(self).__name__)
        for name, hint in stored_fields(type(self))[1:]:
            value = getattr(self, name)
            data |= noise_dict(value, level) if name == "noise" else {name: write_plain(value, hint, level)}
        return data | {name: plain(getattr(self, name), level) for name in self._also}

    @classmethod
    def _stored(cls, data: dict[str, Any]) -> Self:
        stored = read_fields(cls, data, "record", "noise")
        noise = {"noise": noise_from(data)} if "noise" in dict(stored_fields(cls)) else {}
        return cls(header_from(data), **stored, **noise)

    def _summary(self) -> str:
        return ": ".join(filter(None, (repr(self.record.name), getattr(self, "refusal", ""))))


@dataclass(frozen=True, eq=False, repr=False)
class ChannelResult(RecordResult):
    """The result of a job for one channel, or its `refusal`; `alerts` are warnings to report with the results."""

    quality: Quality
    noise: Noise | None = None
    refusal: str = ""

    @property
    def fit(self) -> Fit | None:
        """The identified noise, if it was requested and could be identified."""
        return None if self.noise is None else self.noise.fit

    def __getitem__(self, symbol: str) -> Estimate:
        """The coefficient of a term: ``study["gx"]["N"]``."""
        if self.fit is None:
            raise UsageError(
                f"{self.record.name!r} has no coefficients: {self.refusal or 'its noise was not identified'}"
            )
        return self.fit[symbol]

    def _named(self, name: str) -> Any:
        return self.fit.coefficients.get(name) if self.fit else None

    @classmethod
    def refused(cls, seen: "Inspected", why: str) -> Self:
        """The result of a refused channel."""
        return cls(seen.first, seen.quality, refusal=why)


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
    def warnings(self) -> tuple[Finding, ...]:
        """Findings about the data that the model does not settle."""
        # not repeated if the residuals name it; removed or excluded lines need no warning
        settled = {finding.name for finding in self.residuals.findings} if self.residuals else set()
        scope = self.fit.scope if self.fit else None
        vibrates = any(c.name == "resonance" and c.claimed for c in (self.fit.components if self.fit else ()))
        bounded = scope is not None and (scope.masks or scope.limited)
        met = self.fit is not None and (self.fit.lines or bounded)
        shaped = [TERMS[e.symbol] for e in self.fit or () if e.claimed and e.shape]
        if self.explained and (met or any(row.period for row in shaped)):
            settled.add("lines")
        if self.explained and (shaped or vibrates or (scope and scope.filter)):  # the curve may have any slope
            settled.add("slope")
        return tuple(finding for finding in self.quality.warnings if finding.name not in settled)

    @property
    def alerts(self) -> tuple[str, ...]:
        """Warnings to report with the results, including that the model does not explain the record."""
        doubts = () if self.noise is None else self.noise.doubts
        return (*doubts, *map(str, self.warnings))

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
    def _stored(cls, data: dict[str, Any]) -> Self:
        channel = super()._stored(data)
        if channel.noise is None:
            return channel
        return replace(channel, noise=replace(channel.noise, fit=replace(channel.noise.fit, curve=channel.curve)))

    def _summary(self) -> str:
        return f"{self.record.name!r}: {self.refusal or (self.fit.model if self.fit else 'not analyzed')}"


@dataclass(frozen=True, eq=False, repr=False)
class Study(Job[Channel]):
    """Recording, recipe, and the result of each channel; ``study["gx"]`` is that of a channel.

    Attributes
    ----------
    channels : tuple of Channel
        In the order of the file; each has its `record`, and a `refusal` if there is no result.
    recipe, findings, notes, provenance
        All choices; findings about the file as a whole; assumptions made when reading; version and input files.
    """

    _channel = Channel
    _used = None

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

    @property
    def fits(self) -> dict[str, Fit]:
        """The identified noise of the channels that have any, by their names."""
        return {channel.record.name: channel.fit for channel in self.channels if channel.fit}

    @property
    def curves(self) -> dict[str, Curve]:
        """The curves of the channels that have any, by their names."""
        return {channel.record.name: channel.curve for channel in self.channels if channel.curve}

    def to_dict(self, level: float | None = None) -> dict[str, Any]:
        """Plain data, with limits at `level`, by default that of the recipe."""
        data = super().to_dict(level)
        del data["common"]
        return data | {"shared": None if self.shared is None else self.shared.to_dict()}

    @classmethod
    def _stored(cls, data: dict[str, Any]) -> "Study":
        return super()._stored(data | {"common": data.get("shared")})
