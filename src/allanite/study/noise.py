"""The noise of a channel, identified in the same way for every job, and whether the model explains the record."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, Self

from allanite.core.encoding import plain, read_plain, write_plain
from allanite.core.errors import DataError
from allanite.core.finding import Quality
from allanite.core.fit import REJECTED, Fit
from allanite.core.header import Header, header_from
from allanite.core.limits import Stored, Widened
from allanite.core.model import Model
from allanite.core.plain import Portable, Value, stored_fields
from allanite.core.ranges import demand_pieces
from allanite.core.record import Record, header_dict
from allanite.core.residuals import Residuals, Statement, statement
from allanite.core.validity import UNEXPLAINED, Band, worst
from allanite.identification.checks.contradiction import contradictions, held
from allanite.identification.checks.residuals import residuals
from allanite.identification.front import identify
from allanite.identification.methods import METHODS
from allanite.phrases.phrase import join, say
from allanite.phrases.wording import spelled
from allanite.terms import TERMS, WHITE

from .inspected import Inspected
from .recipe import Recipe


@dataclass(frozen=True, eq=False, repr=False)
class Noise(Portable):
    """A fit with graded coefficients, and its residuals.

    `leftover` computes `residuals`; None if the method has no test.
    """

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
        """The model from which a job may go on: a plan, a filter, a prediction.

        Raises
        ------
        DataError
            No model explains the record, and `unexplained` does not accept the best one; or no noise was identified.
        """
        if not (self.explained or unexplained):
            raise DataError(rejected(self.rejection))
        model = self.fit.valid or self.fit.model
        if not any(t.row.waveform is None and t.value for t in model):
            raise DataError(say("no noise was identified"))
        return model

    @property
    def doubts(self) -> tuple[str, ...]:
        """A warning to report with every result that uses this noise if the model does not explain the record."""
        return () if self.explained else (self.verdict,)


def rejected(why: str) -> str:
    """Why the coefficients of a model that does not explain its record are not used, and how they are nevertheless."""
    remedy = spelled("--unexplained", "unexplained=True")
    return say("{why}. To use the coefficients nevertheless: {remedy}", why=why, remedy=remedy)


def graded(noise: Noise, record: Record) -> Noise:
    """The noise, with coefficients marked as not valid if the record, or its curve, contradicts them."""
    left = noise.residuals
    if left is None:
        return noise
    fit, noise = replace(noise.fit, checked=left.grade), replace(noise, leftover=Stored(left))
    if noise.validity == UNEXPLAINED:
        return replace(noise, fit=fit.invalid(REJECTED))
    for symbol, reason in contradictions(fit, record).items():
        fit = fit.invalid(reason, (symbol,))
    if any(finding.name == "correlation" for finding in left.findings):
        angle = [e.symbol for e in fit if e.claimed and TERMS[e.symbol].edge]
        fit = fit.invalid(say("the residuals are not white: the noise rises with frequency in another way"), angle)
    if any(finding.name == "heavy tails" for finding in left.findings):
        fit = widened(fit, math.sqrt(1 + left["kurtosis"].value / 2))
    until = held(fit, record)
    if until == 0:
        nowhere = say("the deviation of these terms is that of the record at no averaging time")
        claimed = [e.symbol for e in fit if e.claimed]
        others = [e.symbol for e in fit if e.symbol not in claimed and e.status != "not valid"]
        fit = fit.invalid(nowhere, claimed).invalid(REJECTED, others)
    if fit.scope is not None:
        fit = replace(fit, scope=replace(fit.scope, until=until))
    return replace(noise, fit=fit)


def widened(fit: Fit, factor: float) -> Fit:
    """The fit with wider limits of the fast noise.

    The mean square of n independent residuals with an excess kurtosis k has the variance (2 + k) / n instead of 2 / n;
    of slow noise, an average of many of them, the tails are no longer heavy.
    """
    each = [
        replace(e, limits=limits, profile=limits, standard_error=e.standard_error and factor * e.standard_error)
        if e.claimed and e.value is not None and e.limits and TERMS[e.symbol].slope <= WHITE
        and (limits := Widened(e.limits, e.value, factor))
        else e
        for e in fit
    ]  # fmt: skip
    return replace(fit, estimates=tuple(each))


def noise_of(
    record: Record,
    recipe: Recipe,
    *,
    terms: str | None = None,
    band: Band | None = None,
    lines: bool = True,
) -> Noise:
    """Identify the noise of a channel with the choices of the recipe.

    A method that fits a curve uses the recipe's statistic; if it cannot, the notes of the fit say so.

    Parameters
    ----------
    record : Record
    recipe : Recipe
    terms : str, optional
        Instead of those of the recipe.
    band : {"auto", "all"} or (low, high), optional
        Instead of that of the recipe.
    lines : bool
        Whether sinusoids are detected and removed first.

    Raises
    ------
    DataError
        The record cannot support the identification.
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
        masks=demand_pieces(recipe.mask, "Hz") if recipe.mask else (),
        outliers=outliers,
        lines=lines,
        ranges=recipe.ranges,
    )
    if row is not None and row.allowed and not readable:
        note = say(
            "method {method!r} cannot fit {statistic}: the coefficients are those of {other}",
            method=recipe.method,
            statistic=recipe.statistic,
            other=row.statistic,
        )
        fit = replace(fit, notes=(*fit.notes, note))
    if fit.goodness is None:
        return Noise(fit)
    return graded(Noise(fit, partial(residuals, record, fit, outliers=outliers)), record)


