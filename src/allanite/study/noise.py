"""The noise of a channel: identified in one way for every job, with whether the model explains the record."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, Self

from allanite.core.encoding import plain, read, write
from allanite.core.finding import Quality
from allanite.core.fit import REJECTED, Fit
from allanite.core.header import Header, header_from
from allanite.core.limits import Stored
from allanite.core.plain import Portable, Value, stored_fields
from allanite.core.record import Record, header_dict
from allanite.core.residuals import Residuals, Statement, statement
from allanite.core.scope import UNEXPLAINED, Band, worst
from allanite.identification.checks.contradiction import contradictions
from allanite.identification.checks.residuals import residuals
from allanite.identification.front import METHODS, identify
from allanite.statistics import deviation

from .inspected import Inspected
from .recipe import Recipe


@dataclass(frozen=True, eq=False, repr=False)
class Noise(Portable):
    """A fit whose coefficients are graded, and what its model leaves of the record.

    `leftover` gives `residuals`; None where the method has no test.
    """

    fit: Fit
    leftover: Callable[[], Residuals] | None = None

    @cached_property
    def residuals(self) -> Residuals | None:
        """What the model leaves of the record; None where the method does not give it."""
        return None if self.leftover is None else self.leftover()

    @property
    def validity(self) -> str:
        """Grade of the model, one of `GRADES`; empty where the method does not test it."""
        return worst(self.fit.validity, "" if self.residuals is None else self.residuals.grade)

    @property
    def explained(self) -> bool:
        """Whether nothing says that the numbers are wrong: the model explains the record, if only approximately."""
        return self.validity != UNEXPLAINED

    @property
    def statement(self) -> Statement:
        """How well the model explains the record, in words."""
        return statement(self.validity, self.fit, self.residuals)

    @property
    def verdict(self) -> str:
        """The same in a sentence; empty where the method does not say."""
        return str(self.statement)

    @property
    def doubts(self) -> tuple[str, ...]:
        """What must stand beside every number that uses this noise: that the model does not explain the record."""
        return () if self.explained else (self.verdict,)


def graded(noise: Noise, record: Record) -> Noise:
    """The noise whose coefficients are not valid where the record, or its curve, contradicts them."""
    if noise.residuals is None:
        return noise
    fit, noise = replace(noise.fit, checked=noise.residuals.grade), replace(noise, leftover=Stored(noise.residuals))
    if noise.validity == UNEXPLAINED:
        return replace(noise, fit=fit.invalid(REJECTED))
    curve = deviation(record, "oadev", taus="octave", noise=fit)
    for symbol, reason in contradictions(fit, curve).items():
        fit = fit.invalid(reason, (symbol,))
    return replace(noise, fit=fit)


def noise_of(
    record: Record,
    recipe: Recipe,
    *,
    terms: str | None = None,
    band: Band | None = None,
    lines: bool = True,
) -> Noise:
    """The noise of a channel as the recipe wants it identified.

    A method that reads a curve reads that of the recipe's statistic, or the fit says that it cannot.

    Parameters
    ----------
    record : Record
    recipe : Recipe
    terms : str, optional
        In place of those of the recipe.
    band : {"auto", "all"} or (low, high), optional
        In place of that of the recipe.
    lines : bool
        Whether sinusoids are found and taken out first.

    Raises
    ------
    DataError
        The record does not support it.
    """
    row = METHODS.get(recipe.method)
    readable = row is not None and recipe.statistic in row.allowed
    outliers = recipe.outliers or "mark"
    band = band or recipe.band
    fit = identify(
        record,
        method=recipe.method,
        terms=terms or recipe.terms,
        statistic=recipe.statistic if readable else None,
        band=band,
        outliers=outliers,
        lines=lines,
    )
    if row is not None and row.allowed and not readable:
        note = (
            f"method {recipe.method!r} does not read {recipe.statistic}: the coefficients are those of {row.statistic}"
        )
        fit = replace(fit, notes=(*fit.notes, note))
    if fit.goodness is None:
        return Noise(fit)
    return graded(Noise(fit, partial(residuals, record, fit, outliers=outliers)), record)


def noise_dict(noise: Noise | None, level: float) -> dict[str, Any]:
    """What a stored channel says of its noise: the fit, what it leaves, and whether it explains the record."""
    if noise is None:
        return dict.fromkeys(("fit", "residuals", "explained", "validity", "verdict"))
    fit = replace(noise.fit, curve=None)  # the channel has its curves
    left = None if noise.residuals is None else noise.residuals.to_dict(level)
    said = {"explained": noise.explained, "validity": noise.validity or None, "verdict": noise.verdict}
    return {"fit": fit.to_dict(level), "residuals": left} | said


def noise_from(data: dict[str, Any]) -> Noise | None:
    """The noise that `noise_dict` has written."""
    left = data["residuals"] and Stored(Residuals.from_dict(data["residuals"]))
    return data["fit"] and Noise(Fit.from_dict(data["fit"]), left)


@dataclass(frozen=True, eq=False, repr=False)
class RecordResult(Value):
    """What was found of one record; a subclass adds its fields.

    Stored, the header of the record comes first, and a field `noise` becomes the keys of `noise_dict`.
    """

    record: Record | Header

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data."""
        data = header_dict(self.record, type(self).__name__)
        for name, hint in stored_fields(type(self))[1:]:
            value = getattr(self, name)
            data |= noise_dict(value, level) if name == "noise" else {name: write(value, hint, level)}
        return data | {name: plain(getattr(self, name), level) for name in self._also}

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> Self:
        """What `to_dict` has written."""
        own = {name: hint for name, hint in stored_fields(cls) if name != "record"}
        values = {n: noise_from(data) if n == "noise" else read(data[n], hint) for n, hint in own.items()}
        return cls(header_from(data), **values)

    def _summary(self) -> str:
        return ": ".join(filter(None, (repr(self.record.name), getattr(self, "refusal", ""))))


@dataclass(frozen=True, eq=False, repr=False)
class ChannelResult(RecordResult):
    """What a job found in one channel, or the reason (`refusal`) why there is nothing.

    A subclass adds fields with defaults. What must stand beside its numbers is its `alerts`.
    """

    quality: Quality
    noise: Noise | None = None
    refusal: str = ""

    @property
    def fit(self) -> Fit | None:
        """The identified noise, where it was asked for and could be identified."""
        return None if self.noise is None else self.noise.fit

    @classmethod
    def refused(cls, seen: Inspected, why: str) -> Self:
        """The result of a channel that has none."""
        return cls(seen.record, seen.quality, refusal=why)
