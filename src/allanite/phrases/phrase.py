"""Phrases: English text that keeps how it was made, so that a report can say it in another language.

The values that hold a phrase (findings, notes, statements) stay in English, as do JSON and CSV: a phrase is a `str`.
Only where it is shown is it looked up in a catalogue, by its template, with its fields put in afterwards.
"""

import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from string import Formatter
from typing import Any, Protocol, Self


class Catalogue(Protocol):
    """Translations of templates, as `gettext.NullTranslations` has them."""

    def gettext(self, message: str, /) -> str: ...  # noqa: D102
    def ngettext(self, one: str, many: str, count: int, /) -> str: ...  # noqa: D102


class Phrase(str):
    """English text with its template and the fields that were put into it; made by `say`, `say_count` and `join`."""

    __slots__ = ("fields", "templates")
    templates: tuple[str, ...]
    fields: Mapping[str, Any]

    def __new__(cls, templates: tuple[str, ...], fields: Mapping[str, Any]) -> Self:
        """The phrase in English; of two templates, the first is used for a `count` of one, the second otherwise."""
        chosen = templates[0] if fields.get("count") == 1 else templates[-1]
        made = super().__new__(cls, _filled(chosen, fields))
        made.templates, made.fields = templates, fields
        return made

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.templates, dict(self.fields))

    def __str__(self) -> str:
        """Itself: str(error) of an error that was raised with a phrase is still one."""
        return self

    def within(self, catalogue: Catalogue) -> str:
        """The phrase in the language of a catalogue; what that does not hold stays English."""
        fields = {name: translate(value, catalogue) for name, value in self.fields.items()}
        return _filled(self._template(catalogue), fields)

    def _template(self, catalogue: Catalogue) -> str:
        first, last = self.templates[0], self.templates[-1]
        if not first:  # of nothing, a catalogue tells its own header
            return first
        return catalogue.gettext(first) if first is last else catalogue.ngettext(first, last, int(self.fields["count"]))


MAX_PLAIN = 1e7  # numbers below have no power of ten in a sentence


class _Sentence(Formatter):
    """Writes 1640 where ``:.3g`` gives 1.64e+03."""

    def format_field(self, value: Any, spec: str) -> str:
        text = str(super().format_field(value, spec))
        if isinstance(value, str) or "e+0" not in text or abs(value) >= MAX_PLAIN:
            return text
        return format(float(text), spec.partition(".")[0].rstrip("g") + ".0f")


def _filled(template: str, fields: Mapping[str, Any]) -> str:
    """The template with its fields."""
    made = template.format_map(fields) if fields else template
    return _Sentence().vformat(template, (), fields) if "e+0" in made else made


def say(template: str, /, **fields: Any) -> Phrase:
    """A phrase; `fields` fill its template, which is written out at the call: calls are what catalogues collect."""
    return Phrase((template,), fields)


def say_count(count: int, one: str, many: str, /, **fields: Any) -> Phrase:
    """A phrase with a number, named `count` in both templates, that its nouns agree with."""
    return Phrase((one, many), {"count": count, **fields})


class Joined(Phrase):
    """Phrases with a separator between them, which is translated too; made by `join`."""

    __slots__ = ()

    def within(self, catalogue: Catalogue) -> str:
        """The phrases in the language of a catalogue: signs of its own width need no blank behind them."""
        return _BLANK.sub("", super().within(catalogue))

    def _template(self, catalogue: Catalogue) -> str:
        template = self.templates[0]
        for separator in _SEPARATORS:
            template = template.replace(separator, catalogue.gettext(separator))
        return template


_BLANK = re.compile("(?<=[，；：。！？]) ")


def join(separator: str, parts: Iterable[str]) -> Phrase:
    """Texts one after the other, each of which is translated by itself."""
    fields = {f"_{i}": part for i, part in enumerate(parts)}
    escaped = separator.replace("{", "{{").replace("}", "}}")
    return Joined((escaped.join(f"{{{name}}}" for name in fields),), fields)


_SEPARATORS = (say(": "), say("; "), say(", "), say(". "))


def visible(text: str) -> str:
    """A text on one line, which drives no terminal: with replacement characters in place of what cannot be printed."""
    if text.isprintable():  # a phrase stays one
        return text
    return "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in text)


def translate(value: Any, catalogue: Catalogue) -> Any:
    """A phrase in the language of a catalogue; anything else, such as the name of a channel or a number, unchanged."""
    return value.within(catalogue) if isinstance(value, Phrase) else value


MIN_PART_SHARE = 0.25  # share of a recording that a part of it must have to be worth a proposal


def plural(count: int, noun: str, many: str = "") -> str:
    """A number and its noun, singular or plural."""
    return f"{count} {noun if count == 1 else many or noun + 's'}"


def percent(share: float) -> str:
    """A share with two significant digits, and all digits before the point."""
    return f"{100 * share:.2g} %" if share < 0.995 else f"{100 * share:.0f} %"


def duration(seconds: float) -> str:
    """A duration with its unit."""
    for size, unit, least in ((86400.0, "d", 172800.0), (3600.0, "h", 3600.0), (60.0, "min", 120.0), (1.0, "s", 0.0)):
        if seconds >= least:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds:.3g} s"


def averaging(tau: float) -> str:
    """An averaging time: in seconds, as on the axis of a curve."""
    return f"{float(f'{tau:.3g}'):.15g} s"


_AT_COMMAND_LINE = ContextVar("_AT_COMMAND_LINE", default=False)


@contextmanager
def command_line() -> Iterator[None]:
    """Messages made within this context name options; elsewhere they name arguments."""
    token = _AT_COMMAND_LINE.set(True)
    try:
        yield
    finally:
        _AT_COMMAND_LINE.reset(token)


def spelled(option: str, argument: str) -> str:
    """The name of a choice in a message: an option at the command line, an argument in Python."""
    return option if _AT_COMMAND_LINE.get() else argument


def windowing() -> str:
    """The name of the choice of a part of the record."""
    return spelled("--from, --until", "prepare.trim")


def longest_without(bad: Iterable[tuple[float, float]], span: tuple[float, float]) -> str:
    """How to select the longest part of a recording, s, that holds none of these, s, ascending, unless it is short."""
    ends = [span[0], *(time for each in bad for time in each), span[1]]
    start, end = max(zip(ends[::2], ends[1::2], strict=True), key=lambda part: part[1] - part[0])
    return between(start, end) if end - start > MIN_PART_SHARE * (span[1] - span[0]) else windowing()


def between(start: float, end: float) -> str:
    """How to select the part of a recording from `start` to `end`, s."""
    option = (f"--from {start:.6g} " if start > 0 else "") + f"--until {end:.6g}"
    return spelled(option, f"prepare.trim(recording, {start:.6g}, {end:.6g})")
