"""The language that results are shown in: English, or one with a catalogue in `locale`.

What is shown is made of phrases (`phrases.phrase`), and stays English until `tr` says it in that language.
"""

import gettext
import io
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache
from pathlib import Path
from typing import Any

from allanite.core.names import demand_name
from allanite.phrases.phrase import Catalogue, Phrase

from .digits import printed_unit

LANGUAGES = {"en": "English", "ru": "русский", "zh": "中文"}
"""Codes of the languages, and their names in themselves; the catalogue of each but English is ``locale/<code>.po``."""

ENGLISH = "en"

_SPOKEN: ContextVar[str] = ContextVar("_SPOKEN", default=ENGLISH)


@cache
def catalogue(lang: str) -> Catalogue:
    """The translations into a language; what is not translated yet stays English, all of it without a catalogue."""
    demand_name("language", lang, LANGUAGES)
    path = Path(__file__).parent / "locale" / f"{lang}.po"
    if not path.is_file():
        return gettext.NullTranslations()
    # for this alone, and only where it is wanted
    from babel.messages.mofile import write_mo
    from babel.messages.pofile import read_po

    compiled = io.BytesIO()
    with path.open("rb") as file:
        write_mo(compiled, read_po(file, locale=lang))
    compiled.seek(0)
    return gettext.GNUTranslations(compiled)


@contextmanager
def speaking(lang: str) -> Iterator[None]:
    """Whatever is rendered within this context is in this language."""
    catalogue(lang)
    token = _SPOKEN.set(lang)
    try:
        yield
    finally:
        _SPOKEN.reset(token)


def spoken() -> str:
    """The code of the language of this context."""
    return _SPOKEN.get()


def tr(value: Any) -> Any:
    """A phrase in the language of this context, its units as printed; anything else, such as a name, unchanged."""
    if not isinstance(value, Phrase):
        return value
    lang = _SPOKEN.get()
    return printed_unit(str.__str__(value) if lang == ENGLISH else value.within(catalogue(lang)))
