"""From the coefficients of the axes to the fields of a target."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from allanite.core.choices import described
from allanite.core.errors import DataError, UsageError
from allanite.phrases.phrase import join, say, spelled
from allanite.study.results import rejected
from allanite.study.settings import ExportChoices

from .choice import POLICIES, AxisCoefficient, Found, coefficients, remedy, selected
from .content import Axis, Entry, by_sensor
from .target import Target, TargetField, demand_rate

INFLATED, SIZED = 1e6, 1e15
"""The largest inflation, and the largest rate, Hz, or time, s, of an export; the smallest ones are their inverse."""


@described
@dataclass(frozen=True)
class How(ExportChoices):
    """Choices of an export; with `partial`, fields may be missing that the target needs."""

    partial: bool = False

    @property
    def span(self) -> tuple[float, float] | None:
        """The averaging times that are covered or compared, s; None if they follow from the record."""
        return self.cover if isinstance(self.cover, tuple) else None


def usable(axes: Sequence[Axis], how: How, needed: Sequence[str] = ()) -> tuple[Axis, ...]:
    """The axes whose models explain their records, or all if that is asked for."""
    kept = tuple(axis for axis in axes if how.unexplained or not axis.doubt)
    lost = set(() if how.partial else needed) - {axis.sensor for axis in kept}
    doubted = [axis for axis in axes if axis.sensor in lost] if kept else axes
    if doubted or not kept:
        alike: dict[str, list[str]] = {}
        for axis in doubted:
            alike.setdefault(axis.doubt.partition(";")[0], []).append(axis.name or "the record")
        reasons = "; ".join(f"{', '.join(names)}: {doubt}" for doubt, names in alike.items())
        raise DataError(join("; ", (rejected(reasons or "no channel has a result"), remedy())))
    return kept


def fill(target: Target, axes: Sequence[Axis], how: How) -> tuple[tuple[Entry, ...], tuple[str, ...]]:
    """The fields of a target with their values, and what could not be filled in, in sentences."""
    groups = by_sensor(axes)
    if not how.partial:
        _demand_sensors(target, groups, axes)
    sensors = dict.fromkeys(field.sensor for field in target.fields)
    chosen = {sensor: selected(groups[sensor], how.axis) for sensor in sensors if sensor in groups}
    entries: list[Entry] = []
    missing: list[str] = []
    fatal: list[str] = []
    for field in target.fields:
        group = chosen.get(field.sensor)
        if group is None:
            missing.append(field.absent)
            continue
        coefs, reasons = coefficients(group, field.term or "K", markov=target.markov, unexplained=how.unexplained)
        if coefs and (how.axis != "each" or len(coefs) == 3):
            entries.append(_entry(field, POLICIES[how.axis](coefs), group, target, how))
            if reasons and field.term:
                missing.append(say("{field} is taken from the other axes ({reasons})", field=field.full,
                                   reasons=join("; ", reasons)))  # fmt: skip
            continue
        why = say("{field} has no value ({reasons})", field=field.full, reasons=join("; ", reasons))
        (fatal if field.needed and not how.partial else missing).append(why)
    if fatal:
        measured = any(axis.fit.method != "given" for axis in axes)
        cure = ("A longer record gives at least an upper limit (allanite plan), or choose an axis that has one with "
                f"{spelled('--axis', 'axis')}; {remedy()}" if measured else "State it as well")  # fmt: skip
        raise DataError(f"{target.name} cannot be written: {'; '.join(fatal)}. {cure}")
    return tuple(entries), tuple(missing)


def with_identified(entries: Iterable[Entry], target: Target, axes: Sequence[Axis], how: How) -> tuple[Entry, ...]:
    """The fields with the values of what was identified, before cover, inflation and the limits of the target."""
    free = replace(target, fields=tuple(replace(field, span=(0.0, math.inf)) for field in target.fields))
    plain = {entry.full: entry for entry in fill(free, axes, replace(how, partial=True, inflate=1.0))[0]}
    made = []
    for entry in entries:
        own = plain.get(entry.full)
        if own is not None and own.measured and entry.formula != "T":
            channels = own.channels if entry.covers else entry.channels
            entry = replace(entry, identified=own.values, channels=channels)  # noqa: PLW2901 - with more
        made.append(entry)
    return tuple(made)


def _demand_sensors(target: Target, groups: Mapping[str, Sequence[Axis]], axes: Sequence[Axis]) -> None:
    absent = [sensor for sensor in target.sensors if sensor not in groups]
    if absent:
        given = ", ".join(f"{axis.label} ({axis.sensor})" for axis in axes)
        remedy = spelled("add a file with it, or the N and K of its data sheet by --model",
                         "pass a list with a result or a model of it as well")  # fmt: skip
        names = " and ".join(f"an {sensor}" if sensor[0] == "a" else f"a {sensor}" for sensor in absent)
        raise DataError(f"{target.name} needs {names}, and there is only {given}: {remedy}")


def _entry(field: TargetField, coefs: Found, group: Sequence[Axis], target: Target, how: How) -> Entry:
    rates = {axis.name: target.rate(axis.rate, how.filter_rate) for axis in group}
    if field.rate or (target.rated and not how.partial):
        for rate in rates.values():
            demand_rate(target, rate)
    values, remarks = zip(*(_value(field, c, rates[c.channel] or 1.0, how.inflate) for c in coefs), strict=True)
    each = (join(" ", (c.channel, remark)) for c, remark in zip(coefs, remarks, strict=True))
    return Entry(field.name, field.sensor,
                 field.section, field.unit, field.formula, values, tuple(c.channel for c in coefs if c.channel),
                 join("; ", remarks[:1] if len(set(remarks)) == 1 else each), not any(c.limit for c in coefs),
                 all(c.covers for c in coefs))  # fmt: skip


def _value(field: TargetField, coef: AxisCoefficient, rate: float, inflate: float) -> tuple[float, str]:
    """The value of a field, and the remark on it."""
    if not field.term:
        known = coef.note and not coef.limit
        time = say("correlation time of {process}", process=coef.note) if known else say("correlation time")
        return field.value(1.0, rate, coef.time), time
    parts = [coef.note] if coef.note else []
    if coef.limit:
        parts.append(say("this is its 95 % upper limit"))
    elif math.isfinite(coef.low) and math.isfinite(coef.high):
        low, high = (field.value(limit, rate, coef.time) for limit in (coef.low, coef.high))
        parts.append(say("{level:g} %: {low:.4g} to {high:.4g}", level=100 * coef.level, low=low, high=high))
    elif coef.given or not coef.note:
        parts.append(say("given") if coef.given else say("no interval"))
    if inflate != 1:
        parts.append(say("value inflated by {factor:g}", factor=inflate))
    remark, value = join(", ", parts), field.value(coef.value * inflate, rate, coef.time)
    least, most = field.span
    if least <= value <= most:
        return value, remark
    return least if value < least else most, say("{value:.4g} is outside of what is accepted, {least:g} to "
                                                 "{most:g}; {remark}",
                                                 value=value, least=least, most=most, remark=remark)  # fmt: skip


def demand_how(target: Target, how: How) -> None:
    """Refuse impossible choices before any work."""
    if not 1 / INFLATED <= how.inflate <= INFLATED:
        limits = f"{1 / INFLATED:g} to {INFLATED:g}"
        raise UsageError(f"an inflation must be a positive number, {limits}, not {how.inflate:g}")
    for rate in (how.rate, how.filter_rate):
        if rate is not None and not 1 / SIZED <= rate <= SIZED:
            raise UsageError(f"a rate must be above 0 Hz, {1 / SIZED:g} to {SIZED:g} Hz, not {rate:g}")
    if how.span and not (how.span[0] >= 1 / SIZED and how.span[1] <= SIZED):
        raise UsageError(f"{spelled('--cover', 'cover')} is from {1 / SIZED:g} to {SIZED:g} s, not {how.span}")
    if how.inflate != 1 and not target.inflatable:
        raise UsageError(f"{target.name} states what was measured: it is not inflated")
    if how.cover and not target.drifts:
        what = ("only white noise, which covers no drift" if target.fields else "the whole model: there is nothing to "
                "cover")  # fmt: skip
        raise UsageError(f"{target.name} takes {what}; omit {spelled('--cover', 'cover')}")
    if how.axis == "each" and target.fields and not target.each:
        raise UsageError(f"{target.name} takes one value for all axes; choose worst, median, x, y or z")
