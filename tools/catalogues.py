"""Collect what reports say from the source, and bring the translations up to date: ``make catalogues``.

    python tools/catalogues.py [--check] [LANG ...]

With --check nothing is written, and how many sentences of a language are shown in English is printed.
"""

import io
import re
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from babel.messages.catalog import Catalog, Message
from babel.messages.extract import extract_from_dir
from babel.messages.pofile import read_po, write_po

from allanite.reporting.language import ENGLISH, LANGUAGES

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "src" / "allanite"
LOCALE = PACKAGE / "reporting" / "locale"
TABLES = {"interpretation/words.toml": "is", "interpretation/devices.toml": ""}
"""Tables with texts, and the key of those that are translated; empty if all are."""

METHODS = [("**.py", "python"), ("**.j2", "jinja2")]
KEYWORDS = {"say": None, "say_count": (2, 3)}  # calls whose arguments are templates

HEADER = re.compile(
    r'^"(POT-Creation-Date|PO-Revision-Date|Last-Translator|Language-Team|Report|Generated-By).*\n', re.M
)
"""What would differ with every run."""


def templates() -> Catalog:
    """Every template of the package, with the files that have it."""
    found = Catalog(project="allanite", charset="utf-8", fuzzy=False)
    said = extract_from_dir(
        PACKAGE, METHODS, keywords=KEYWORDS, comment_tags=("Translators:",), strip_comment_tags=True
    )
    for name, line, message, comments, _ in said:
        path = Path(name).as_posix()
        found.add(message, None, [(path, line)], auto_comments=comments)
    for file, key in TABLES.items():
        for text in _texts(tomllib.loads((PACKAGE / file).read_text("utf-8")), key):
            found.add(text, None, [(file, 1)])
    return found


def _texts(table: Any, key: str, *, taken: bool = False) -> Iterator[str]:
    """The texts of a table that are translated: those of a key, or all."""
    if isinstance(table, str):
        yield from [table] if taken or not key else []
    for part in table if isinstance(table, list) else ():
        yield from _texts(part, key)
    for name, part in table.items() if isinstance(table, dict) else ():
        yield from _texts(part, key, taken=name == key)


def stored(lang: str) -> Catalog:
    """The catalogue of a language as it is in the source; empty if there is none yet."""
    path = LOCALE / f"{lang}.po"
    if not path.exists():
        return Catalog(locale=lang, project="allanite", charset="utf-8", fuzzy=False)
    with path.open("rb") as file:
        return read_po(file, locale=lang)


def languages() -> list[str]:
    """The languages that have, or get, a catalogue."""
    return sorted(set(LANGUAGES) - {ENGLISH})


def renewed(lang: str, found: Catalog) -> Catalog:
    """The same with the templates that were found; of one that has changed, the old translation is kept as fuzzy."""
    catalogue = stored(lang)
    catalogue.update(found, update_creation_date=False)
    for message in catalogue:
        if message.id and not all(strings(message)):  # made fuzzy after one that is empty, too
            message.flags.discard("fuzzy")
    return catalogue


def text_of(catalogue: Catalog) -> str:
    """A catalogue as its file, the same for the same content."""
    catalogue.header_comment = f"# {catalogue.locale.english_name} reports of allanite: see docs/architecture.md"
    for message in catalogue:
        _flag(message)
    out = io.BytesIO()
    write_po(out, catalogue, width=120, sort_by_file=True, no_location=True, ignore_obsolete=True)
    return HEADER.sub("", out.getvalue().decode())


def _flag(message: Message) -> None:
    """A template has fields in braces; a per cent sign in it is one."""
    message.flags.discard("python-format")
    if message.id and "{" in "".join(message.id):
        message.flags.add("python-brace-format")


def strings(message: Message) -> tuple[str, ...]:
    """The translations of a template: one, or one for each plural form."""
    return (message.string,) if isinstance(message.string, str) else tuple(message.string or ("",))


def unfinished(catalogue: Catalog) -> list[Message]:
    """Templates without a translation, or with one that nobody has looked at since the template changed."""
    return [message for message in catalogue if message.id and (message.fuzzy or not all(strings(message)))]


def english(catalogue: Catalog) -> str:
    """How much of a language is shown in English, in a line; nothing if all of it is translated."""
    left = len(unfinished(catalogue))
    return (left and f"{catalogue.locale}: {left} sentence{'s are' if left > 1 else ' is'} shown in English") or ""


def main() -> None:
    """Write the catalogues, or leave them as they are, and say what is left to translate."""
    words = [word for word in sys.argv[1:] if word != "--check"]
    found = templates()
    for lang in words or languages():
        catalogue = renewed(lang, found)
        if "--check" not in sys.argv:
            (LOCALE / f"{lang}.po").write_text(text_of(catalogue), encoding="utf-8")
        print(english(catalogue) or f"{lang}: all {len(catalogue)} sentences are translated")


if __name__ == "__main__":
    main()