def noise_dict(noise: Noise | None, level: float) -> dict[str, Any]:
    """The stored data of a channel's noise: the fit, its residuals, and whether it explains the record."""
    if noise is None:
        return dict.fromkeys(("fit", "residuals", "explained", "validity", "verdict"))
    fit = replace(noise.fit, curve=None)  # the channel has its curves
    left = None if noise.residuals is None else noise.residuals.to_dict(level)
    said = {"explained": noise.explained, "validity": noise.validity or None, "verdict": noise.verdict}
    return {"fit": fit.to_dict(level), "residuals": left} | said


def noise_from(data: dict[str, Any]) -> Noise | None:
    """The noise written by `noise_dict`."""
    left = data["residuals"] and Stored(Residuals.from_dict(data["residuals"]))
    return data["fit"] and Noise(Fit.from_dict(data["fit"]), left)


@dataclass(frozen=True, eq=False, repr=False)
class RecordResult(Value):
    """Results for one record; a subclass adds its fields.

    When stored, the header of the record comes first, and a field `noise` becomes the keys of `noise_dict`.
    """

    record: Record | Header

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data."""
        data = header_dict(self.record, type(self).__name__)
        for name, hint in stored_fields(type(self))[1:]:
            value = getattr(self, name)
            data |= noise_dict(value, level) if name == "noise" else {name: write_plain(value, hint, level)}
        return data | {name: plain(getattr(self, name), level) for name in self._also}

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> Self:
        """The value written by `to_dict`."""
        own = {name: hint for name, hint in stored_fields(cls) if name != "record"}
        values = {n: noise_from(data) if n == "noise" else read_plain(data[n], hint) for n, hint in own.items()}
        return cls(header_from(data), **values)

    def _summary(self) -> str:
        return ": ".join(filter(None, (repr(self.record.name), getattr(self, "refusal", ""))))


@dataclass(frozen=True, eq=False, repr=False)
class ChannelResult(RecordResult):
    """The result of a job for one channel, or the reason (`refusal`) why there is none.

    A subclass adds fields with defaults. `alerts` are the warnings to report with the results.
    """

    quality: Quality
    noise: Noise | None = None
    refusal: str = ""

    @property
    def fit(self) -> Fit | None:
        """The identified noise, if it was requested and could be identified."""
        return None if self.noise is None else self.noise.fit

    @classmethod
    def refused(cls, seen: Inspected, why: str) -> Self:
        """The result of a refused channel."""
        return cls(seen.record, seen.quality, refusal=why)
