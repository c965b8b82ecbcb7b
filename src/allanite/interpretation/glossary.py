"""Words of the field and of the program, with a formula and an example: what ``allanite explain`` says of them."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

from allanite.core.plain import Value
from allanite.phrases.phrase import say
from allanite.terms import TERMS


@dataclass(frozen=True, repr=False)
class Word(Value):
    """A word, in a row of `words`."""

    name: str
    synonyms: tuple[str, ...]  # other names, which are taken, too
    meaning: str
    formula: str = ""
    example: str = ""
    see: tuple[str, ...] = ()  # related names


@cache
def words() -> Mapping[str, Word]:
    """The words by name."""
    own = {name: Word(name, tuple(row["names"]), say(row["is"]), row["formula"], row["example"], tuple(row["see"]))
           for name, row in tomllib.loads((files(__package__) / "words.toml").read_text("utf-8")).items()}  # fmt: skip
    named = {name for word in own.values() for name in word.synonyms}
    added = {row.title: Word(row.title, (symbol,), row.meaning) for symbol, row in TERMS.items() if symbol not in named}
    return own | added


@cache
def named_words() -> Mapping[str, Word]:
    """The words by each of their names."""
    return {name: word for word in words().values() for name in (*word.synonyms, word.name)}
