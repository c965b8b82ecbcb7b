"""Models as text: ``N 0.003 deg/sqrt(h), B 0.5 deg/h, GM 0.1 deg/h 20 s``."""

import re

from allanite.terms import TERMS

from .errors import UsageError
from .model import Model, Term, term
from .names import unknown
from .units import convert

_NUMBER = re.compile(r"[-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][-+]?\d+)?")


def terms_of(text: str) -> tuple[Term, ...]:
    """The terms of a model that a text describes; see `Model`."""
    parts: list[list[str]] = []
    titles = (f"{p.name} {p.title}" for row in TERMS.values() for p in row.parameters)
    fillers = {"with", *" ".join(titles).replace("_", " ").split()}  # words that carry no information
    for part in text.split(","):
        words = [word for word in part.replace("=", " ").split() if word not in fillers]
        if parts and words and _NUMBER.match(words[0]):  # the previous term has another parameter
            parts[-1] += words
        else:
            parts.append(words)
    return tuple(_term(words, text) for words in parts)


def _term(words: list[str], text: str) -> Term:
    if not words or words[0] not in TERMS:
        where = f" in {text!r}"
        error = unknown("term", words[0], TERMS, where=where) if words else UsageError(f"there is no term{where}")
        raise type(error)(f"{error}; a model has the form 'N 0.003 deg/sqrt(h), Q 0.2 arcsec'", cure=error.cure)
    symbol, parameters = words[0], TERMS[words[0]].parameters
    # the unit of the coefficient may begin with 1, as 1/s
    plain = len(words) > 2 and _NUMBER.fullmatch(words[1]) and re.fullmatch(r"1(/.*)?", words[2])
    first = [(float(words[1]), words[2])] if plain else []
    quantities = [*first, *split_quantities(words[1 + 2 * len(first) :])]
    if not 0 < len(quantities) <= 1 + len(parameters) or not quantities[0][1]:
        wanted = "".join(f", its {p.name.replace('_', ' ')}{p.unit and f' in {p.unit}'}" for p in parameters)
        raise UsageError(
            f"{' '.join(words)!r} is not a noise term: {symbol} must be followed by a number and a unit{wanted}, "
            "e.g. 'N 0.003 deg/sqrt(h), GM 0.1 deg/h 20 s'"
        )
    (value, unit), *rest = quantities
    shape = (convert(v, u or p.unit or "1", p.unit or "1") for (v, u), p in zip(rest, parameters, strict=False))
    return term(symbol, value, unit, tuple(shape))


def split_quantities(words: list[str]) -> list[tuple[float, str]]:
    """Numbers with the units that follow them, with or without a space; the unit is empty if none follows.

    Examples
    --------
    >>> split_quantities(["0.1", "deg/h", "20s", "3"])
    [(0.1, 'deg/h'), (20.0, 's'), (3.0, '')]
    """
    found: list[tuple[float, str]] = []
    for word in words:
        number = _NUMBER.match(word)
        if number:
            found.append((float(number[0]), word[number.end() :]))
        elif found and not found[-1][1]:
            found[-1] = (found[-1][0], word)
        else:
            raise UsageError(f"expected a number instead of {word!r} in {' '.join(words)!r}, e.g. 0.1 deg/h")
    return found


def written(model: Model) -> str:
    """The text from which `Model` makes exactly the same model.

    Examples
    --------
    >>> model = Model("N 0.003 deg/sqrt(h), GM 0.1 deg/h 20 s")
    >>> Model(written(model)) == model
    True
    """
    texts = list[str]()
    for found in model:
        parameters = zip(found.shape, found.row.parameters, strict=True)
        shape = (f"{float(value)!r} {row.unit}".rstrip() for value, row in parameters)
        texts.append(" ".join([found.symbol, f"{float(found.value)!r}", found.unit, *shape]))
    return ", ".join(texts)
