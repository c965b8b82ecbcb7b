"""Sentences of the table, the page and the figures."""

import math
from collections.abc import Mapping
from string import Formatter
from typing import TYPE_CHECKING, Any, Self

from allanite.phrases.phrase import (  # isort: skip
    Catalogue, Phrase, averaging as averaging, duration as duration, join, say, say_count,  # noqa: PLC0414
)  # fmt: skip
from allanite.core.estimate import Estimate
from allanite.core.fit import Fit, chance
from allanite.core.kinds import KIND_WORDS, title_of
from allanite.core.plain import Header
from allanite.core.record import Record
from allanite.core.units import unit_of
from allanite.core.validity import UNEXPLAINED, graded
from allanite.identification.methods import METHODS
from allanite.terms import TERMS

from .digits import digits, printed_unit

if TYPE_CHECKING:
    from allanite.comparison.change import Change

title = title_of

ARCSEC = unit_of("arcsec").factor


def grade(fit: Fit) -> str:
    """How well the model of a fit explains its record: ``explained, p = 0.29``; empty where that was not tested."""
    good = fit.goodness
    if good is None:
        return ""
    # where the coefficients or the residuals say no, the p value of the spectrum is no reason
    shown = fit.validity != UNEXPLAINED or good.grade == UNEXPLAINED
    return join(", ", (graded(fit.validity, fit.scope), *([chance(good.p)] if shown else [])))


class Capital(Phrase):
    """A phrase that begins with a capital letter, in any language; the name of a channel is left as it is."""

    __slots__ = ()

    def __new__(cls, templates: tuple[str, ...], fields: Mapping[str, Any]) -> Self:
        """As for a phrase."""
        plain = Phrase(templates, fields)
        made = str.__new__(cls, _capital(plain, fields["text"]))
        made.templates, made.fields = templates, fields
        return made

    def within(self, catalogue: Catalogue) -> str:
        """The phrase in the language of a catalogue."""
        return _capital(super().within(catalogue), self.fields["text"])


def capital(text: str) -> Capital:
    """A text that begins with a capital letter."""
    return Capital(("{text}",), {"text": text})


def _capital(shown: str, text: str) -> str:
    return shown if isinstance(text, Phrase) and _named(text) else shown[:1].upper() + shown[1:]


def _named(text: Any) -> bool:
    """Whether a text begins with data: with a field that is no phrase."""
    if not isinstance(text, Phrase):
        return True
    first = next(iter(Formatter().parse(text.templates[-1])), ("", None, "", None))
    return not first[0] and first[1] is not None and _named(text.fields[first[1]])


def symbol(estimate: Estimate) -> str:
    """The symbol of an estimate's term: ``|R|`` by a method that finds the size of a ramp, not its sign."""
    unsigned = _ramp(estimate) and not signed(estimate)
    return f"|{estimate.symbol}|" if unsigned and estimate.status != "negative" else estimate.symbol


def signed(estimate: Estimate) -> bool:
    """Whether the sign of an estimate is one: that of a ramp, by a method that knows it."""
    return _ramp(estimate) and METHODS[estimate.method].signed


def _ramp(estimate: Estimate) -> bool:
    row = TERMS[estimate.symbol]
    return row.waveform is not None and not row.periodic


def named(estimate: Estimate, level: float) -> str:
    """The name of an estimate's term, and its shape if it has one."""
    return join(", ", (title(estimate.symbol, estimate.signal), *shapes(estimate, level)))


def shapes(estimate: Estimate, level: float) -> list[str]:
    """The shape parameters of an estimate: ``T = 20 (15 .. 28) s``."""
    sizes = ((p, f"{digits(*size).words()} {p.unit}".rstrip()) for p, *size in estimate.shaped(level))
    return [join(" = ", (parameter.letter or parameter.title, shown)) for parameter, shown in sizes]


def brief(estimate: Estimate, level: float, parameter: str = "") -> str:
    """A coefficient to its significant digits, in brackets if not valid, or its limit; or a parameter of its shape."""
    if parameter:
        return next((digits(*numbers).plain()[0] for p, *numbers in estimate.shaped(level) if p.name == parameter), "-")
    unit = estimate.sheet_unit
    number, most = estimate.rounded(unit, level, signed=signed(estimate)), estimate.rounded_limit(unit)
    if number is not None:
        return number.plain()[0] if estimate.status != "not valid" else f"({number.plain()[0]})"
    return f"< {most.plain()[0]}" if most else "-"


def change_of(change: "Change", level: float) -> tuple[str, str]:
    """The change and its interval in percent."""
    low, high = change.interval(level)
    least = -100.0 if TERMS[change.symbol].waveform is None else -math.inf
    # beside a limit there is no number to compare, but a sinusoid that has gone
    known = math.isfinite(change.ratio) and (None not in (change.before.value, change.after.value) or not change.ratio)
    if low > least and math.isfinite(high):
        size, interval = digits(change.percent if known else high, low, high, signed=True).plain()
        return f"{size} %" if known else "-", f"{interval} %"
    size = f"{change.percent:+.3g} %" if known and math.isfinite(high) else "-"
    if math.isfinite(high):
        return size, say("below {limit}", limit=f"{high:+.3g} %")
    return "-", say("above {limit}", limit=f"{low:+.3g} %") if low > least else say("any")


def below(estimate: Estimate, most: str) -> Phrase:
    """A limit with the word before it: a ramp has a sign, its size is limited."""
    return say("size below {limit}", limit=most) if _ramp(estimate) else say("below {limit}", limit=most)


def in_print(estimate: Estimate, unit: str, level: float) -> str:
    """A coefficient as printed: ``0.310 (0.302 … 0.318) deg/√h`` or ``below 2.1 deg/h``."""
    number, most = estimate.rounded(unit, level, signed=signed(estimate)), estimate.rounded_limit(unit)
    if number is not None:
        return f"{number.pretty()} {printed_unit(unit)}"
    return below(estimate, f"{most.pretty()} {printed_unit(unit)}") if most else ""


def about(record: Record | Header) -> str:
    """The record of a channel: ``gyroscope, rate in deg/h, 100 Hz, 360000 samples, 1 h``."""
    scale = "" if record.scale is None else f"{record.scale:g} "
    plain = record.kind == "rate" and not record.signal.inertial
    return say(
        "{sensor}, {kind} in {unit}, {rate:.8g} Hz, {samples}, {length}", sensor=record.signal.sensor,
        kind=record.signal.quantity if plain else KIND_WORDS[record.kind], unit=f"{scale}{record.unit}",
        rate=record.rate, samples=say_count(record.size, "{count} sample", "{count} samples"),
        length=duration(record.duration),
    )  # fmt: skip


def percent(share: float, figures: int = 6) -> str:
    """A share, as a confidence level: ``95 %``; empty where there is none."""
    return f"{100 * share:.{figures}g} %" if math.isfinite(share) else ""


def interval(level: float) -> str:
    """The heading of confidence limits: ``95 % interval``."""
    return say("{share} interval", share=percent(level))


def probability(p: float, least: float = 1e-12) -> str:
    """A p value as a cell of a table."""
    return f"{p:.2g}" if p > least else f"< {least:g}"


def number(estimate: Estimate, level: float) -> str:
    """A coefficient in print without its interval: ``0.310 deg/√h``."""
    rounded = estimate.rounded(estimate.sheet_unit, level, signed=signed(estimate))
    assert rounded is not None  # noqa: S101 - asked for values only
    value = rounded.value.replace("-", "−") + rounded.power
    return f"{value} {printed_unit(estimate.sheet_unit)}"
